//! What a function is made of: steps, expressions, places.

/// What a name stands for.
#[derive(Debug, Clone, PartialEq)]
pub enum ValueType {
    /// A real number.
    Real,
    /// A whole number, not negative.
    Integer,
    /// The state of the block of this name.
    Part(String),
    /// Room for so many numbers.
    Array(usize),
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
    pub takes: Vec<Argument>,
    /// What it does.
    pub steps: Vec<Statement>,
    /// What it returns.
    pub returns: Vec<Expr>,
}

/// A parameter of a function.
#[derive(Debug, Clone, PartialEq)]
pub struct Argument {
    /// Its name.
    pub name: String,
    /// What it is.
    pub kind: ValueType,
    /// Whether the function changes it, as it may a state.
    pub changed: bool,
}

/// A statement.
#[derive(Debug, Clone, PartialEq)]
pub enum Statement {
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
    Array(String, usize),
    /// A new value for what has a name.
    Set(Place, Expr),
    /// A call for what it changes.
    Do(Expr),
    /// One way or the other.
    If(Expr, Vec<Statement>, Vec<Statement>),
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
        steps: Vec<Statement>,
    },
    /// As long as it holds.
    While(Expr, Vec<Statement>),
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
    Integer(usize),
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
            Expr::Integer(_) | Expr::Variable(_, true) => true,
            Expr::Call(name, _) => name == "whole",
            Expr::Binary(op, left, _) => op.binds() >= Op::Add.binds() && left.whole(),
            _ => false,
        }
    }
}

impl Function {
    /// Whether it gives the variable of this name another value later.
    pub fn changes(&self, name: &str) -> bool {
        let mut changes = false;
        let mut look = |step: &Statement| {
            changes |= matches!(step, Statement::Set(place, _) if place.root == name && place.path.is_empty());
        };
        self.steps.iter().for_each(|step| step.all(&mut look));
        changes
    }

    /// Leaves out names that are never read, if what they stand for changes nothing. Returns whether there were any.
    pub(super) fn forgets_what_nobody_reads(&mut self) -> bool {
        let mut read = Vec::new();
        self.expressions(&mut |expr| match expr {
            Expr::Variable(name, _) => read.push(name.clone()),
            Expr::At(place) | Expr::Part(place) => read.push(place.root.clone()),
            _ => {}
        });
        let given: Vec<&str> = self.takes.iter().map(|p| &*p.name).collect();
        let idle = |step: &Statement| match step {
            Statement::Let(names, value) => names.iter().all(|name| !read.contains(name)) && value.changes_nothing(),
            Statement::Set(Place { root, .. }, value) => {
                !read.contains(root) && !given.contains(&&**root) && value.changes_nothing()
            }
            Statement::Array(name, _) => !read.contains(name),
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
fn forget(steps: &mut Vec<Statement>, idle: &impl Fn(&Statement) -> bool) -> bool {
    let before = steps.len();
    steps.retain(|step| !idle(step));
    let mut any = steps.len() < before;
    for step in steps {
        match step {
            Statement::If(_, yes, no) => any |= forget(yes, idle) | forget(no, idle),
            Statement::For { steps, .. } | Statement::While(_, steps) => any |= forget(steps, idle),
            _ => {}
        }
    }
    any
}

impl Statement {
    fn expressions(&self, see: &mut impl FnMut(&Expr)) {
        match self {
            Statement::Note(_) | Statement::Copy { .. } | Statement::Array(..) => {}
            Statement::Let(_, expr) | Statement::Do(expr) => expr.all(see),
            Statement::Set(place, expr) => {
                place.index.iter().for_each(|index| index.all(see));
                expr.all(see);
            }
            Statement::If(holds, yes, no) => {
                holds.all(see);
                yes.iter().chain(no).for_each(|step| step.expressions(see));
            }
            Statement::For { from, to, steps, .. } => {
                from.all(see);
                to.all(see);
                steps.iter().for_each(|step| step.expressions(see));
            }
            Statement::While(holds, steps) => {
                holds.all(see);
                steps.iter().for_each(|step| step.expressions(see));
            }
        }
    }

    /// Hands this step and all within it to `see`.
    pub fn all<'s>(&'s self, see: &mut impl FnMut(&'s Statement)) {
        see(self);
        match self {
            Statement::If(_, yes, no) => yes.iter().chain(no).for_each(|step| step.all(see)),
            Statement::For { steps, .. } | Statement::While(_, steps) => steps.iter().for_each(|step| step.all(see)),
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
