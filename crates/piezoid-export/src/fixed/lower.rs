//! Rewrites a program for real numbers with integers.
//!
//! ```text
//! v = n 2^e           n: the count, in 32 bits; e: fixed for every named number
//! a + b               both with the finer exponent, in 64 bits
//! a b                 n_a n_b in 64 bits, then rounded once to the exponent of the result
//! a / b               n_a 2^s / n_b in 64 bits, rounded
//! ```
//! The largest number of bits is fixed too, for all inputs: intermediate results need at most 62 bits, and named
//! numbers are clamped to 32. Accumulating fields have 20 more bits. `epsilon` is 2^-30. The other limits of
//! floating-point numbers have no meaning for integers: programs that use them are errors.

use super::formats::{Formats, Key, MORE, PLAIN, above, fitting, key};
use super::number::{NARROW, Number, WIDE, WIDEST, aligned, binary, call, counts, power, sum};
use piezoid::error::Error;
use piezoid_models::program::{Block, Expr, FieldValue, Function, Limit, Op, Place, Program, Statement, ValueType};

#[derive(Debug)]
enum Condition {
    Always,
    Never,
    If(Expr),
}

/// The program with integers.
pub(super) fn lowered(program: &Program, formats: &Formats) -> Result<Program, Error> {
    let blocks = program.blocks.iter().map(|block| in_counts(block, formats)).collect();
    let functions = program.functions.iter().map(|function| {
        if PLAIN.contains(&function.name.as_str()) {
            return Ok(function.clone());
        }
        Lowering { program, formats, function }.lowered()
    });
    Ok(Program { blocks, functions: functions.collect::<Result<_, _>>()? })
}

/// The exponent of a constant.
fn of_constant(values: &[f64]) -> i32 {
    fitting(values.iter().fold(0.0, |most, v| v.abs().max(most)))
}

fn in_counts(block: &Block, formats: &Formats) -> Block {
    let mut block = block.clone();
    for constant in &mut block.constants {
        let exponent = of_constant(&constant.values);
        constant.values.iter_mut().for_each(|v| *v = counts(*v, exponent));
    }
    for field in &mut block.fields {
        let exponent = formats.exponent(&Key::Field(block.name.clone(), field.name.clone()));
        match &mut field.holds {
            FieldValue::Number(v) => *v = counts(*v, exponent),
            FieldValue::Numbers(values) => values.iter_mut().for_each(|v| *v = counts(*v, exponent)),
            FieldValue::Block(_) => {}
        }
    }
    block
}

fn unsuited<T>(because: String) -> Result<T, Error> {
    Err(Error::Unsuited { what: "export in fixed point".into(), because })
}

struct Lowering<'l> {
    program: &'l Program,
    formats: &'l Formats,
    function: &'l Function,
}

