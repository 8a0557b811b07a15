//! The parts of a function: statements, expressions, places.

use piezoid_numerics::number::MEASURABLE;

/// Type of a name.
#[derive(Debug, Clone, PartialEq)]
pub enum ValueType {
    /// A real number.
    Real,
    /// An integer that is not negative.
    Integer,
    /// The state of the block with this name.
    Part(String),
    /// An array of this length.
    Array(usize),
}

/// A function.
#[derive(Debug, Clone, PartialEq)]
pub struct Function {
    /// Number of the block whose constants it reads.
    pub block: usize,
    /// Its comment, line by line.
    pub about: Vec<String>,
    /// Name, unique in a program.
    pub name: String,
    /// Parameters.
    pub takes: Vec<Argument>,
    /// Statements.
    pub steps: Vec<Statement>,
    /// Returned values.
    pub returns: Vec<Expr>,
}

/// A parameter of a function.
#[derive(Debug, Clone, PartialEq)]
pub struct Argument {
    /// Name.
    pub name: String,
    /// Type.
    pub kind: ValueType,
    /// True if it is a state that the function changes.
    pub changed: bool,
}

/// A statement.
#[derive(Debug, Clone, PartialEq)]
pub enum Statement {
    /// A comment.
    Note(String),
    /// New variables with the values of an expression.
    Let(Vec<String>, Expr),
    /// A new state: a copy of another one, or zeros.
    Copy {
        /// Name of the new state.
        name: String,
        /// The other state.
        of: Place,
        /// Its block.
        block: String,
        /// True for zeros.
        zero: bool,
    },
    /// A new array of zeros with this length.
    Array(String, usize),
    /// A new value for a variable, a field or an element.
    Set(Place, Expr),
    /// A call without a result, for its changes of a state.
    Do(Expr),
    /// Condition, statements if it holds, statements otherwise.
    If(Expr, Vec<Statement>, Vec<Statement>),
    /// A loop over integers.
    For {
        /// Name of the integer.
        name: String,
        /// First integer.
        from: Expr,
        /// One more than the last integer.
        to: Expr,
        /// True if it runs from the last to the first.
        down: bool,
        /// The largest number of passes, if the ends are not constant.
        most: Option<usize>,
        /// Statements.
        steps: Vec<Statement>,
    },
    /// A loop while the condition holds: the condition, the largest number of passes, statements.
    While(Expr, usize, Vec<Statement>),
}

/// Place of a number or a state: a name, a field of a state, or an element of an array.
#[derive(Debug, Clone, PartialEq)]
pub struct Place {
    /// Name.
    pub root: String,
    /// Field, field of this field, and so on.
    pub path: Vec<String>,
    /// Index of the element.
    pub index: Option<Box<Expr>>,
}

/// An expression.
#[derive(Debug, Clone, PartialEq)]
pub enum Expr {
    /// A real number.
    Real(f64),
    /// An integer.
    Integer(usize),
    /// A property of the precision.
    Limit(Limit),
    /// A variable; true for an integer.
    Variable(String, bool),
    /// A constant of a block: block number, name, index in a table.
    Constant(usize, String, Option<Box<Expr>>),
    /// A field of a state or an element of an array.
    At(Place),
    /// A state, as an argument.
    Part(Place),
    /// A function call.
    Call(String, Vec<Expr>),
    /// A change of sign.
    Negative(Box<Expr>),
    /// A binary operation.
    Binary(Op, Box<Expr>, Box<Expr>),
}

/// A property of the precision.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Limit {
    /// Distance from 1 to the next number.
    Epsilon,
    /// Smallest positive number that is not subnormal.
    Least,
    /// Largest number.
    Most,
    /// The largest size of a reading: [`MEASURABLE`].
    Measurable,
}

impl Limit {
    /// Value in single or double precision.
    pub fn value(self, single: bool) -> f64 {
        match (self, single) {
            (Limit::Epsilon, true) => f32::EPSILON.into(),
            (Limit::Least, true) => f32::MIN_POSITIVE.into(),
            (Limit::Most, true) => f32::MAX.into(),
            (Limit::Epsilon, false) => f64::EPSILON,
            (Limit::Least, false) => f64::MIN_POSITIVE,
            (Limit::Most, false) => f64::MAX,
            (Limit::Measurable, true) => f64::from(MEASURABLE as f32),
            (Limit::Measurable, false) => MEASURABLE,
        }
    }
}

