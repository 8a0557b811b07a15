//! Programs: a step in words that every language of the target machines has.
//!
//! ```text
//! // What the play of threshold r holds back.
//! fn play(p, u, r) {
//!     return clamp(p, u - r, u + r);
//! }
//! fn hysteresis(x: hysteresis, u) {
//!     let z = w[0] * u;
//!     for k in 0..n {
//!         x.play[k] = play(x.play[k], u, r[k]);
//!         z += w[k + 1] * x.play[k];
//!     }
//!     return z;
//! }
//! ```
//! A block has fields (its state), constants, and functions. Numbers are real or whole; a parameter is real unless it says
//! `whole` or names the block whose state it is. There are no early returns, no recursion, no names that hide others; a function may
//! return several numbers. Conditions change nothing. `let t = copy(x);` copies a state, `let t = zero(x);` makes one of zeros, `[0.0; n]` is room for n numbers;
//! `real(i)` and `whole(v)` convert, the latter a number that is not negative, towards zero; `epsilon`, `least` and `most` are those of the
//! precision at hand. Some languages look at both sides of `&&` and `||`. A comment before a function or a step goes with it into every language.
//!
//! A program is read ([`Program::new`]), differentiated ([`Program::slope`]), run ([`Machine`]) in either precision, and
//! printed by [`crate::export`]. It is the same arithmetic in the same order everywhere, so that all give the same bits.

mod counted;
mod read;
mod run;
mod slope;

pub use run::{Counts, Machine};

use crate::error::Error;

/// A part of a program: a state, constants, and what it does.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Block {
    /// As functions name the type of its state.
    pub name: String,
    /// What it is, in a line or two.
    pub about: String,
    /// The state, in order.
    pub fields: Vec<Field>,
    /// Numbers that never change.
    pub constants: Vec<Constant>,
    /// Numbers that stand for themselves, as lengths do.
    pub counts: Vec<(String, usize)>,
    /// The functions.
    pub text: String,
}

/// A part of a state.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    /// As functions name it.
    pub name: String,
    /// What it begins with.
    pub holds: Holds,
}

/// What a field holds at rest.
#[derive(Debug, Clone, PartialEq)]
pub enum Holds {
    /// One number.
    Number(f64),
    /// Several.
    Numbers(Vec<f64>),
    /// The state of the block of this name.
    Block(String),
}

/// A constant or a table of them.
#[derive(Debug, Clone, PartialEq)]
pub struct Constant {
    /// As functions name it.
    pub name: String,
    /// The numbers.
    pub values: Vec<f64>,
    /// Whether it is a table, even of one.
    pub table: bool,
}

impl Block {
    /// A block without state, constants or functions.
    pub fn new(name: &str, about: impl Into<String>) -> Self {
        Block { name: name.into(), about: about.into(), ..Block::default() }
    }

    /// With one more number in its state.
    pub fn number(self, name: &str, at_rest: f64) -> Self {
        self.field(name, Holds::Number(at_rest))
    }

    /// With several more numbers in its state; none are no field.
    pub fn numbers(self, name: &str, at_rest: Vec<f64>) -> Self {
        if at_rest.is_empty() { self } else { self.field(name, Holds::Numbers(at_rest)) }
    }

    /// With the state of another block in its own.
    pub fn part(self, name: &str, block: &str) -> Self {
        self.field(name, Holds::Block(block.into()))
    }

    fn field(mut self, name: &str, holds: Holds) -> Self {
        self.fields.push(Field { name: name.into(), holds });
        self
    }

    /// With a constant.
    pub fn constant(mut self, name: &str, value: f64) -> Self {
        self.constants.push(Constant { name: name.into(), values: vec![value], table: false });
        self
    }

    /// With a table of constants; none are no table.
    pub fn table(mut self, name: &str, values: &[f64]) -> Self {
        if !values.is_empty() {
            self.constants.push(Constant { name: name.into(), values: values.to_vec(), table: true });
        }
        self
    }

    /// With a whole number that functions know by name.
    pub fn count(mut self, name: &str, value: usize) -> Self {
        self.counts.push((name.into(), value));
        self
    }

