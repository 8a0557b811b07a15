//! Intermediate fixed-point numbers: their scale and the bits they need.

use super::formats::{above, fitting};
use piezoid_models::program::{Expr, Op};
use piezoid_numerics::number;

/// Bits of a named number.
pub(super) const NARROW: i32 = 31;
/// Bits of sums and comparisons.
pub(super) const WIDE: i32 = 52;
/// Bits of products and numerators.
pub(super) const WIDEST: i32 = 62;

/// An intermediate number: counts of 2^exponent, at most 2^bits of them.
#[derive(Debug, Clone)]
pub(super) struct Number {
    pub(super) expr: Expr,
    pub(super) exponent: i32,
    pub(super) bits: i32,
    /// True if it has 64 bits.
    pub(super) wide: bool,
    /// Its exact value, if it is a literal.
    pub(super) literal: Option<f64>,
}

/// `v` in counts of 2^exponent.
pub(super) fn counts(v: f64, exponent: i32) -> f64 {
    (v * power(-exponent)).round() + 0.0
}

pub(super) fn call(name: &str, arguments: Vec<Expr>) -> Expr {
    Expr::Call(name.into(), arguments)
}

pub(super) fn binary(op: Op, left: Expr, right: Expr) -> Expr {
    Expr::Binary(op, Box::new(left), Box::new(right))
}

pub(super) fn power(n: i32) -> f64 {
    number::power(2.0, n)
}

impl Number {
    pub(super) fn named(expr: Expr, exponent: i32) -> Self {
        Number { expr, exponent, bits: NARROW, wide: false, literal: None }
    }

    pub(super) fn literal(v: f64) -> Self {
        let exponent = fitting(v.abs());
        Number { literal: Some(v), ..Number::named(Expr::Real(counts(v, exponent)), exponent) }
    }

    pub(super) fn computed(expr: Expr, exponent: i32, bits: i32) -> Self {
        Number { expr, exponent, bits, wide: true, literal: None }
    }

    /// The bits it needs with another exponent.
    pub(super) fn bits(&self, exponent: i32) -> i32 {
        match self.literal {
            Some(0.0) => 0,
            Some(v) => (above(v.abs()) - exponent).max(0) + 1,
            None if exponent > self.exponent => (self.bits - (exponent - self.exponent)).max(0) + 1,
            None => self.bits + self.exponent - exponent,
        }
    }

    /// Converted to another exponent; clamped to [`WIDE`] bits if that is finer.
    pub(super) fn to(self, exponent: i32) -> Self {
        let (bits, finer) = (self.bits(exponent), self.exponent - exponent);
        if let Some(v) = self.literal {
            let count = counts(v, exponent).clamp(-power(WIDE), power(WIDE));
            return Number { expr: Expr::Real(count), exponent, bits: bits.min(WIDE), ..self };
        }
        let expr = match finer {
            0 => return self,
            _ if finer < -WIDEST => Expr::Real(0.0),
            _ if finer < 0 => call("shift", vec![self.expr, Expr::Integer(finer.unsigned_abs() as usize)]),
            _ if bits <= WIDE => binary(Op::Multiply, self.long(), Expr::Real(power(finer))),
            // The clamped range is far beyond that of the result.
            _ => {
                let end = power((WIDE - finer).max(0)) - 1.0;
                let held = call("clamp", vec![self.expr, Expr::Real(-end), Expr::Real(end)]);
                binary(Op::Multiply, held, Expr::Real(power(finer.min(WIDE))))
            }
        };
        Number::computed(expr, exponent, bits.min(WIDE))
    }

    /// An expression of 64 bits.
    pub(super) fn long(self) -> Expr {
        if self.wide { self.expr } else { call("wide", vec![self.expr]) }
    }

    /// An expression of 32 bits with this exponent.
    pub(super) fn narrow(self, exponent: i32) -> Expr {
        let there = self.to(exponent);
        match there.expr {
            Expr::Real(v) => Expr::Real(v.clamp(-power(NARROW) + 1.0, power(NARROW) - 1.0)),
            expr if there.wide => call("narrow", vec![expr]),
            expr => expr,
        }
    }
}

/// All with the finest exponent among them, as far as the bits allow.
pub(super) fn aligned(numbers: Vec<Number>) -> Vec<Number> {
    let named = numbers.iter().filter(|n| n.literal.is_none());
    let exponent = named.map(|n| n.exponent).min().unwrap_or(-30);
    let excess = numbers.iter().map(|n| n.bits(exponent) - WIDE).max().unwrap_or(0).max(0);
    numbers.into_iter().map(|n| n.to(exponent + excess)).collect()
}

pub(super) fn sum(op: Op, left: Number, right: Number) -> Number {
    let mut numbers = aligned(vec![left, right]).into_iter();
    let (Some(left), Some(right)) = (numbers.next(), numbers.next()) else { return Number::literal(0.0) };
    let (exponent, bits) = (left.exponent, left.bits.max(right.bits) + 1);
    let left = if right.wide { left.expr } else { left.long() };
    Number::computed(binary(op, left, right.expr), exponent, bits)
}