impl Lowering<'_> {
    fn lowered(&self) -> Result<Function, Error> {
        let f = self.function;
        let returns = f.returns.iter().enumerate().map(|(k, expr)| self.stored(expr, &Key::Gives(f.name.clone(), k)));
        Ok(Function { steps: self.steps(&f.steps)?, returns: returns.collect::<Result<_, _>>()?, ..f.clone() })
    }

    fn steps(&self, steps: &[Statement]) -> Result<Vec<Statement>, Error> {
        Ok(steps.iter().map(|step| self.step(step)).collect::<Result<Vec<_>, _>>()?.concat())
    }

    fn step(&self, step: &Statement) -> Result<Vec<Statement>, Error> {
        Ok(vec![match step {
            Statement::Note(_) | Statement::Copy { .. } | Statement::Array(..) => step.clone(),
            Statement::Let(names, Expr::Call(called, values)) if names.len() > 1 => {
                Statement::Let(names.clone(), call(called, self.arguments(called, values)?))
            }
            Statement::Let(names, expr) => Statement::Let(names.clone(), self.assigned(expr, &self.local(&names[0]))?),
            Statement::Set(place, expr) => Statement::Set(self.place(place)?, self.assigned(expr, &self.key(place))?),
            Statement::Do(Expr::Call(called, values)) => Statement::Do(call(called, self.arguments(called, values)?)),
            Statement::Do(_) => return Ok(Vec::new()),
            Statement::If(holds, yes, no) => match self.holds(holds)? {
                Condition::Always => return self.steps(yes),
                Condition::Never => return self.steps(no),
                Condition::If(holds) => Statement::If(holds, self.steps(yes)?, self.steps(no)?),
            },
            Statement::For { name, from, to, down, most, steps } => {
                let (name, from, to) = (name.clone(), self.whole(from)?, self.whole(to)?);
                Statement::For { name, from, to, down: *down, most: *most, steps: self.steps(steps)? }
            }
            Statement::While(holds, most, steps) => match self.holds(holds)? {
                Condition::Always => return unsuited(format!("`{}` would not end", self.function.name)),
                Condition::Never => return Ok(Vec::new()),
                Condition::If(holds) => Statement::While(holds, *most, self.steps(steps)?),
            },
        }])
    }

    fn local(&self, name: &str) -> Key {
        Key::Local(self.function.name.clone(), name.to_owned())
    }

    fn key(&self, place: &Place) -> Key {
        key(self.program, self.function, place)
    }

    fn place(&self, place: &Place) -> Result<Place, Error> {
        let index = place.index.as_ref().map(|index| self.whole(index)).transpose()?;
        Ok(Place { index: index.map(Box::new), ..place.clone() })
    }

    fn arguments(&self, called: &str, values: &[Expr]) -> Result<Vec<Expr>, Error> {
        let takes = self.program.function(called).map_or(&[][..], |f| &f.takes);
        let argument = |(takes, values): (&piezoid_models::program::Argument, &Expr)| match takes.kind {
            ValueType::Real => self.stored(values, &Key::Local(called.to_owned(), takes.name.clone())),
            ValueType::Integer => self.whole(values),
            _ => Ok(values.clone()),
        };
        takes.iter().zip(values).map(argument).collect()
    }

    fn assigned(&self, expr: &Expr, to: &Key) -> Result<Expr, Error> {
        if expr.whole() { self.whole(expr) } else { self.stored(expr, to) }
    }

    /// An expression with the exponent of its destination, clamped to its range.
    fn stored(&self, expr: &Expr, to: &Key) -> Result<Expr, Error> {
        let exponent = self.formats.exponent(to);
        let number = self.real(expr, Some(exponent))?;
        match to {
            Key::Field(block, field) if self.formats.is_long(block, field) => {
                let there = number.to(exponent);
                Ok(if there.literal.is_some() { there.expr } else { call("keep", vec![there.expr]) })
            }
            _ => Ok(number.narrow(exponent)),
        }
    }

    fn whole(&self, expr: &Expr) -> Result<Expr, Error> {
        Ok(match expr {
            Expr::Call(name, values) if name == "whole" => {
                let number = self.real(&values[0], None)?;
                let (op, unit) = match number.exponent {
                    0.. => return Ok(call("whole", vec![number.to(0).expr])),
                    e => (Op::Divide, Expr::Real(power(-e))),
                };
                call("whole", vec![binary(op, number.expr, unit)])
            }
            Expr::Binary(op, left, right) => binary(*op, self.whole(left)?, self.whole(right)?),
            expr => expr.clone(),
        })
    }

    /// A number; products and quotients have the exponent `target` if the bits allow.
    fn real(&self, expr: &Expr, target: Option<i32>) -> Result<Number, Error> {
        if let Some(v) = literal(expr) {
            return Ok(Number::literal(v));
        }
        Ok(match expr {
            Expr::Limit(limit) => {
                let limit = if matches!(limit, Limit::Most | Limit::Measurable) { "largest" } else { "least positive" };
                let compares = format!("its function `{}` compares with the {limit}", self.function.name);
                return unsuited(format!("{compares} floating-point number, which fixed point does not have"));
            }
            Expr::Variable(name, _) => Number::named(expr.clone(), self.formats.exponent(&self.local(name))),
            Expr::Constant(block, name, index) => {
                let constant = self.program.blocks[*block].constants.iter().find(|c| c.name == *name);
                let exponent = of_constant(constant.map_or(&[], |c| &c.values));
                let index = index.as_ref().map(|index| self.whole(index)).transpose()?;
                Number::named(Expr::Constant(*block, name.clone(), index.map(Box::new)), exponent)
            }
            Expr::At(place) => {
                let (key, at) = (self.key(place), Expr::At(self.place(place)?));
                let number = Number::named(at, self.formats.exponent(&key));
                match &key {
                    Key::Field(block, field) if self.formats.is_long(block, field) => {
                        Number { bits: NARROW + MORE, wide: true, ..number }
                    }
                    _ => number,
                }
            }
            Expr::Call(name, values) if name == "real" => Number::named(call(name, vec![self.whole(&values[0])?]), 0),
            Expr::Call(name, values) if PLAIN.contains(&name.as_str()) => {
                let numbers = values.iter().map(|g| self.real(g, target)).collect::<Result<Vec<_>, _>>()?;
                let numbers = aligned(numbers);
                let (exponent, bits) = (numbers[0].exponent, numbers.iter().map(|n| n.bits).max().unwrap_or(0));
                let passed = call(name, numbers.into_iter().map(|n| n.expr).collect());
                if name == "way" { Number::computed(passed, 0, 1) } else { Number::computed(passed, exponent, bits) }
            }
            Expr::Call(name, values) => {
                let exponent = self.formats.exponent(&Key::Gives(name.clone(), 0));
                Number::named(call(name, self.arguments(name, values)?), exponent)
            }
            Expr::Negative(inner) => {
                let number = self.real(inner, target)?;
                let (exponent, bits) = (number.exponent, number.bits);
                Number::computed(Expr::Negative(Box::new(number.long())), exponent, bits)
            }
            Expr::Binary(Op::Multiply, left, right) => self.product(left, right, target)?,
            Expr::Binary(Op::Divide, left, right) => self.quotient(expr, left, right, target)?,
            Expr::Binary(op, left, right) => {
                let (left, right) = (self.real(left, target)?, self.real(right, target)?);
                match (left.literal, right.literal) {
                    (Some(0.0), _) if *op == Op::Add => right,
                    (_, Some(0.0)) => left,
                    _ => sum(*op, left, right),
                }
            }
            Expr::Real(_) | Expr::Integer(_) | Expr::Part(_) => {
                return unsuited(format!("{expr:?} is not a real number"));
            }
        })
    }

    /// A factor in 32 bits, scaled to its own largest value.
    fn factor(&self, expr: &Expr) -> Result<Number, Error> {
        let stated = self.formats.stated(expr);
        let number = self.real(expr, stated)?;
        if !number.wide {
            return Ok(number);
        }
        let room = number.exponent + (number.bits - NARROW).max(0);
        let exponent = stated.map_or(room, |stated| stated.max(number.exponent)).min(room);
        Ok(Number::named(number.narrow(exponent), exponent))
    }

    fn product(&self, left: &Expr, right: &Expr, target: Option<i32>) -> Result<Number, Error> {
        for (one, other) in [(left, right), (right, left)] {
            // A power of two changes only the exponent.
            if let Some(v) = literal(one)
                && v > 0.0
                && v == power(above(v) - 1)
            {
                let n = above(v) - 1;
                let number = self.real(other, target.map(|target| target - n))?;
                return Ok(Number { exponent: number.exponent + n, ..number });
            }
        }
        let (a, b) = (self.factor(left)?, self.factor(right)?);
        let exponent = a.exponent + b.exponent;
        let n = target.map_or(0, |target| target - exponent).clamp(WIDEST - WIDE, WIDEST - 1);
        let product = call("product", vec![a.expr, b.expr, Expr::Integer(n.unsigned_abs() as usize)]);
        Ok(Number::computed(product, exponent + n, WIDEST - n + 1))
    }

    fn quotient(&self, expr: &Expr, left: &Expr, right: &Expr, target: Option<i32>) -> Result<Number, Error> {
        if let Some(v) = literal(right) {
            return self.product(left, &Expr::Real(1.0 / v), target);
        }
        let (a, b) = (self.factor(left)?, self.factor(right)?);
        let difference = a.exponent - b.exponent;
        let exponent = self.formats.stated(expr).or(target).unwrap_or(difference);
        let n = (difference - exponent).clamp(0, WIDEST - NARROW);
        let quotient = call("quotient", vec![a.expr, b.expr, Expr::Integer(n.unsigned_abs() as usize)]);
        Ok(Number::named(quotient, difference - n))
    }

    fn holds(&self, expr: &Expr) -> Result<Condition, Error> {
        let Expr::Binary(op, left, right) = expr else {
            return unsuited(format!("`{}` has an invalid condition", self.function.name));
        };
        Ok(match op {
            Op::And | Op::Or => match (op, self.holds(left)?, self.holds(right)?) {
                (_, Condition::If(left), Condition::If(right)) => Condition::If(binary(*op, left, right)),
                (Op::And, Condition::Never, _) | (Op::And, _, Condition::Never) => Condition::Never,
                (Op::Or, Condition::Always, _) | (Op::Or, _, Condition::Always) => Condition::Always,
                (_, Condition::If(holds), _) | (_, _, Condition::If(holds)) => Condition::If(holds),
                (_, decided, _) => decided,
            },
            // Integers are always finite.
            Op::AtMost if matches!(**right, Expr::Limit(Limit::Most | Limit::Measurable)) => Condition::Always,
            _ if left.whole() => Condition::If(binary(*op, self.whole(left)?, self.whole(right)?)),
            _ => {
                let numbers = aligned(vec![self.real(left, None)?, self.real(right, None)?]);
                match (decided(*op, &numbers[0], &numbers[1]), &numbers[..]) {
                    (Some(true), _) => Condition::Always,
                    (Some(false), _) => Condition::Never,
                    (None, [left, right, ..]) => Condition::If(binary(*op, left.expr.clone(), right.expr.clone())),
                    (None, _) => Condition::Never,
                }
            }
        })
    }
}

