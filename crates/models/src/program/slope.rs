//! Differentiation of a program: every number that depends on the input gets a slope.
//!
//! ```text
//! (a + b)' = a' + b'    (a b)' = a' b + a b'    (a / b)' = (a' - (a / b) b') / b    f(a)' = f_derivative(a) a'
//! ```
//! The rules and the order of the arithmetic are those of the dual numbers of the hysteresis laws. A function `f` with
//! an `f_derivative` is not differentiated itself; a parameter `value` of the derivative is f(a), so that it need not
//! be computed twice. Comparisons use only the values: at a kink the slope is that of the selected side.
//!
//! Reference: R. E. Wengert, Commun. ACM 7 (1964), DOI 10.1145/355586.364791. Functions that copy states are not
//! supported.

use super::{Argument, Expr, Function, Op, Place, Program, Statement, ValueType};
use piezoid_numerics::error::Error;
use std::collections::{BTreeMap, BTreeSet};

/// Name of the slope of `name`.
fn slope_of(name: &str) -> String {
    format!("{name}_slope")
}

/// Name of the given derivative of `name`.
fn derivative_of(name: &str) -> String {
    format!("{name}_derivative")
}

impl Program {
    /// Adds the function `name_slope` to the function `name`, and what it needs. Each state and number that it takes or
    /// returns is followed by its slope.
    ///
    /// ```
    /// use piezoid_models::program::{Block, Machine, Program};
    /// let text = "fn square(u) { return u * u; }";
    /// let mut program = Program::new(vec![Block::new("square", "").text(text)])?;
    /// program.slope("square")?;
    /// assert_eq!(Machine::new(&program, "square", false).call("square_slope", &[3.0, 1.0])?, [9.0, 6.0]);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Content`] if there is no such function, or if it copies states.
    pub fn slope(&mut self, name: &str) -> Result<(), Error> {
        let unknown = || Error::Content(format!("program: there is no function `{name}`"));
        let root = self.function(name).ok_or_else(unknown)?;
        let mut moving = Dependent::default();
        moving.takes.insert(name.into(), vec![true; root.takes.len()]);
        loop {
            let before = moving.clone();
            for function in &self.functions {
                moving.watch(self, function);
            }
            if moving == before {
                break;
            }
        }
        let mut result = Vec::new();
        for function in self.functions.iter().filter(|f| moving.takes.contains_key(&f.name)) {
            result.push(Slopes { program: self, moving: &moving, function, temporaries: 0 }.function()?);
        }
        self.functions.extend(result);
        Ok(())
    }

    /// True if the derivative of `name` is given.
    fn known(&self, name: &str) -> bool {
        self.function(&derivative_of(name)).is_some()
    }
}

/// The parts of a program that depend on the input.
#[derive(Debug, Clone, Default, PartialEq)]
struct Dependent {
    /// For each function with dependent arguments, the dependent parameters.
    takes: BTreeMap<String, Vec<bool>>,
    /// Variables: (function, name).
    names: BTreeSet<(String, String)>,
    /// Fields of states: (block, field).
    fields: BTreeSet<(String, String)>,
    /// Functions with dependent results.
    returns: BTreeSet<String>,
}

impl Dependent {
    fn watch(&mut self, program: &Program, function: &Function) {
        let Some(takes) = self.takes.get(&function.name).cloned() else { return };
        for (parameter, _) in function.takes.iter().zip(takes).filter(|(p, moves)| *moves && p.kind == ValueType::Real)
        {
            self.names.insert((function.name.clone(), parameter.name.clone()));
        }
        for step in &function.steps {
            step.all(&mut |step| match step {
                Statement::Let(names, expr) if self.expr(program, function, expr) => {
                    self.names.extend(names.iter().map(|name| (function.name.clone(), name.clone())));
                }
                Statement::Set(place, expr) if self.expr(program, function, expr) => {
                    match field(program, function, place) {
                        Some(field) => self.fields.insert(field),
                        None => self.names.insert((function.name.clone(), place.root.clone())),
                    };
                }
                Statement::Do(expr) => drop(self.expr(program, function, expr)),
                _ => {}
            });
        }
        if function.returns.iter().any(|expr| self.expr(program, function, expr)) {
            self.returns.insert(function.name.clone());
        }
    }

    /// True if the number at `place` depends on the input.
    fn place(&self, program: &Program, function: &Function, place: &Place) -> bool {
        match field(program, function, place) {
            Some(field) => self.fields.contains(&field),
            None => self.names.contains(&(function.name.clone(), place.root.clone())),
        }
    }