    /// With functions.
    pub fn text(mut self, text: &str) -> Self {
        self.text += text;
        self
    }
}

/// What a name stands for.
#[derive(Debug, Clone, PartialEq)]
pub enum Kind {
    /// A real number.
    Real,
    /// A whole number, not negative.
    Whole,
    /// The state of the block of this name.
    Part(String),
    /// Room for so many numbers.
    Room(usize),
}

/// A function.
#[derive(Debug, Clone, PartialEq)]
pub struct Function {
    /// The block whose constants it reads.
    pub block: usize,
    /// What it does, as its comment says.
    pub about: Vec<String>,
    /// Its name, one of its kind in a program.
    pub name: String,
    /// What it is given.
    pub takes: Vec<Parameter>,
    /// What it does.
    pub steps: Vec<Step>,
    /// What it returns.
    pub returns: Vec<Expr>,
}

/// A parameter of a function.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameter {
    /// Its name.
    pub name: String,
    /// What it is.
    pub kind: Kind,
    /// Whether the function changes it, as it may a state.
    pub changed: bool,
}

/// A statement.
#[derive(Debug, Clone, PartialEq)]
pub enum Step {
    /// A comment.
    Note(String),
    /// New names for what an expression gives.
    Let(Vec<String>, Expr),
    /// A new state: a copy of that at the place, or zeros.
    Copy {
        /// Its name.
        name: String,
        /// Of what.
        of: Place,
        /// Its block.
        block: String,
        /// Whether it is zeros instead.
        zero: bool,
    },
    /// Room for so many numbers, all zero.
    Room(String, usize),
    /// A new value for what has a name.
    Set(Place, Expr),
    /// A call for what it changes.
    Do(Expr),
    /// One way or the other.
    If(Expr, Vec<Step>, Vec<Step>),
    /// Once for each whole number from the first to below the second, or back down.
    For {
        /// The whole number.
        name: String,
        /// The first.
        from: Expr,
        /// One more than the last.
        to: Expr,
        /// Whether from the last to the first.
        down: bool,
        /// What is done.
        steps: Vec<Step>,
    },
    /// As long as it holds.
    While(Expr, Vec<Step>),
}

/// Where a number or a state stands: a name, or the field of a state, or what is counted off in one.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// A name.
    pub root: String,
    /// A field of it, and a field of that.
    pub path: Vec<String>,
    /// The number of what is meant there.
    pub index: Option<Box<Expr>>,
}

/// What gives a number.
#[derive(Debug, Clone, PartialEq)]
pub enum Expr {
    /// A real number.
    Real(f64),
    /// A whole number.
    Whole(usize),
    /// A property of the numbers at hand.
    Limit(Limit),
    /// A variable; whether it is whole.
    Variable(String, bool),
    /// A constant of a block, or that of this number in a table.
    Constant(usize, String, Option<Box<Expr>>),
    /// A number in a state or room.
    At(Place),
    /// A state, as an argument.
    Part(Place),
    /// What a function gives.
    Call(String, Vec<Expr>),
    /// Its negative.
    Negative(Box<Expr>),
    /// Two together.
    Binary(Op, Box<Expr>, Box<Expr>),
}

/// A property of the precision at hand.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limit {
    /// From 1 to the next number.
    Epsilon,
    /// The least positive number that is not subnormal.
    Least,
    /// The largest number.
    Most,
}

impl Limit {
    /// Its value in single or double precision.
    pub fn value(self, single: bool) -> f64 {
        match (self, single) {
            (Limit::Epsilon, true) => f32::EPSILON.into(),
            (Limit::Least, true) => f32::MIN_POSITIVE.into(),
            (Limit::Most, true) => f32::MAX.into(),
            (Limit::Epsilon, false) => f64::EPSILON,
            (Limit::Least, false) => f64::MIN_POSITIVE,
            (Limit::Most, false) => f64::MAX,
        }
    }
}

/// What joins two.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(missing_docs, reason = "named as they are read")]
pub enum Op {
    Add,
    Subtract,
    Multiply,
    Divide,
    Remainder,
    Less,
    AtMost,
    More,
    AtLeast,
    Equal,
    Unequal,
    And,
    Or,
}

