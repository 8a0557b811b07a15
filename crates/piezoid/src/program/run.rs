//! Running a program here, number by number: what it gives in either precision, and what it takes.

use super::{Block, Expr, Holds, Op, Place, Program, Step, counted};
use crate::error::Error;
use std::collections::HashMap;

/// A program at work.
///
/// ```
/// use piezoid::program::{Block, Machine, Program};
/// let text = "fn sum(x: sum, u) { x.total += u; return x.total; }";
/// let program = Program::new(vec![Block::new("sum", "all so far").number("total", 0.0).text(text)])?;
/// let mut machine = Machine::new(&program, "sum", false);
/// machine.call("sum", &[0.1])?;
/// assert_eq!(machine.call("sum", &[0.2])?, [0.1 + 0.2]);
/// assert_eq!(machine.counts.sums, 2);
/// # Ok::<(), piezoid::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Machine<'p> {
    program: &'p Program,
    single: bool,
    /// States: the first is that of the machine, the others are those of the functions at work.
    states: Vec<Vec<f64>>,
    block: String,
    /// What it has taken so far.
    pub counts: Counts,
    /// The largest size of what each expression gave, of a machine that is watched.
    largest: Option<HashMap<*const Expr, f64>>,
}

/// Operations.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// Sums and differences of real numbers.
    pub sums: usize,
    /// Products.
    pub products: usize,
    /// Quotients.
    pub quotients: usize,
    /// Comparisons.
    pub comparisons: usize,
}

impl Counts {
    /// All together.
    pub fn total(&self) -> usize {
        self.sums + self.products + self.quotients + self.comparisons
    }
}

/// What a name stands for.
#[derive(Debug, Clone)]
enum Value<'p> {
    Real(f64),
    Whole(usize),
    Room(Vec<f64>),
    /// Which state, from where, and of what block.
    Part(usize, usize, &'p str),
}

type Names<'p> = HashMap<&'p str, Value<'p>>;

impl<'p> Machine<'p> {
    /// With the state of `block` at rest; in single precision, every result is rounded to it.
    pub fn new(program: &'p Program, block: &str, single: bool) -> Self {
        let round = |v: f64| if single { f64::from(v as f32) } else { v };
        let state = program.at_rest(block).into_iter().map(round).collect();
        Machine { program, single, states: vec![state], block: block.into(), counts: Counts::default(), largest: None }
    }

    /// The same, which from now on knows the [`largest`](Self::largest) of what each expression gave.
    pub fn watched(self) -> Self {
        Machine { largest: Some(HashMap::new()), ..self }
    }

    /// The largest size of what this expression of the program gave while the machine was watched, if it was reached.
    pub fn largest(&self, expr: &Expr) -> Option<f64> {
        self.largest.as_ref()?.get(&std::ptr::from_ref(expr)).copied()
    }

    /// The state, as one vector.
    pub fn state(&mut self) -> &mut [f64] {
        &mut self.states[0]
    }

    /// What the function called `name` gives for these numbers; of its parameters that are states, all are the machine's.
    ///
    /// # Errors
    /// [`Error::Content`] where there is no such function, or it counts beyond what there is.
    pub fn call(&mut self, name: &str, numbers: &[f64]) -> Result<Vec<f64>, Error> {
        let Some(function) = self.program.function(name) else {
            return wrong(format!("there is no function `{name}`"));
        };
        let block = self.program.block(&self.block).map_or("", |b| &b.name);
        let mut numbers = numbers.iter().map(|v| self.round(*v));
        let given = |takes: &super::Parameter| match takes.kind {
            super::Kind::Part(_) => Value::Part(0, 0, block),
            _ => Value::Real(numbers.next().unwrap_or(f64::NAN)),
        };
        let given = function.takes.iter().map(given).collect();
        self.enter(name, given)
    }

    fn round(&self, v: f64) -> f64 {
        if self.single { f64::from(v as f32) } else { v }
    }

    fn enter(&mut self, name: &str, given: Vec<Value<'p>>) -> Result<Vec<f64>, Error> {
        let program = self.program;
        let Some(function) = program.function(name) else { return wrong(format!("there is no function `{name}`")) };
        let states = self.states.len();
        let mut names: Names = function.takes.iter().map(|p| p.name.as_str()).zip(given).collect();
        self.steps(&function.steps, &mut names)?;
        let gives = function.returns.iter().map(|expr| self.real(expr, &mut names)).collect();
        self.states.truncate(states);
        gives
    }

    fn steps(&mut self, steps: &'p [Step], names: &mut Names<'p>) -> Result<(), Error> {
        steps.iter().try_for_each(|step| self.step(step, names))
    }