    /// True if `expr` depends on the input. Records dependent arguments of the functions in it.
    fn expr(&mut self, program: &Program, function: &Function, expr: &Expr) -> bool {
        match expr {
            Expr::Variable(name, whole) => !whole && self.names.contains(&(function.name.clone(), name.clone())),
            Expr::At(place) => self.place(program, function, place),
            Expr::Negative(inner) => self.expr(program, function, inner),
            Expr::Binary(op, left, right) if op.precedence() >= Op::Add.precedence() => {
                let (left, right) = (self.expr(program, function, left), self.expr(program, function, right));
                left || right
            }
            Expr::Call(name, arguments) => {
                let moves: Vec<bool> =
                    arguments.iter().map(|a| matches!(a, Expr::Part(_)) || self.expr(program, function, a)).collect();
                if program.known(name) || name == "real" || name == "whole" {
                    return moves.contains(&true) && name != "real" && name != "whole";
                }
                if moves.contains(&true) {
                    let known = self.takes.entry(name.clone()).or_insert_with(|| vec![false; moves.len()]);
                    known.iter_mut().zip(moves).for_each(|(known, moves)| *known |= moves);
                }
                self.returns.contains(name)
            }
            _ => false,
        }
    }
}

/// Block and field of a place in a state.
fn field(program: &Program, function: &Function, place: &Place) -> Option<(String, String)> {
    let parameter = function.takes.iter().find(|p| p.name == place.root)?;
    let (last, path) = place.path.split_last()?;
    match program.within(parameter.kind.clone(), path) {
        Ok((_, ValueType::Part(block))) => Some((block, last.clone())),
        _ => None,
    }
}

/// Writes a function with slopes.
struct Slopes<'p> {
    program: &'p Program,
    moving: &'p Dependent,
    function: &'p Function,
    temporaries: usize,
}

