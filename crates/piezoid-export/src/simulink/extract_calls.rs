//! A program in which every call that changes a state is a statement of its own.
//!
//! ```text
//! return linear(s.linear, crept) + offset;        let from_linear = linear(s.linear, crept);
//!                                                 return from_linear + offset;
//! ```
//! It is for languages in which a function returns a changed state together with its result. The order of the calls is
//! kept. Conditions do not change states, so they need no extraction.

use piezoid_models::program::{Expr, Function, Program, Statement};

/// Extracts the calls of a function that change a state.
pub(super) struct CallExtractor<'p> {
    program: &'p Program,
    known: Vec<String>,
}

impl<'p> CallExtractor<'p> {
    /// The same function with such calls as statements of their own.
    pub(super) fn of(function: &Function, program: &'p Program) -> Function {
        let mut alone = CallExtractor { program, known: known(function) };
        let mut steps = alone.steps(&function.steps);
        let returns = function.returns.iter().map(|expr| alone.lifted(expr, &mut steps)).collect();
        Function { steps, returns, ..function.clone() }
    }

    fn steps(&mut self, steps: &[Statement]) -> Vec<Statement> {
        let mut out = Vec::with_capacity(steps.len());
        for step in steps {
            let step = match step {
                Statement::Let(names, value) => Statement::Let(names.clone(), self.kept(value, &mut out)),
                Statement::Do(call) => Statement::Do(self.kept(call, &mut out)),
                Statement::Set(place, value) => Statement::Set(place.clone(), self.lifted(value, &mut out)),
                Statement::If(holds, yes, no) => Statement::If(holds.clone(), self.steps(yes), self.steps(no)),
                Statement::For { name, from, to, down, most, steps } => {
                    let (name, from, to) = (name.clone(), from.clone(), to.clone());
                    Statement::For { name, from, to, down: *down, most: *most, steps: self.steps(steps) }
                }
                Statement::While(holds, most, steps) => Statement::While(holds.clone(), *most, self.steps(steps)),
                step => step.clone(),
            };
            out.push(step);
        }
        out
    }

    /// `expr` with extracted arguments; a call that is a whole statement stays.
    fn kept(&mut self, expr: &Expr, out: &mut Vec<Statement>) -> Expr {
        match expr {
            Expr::Call(name, arguments) => {
                Expr::Call(name.clone(), arguments.iter().map(|a| self.lifted(a, out)).collect())
            }
            expr => self.lifted(expr, out),
        }
    }

    /// `expr` with a variable for each call that changes a state; the call is added to `out`.
    fn lifted(&mut self, expr: &Expr, out: &mut Vec<Statement>) -> Expr {
        match expr {
            Expr::Call(name, _) => {
                let call = self.kept(expr, out);
                if !self.program.function(name).is_some_and(|f| f.takes.iter().any(|p| p.changed)) {
                    return call;
                }
                let arguments = fresh(&format!("from_{name}"), &mut self.known);
                out.push(Statement::Let(vec![arguments.clone()], call));
                Expr::Variable(arguments, false)
            }
            Expr::Negative(inner) => Expr::Negative(Box::new(self.lifted(inner, out))),
            Expr::Binary(op, left, right) => {
                let left = self.lifted(left, out);
                Expr::Binary(*op, Box::new(left), Box::new(self.lifted(right, out)))
            }
            expr => expr.clone(),
        }
    }
}

/// The local names of a function.
pub(super) fn known(function: &Function) -> Vec<String> {
    let mut names: Vec<String> = function.takes.iter().map(|p| p.name.clone()).collect();
    let mut look = |step: &Statement| match step {
        Statement::Let(new, _) => names.extend(new.iter().cloned()),
        Statement::Copy { name, .. } | Statement::Array(name, _) | Statement::For { name, .. } => {
            names.push(name.clone())
        }
        _ => {}
    };
    function.steps.iter().for_each(|step| step.all(&mut look));
    names
}

/// `wish`, with a number appended if it is already known.
pub(super) fn fresh(wish: &str, known: &mut Vec<String>) -> String {
    let numbered = (2..).map(|k| format!("{wish}_{k}"));
    let name = std::iter::once(wish.to_owned()).chain(numbered).find(|name| !known.contains(name)).unwrap_or_default();
    known.push(name.clone());
    name
}
