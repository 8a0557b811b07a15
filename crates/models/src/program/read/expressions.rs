//! Reading expressions by precedence; integers and real numbers do not mix.

use super::{Read, Reader};
use crate::program::tokens::Token;
use crate::program::{Expr, Limit, Op, Place, ValueType};

impl Reader<'_> {
    pub(super) fn place(&mut self) -> Read<Place> {
        let root = self.name()?;
        let mut path = Vec::new();
        while self.pass(".") {
            path.push(self.name()?);
        }
        let index = if self.pass("[") {
            let index = self.expr()?;
            self.expect("]")?;
            Some(Box::new(index))
        } else {
            None
        };
        Ok(Place { root, path, index })
    }

    /// Type of the value at a place.
    pub(super) fn kind_at(&self, place: &Place) -> Read<ValueType> {
        let Some(kind) = self.kind(&place.root).cloned() else {
            return self.wrong(format!("`{}` is not known", place.root));
        };
        let (_, kind) = self.program.within(kind, &place.path).or_else(|what| self.wrong(what))?;
        match (&place.index, kind) {
            (None, kind) => Ok(kind),
            (Some(index), ValueType::Array(_)) if index.whole() => Ok(ValueType::Real),
            (Some(_), kind) => self.wrong(format!("{kind:?} has no such index")),
        }
    }

    pub(super) fn expr(&mut self) -> Read<Expr> {
        self.binary(1)
    }

    fn binary(&mut self, least: u8) -> Read<Expr> {
        const OPS: [(&str, Op); 13] = [
            ("+", Op::Add),
            ("-", Op::Subtract),
            ("*", Op::Multiply),
            ("/", Op::Divide),
            ("%", Op::Remainder),
            ("<", Op::Less),
            ("<=", Op::AtMost),
            (">", Op::More),
            (">=", Op::AtLeast),
            ("==", Op::Equal),
            ("!=", Op::Unequal),
            ("&&", Op::And),
            ("||", Op::Or),
        ];
        let mut left = self.unary()?;
        while let Some((sign, op)) = OPS.into_iter().find(|(sign, op)| op.precedence() >= least && self.is(sign)) {
            self.expect(sign)?;
            let right = self.binary(op.precedence() + 1)?;
            if op.precedence() > Op::And.precedence() && left.whole() != right.whole() {
                return self.wrong(format!("`{sign}` mixes an integer and a real number"));
            }
            left = match (op, &left, &right) {
                (Op::Divide, Expr::Real(a), Expr::Real(b)) => Expr::Real(a / b),
                (Op::Add, Expr::Variable(..), Expr::Integer(0)) => left,
                (Op::Add, Expr::Integer(a), Expr::Integer(b)) => Expr::Integer(a + b),
                (Op::Subtract, Expr::Integer(a), Expr::Integer(b)) if a >= b => Expr::Integer(a - b),
                _ => Expr::Binary(op, Box::new(left), Box::new(right)),
            };
        }
        Ok(left)
    }

    fn unary(&mut self) -> Read<Expr> {
        if self.pass("-") {
            return Ok(match self.unary()? {
                Expr::Real(value) => Expr::Real(-value),
                inner => Expr::Negative(Box::new(inner)),
            });
        }
        if self.pass("(") {
            let inner = self.expr()?;
            self.expect(")")?;
            return Ok(inner);
        }
        match self.tokens.get(self.at) {
            Some(Token::Real(value)) => {
                self.at += 1;
                Ok(Expr::Real(*value))
            }
            Some(Token::Integer(value)) => {
                self.at += 1;
                Ok(Expr::Integer(*value))
            }
            Some(Token::Name(name)) if matches!(self.tokens.get(self.at + 1), Some(Token::Sign("("))) => {
                let name = name.clone();
                self.at += 2;
                let gives = self.program.function(&name).is_none_or(|f| !f.returns.is_empty());
                if gives { self.call(name) } else { self.wrong(format!("`{name}` returns nothing")) }
            }
            Some(Token::Name(_)) => self.named(),
            _ => self.wrong("a number is missing"),
        }
    }

    pub(super) fn call(&mut self, name: String) -> Read<Expr> {
        let mut arguments = Vec::new();
        while !self.pass(")") {
            arguments.push(self.expr()?);
            if !self.is(")") {
                self.expect(",")?;
            }
        }
        if name == "real" || name == "whole" {
            if arguments.len() != 1 || arguments[0].whole() != (name == "real") {
                return self.wrong(format!("`{name}` converts one number of the other type"));
            }
            return Ok(Expr::Call(name, arguments));
        }
        let Some(function) = self.program.function(&name) else {
            return self.wrong(format!("there is no function `{name}` before this one"));
        };
        if function.takes.len() != arguments.len() {
            return self.wrong(format!("`{name}` takes {} arguments", function.takes.len()));
        }
        for (parameter, argument) in function.takes.iter().zip(&arguments) {
            let fits = match (&parameter.kind, argument) {
                (ValueType::Part(block), Expr::Part(place)) => self.kind_at(place)? == ValueType::Part(block.clone()),
                (kind, argument) => argument.whole() == (*kind == ValueType::Integer),
            };
            if !fits {
                return self.wrong(format!("`{name}` takes another type of `{}`", parameter.name));
            }
            if let (true, Expr::Part(place)) = (parameter.changed, argument) {
                self.changed.push(place.root.clone());
            }
        }
        Ok(Expr::Call(name, arguments))
    }

    /// A variable, a field, a constant, an integer, or a property of the precision.
    fn named(&mut self) -> Read<Expr> {
        let place = self.place()?;
        let name = &place.root;
        if self.kind(name).is_some() {
            return match self.kind_at(&place)? {
                ValueType::Part(_) => Ok(Expr::Part(place)),
                ValueType::Array(_) => self.wrong(format!("`{name}` is an array: give an index")),
                kind => Ok(number_at(place, &kind)),
            };
        }
        let number = self.program.blocks.len() - 1;
        let block = &self.program.blocks[number];
        if let Some((_, value)) = block.counts.iter().find(|(known, _)| known == name) {
            return Ok(Expr::Integer(*value));
        }
        if let Some(constant) = block.constants.iter().find(|c| c.name == *name) {
            return match constant.table == place.index.is_some() {
                true => Ok(Expr::Constant(number, place.root, place.index)),
                false => {
                    self.wrong(format!("`{name}` is a table without an index, or has an index and is not a table"))
                }
            };
        }
        match name.as_str() {
            "epsilon" => Ok(Expr::Limit(Limit::Epsilon)),
            "least" => Ok(Expr::Limit(Limit::Least)),
            "most" => Ok(Expr::Limit(Limit::Most)),
            "measurable" => Ok(Expr::Limit(Limit::Measurable)),
            _ => self.wrong(format!("`{name}` is not known")),
        }
    }
}

/// The number of this `kind` at a place.
pub(super) fn number_at(place: Place, kind: &ValueType) -> Expr {
    let is_integer = *kind == ValueType::Integer;
    let is_variable = place.path.is_empty() && place.index.is_none();
    if is_integer || is_variable { Expr::Variable(place.root, is_integer) } else { Expr::At(place) }
}
