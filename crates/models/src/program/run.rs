//! Running a program in single or double precision, with counts of its operations.

use super::resolve::{ResolvedFunction, Resolver};
use super::{Expr, Function, Op, Program, ValueType};
use piezoid_numerics::error::Error;
use std::collections::HashMap;

/// An interpreter of a program with a state.
///
/// ```
/// use piezoid_models::program::{Block, Machine, Program};
/// let text = "fn sum(x: sum, u) { x.total += u; return x.total; }";
/// let program = Program::new(vec![Block::new("sum", "all so far").number("total", 0.0).text(text)])?;
/// let mut machine = Machine::new(&program, "sum", false);
/// machine.call("sum", &[0.1])?;
/// assert_eq!(machine.call("sum", &[0.2])?, [0.1 + 0.2]);
/// assert_eq!(machine.counts.sums, 2);
/// # Ok::<(), piezoid::Error>(())
/// ```
#[derive(Clone)]
pub struct Machine<'p> {
    pub(super) program: &'p Program,
    block: String,
    pub(super) work: Work,
    /// The functions, in the order of the program.
    pub(super) ready: Vec<ResolvedFunction<'p>>,
    /// Operations on real numbers so far.
    pub counts: Counts,
    /// Operations and comparisons so far, those of integers included.
    pub operations: usize,
    /// In a watched machine, the cell with the largest absolute value of each expression; negative before the first
    /// value.
    pub(super) largest: Option<HashMap<*const Expr, usize>>,
}

/// Numbers of operations on real numbers.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Counts {
    /// Sums and differences of real numbers.
    pub sums: usize,
    /// Multiplications.
    pub products: usize,
    /// Divisions.
    pub quotients: usize,
    /// Comparisons.
    pub comparisons: usize,
}

impl Counts {
    /// Their sum.
    pub fn total(&self) -> usize {
        self.sums + self.products + self.quotients + self.comparisons
    }
}

/// The memory of a machine.
#[derive(Debug, Clone)]
pub(super) struct Work {
    /// The state, then the variables of functions. Integers and positions of states are stored here too, exact below
    /// 2^53.
    pub(super) cells: Vec<f64>,
    pub(super) single: bool,
    pub(super) counts: Counts,
    pub(super) operations: usize,
    /// The first error. After it no statement is run.
    pub(super) wrong: Option<Error>,
}

impl Work {
    pub(super) fn round(&self, v: f64) -> f64 {
        if self.single { f64::from(v as f32) } else { v }
    }

    /// A binary operation on real numbers.
    pub(super) fn real(&mut self, op: Op, a: f64, b: f64) -> f64 {
        let (count, v) = match op {
            Op::Add => (&mut self.counts.sums, a + b),
            Op::Subtract => (&mut self.counts.sums, a - b),
            Op::Multiply => (&mut self.counts.products, a * b),
            Op::Divide => (&mut self.counts.quotients, a / b),
            _ => return self.fail(format!("{op:?} of real numbers is not a number")),
        };
        *count += 1;
        self.operations += 1;
        self.round(v)
    }

    /// A binary operation on integers.
    pub(super) fn whole(&mut self, op: Op, a: f64, b: f64) -> f64 {
        let v = match op {
            Op::Add => a + b,
            Op::Subtract => a - b,
            Op::Multiply => a * b,
            Op::Divide => (a / b).trunc(),
            Op::Remainder => a % b,
            _ => f64::NAN,
        };
        self.operations += 1;
        let fits = (0.0..1.0 / f64::EPSILON).contains(&v);
        if fits { v } else { self.fail(format!("{op:?} of {a} and {b} is not an integer in range")) }
    }

    pub(super) fn fail(&mut self, what: String) -> f64 {
        self.wrong.get_or_insert(Error::Content(format!("program: {what}")));
        f64::NAN
    }
}

impl<'p> Machine<'p> {
    /// A machine with the state of `block` at rest. If `single`, every result is rounded to single precision.
    pub fn new(program: &'p Program, block: &str, single: bool) -> Self {
        let mut work = Work { cells: Vec::new(), single, counts: Counts::default(), operations: 0, wrong: None };
        work.cells = program.at_rest(block).into_iter().map(|v| work.round(v)).collect();
        let (block, ready) = (block.into(), Vec::new());
        Machine { program, block, work, ready, counts: Counts::default(), operations: 0, largest: None }.resolved()
    }

    fn resolved(self) -> Self {
        let (functions, names) = (&self.program.functions, HashMap::new());
        let mut resolver = Resolver { machine: self, names };
        functions.iter().for_each(|function| resolver.function(function));
        resolver.machine
    }

    /// The same machine, which from now on records the [`largest`](Self::largest) value of each expression.
    pub fn watched(mut self) -> Self {
        self.work.cells.truncate(self.program.order(&self.block));
        Machine { ready: Vec::new(), largest: Some(HashMap::new()), ..self }.resolved()
    }

    /// The largest absolute value of this expression of the program since [`watched`](Self::watched), if it was
    /// evaluated.
    pub fn largest(&self, expr: &Expr) -> Option<f64> {
        let at = self.largest.as_ref()?.get(&std::ptr::from_ref(expr))?;
        Some(self.work.cells[*at]).filter(|v| *v >= 0.0)
    }

    /// The state, as one vector.
    pub fn state(&mut self) -> &mut [f64] {
        &mut self.work.cells[..self.program.order(&self.block)]
    }

    /// Calls the function `name` with `numbers` as real arguments; the state of the machine is passed for states.
    ///
    /// # Errors
    /// [`Error::Content`] if there is no such function, if it takes an integer, an array or the state of another block,
    /// or if an index is out of range.
    pub fn call(&mut self, name: &str, numbers: &[f64]) -> Result<Vec<f64>, Error> {
        let (function, ResolvedFunction { run, takes, gives }) = self.ready(name)?;
        let mut numbers = numbers.iter();
        for (k, parameter) in function.takes.iter().enumerate() {
            self.work.cells[takes + k] = match &parameter.kind {
                ValueType::Real => self.work.round(numbers.next().copied().unwrap_or(f64::NAN)),
                ValueType::Part(block) if *block == self.block => 0.0,
                kind => {
                    return wrong(format!("`{name}` takes {kind:?} as `{}`, which is not available", parameter.name));
                }
            };
        }
        (self.work.counts, self.work.operations) = (self.counts, self.operations);
        run(&mut self.work);
        (self.counts, self.operations) = (self.work.counts, self.work.operations);
        match self.work.wrong.take() {
            None => Ok(self.work.cells[gives..gives + function.returns.len()].to_vec()),
            Some(error) => Err(error),
        }
    }

    /// The function with this name, if it is resolved.
    pub(super) fn ready(&self, name: &str) -> Result<(&'p Function, ResolvedFunction<'p>), Error> {
        match self.program.functions.iter().zip(&self.ready).find(|(function, _)| function.name == name) {
            Some((function, ready)) => Ok((function, ready.clone())),
            None => wrong(format!("there is no function `{name}`")),
        }
    }
}

impl std::fmt::Debug for Machine<'_> {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Machine").field("work", &self.work).finish_non_exhaustive()
    }
}

pub(super) fn wrong<T>(what: String) -> Result<T, Error> {
    Err(Error::Content(format!("program: {what}")))
}