impl Slopes<'_> {
    fn function(mut self) -> Result<Function, Error> {
        let mut takes = Vec::new();
        for (parameter, moves) in self.function.takes.iter().zip(&self.moving.takes[&self.function.name]) {
            takes.push(parameter.clone());
            if *moves {
                takes.push(Argument { name: slope_of(&parameter.name), ..parameter.clone() });
            }
        }
        let mut steps = self.steps(&self.function.steps)?;
        let mut returns = Vec::new();
        for expr in &self.function.returns {
            let (value, slope) = self.dual(expr, &mut steps)?;
            returns.extend([value, slope.unwrap_or(Expr::Real(0.0))]);
        }
        let about = vec![format!("As {}, with slopes beside what moves.", self.function.name)];
        let block = self.function.block;
        let mut function = Function { block, about, name: slope_of(&self.function.name), takes, steps, returns };
        while function.remove_unread() {}
        Ok(function)
    }

    fn moves(&self, name: &str) -> bool {
        self.moving.names.contains(&(self.function.name.clone(), name.into()))
    }

    /// True if a call has a slope, or may change a state with one.
    fn moves_along(&self, name: &str, arguments: &[Expr]) -> bool {
        let known = self.moving.takes.contains_key(name);
        known && (self.moving.returns.contains(name) || arguments.iter().any(|a| matches!(a, Expr::Part(_))))
    }

    fn steps(&mut self, steps: &[Statement]) -> Result<Vec<Statement>, Error> {
        let mut out = Vec::new();
        for step in steps {
            match step {
                Statement::Note(_) => out.push(step.clone()),
                Statement::Let(names, expr) => {
                    let (value, slope) = self.dual(expr, &mut out)?;
                    out.push(Statement::Let(names.clone(), value));
                    if self.moves(&names[0]) {
                        out.push(Statement::Let(vec![slope_of(&names[0])], slope.unwrap_or(Expr::Real(0.0))));
                    }
                }
                Statement::Array(name, n) => {
                    out.push(step.clone());
                    if self.moves(name) {
                        out.push(Statement::Array(slope_of(name), *n));
                    }
                }
                Statement::Set(place, expr) => {
                    let (value, slope) = self.dual(expr, &mut out)?;
                    if self.moving.place(self.program, self.function, place) {
                        // The slope first: it may need the old value.
                        let beside = Place { root: slope_of(&place.root), ..place.clone() };
                        out.push(Statement::Set(beside, slope.unwrap_or(Expr::Real(0.0))));
                    }
                    out.push(Statement::Set(place.clone(), value));
                }
                Statement::Do(expr) => drop(self.dual(expr, &mut out)?),
                Statement::If(holds, yes, no) => {
                    let (yes, no) = (self.steps(yes)?, self.steps(no)?);
                    out.push(Statement::If(holds.clone(), yes, no));
                }
                Statement::For { name, from, to, down, most, steps } => {
                    let steps = self.steps(steps)?;
                    let (name, from, to) = (name.clone(), from.clone(), to.clone());
                    out.push(Statement::For { name, from, to, down: *down, most: *most, steps });
                }
                Statement::While(holds, most, steps) => {
                    out.push(Statement::While(holds.clone(), *most, self.steps(steps)?));
                }
                Statement::Copy { name, .. } => {
                    let what = format!("program: `{name}` is a copied state and has no slope");
                    return Err(Error::Content(what));
                }
            }
        }
        Ok(out)
    }

    /// `expr` in a form that can be used twice: a variable if it is not one already.
    fn once(&mut self, expr: Expr, out: &mut Vec<Statement>) -> Expr {
        if !matches!(expr, Expr::Negative(_) | Expr::Binary(..) | Expr::Call(..)) {
            return expr;
        }
        let name = self.temporary();
        out.push(Statement::Let(vec![name.clone()], expr));
        Expr::Variable(name, false)
    }

    fn temporary(&mut self) -> String {
        self.temporaries += 1;
        format!("part_{}", self.temporaries)
    }

    /// The value and, if any, the slope; common parts are added to `out`.
    fn dual(&mut self, expr: &Expr, out: &mut Vec<Statement>) -> Result<(Expr, Option<Expr>), Error> {
        Ok(match expr {
            Expr::Variable(name, false) if self.moves(name) => {
                (expr.clone(), Some(Expr::Variable(slope_of(name), false)))
            }
            Expr::At(place) => {
                let moves = self.moving.place(self.program, self.function, place);
                let beside = Place { root: slope_of(&place.root), ..place.clone() };
                (expr.clone(), moves.then_some(Expr::At(beside)))
            }
            Expr::Negative(inner) => {
                let (value, slope) = self.dual(inner, out)?;
                (negative(value), slope.map(negative))
            }
            Expr::Binary(op, left, right) if op.precedence() >= Op::Add.precedence() && !expr.whole() => {
                let ((left, left_slope), (right, right_slope)) = (self.dual(left, out)?, self.dual(right, out)?);
                self.joined(*op, (left, left_slope), (right, right_slope), out)
            }
            Expr::Call(name, arguments) if self.program.known(name) => {
                let (argument, slope) = self.dual(&arguments[0], out)?;
                let Some(slope) = slope else { return Ok((Expr::Call(name.clone(), vec![argument]), None)) };
                let argument = self.once(argument, out);
                let value = self.once(Expr::Call(name.clone(), vec![argument.clone()]), out);
                let derivative = derivative_of(name);
                let takes = self.program.function(&derivative).map_or(&[][..], |f| &f.takes);
                let values = |p: &Argument| if p.name == "value" { value.clone() } else { argument.clone() };
                let derivative = Expr::Call(derivative, takes.iter().map(values).collect());
                (value, Some(binary(Op::Multiply, derivative, slope)))
            }
            Expr::Call(name, arguments) if self.moves_along(name, arguments) => {
                let mut values = Vec::new();
                for (argument, moves) in arguments.iter().zip(&self.moving.takes[name]) {
                    let beside = match argument {
                        Expr::Part(place) => {
                            values.push(argument.clone());
                            Expr::Part(Place { root: slope_of(&place.root), ..place.clone() })
                        }
                        argument => {
                            let (value, slope) = self.dual(argument, out)?;
                            values.push(value);
                            slope.unwrap_or(Expr::Real(0.0))
                        }
                    };
                    if *moves {
                        values.push(beside);
                    }
                }
                let call = Expr::Call(slope_of(name), values);
                let returns = self.program.function(name).map_or(0, |f| f.returns.len());
                if returns == 0 {
                    out.push(Statement::Do(call));
                    return Ok((Expr::Real(0.0), None));
                }
                let value = self.temporary();
                let slope = slope_of(&value);
                out.push(Statement::Let(vec![value.clone(), slope.clone()], call));
                let moves = self.moving.returns.contains(name);
                (Expr::Variable(value, false), moves.then_some(Expr::Variable(slope, false)))
            }
            _ => (expr.clone(), None),
        })
    }

    fn joined(
        &mut self,
        op: Op,
        (left, left_slope): (Expr, Option<Expr>),
        (right, right_slope): (Expr, Option<Expr>),
        out: &mut Vec<Statement>,
    ) -> (Expr, Option<Expr>) {
        match (op, left_slope, right_slope) {
            (_, None, None) => (binary(op, left, right), None),
            (Op::Add | Op::Subtract, Some(a), Some(b)) => (binary(op, left, right), Some(binary(op, a, b))),
            (Op::Subtract, None, Some(b)) => (binary(op, left, right), Some(negative(b))),
            (Op::Add | Op::Subtract, a, b) => (binary(op, left, right), a.or(b)),
            (Op::Multiply, Some(a), None) => {
                let right = self.once(right, out);
                (binary(op, left, right.clone()), Some(binary(op, a, right)))
            }
            (Op::Multiply, None, Some(b)) => {
                let left = self.once(left, out);
                (binary(op, left.clone(), right), Some(binary(op, left, b)))
            }
            (Op::Multiply, Some(a), Some(b)) => {
                let (left, right) = (self.once(left, out), self.once(right, out));
                let slope = binary(Op::Add, binary(op, a, right.clone()), binary(op, left.clone(), b));
                (binary(op, left, right), Some(slope))
            }
            (_, a, b) => {
                let right = self.once(right, out);
                let value = binary(op, left, right.clone());
                let Some(b) = b else { return (value, a.map(|a| binary(op, a, right))) };
                let value = self.once(value, out);
                let lost = binary(Op::Multiply, value.clone(), b);
                let left = a.map_or_else(|| negative(lost.clone()), |a| binary(Op::Subtract, a, lost.clone()));
                (value, Some(binary(op, left, right)))
            }
        }
    }
}

fn binary(op: Op, left: Expr, right: Expr) -> Expr {
    Expr::Binary(op, Box::new(left), Box::new(right))
}

fn negative(expr: Expr) -> Expr {
    Expr::Negative(Box::new(expr))
}