    fn step(&mut self, step: &'p Step, names: &mut Names<'p>) -> Result<(), Error> {
        match step {
            Step::Note(_) => {}
            Step::Let(new, Expr::Call(function, arguments)) if new.len() > 1 => {
                let gives = self.calling(function, arguments, names)?;
                names.extend(new.iter().map(String::as_str).zip(gives.into_iter().map(Value::Real)));
            }
            Step::Let(new, expr) => {
                let value = self.value(expr, names)?;
                names.insert(&new[0], value);
            }
            Step::Copy { name, of, block, zero } => {
                let (state, from, _) = self.part(of, names)?;
                let copy = self.states[state][from..from + self.program.order(block)].to_vec();
                self.states.push(if *zero { vec![0.0; copy.len()] } else { copy });
                names.insert(name, Value::Part(self.states.len() - 1, 0, block));
            }
            Step::Room(name, n) => drop(names.insert(name, Value::Room(vec![0.0; *n]))),
            Step::Set(place, expr) => {
                let value = self.value(expr, names)?;
                if place.path.is_empty() && place.index.is_none() {
                    names.insert(&place.root, value);
                } else if let Value::Real(v) = value {
                    *self.place(place, names)? = v;
                }
            }
            Step::Do(Expr::Call(function, arguments)) => drop(self.calling(function, arguments, names)?),
            Step::Do(_) => {}
            Step::If(holds, yes, no) => {
                let steps = if self.holds(holds, names)? { yes } else { no };
                self.steps(steps, names)?;
            }
            Step::For { name, from, to, down, steps } => {
                let (from, to) = (self.whole(from, names)?, self.whole(to, names)?);
                for k in from..to {
                    names.insert(name, Value::Whole(if *down { from + to - 1 - k } else { k }));
                    self.steps(steps, names)?;
                }
            }
            Step::While(holds, steps) => {
                while self.holds(holds, names)? {
                    self.steps(steps, names)?;
                }
            }
        }
        Ok(())
    }

    fn calling(&mut self, name: &str, arguments: &'p [Expr], names: &mut Names<'p>) -> Result<Vec<f64>, Error> {
        let mut given = Vec::with_capacity(arguments.len());
        for argument in arguments {
            given.push(match argument {
                Expr::Part(place) => {
                    let (state, from, block) = self.part(place, names)?;
                    Value::Part(state, from, block)
                }
                expr => self.value(expr, names)?,
            });
        }
        self.enter(name, given)
    }

    fn real(&mut self, expr: &'p Expr, names: &mut Names<'p>) -> Result<f64, Error> {
        match self.value(expr, names)? {
            Value::Real(v) => Ok(v),
            other => wrong(format!("{other:?} is no real number")),
        }
    }

    fn whole(&mut self, expr: &'p Expr, names: &mut Names<'p>) -> Result<usize, Error> {
        match self.value(expr, names)? {
            Value::Whole(i) => Ok(i),
            other => wrong(format!("{other:?} is no whole number")),
        }
    }

