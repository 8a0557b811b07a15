//! The largest number of operations that a function can take, whatever its arguments and the state.
//!
//! ```text
//! a choice    its condition and the longer side
//! a loop      the number of passes times the longest pass
//! a call      the bound of the function
//! ```
//! Operations are counted as a [`Machine`](super::Machine) counts them; of `&&` and `||` both sides are counted,
//! because some languages evaluate both. The passes of a loop follow from its ends if these are constant; otherwise its
//! text states them (`at most`), and a machine stops with an error if that is wrong. It does not do: conditions that
//! exclude each other in different statements, so the bound need not be reached.

use super::{Counts, Expr, Op, Place, Program, Statement};
use piezoid_numerics::error::Error;
use std::collections::HashMap;

impl Program {
    /// The largest number of operations in a call of the function `name`: sums, multiplications, divisions and
    /// comparisons of real numbers.
    ///
    /// ```
    /// use piezoid_models::program::{Block, Program};
    /// let text = "fn f(u) { let s = u; for k in 0..3 { if s > 1.0 { s = s * s + u; } } return s; }";
    /// let program = Program::new(vec![Block::new("b", "").text(text)])?;
    /// assert_eq!(program.bound("f")?, 9);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Content`] if there is no such function, or the number of passes of a loop is not known.
    pub fn bound(&self, name: &str) -> Result<usize, Error> {
        Ok(self.bounds(name)?.all)
    }

    /// The largest number of operations of each kind. Their sum may exceed [`bound`](Self::bound), because the sides of
    /// a choice may have different kinds.
    ///
    /// # Errors
    /// Those of [`bound`](Self::bound).
    pub fn bound_by_kind(&self, name: &str) -> Result<Counts, Error> {
        let Bound { sums, products, quotients, comparisons, .. } = self.bounds(name)?;
        Ok(Counts { sums, products, quotients, comparisons })
    }

    fn bounds(&self, name: &str) -> Result<Bound, Error> {
        let mut bounds = Bounds { known: HashMap::new(), whole: Vec::new() };
        for function in &self.functions {
            let steps = bounds
                .steps(&function.steps)
                .map_err(|what| Error::Content(format!("program, fn {}: {what}", function.name)))?;
            let returns = function.returns.iter().fold(steps, |sum, expr| sum.and(bounds.expr(expr)));
            bounds.known.insert(&function.name, returns);
        }
        let missing = || Error::Content(format!("program: there is no function `{name}`"));
        bounds.known.get(name).copied().ok_or_else(missing)
    }
}

/// Largest numbers of operations, which are counted apart.
#[derive(Clone, Copy, Default)]
struct Bound {
    all: usize,
    sums: usize,
    products: usize,
    quotients: usize,
    comparisons: usize,
}

impl Bound {
    fn with(self, other: Bound, of: fn(usize, usize) -> usize) -> Bound {
        Bound {
            all: of(self.all, other.all),
            sums: of(self.sums, other.sums),
            products: of(self.products, other.products),
            quotients: of(self.quotients, other.quotients),
            comparisons: of(self.comparisons, other.comparisons),
        }
    }

    fn and(self, other: Bound) -> Bound {
        self.with(other, usize::saturating_add)
    }

    fn or(self, other: Bound) -> Bound {
        self.with(other, usize::max)
    }

    fn times(self, n: usize) -> Bound {
        self.with(Bound { all: n, sums: n, products: n, quotients: n, comparisons: n }, usize::saturating_mul)
    }

    /// One operation.
    fn one(op: Op) -> Bound {
        let mut bound = Bound { all: 1, ..Bound::default() };
        *match op {
            Op::Add | Op::Subtract => &mut bound.sums,
            Op::Multiply => &mut bound.products,
            Op::Divide => &mut bound.quotients,
            _ => &mut bound.comparisons,
        } = 1;
        bound
    }
}

struct Bounds<'p> {
    /// Bounds of the functions so far.
    known: HashMap<&'p str, Bound>,
    /// The values of the integers of the loops around.
    whole: Vec<(&'p str, usize)>,
}

impl<'p> Bounds<'p> {
    fn steps(&mut self, steps: &'p [Statement]) -> Result<Bound, String> {
        steps.iter().try_fold(Bound::default(), |sum, step| Ok(sum.and(self.step(step)?)))
    }

    fn step(&mut self, step: &'p Statement) -> Result<Bound, String> {
        Ok(match step {
            Statement::Note(_) | Statement::Copy { .. } | Statement::Array(..) => Bound::default(),
            Statement::Let(_, expr) | Statement::Do(expr) => self.expr(expr),
            Statement::Set(place, expr) => self.place(place).and(self.expr(expr)),
            Statement::If(holds, yes, no) => self.expr(holds).and(self.steps(yes)?.or(self.steps(no)?)),
            Statement::While(holds, most, steps) => {
                let holds = self.expr(holds);
                holds.and(self.steps(steps)?).times(*most).and(holds)
            }
            Statement::For { name, from, to, most, steps, .. } => {
                let ends = self.expr(from).and(self.expr(to));
                let passes = match (most, value(from, &self.whole), value(to, &self.whole)) {
                    (Some(most), ..) => self.passes(name, 0..*most, steps)?,
                    (None, Some(from), Some(to)) => self.passes(name, from..to, steps)?,
                    _ => return Err(format!("the loop over `{name}` must say `at most` how many passes it takes")),
                };
                ends.and(passes)
            }
        })
    }