/// A binary operator.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(missing_docs, reason = "the names say it")]
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
    /// Precedence: a higher one binds tighter.
    pub fn precedence(self) -> u8 {
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
    /// True if the value is an integer.
    pub fn whole(&self) -> bool {
        match self {
            Expr::Integer(_) | Expr::Variable(_, true) => true,
            Expr::Call(name, _) => name == "whole",
            Expr::Binary(op, left, _) => op.precedence() >= Op::Add.precedence() && left.whole(),
            _ => false,
        }
    }
}

impl Function {
    /// True if a statement assigns a new value to the variable `name`.
    pub fn changes(&self, name: &str) -> bool {
        let mut changes = false;
        let mut look = |step: &Statement| {
            changes |= matches!(step, Statement::Set(place, _) if place.root == name && place.path.is_empty());
        };
        self.steps.iter().for_each(|step| step.all(&mut look));
        changes
    }

    /// Removes variables that are never read and whose values have no side effects. Returns true if there were any.
    pub(super) fn remove_unread(&mut self) -> bool {
        let mut read = Vec::new();
        self.expressions(&mut |expr| match expr {
            Expr::Variable(name, _) => read.push(name.clone()),
            Expr::At(place) | Expr::Part(place) => read.push(place.root.clone()),
            _ => {}
        });
        let arguments: Vec<&str> = self.takes.iter().map(|p| &*p.name).collect();
        let idle = |step: &Statement| match step {
            Statement::Let(names, value) => names.iter().all(|name| !read.contains(name)) && value.changes_nothing(),
            Statement::Set(Place { root, .. }, value) => {
                !read.contains(root) && !arguments.contains(&&**root) && value.changes_nothing()
            }
            Statement::Array(name, _) => !read.contains(name),
            _ => false,
        };
        remove(&mut self.steps, &idle)
    }

    /// Passes the name of every function it calls to `see`.
    pub fn calls(&self, see: &mut impl FnMut(&str)) {
        self.expressions(&mut |expr| {
            if let Expr::Call(name, _) = expr {
                see(name);
            }
        });
    }

    /// Passes every expression to `see`, a parent before its parts.
    pub fn expressions(&self, see: &mut impl FnMut(&Expr)) {
        self.steps.iter().for_each(|step| step.expressions(see));
        self.returns.iter().for_each(|expr| expr.all(see));
    }
}

/// Removes `idle` statements at all levels. Returns true if there were any.
fn remove(steps: &mut Vec<Statement>, idle: &impl Fn(&Statement) -> bool) -> bool {
    let before = steps.len();
    steps.retain(|step| !idle(step));
    let mut any = steps.len() < before;
    for step in steps {
        match step {
            Statement::If(_, yes, no) => any |= remove(yes, idle) | remove(no, idle),
            Statement::For { steps, .. } | Statement::While(_, _, steps) => any |= remove(steps, idle),
            _ => {}
        }
    }
    any
}

impl Statement {
    fn expressions(&self, see: &mut impl FnMut(&Expr)) {
        self.all(&mut |step| match step {
            Statement::Note(_) | Statement::Copy { .. } | Statement::Array(..) => {}
            Statement::Set(place, expr) => {
                place.index.iter().for_each(|index| index.all(see));
                expr.all(see);
            }
            Statement::For { from, to, .. } => {
                from.all(see);
                to.all(see);
            }
            Statement::Let(_, expr) | Statement::Do(expr) | Statement::If(expr, ..) | Statement::While(expr, ..) => {
                expr.all(see);
            }
        });
    }

    /// Passes this statement and all statements in it to `see`.
    pub fn all<'s>(&'s self, see: &mut impl FnMut(&'s Statement)) {
        see(self);
        match self {
            Statement::If(_, yes, no) => yes.iter().chain(no).for_each(|step| step.all(see)),
            Statement::For { steps, .. } | Statement::While(_, _, steps) => steps.iter().for_each(|step| step.all(see)),
            _ => {}
        }
    }
}

impl Expr {
    /// True if no function in it has a state as an argument, which it might change.
    fn changes_nothing(&self) -> bool {
        let mut states = 0;
        self.all(&mut |expr| states += usize::from(matches!(expr, Expr::Part(_))));
        states == 0
    }

    /// Passes this expression and all its parts to `see`.
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
