//! A program with resolved names: closures over cells, one cell per stored number.

use super::run::{Work, wrong};
use super::{Expr, Function, Machine, Op, Place, Statement, ValueType, counted};
use piezoid_numerics::error::Error;
use std::collections::HashMap;
use std::rc::Rc;

/// A statement, an expression or a condition, ready to run.
type Closure<'p, T = f64> = Box<dyn Fn(&mut Work) -> T + 'p>;

/// A number of an expression. Most are constants and variables, which need no call.
struct Number<'p> {
    source: Source<'p>,
    /// In a watched machine, the cell with its largest absolute value.
    largest: Option<usize>,
}

enum Source<'p> {
    Constant(f64),
    Cell(usize),
    Computed(Closure<'p>),
}

impl<'p> Number<'p> {
    fn constant(v: f64) -> Self {
        Source::Constant(v).into()
    }

    fn computed(value: impl Fn(&mut Work) -> f64 + 'p) -> Self {
        Source::Computed(Box::new(value)).into()
    }

    /// Its value now.
    fn at(&self, w: &mut Work) -> f64 {
        let v = match &self.source {
            Source::Constant(v) => *v,
            Source::Cell(at) => w.cells[*at],
            Source::Computed(value) => value(w),
        };
        if let Some(at) = self.largest {
            w.cells[at] = w.cells[at].max(0.0).max(v.abs());
        }
        v
    }

    fn then(self, act: impl Fn(&mut Work, f64) -> f64 + 'p) -> Self {
        Number::computed(move |w| {
            let v = self.at(w);
            act(w, v)
        })
    }
}

impl<'p> From<Source<'p>> for Number<'p> {
    fn from(source: Source<'p>) -> Self {
        Number { source, largest: None }
    }
}

/// A function with its own cells: there is no recursion.
#[derive(Clone)]
pub(super) struct ResolvedFunction<'p> {
    pub(super) run: Rc<dyn Fn(&mut Work) + 'p>,
    /// First cell of its parameters, and of its returned values.
    pub(super) takes: usize,
    pub(super) gives: usize,
}

/// A machine while the names of its program are resolved.
pub(super) struct Resolver<'p> {
    pub(super) machine: Machine<'p>,
    /// Cell and type of each name of the present function. For a state or an array the cell contains its first
    /// position.
    pub(super) names: HashMap<&'p str, (usize, ValueType)>,
}

impl<'p> Resolver<'p> {
    pub(super) fn function(&mut self, function: &'p Function) {
        self.names.clear();
        let takes = self.machine.work.cells.len();
        for parameter in &function.takes {
            self.name(&parameter.name, parameter.kind.clone(), 0);
        }
        let steps = self.steps(&function.steps);
        let gives = self.room(function.returns.len());
        let returns: Vec<Number> = function.returns.iter().map(|expr| self.result(expr)).collect();
        let run = Rc::new(move |w: &mut Work| {
            steps(w);
            for (k, value) in returns.iter().enumerate() {
                w.cells[gives + k] = value.at(w);
            }
        });
        self.machine.ready.push(ResolvedFunction { run, takes, gives });
    }