impl Op {
    /// How tightly it binds.
    pub fn binds(self) -> u8 {
        match self {
            Op::Or => 1,
            Op::And => 2,
            Op::Less | Op::AtMost | Op::More | Op::AtLeast | Op::Equal | Op::Unequal => 3,
            Op::Add | Op::Subtract => 4,
            Op::Multiply | Op::Divide | Op::Remainder => 5,
        }
    }
}

impl Expr {
    /// Whether it is a whole number.
    pub fn whole(&self) -> bool {
        match self {
            Expr::Whole(_) | Expr::Variable(_, true) => true,
            Expr::Call(name, _) => name == "whole",
            Expr::Binary(op, left, _) => op.binds() >= Op::Add.binds() && left.whole(),
            _ => false,
        }
    }
}

/// Blocks and what they do together.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Program {
    /// The blocks, each after those it holds.
    pub blocks: Vec<Block>,
    /// The functions, each after those it calls.
    pub functions: Vec<Function>,
}

impl Program {
    /// Reads the functions of blocks that stand in the order of use.
    ///
    /// # Errors
    /// [`Error::Content`] with the function and the place, where a text is not in the language.
    pub fn new(blocks: Vec<Block>) -> Result<Self, Error> {
        let mut program = Program::default();
        for block in blocks {
            program.add(block)?;
        }
        Ok(program)
    }

    /// Adds a block.
    ///
    /// # Errors
    /// As [`Program::new`].
    pub fn add(&mut self, block: Block) -> Result<(), Error> {
        let text = block.text.clone();
        self.blocks.push(block);
        self.extend(&text)
    }

    /// Adds functions to the last block.
    ///
    /// # Errors
    /// As [`Program::new`].
    pub fn extend(&mut self, text: &str) -> Result<(), Error> {
        read::functions(self, text)
    }

    /// The block of this name.
    pub fn block(&self, name: &str) -> Option<&Block> {
        self.blocks.iter().find(|b| b.name == name)
    }

    /// The function of this name.
    pub fn function(&self, name: &str) -> Option<&Function> {
        self.functions.iter().find(|f| f.name == name)
    }

    /// Numbers in the state of the block of this name.
    pub fn order(&self, block: &str) -> usize {
        self.block(block).map_or(0, |b| b.fields.iter().map(|f| self.length(&f.holds)).sum())
    }

    /// Numbers in a field.
    fn length(&self, holds: &Holds) -> usize {
        match holds {
            Holds::Number(_) => 1,
            Holds::Numbers(values) => values.len(),
            Holds::Block(name) => self.order(name),
        }
    }

    /// The state of the block of this name at rest, as one vector.
    pub fn at_rest(&self, block: &str) -> Vec<f64> {
        let fields = self.block(block).map_or(&[][..], |b| &b.fields);
        fields.iter().flat_map(|f| self.held(&f.holds)).collect()
    }

    fn held(&self, holds: &Holds) -> Vec<f64> {
        match holds {
            Holds::Number(value) => vec![*value],
            Holds::Numbers(values) => values.clone(),
            Holds::Block(name) => self.at_rest(name),
        }
    }

    /// Leaves out functions that none of `kept` needs.
    pub fn keep(&mut self, kept: &[&str]) {
        let mut needed: Vec<String> = kept.iter().map(|name| (*name).to_owned()).collect();
        for function in self.functions.iter().rev() {
            if needed.contains(&function.name) {
                function.calls(&mut |name| needed.push(name.to_owned()));
            }
        }
        self.functions.retain(|f| needed.contains(&f.name));
    }
}

impl Function {
    /// Whether it gives the variable of this name another value later.
    pub fn changes(&self, name: &str) -> bool {
        let mut changes = false;
        let mut look = |step: &Step| {
            changes |= matches!(step, Step::Set(place, _) if place.root == name && place.path.is_empty());
        };
        self.steps.iter().for_each(|step| step.all(&mut look));
        changes
    }