/// The result of a comparison with a literal that is out of the range of the other number.
fn decided(op: Op, left: &Number, right: &Number) -> Option<bool> {
    let beyond = |one: &Number, other: &Number| match (one, other) {
        (Number { literal: Some(_), expr: Expr::Real(n), .. }, Number { literal: None, bits, .. }) => {
            Some(*n).filter(|n| n.abs() > power(*bits))
        }
        _ => None,
    };
    let (a, b) = match (beyond(left, right), beyond(right, left)) {
        (Some(n), _) => (n, 0.0),
        (None, Some(n)) => (0.0, n),
        (None, None) => return None,
    };
    match op {
        Op::Less | Op::AtMost => Some(a < b),
        Op::More | Op::AtLeast => Some(a > b),
        Op::Equal => Some(false),
        Op::Unequal => Some(true),
        _ => None,
    }
}

/// The value of a constant expression.
fn literal(expr: &Expr) -> Option<f64> {
    match expr {
        Expr::Real(v) => Some(*v),
        Expr::Limit(Limit::Epsilon) => Some(power(-30)),
        Expr::Negative(inner) => Some(-literal(inner)?),
        Expr::Binary(op, left, right) => {
            let (a, b) = (literal(left)?, literal(right)?);
            match op {
                Op::Add => Some(a + b),
                Op::Subtract => Some(a - b),
                Op::Multiply => Some(a * b),
                Op::Divide => Some(a / b),
                _ => None,
            }
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_models::program::Machine;

    /// The program of a text with real numbers, its formats after these inputs, and the program with integers.
    fn both(text: &str, inputs: &[f64]) -> (Program, Formats, Program) {
        let block = Block::new("sum", "all so far").number("total", 0.0).text(text);
        let program = Program::new(vec![piezoid_models::program::Block::elementary(), block]).unwrap();
        let mut machine = Machine::new(&program, "sum", false).watched();
        inputs.iter().for_each(|u| drop(machine.call("sum", &[*u]).unwrap()));
        let mut formats = Formats::of(&program, &[machine]);
        let most = inputs.iter().fold(0.0, |most: f64, u| most.max(u.abs()));
        formats.raise(Key::Local("sum".into(), "u".into()), most);
        let mut kept = program;
        kept.keep(&["sum", "clamp"]);
        let counted = lowered(&kept, &formats).unwrap();
        (kept, formats, counted)
    }

    #[test]
    fn changes_below_a_32_bit_count_accumulate() {
        let text = "fn sum(x: sum, u) { x.total += 1e-9 * (u - x.total); return x.total; }";
        let (program, formats, counted) = both(text, &[1.0; 1000]);
        assert!(formats.is_long("sum", "total"));
        let mut machine = Machine::new(&counted, "sum", false);
        let mut exact = Machine::new(&program, "sum", false);
        let one = counts(1.0, formats.exponent(&Key::Local("sum".into(), "u".into())));
        for _ in 0..1000 {
            machine.call("sum", &[one]).unwrap();
            exact.call("sum", &[1.0]).unwrap();
        }
        let worth = power(formats.exponent(&Key::Field("sum".into(), "total".into())));
        assert!((machine.state()[0] * worth / exact.state()[0] - 1.0).abs() < 1e-6);
    }

    #[test]
    fn values_far_above_the_known_range_are_clamped() {
        let text = "fn sum(x: sum, u) { x.total = u * u * u; return x.total + u; }";
        let (_, _, counted) = both(text, &[0.5, 1.0]);
        let mut machine = Machine::new(&counted, "sum", false);
        let most = power(31) - 1.0;
        assert_eq!(machine.call("sum", &[most]).unwrap(), [most]);
        assert_eq!(machine.call("sum", &[-most]).unwrap(), [-most]);
    }

    #[test]
    fn comparisons_with_numbers_out_of_range_are_decided() {
        for (condition, gives) in [
            ("u < 1e9", Some(2.0)),
            ("1e9 <= u", Some(1.0)),
            ("u > 1e9 || u > 0.5", None),
            ("u > -1e9 && u < 1e9", Some(2.0)),
            ("u == 1e9 && u > 0.5", Some(1.0)),
        ] {
            let text = format!("fn sum(x: sum, u) {{ let v = 1.0; if {condition} {{ v = 2.0; }} return v; }}");
            let (_, _, counted) = both(&text, &[1.0]);
            let step = &counted.function("sum").unwrap().steps[1..];
            let decided = !step.iter().any(|step| matches!(step, Statement::If(..)));
            assert_eq!(decided, gives.is_some(), "{condition}: {step:?}");
            assert_eq!(step.is_empty(), gives == Some(1.0), "{condition}: {step:?}");
        }
    }

    #[test]
    fn limits_of_floating_point_are_errors_except_in_checks_for_finite_numbers() {
        let text = "fn sum(x: sum, u) { if magnitude(u) <= most { x.total = u; } return x.total; }";
        let (_, _, counted) = both(text, &[1.0]);
        let step = &counted.function("sum").unwrap().steps[0];
        assert!(matches!(step, Statement::Set(..)), "{step:?}");
        let block = Block::new("sum", "").number("total", 0.0).text("fn sum(x: sum, u) { return u * least; }");
        let program = Program::new(vec![block]).unwrap();
        let error = lowered(&program, &Formats::of(&program, &[])).unwrap_err().to_string();
        assert!(error.contains("`sum` compares with the least positive"), "{error}");
    }
}