    /// A returned number; an error is reported only when it is computed.
    fn result(&mut self, expr: &'p Expr) -> Number<'p> {
        self.of(&ValueType::Real, expr).unwrap_or_else(|error| Source::Computed(later(Err(error))).into())
    }

    /// Allocates `n` cells; returns the first.
    fn room(&mut self, n: usize) -> usize {
        let at = self.machine.work.cells.len();
        self.machine.work.cells.resize(at + n, 0.0);
        at
    }

    /// Allocates a cell for a new name, which contains the position of the `n` cells after it.
    fn name(&mut self, name: &'p str, kind: ValueType, n: usize) -> usize {
        let at = self.room(1 + n);
        self.machine.work.cells[at] = (at + 1) as f64;
        self.names.insert(name, (at, kind));
        at
    }

    /// Statements; the closure returns true if there was no error.
    fn steps(&mut self, steps: &'p [Statement]) -> Closure<'p, bool> {
        let steps: Vec<Closure<()>> = steps.iter().map(|step| later(self.step(step))).collect();
        Box::new(move |w| {
            for step in &steps {
                if w.wrong.is_none() {
                    step(w);
                }
            }
            w.wrong.is_none()
        })
    }

    fn step(&mut self, step: &'p Statement) -> Result<Closure<'p, ()>, Error> {
        Ok(match step {
            Statement::Let(new, Expr::Call(function, arguments)) if new.len() > 1 => {
                let (call, gives) = self.call(function, arguments)?;
                let (to, n) = (self.machine.work.cells.len(), new.len());
                for name in new {
                    self.name(name, ValueType::Real, 0);
                }
                Box::new(move |w| {
                    call(w);
                    w.cells.copy_within(gives..gives + n, to);
                })
            }
            Statement::Let(new, expr) => {
                let (value, kind) = self.value(expr)?;
                let to = self.name(&new[0], kind, 0);
                Box::new(move |w| w.cells[to] = value.at(w))
            }
            Statement::Copy { name, of, block, zero } => {
                let ((begins, before, _), n, zero) = (self.meant(of)?, self.machine.program.order(block), *zero);
                let to = self.name(name, ValueType::Part(block.clone()), n) + 1;
                Box::new(move |w| {
                    let from = w.cells[begins] as usize + before;
                    w.cells.copy_within(from..from + n, to);
                    w.cells[to..if zero { to + n } else { to }].fill(0.0);
                })
            }
            Statement::Array(name, n) => {
                let (to, n) = (self.name(name, ValueType::Array(*n), *n) + 1, *n);
                Box::new(move |w| w.cells[to..to + n].fill(0.0))
            }
            Statement::Set(place, expr) => {
                let (value, place) = (self.value(expr)?.0, self.place(place)?);
                Box::new(move |w| {
                    let v = value.at(w);
                    place(w).into_iter().for_each(|at| w.cells[at] = v);
                })
            }
            Statement::Do(Expr::Call(function, arguments)) => self.call(function, arguments)?.0,
            Statement::Note(_) | Statement::Do(_) => Box::new(|_| {}),
            Statement::If(holds, yes, no) => {
                let (holds, yes, no) = (self.holds(holds)?, self.steps(yes), self.steps(no));
                Box::new(move |w| {
                    if holds(w) {
                        yes(w)
                    } else {
                        no(w)
                    };
                })
            }
            Statement::For { name, from, to, down, most, steps } => {
                let (from, to, down) = (self.of(&ValueType::Integer, from)?, self.of(&ValueType::Integer, to)?, *down);
                let (at, steps) = (self.name(name, ValueType::Integer, 0), self.steps(steps));
                let most = most.unwrap_or(usize::MAX);
                Box::new(move |w| {
                    let (from, to) = (from.at(w) as usize, to.at(w) as usize);
                    if to.saturating_sub(from) > most {
                        w.fail(format!("the loop over `{name}` takes more than {most} passes"));
                    }
                    (from..to).all(|k| {
                        w.cells[at] = if down { from + to - 1 - k } else { k } as f64;
                        steps(w)
                    });
                })
            }
            Statement::While(holds, most, steps) => {
                let (holds, most, steps) = (self.holds(holds)?, *most, self.steps(steps));
                Box::new(move |w| {
                    let mut passes = 0;
                    while holds(w) && steps(w) {
                        passes += 1;
                        if passes > most {
                            w.fail(format!("a loop takes more than {most} passes"));
                        }
                    }
                })
            }
        })
    }

    /// A call, and the first cell of its results.
    fn call(&mut self, name: &str, arguments: &'p [Expr]) -> Result<(Closure<'p, ()>, usize), Error> {
        let (function, ResolvedFunction { run, takes, gives }) = self.machine.ready(name)?;
        let inputs = function.takes.iter().zip(arguments).map(|(takes, argument)| self.of(&takes.kind, argument));
        let inputs = inputs.collect::<Result<Vec<_>, Error>>()?;
        // All arguments are evaluated before one is passed, because an argument may call the same function.
        let room = self.room(inputs.len());
        let call = move |w: &mut Work| {
            for (k, value) in inputs.iter().enumerate() {
                w.cells[room + k] = value.at(w);
            }
            w.cells.copy_within(room..room + inputs.len(), takes);
            run(w);
        };
        Ok((Box::new(call), gives))
    }

    /// A number of type `kind`, or the position of a state of this type.
    fn of(&mut self, kind: &ValueType, expr: &'p Expr) -> Result<Number<'p>, Error> {
        let (value, known) = match expr {
            Expr::Part(place) => {
                let (begins, before, known) = self.meant(place)?;
                (Number::computed(move |w| w.cells[begins] + before as f64), known)
            }
            expr => self.value(expr)?,
        };
        if known == *kind { Ok(value) } else { wrong(format!("{expr:?} is {known:?}, not {kind:?}")) }
    }

    /// A number and its type.
    fn value(&mut self, expr: &'p Expr) -> Result<(Number<'p>, ValueType), Error> {
        let (mut value, kind) = self.computed(expr)?;
        let at = self.machine.work.cells.len();
        if let Some(largest) = self.machine.largest.as_mut().filter(|_| kind == ValueType::Real) {
            largest.insert(expr, at);
            self.machine.work.cells.push(-1.0);
            value.largest = Some(at);
        }
        Ok((value, kind))
    }

    fn computed(&mut self, expr: &'p Expr) -> Result<(Number<'p>, ValueType), Error> {
        let value = match expr {
            Expr::Real(v) => Number::constant(self.machine.work.round(*v)),
            Expr::Integer(i) => return Ok((Number::constant(*i as f64), ValueType::Integer)),
            Expr::Limit(limit) => Number::constant(limit.value(self.machine.work.single)),
            Expr::Variable(name, _) => match self.names.get(name.as_str()).cloned() {
                Some((at, kind)) => return Ok((Source::Cell(at).into(), kind)),
                None => return wrong(format!("`{name}` has no value yet")),
            },
            Expr::Constant(block, name, index) => {
                let constant = self.machine.program.blocks[*block].constants.iter().find(|c| c.name == *name);
                let values = constant.map_or(&[][..], |c| &c.values);
                match (index, values) {
                    (None, [v, ..]) => Number::constant(self.machine.work.round(*v)),
                    (index, _) => {
                        let first = Ok(Number::constant(0.0));
                        let index = index.as_ref().map_or(first, |index| self.of(&ValueType::Integer, index))?;
                        index.then(move |w, k| match values.get(k as usize) {
                            Some(v) => w.round(*v),
                            None => w.fail(format!("`{name}` has no element {k}")),
                        })
                    }
                }
            }
            Expr::At(place) => {
                let place = self.place(place)?;
                Number::computed(move |w| place(w).map_or(f64::NAN, |at| w.cells[at]))
            }
            Expr::Part(_) => return wrong("a state is not a number".into()),
            Expr::Call(name, arguments) if name == "real" => self.of(&ValueType::Integer, &arguments[0])?,
            Expr::Call(name, arguments) if name == "whole" => {
                let value = self.of(&ValueType::Real, &arguments[0])?;
                let whole = value.then(|w, v| {
                    let fits = (0.0..1e9).contains(&v);
                    if fits { v.trunc() } else { w.fail(format!("{v} cannot be converted to an integer")) }
                });
                return Ok((whole, ValueType::Integer));
            }
            Expr::Call(name, arguments) => match counted::operation(name) {
                Some(operation) => {
                    let inputs = arguments.iter().map(|a| Ok(self.value(a)?.0)).collect::<Result<Vec<_>, Error>>()?;
                    Number::computed(move |w| {
                        let mut counts = [0.0; 3];
                        counts.iter_mut().zip(&inputs).for_each(|(count, value)| *count = value.at(w));
                        w.operations += 1;
                        operation(&counts)
                    })
                }
                None => {
                    let (call, gives) = self.call(name, arguments)?;
                    Number::computed(move |w| {
                        call(w);
                        w.cells[gives]
                    })
                }
            },
            Expr::Negative(expr) => self.of(&ValueType::Real, expr)?.then(|_, v| -v),
            Expr::Binary(op, left, right) => {
                let (a, kind) = self.value(left)?;
                let (b, op) = (self.of(&kind, right)?, *op);
                let value = match (&kind, op) {
                    (ValueType::Real, Op::Add) => both(a, b, |w, a, b| w.real(Op::Add, a, b)),
                    (ValueType::Real, Op::Subtract) => both(a, b, |w, a, b| w.real(Op::Subtract, a, b)),
                    (ValueType::Real, Op::Multiply) => both(a, b, |w, a, b| w.real(Op::Multiply, a, b)),
                    (ValueType::Real, _) => both(a, b, move |w, a, b| w.real(op, a, b)),
                    _ => both(a, b, move |w, a, b| w.whole(op, a, b)),
                };
                return Ok((Source::Computed(value).into(), kind));
            }
        };
        Ok((value, ValueType::Real))
    }

    fn holds(&mut self, expr: &'p Expr) -> Result<Closure<'p, bool>, Error> {
        let Expr::Binary(op, left, right) = expr else { return wrong(format!("{expr:?} is not a condition")) };
        if matches!(op, Op::And | Op::Or) {
            let (left, right, enough) = (self.holds(left)?, self.holds(right)?, *op == Op::Or);
            return Ok(Box::new(move |w| if left(w) == enough { enough } else { right(w) }));
        }
        let (a, kind) = self.value(left)?;
        let (b, counts) = (self.of(&kind, right)?, usize::from(kind == ValueType::Real));
        let compares = match op {
            Op::Less => f64::lt,
            Op::AtMost => f64::le,
            Op::More => f64::gt,
            Op::AtLeast => f64::ge,
            Op::Equal => f64::eq,
            Op::Unequal => f64::ne,
            _ => return wrong(format!("{op:?} of {kind:?} is not a condition")),
        };
        Ok(both(a, b, move |w, a, b| {
            w.counts.comparisons += counts;
            w.operations += 1;
            compares(&a, &b)
        }))
    }

    /// The cell of the root of a place, the offset of the place, and its type.
    fn meant(&self, place: &Place) -> Result<(usize, usize, ValueType), Error> {
        let Some((begins, kind)) = self.names.get(place.root.as_str()) else {
            return wrong(format!("`{}` has no value yet", place.root));
        };
        let (before, kind) = self.machine.program.within(kind.clone(), &place.path).or_else(wrong)?;
        Ok((*begins, before, kind))
    }

    /// The cell of a number, if its index is in range.
    fn place(&mut self, place: &'p Place) -> Result<Closure<'p, Option<usize>>, Error> {
        Ok(match (self.meant(place)?, &place.index) {
            ((at, _, ValueType::Real | ValueType::Integer), None) if place.path.is_empty() => {
                Box::new(move |_| Some(at))
            }
            ((begins, before, ValueType::Real), None) => Box::new(move |w| Some(w.cells[begins] as usize + before)),
            ((begins, before, ValueType::Array(n)), Some(index)) => {
                let index = self.of(&ValueType::Integer, index)?;
                Box::new(move |w| {
                    let k = index.at(w) as usize;
                    if k >= n {
                        w.fail(format!("`{}` has no element {k}", place.root));
                    }
                    (k < n).then(|| w.cells[begins] as usize + before + k)
                })
            }
            _ => return wrong(format!("`{}` is not a number", place.root)),
        })
    }
}

/// An error is reported only when the statement is run.
fn later<'p, T: Default + 'p>(act: Result<Closure<'p, T>, Error>) -> Closure<'p, T> {
    act.unwrap_or_else(|error| {
        Box::new(move |w| {
            w.wrong.get_or_insert_with(|| error.clone());
            T::default()
        })
    })
}

fn both<'p, T>(a: Number<'p>, b: Number<'p>, act: impl Fn(&mut Work, f64, f64) -> T + 'p) -> Closure<'p, T> {
    Box::new(move |w| {
        let (a, b) = (a.at(w), b.at(w));
        act(w, a, b)
    })
}