    /// Leaves out names that are never read, if what they stand for changes nothing. Returns whether there were any.
    fn forgets_what_nobody_reads(&mut self) -> bool {
        let mut read = Vec::new();
        self.expressions(&mut |expr| match expr {
            Expr::Variable(name, _) => read.push(name.clone()),
            Expr::At(place) | Expr::Part(place) => read.push(place.root.clone()),
            _ => {}
        });
        let given: Vec<&str> = self.takes.iter().map(|p| &*p.name).collect();
        let idle = |step: &Step| match step {
            Step::Let(names, value) => names.iter().all(|name| !read.contains(name)) && value.changes_nothing(),
            Step::Set(Place { root, .. }, value) => {
                !read.contains(root) && !given.contains(&&**root) && value.changes_nothing()
            }
            Step::Room(name, _) => !read.contains(name),
            _ => false,
        };
        forget(&mut self.steps, &idle)
    }

    /// Hands the name of every function it calls to `see`.
    pub fn calls(&self, see: &mut impl FnMut(&str)) {
        self.expressions(&mut |expr| {
            if let Expr::Call(name, _) = expr {
                see(name);
            }
        });
    }

    /// Hands every expression in it to `see`, the whole before its parts.
    pub fn expressions(&self, see: &mut impl FnMut(&Expr)) {
        self.steps.iter().for_each(|step| step.expressions(see));
        self.returns.iter().for_each(|expr| expr.all(see));
    }
}

/// Leaves out steps that are `idle`, however deep. Returns whether there were any.
fn forget(steps: &mut Vec<Step>, idle: &impl Fn(&Step) -> bool) -> bool {
    let before = steps.len();
    steps.retain(|step| !idle(step));
    let mut any = steps.len() < before;
    for step in steps {
        match step {
            Step::If(_, yes, no) => any |= forget(yes, idle) | forget(no, idle),
            Step::For { steps, .. } | Step::While(_, steps) => any |= forget(steps, idle),
            _ => {}
        }
    }
    any
}

impl Step {
    fn expressions(&self, see: &mut impl FnMut(&Expr)) {
        match self {
            Step::Note(_) | Step::Copy { .. } | Step::Room(..) => {}
            Step::Let(_, expr) | Step::Do(expr) => expr.all(see),
            Step::Set(place, expr) => {
                place.index.iter().for_each(|index| index.all(see));
                expr.all(see);
            }
            Step::If(holds, yes, no) => {
                holds.all(see);
                yes.iter().chain(no).for_each(|step| step.expressions(see));
            }
            Step::For { from, to, steps, .. } => {
                from.all(see);
                to.all(see);
                steps.iter().for_each(|step| step.expressions(see));
            }
            Step::While(holds, steps) => {
                holds.all(see);
                steps.iter().for_each(|step| step.expressions(see));
            }
        }
    }

    /// Hands this step and all within it to `see`.
    pub fn all<'s>(&'s self, see: &mut impl FnMut(&'s Step)) {
        see(self);
        match self {
            Step::If(_, yes, no) => yes.iter().chain(no).for_each(|step| step.all(see)),
            Step::For { steps, .. } | Step::While(_, steps) => steps.iter().for_each(|step| step.all(see)),
            _ => {}
        }
    }
}

impl Expr {
    /// Whether no function in it is given a state, which it might change.
    fn changes_nothing(&self) -> bool {
        let mut states = 0;
        self.all(&mut |expr| states += usize::from(matches!(expr, Expr::Part(_))));
        states == 0
    }

    /// Hands this expression and all its parts to `see`.
    pub fn all(&self, see: &mut impl FnMut(&Expr)) {
        see(self);
        match self {
            Expr::Constant(_, _, Some(index)) => index.all(see),
            Expr::At(place) | Expr::Part(place) => place.index.iter().for_each(|index| index.all(see)),
            Expr::Call(_, arguments) => arguments.iter().for_each(|a| a.all(see)),
            Expr::Negative(expr) => expr.all(see),
            Expr::Binary(_, left, right) => {
                left.all(see);
                right.all(see);
            }
            _ => {}
        }
    }
}