    fn value(&mut self, expr: &'p Expr, names: &mut Names<'p>) -> Result<Value<'p>, Error> {
        let value = self.computed(expr, names)?;
        if let (Some(largest), Value::Real(v)) = (&mut self.largest, &value) {
            let most = largest.entry(expr).or_insert(0.0);
            *most = most.max(v.abs());
        }
        Ok(value)
    }

    fn computed(&mut self, expr: &'p Expr, names: &mut Names<'p>) -> Result<Value<'p>, Error> {
        Ok(match expr {
            Expr::Real(v) => Value::Real(self.round(*v)),
            Expr::Whole(i) => Value::Whole(*i),
            Expr::Limit(limit) => Value::Real(limit.value(self.single)),
            Expr::Variable(name, _) => match names.get(name.as_str()) {
                Some(value) => value.clone(),
                None => return wrong(format!("`{name}` has no value yet")),
            },
            Expr::Constant(block, name, index) => {
                let k = index.as_ref().map_or(Ok(0), |index| self.whole(index, names))?;
                let constant = self.program.blocks[*block].constants.iter().find(|c| c.name == *name);
                match constant.and_then(|c| c.values.get(k)) {
                    Some(v) => Value::Real(self.round(*v)),
                    None => return wrong(format!("`{name}` has no number {k}")),
                }
            }
            Expr::At(place) => Value::Real(*self.place(place, names)?),
            Expr::Part(_) => return wrong("a state is no number".into()),
            Expr::Call(name, arguments) if name == "real" => Value::Real(self.whole(&arguments[0], names)? as f64),
            Expr::Call(name, arguments) if name == "whole" => {
                let v = self.real(&arguments[0], names)?;
                if !(0.0..1e9).contains(&v) {
                    return wrong(format!("{v} is taken for a whole number"));
                }
                Value::Whole(v as usize)
            }
            Expr::Call(name, arguments) => match counted::operation(name) {
                Some(operation) => {
                    let counts = arguments.iter().map(|a| match self.value(a, names)? {
                        Value::Whole(n) => Ok(n as f64),
                        Value::Real(v) => Ok(v),
                        other => wrong(format!("{other:?} is no count")),
                    });
                    Value::Real(operation(&counts.collect::<Result<Vec<f64>, Error>>()?))
                }
                None => Value::Real(self.calling(name, arguments, names)?[0]),
            },
            Expr::Negative(expr) => Value::Real(-self.real(expr, names)?),
            Expr::Binary(op, left, right) => {
                let (left, right) = (self.value(left, names)?, self.value(right, names)?);
                self.joined(*op, left, right)?
            }
        })
    }

    fn joined(&mut self, op: Op, left: Value<'p>, right: Value<'p>) -> Result<Value<'p>, Error> {
        match (left, right) {
            (Value::Real(a), Value::Real(b)) => {
                let count = match op {
                    Op::Add | Op::Subtract => &mut self.counts.sums,
                    Op::Multiply => &mut self.counts.products,
                    _ => &mut self.counts.quotients,
                };
                *count += 1;
                let result = match op {
                    Op::Add => a + b,
                    Op::Subtract => a - b,
                    Op::Multiply => a * b,
                    Op::Divide => a / b,
                    _ => return wrong(format!("{op:?} of real numbers is no number")),
                };
                Ok(Value::Real(self.round(result)))
            }
            (Value::Whole(a), Value::Whole(b)) => {
                let result = match op {
                    Op::Add => a.checked_add(b),
                    Op::Subtract => a.checked_sub(b),
                    Op::Multiply => a.checked_mul(b),
                    Op::Divide => a.checked_div(b),
                    Op::Remainder => a.checked_rem(b),
                    _ => None,
                };
                result
                    .map_or_else(|| wrong(format!("{op:?} of {a} and {b} is no whole number")), |i| Ok(Value::Whole(i)))
            }
            (left, right) => wrong(format!("{op:?} of {left:?} and {right:?}")),
        }
    }

    fn holds(&mut self, expr: &'p Expr, names: &mut Names<'p>) -> Result<bool, Error> {
        let Expr::Binary(op, left, right) = expr else { return wrong(format!("{expr:?} neither holds nor not")) };
        if matches!(op, Op::And | Op::Or) {
            let left = self.holds(left, names)?;
            return if left == (*op == Op::Or) { Ok(left) } else { self.holds(right, names) };
        }
        match (self.value(left, names)?, self.value(right, names)?) {
            (Value::Real(a), Value::Real(b)) => {
                self.counts.comparisons += 1;
                compared(*op, a, b)
            }
            (Value::Whole(a), Value::Whole(b)) => compared(*op, a, b),
            (a, b) => wrong(format!("{a:?} and {b:?} are not compared")),
        }
    }

    /// Which state the part at `place` is in, where it begins, and its block.
    fn part(&self, place: &Place, names: &Names<'p>) -> Result<(usize, usize, &'p str), Error> {
        let Some(Value::Part(state, from, block)) = names.get(place.root.as_str()) else {
            return wrong(format!("`{}` is no state", place.root));
        };
        let (mut from, mut block) = (*from, *block);
        for name in &place.path {
            let (offset, field) = self.field(block, name)?;
            from += offset;
            block = match &field.holds {
                Holds::Block(name) => name,
                _ => return wrong(format!("`{name}` is no state")),
            };
        }
        Ok((*state, from, block))
    }

    /// A field of a block, and how many numbers stand before it.
    fn field(&self, block: &str, name: &str) -> Result<(usize, &'p super::Field), Error> {
        let fields = self.program.block(block).map_or(&[][..], |b: &Block| &b.fields);
        let mut before = 0;
        for field in fields {
            if field.name == name {
                return Ok((before, field));
            }
            before += self.program.length(&field.holds);
        }
        wrong(format!("block `{block}` has no field `{name}`"))
    }

    fn place<'n>(&'n mut self, place: &'p Place, names: &'n mut Names<'p>) -> Result<&'n mut f64, Error> {
        let k = place.index.as_ref().map_or(Ok(0), |index| self.whole(index, names))?;
        let beyond = || Error::Content(format!("program: `{}` has no number {k}", place.root));
        let Some((last, path)) = place.path.split_last() else {
            return match names.get_mut(place.root.as_str()) {
                Some(Value::Room(room)) => room.get_mut(k).ok_or_else(beyond),
                _ => wrong(format!("`{}` is no room", place.root)),
            };
        };
        let outer = Place { root: place.root.clone(), path: path.to_vec(), index: None };
        let (state, from, block) = self.part(&outer, names)?;
        let (offset, field) = self.field(block, last)?;
        if k >= self.program.length(&field.holds) {
            return Err(beyond());
        }
        self.states[state].get_mut(from + offset + k).ok_or_else(beyond)
    }
}

fn compared<T: PartialOrd + std::fmt::Debug>(op: Op, a: T, b: T) -> Result<bool, Error> {
    Ok(match op {
        Op::Less => a < b,
        Op::AtMost => a <= b,
        Op::More => a > b,
        Op::AtLeast => a >= b,
        Op::Equal => a == b,
        Op::Unequal => a != b,
        _ => return wrong(format!("{op:?} of {a:?} and {b:?} neither holds nor not")),
    })
}

fn wrong<T>(what: String) -> Result<T, Error> {
    Err(Error::Content(format!("program: {what}")))
}