    /// All passes of a loop. One stands for all, unless loops inside depend on its integer.
    fn passes(
        &mut self,
        name: &'p str,
        range: std::ops::Range<usize>,
        steps: &'p [Statement],
    ) -> Result<Bound, String> {
        let mut depends = false;
        let mut look = |step: &Statement| {
            if let Statement::For { from, to, .. } = step {
                let mut see = |expr: &Expr| depends |= matches!(expr, Expr::Variable(other, _) if other == name);
                from.all(&mut see);
                to.all(&mut see);
            }
        };
        steps.iter().for_each(|step| step.all(&mut look));
        let (tried, times) =
            if depends { (range, 1) } else { (range.start..range.end.min(range.start + 1), range.len()) };
        tried.into_iter().try_fold(Bound::default(), |sum, k| {
            self.whole.push((name, k));
            let pass = self.steps(steps);
            self.whole.pop();
            Ok(sum.and(pass?.times(times)))
        })
    }

    fn place(&self, place: &Place) -> Bound {
        place.index.as_ref().map_or(Bound::default(), |index| self.expr(index))
    }

    fn expr(&self, expr: &Expr) -> Bound {
        match expr {
            Expr::Real(_) | Expr::Integer(_) | Expr::Limit(_) | Expr::Variable(..) => Bound::default(),
            Expr::Constant(_, _, index) => index.as_ref().map_or(Bound::default(), |index| self.expr(index)),
            Expr::At(place) | Expr::Part(place) => self.place(place),
            Expr::Negative(inner) => self.expr(inner),
            Expr::Call(name, arguments) => {
                let own = self.known.get(name.as_str()).copied().unwrap_or_default();
                arguments.iter().fold(own, |sum, argument| sum.and(self.expr(argument)))
            }
            Expr::Binary(op, left, right) => {
                let counts = !(matches!(op, Op::And | Op::Or) || left.whole());
                let own = if counts { Bound::one(*op) } else { Bound::default() };
                own.and(self.expr(left)).and(self.expr(right))
            }
        }
    }
}

/// The value of an integer expression, if it is constant for these values of variables.
pub(super) fn value(expr: &Expr, known: &[(&str, usize)]) -> Option<usize> {
    match expr {
        Expr::Integer(n) => Some(*n),
        Expr::Variable(name, true) => known.iter().find(|(other, _)| other == name).map(|(_, n)| *n),
        Expr::Binary(op, left, right) => {
            let (a, b) = (value(left, known)?, value(right, known)?);
            match op {
                Op::Add => a.checked_add(b),
                Op::Subtract => a.checked_sub(b),
                Op::Multiply => a.checked_mul(b),
                Op::Divide => a.checked_div(b),
                Op::Remainder => a.checked_rem(b),
                _ => None,
            }
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Block, Machine};
    use super::*;

    /// The bound of `f`, and the largest count of a call with these numbers.
    fn both(text: &str, numbers: &[f64]) -> (usize, usize) {
        let program = Program::new(vec![Block::new("b", "").count("n", 4).text(text)]).unwrap();
        let mut machine = Machine::new(&program, "b", false);
        let mut counted = |u: &f64| {
            let before = machine.counts.total();
            machine.call("f", &[*u]).unwrap();
            machine.counts.total() - before
        };
        (program.bound("f").unwrap(), numbers.iter().map(&mut counted).max().unwrap())
    }

    #[test]
    fn the_longest_way_through_a_function_takes_the_bound() {
        for (text, numbers, most) in [
            ("fn f(u) { return u; }", &[1.0][..], 0),
            ("fn f(u) { let k = 2 * 3 + 1; return -u * real(k) / 2.0 - u; }", &[1.0], 3),
            (
                "fn f(u) { let s = u; if u > 1.0 { s = u * u; } else if u < 0.0 { s = u * u * u; } return s; }",
                &[-1.0],
                4,
            ),
            ("fn g(v) { return v * v; } fn f(u) { return g(g(u) + g(u)); }", &[1.0], 4),
            ("fn f(u) { let s = u; for j in 0..n { for i in 0..j + 1 { s += u; } } return s; }", &[1.0], 10),
            ("fn f(u) { let s = u; for j in 1..n down { for i in 0..n - 1 - j { s += u; } } return s; }", &[1.0], 3),
            ("fn f(u) { let s = u; while s > 1.0 at most 5 { s -= 1.0; } return s; }", &[0.0, 5.5], 11),
            ("fn f(u) { let s = u; for k in 0..whole(u) at most n { s += u; } return s; }", &[1.0, 4.0], 4),
            ("fn f(u) { let s = u; if u < 1.0 || u > 2.0 && u < 3.0 { s = u + u; } return s; }", &[2.5], 4),
        ] {
            assert_eq!(both(text, numbers), (most, most), "{text}");
        }
    }

    #[test]
    fn operations_of_each_kind_are_bounded_apart() {
        let text = "fn f(u) { let s = u; if u > 1.0 { s = u * u / 2.0; } else { s = u + u - 1.0 + u; } return s; }";
        let program = Program::new(vec![Block::new("b", "").text(text)]).unwrap();
        let counts = Counts { sums: 3, products: 1, quotients: 1, comparisons: 1 };
        assert_eq!((program.bound("f").unwrap(), program.bound_by_kind("f").unwrap()), (4, counts));
    }

    #[test]
    fn a_loop_of_unknown_length_is_an_error() {
        let text = "fn f(u) { for k in 0..whole(u) { } return u; }";
        let program = Program::new(vec![Block::new("b", "").text(text)]).unwrap();
        let error = program.bound("f").unwrap_err().to_string();
        assert!(error.contains("fn f: the loop over `k` must say `at most`"), "{error}");
        let program = Program::new(vec![Block::new("b", "").text("fn f(u) { return u; }")]).unwrap();
        assert!(program.bound("g").unwrap_err().to_string().contains("no function `g`"));
    }
}
