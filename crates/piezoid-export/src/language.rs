//! Printing functions in any language: the walk is the same, the words are a [`Language`]'s.

use piezoid::program::{Block, Expr, Function, Limit, Op, Place, Program, Step};

/// The words of a language. Lines come without their indentation.
pub(super) trait Language {
    /// Whether its numbers are of single precision.
    fn single(&self) -> bool;

    /// A real number.
    fn real(&self, value: f64) -> String;

    /// A whole number.
    fn whole(&self, value: usize) -> String {
        value.to_string()
    }

    /// A property of its numbers.
    fn limit(&self, limit: Limit) -> String {
        self.real(limit.value(self.single()))
    }

    /// A constant of `block`, or that of this number in a table.
    fn constant(&self, block: &Block, name: &str, index: Option<&Expr>, words: &Words) -> String;

    /// A number in a state or room, or a state within another.
    fn place(&self, place: &Place, words: &Words) -> String;

    /// What a function gives.
    fn call(&self, name: &str, arguments: &[Expr], words: &Words) -> String;

    /// A whole number as a real one.
    fn to_real(&self, value: String) -> String;

    /// A real number as a whole one.
    fn to_whole(&self, value: String) -> String;

    /// What stands between two, which are whole or not; as in C unless it has others.
    fn between(&self, op: Op, _whole: bool) -> &'static str {
        match op {
            Op::Add => "+",
            Op::Subtract => "-",
            Op::Multiply => "*",
            Op::Divide => "/",
            Op::Remainder => "%",
            Op::Less => "<",
            Op::AtMost => "<=",
            Op::More => ">",
            Op::AtLeast => ">=",
            Op::Equal => "==",
            Op::Unequal => "!=",
            Op::And => "&&",
            Op::Or => "||",
        }
    }

    /// A quotient of two whole numbers or what it leaves, where nothing stands between them.
    fn divided(&self, _op: Op, _left: &str, _right: &str) -> Option<String> {
        None
    }

    /// A comment.
    fn note(&self, text: &str) -> String;

    /// New names for what an expression gives.
    fn fresh(&self, names: &[String], value: &Expr, words: &Words) -> Vec<String>;

    /// A copy of a state, or zeros instead.
    fn copy(&self, name: &str, of: &Place, block: &str, zero: bool, words: &Words) -> Vec<String>;

    /// Room for `n` zeros.
    fn room(&self, name: &str, n: usize) -> Vec<String>;

    /// A new value for what has a name.
    fn set(&self, place: String, value: String) -> String {
        format!("{place} = {value};")
    }

    /// A new value for what stands at a place.
    fn assign(&self, place: &Place, value: &Expr, words: &Words) -> String {
        self.set(self.place(place, words), words.expr(value))
    }

    /// A call for what it changes.
    fn done(&self, call: &Expr, words: &Words) -> String;

    /// The beginning of what is done if this holds.
    fn if_holds(&self, holds: String) -> String;

    /// The beginning of what is done else, if this holds.
    fn else_if(&self, holds: String) -> String;

    /// The beginning of what is done else.
    fn or_else(&self) -> String;

    /// Word that else nothing is done, where one thing or another was.
    fn otherwise_nothing(&self) -> Vec<String> {
        Vec::new()
    }

    /// The beginning of a loop over whole numbers.
    fn counting(&self, name: &str, from: &Expr, to: &Expr, down: bool, words: &Words) -> String;

    /// The beginning of a loop.
    fn as_long_as(&self, holds: String) -> String;

    /// The end of what these begin; as in C unless it has others.
    fn end(&self, _begun: Begun) -> &'static str {
        "}"
    }

    /// The spaces of a level.
    fn indent(&self) -> &'static str {
        "    "
    }
}

/// What ends.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Begun {
    If,
    For,
    While,
}

/// A function on its way into a language.
pub(super) struct Words<'w> {
    pub(super) program: &'w Program,
    pub(super) function: &'w Function,
    pub(super) language: &'w dyn Language,
}

impl Words<'_> {
    /// Whether a call gives something, which then nobody takes.
    pub(super) fn gives(&self, call: &Expr) -> bool {
        match call {
            Expr::Call(name, _) => self.program.function(name).is_some_and(|f| !f.returns.is_empty()),
            _ => true,
        }
    }

    /// The steps, one line each, `depth` levels deep.
    pub(super) fn steps(&self, steps: &[Step], depth: usize) -> String {
        let indent = self.language.indent().repeat(depth);
        let mut out = String::new();
        for line in steps.iter().flat_map(|step| self.step(step)) {
            out += if line.is_empty() { "" } else { &indent };
            out += &line;
            out += "\n";
        }
        out
    }

    fn step(&self, step: &Step) -> Vec<String> {
        let l = self.language;
        match step {
            Step::Note(text) => vec![l.note(text)],
            Step::Let(names, value) => l.fresh(names, value, self),
            Step::Copy { name, of, block, zero } => l.copy(name, of, block, *zero, self),
            Step::Room(name, n) => l.room(name, *n),
            Step::Set(place, value) => vec![l.assign(place, value, self)],
            Step::Do(call) => vec![l.done(call, self)],
            Step::If(..) => {
                let mut lines = Vec::new();
                self.choice(step, false, &mut lines);
                lines
            }
            Step::For { from: Expr::Whole(from), to: Expr::Whole(to), .. } if from >= to => Vec::new(),
            Step::For { name, from, to, down, steps } => {
                self.around(l.counting(name, from, to, *down, self), steps, Begun::For)
            }
            Step::While(holds, steps) => self.around(l.as_long_as(self.expr(holds)), steps, Begun::While),
        }
    }

    fn choice(&self, step: &Step, chained: bool, lines: &mut Vec<String>) {
        let (Step::If(holds, yes, no), l) = (step, self.language) else { return };
        let holds = self.expr(holds);
        lines.push(if chained { l.else_if(holds) } else { l.if_holds(holds) });
        lines.extend(self.inner(yes));
        match &no[..] {
            [] => {
                lines.extend(if chained { l.otherwise_nothing() } else { Vec::new() });
                lines.push(l.end(Begun::If).into());
            }
            [next @ Step::If(..)] => self.choice(next, true, lines),
            no => {
                lines.push(l.or_else());
                lines.extend(self.inner(no));
                lines.push(l.end(Begun::If).into());
            }
        }
    }

    fn around(&self, begin: String, steps: &[Step], begun: Begun) -> Vec<String> {
        let mut lines = vec![begin];
        lines.extend(self.inner(steps));
        lines.push(self.language.end(begun).into());
        lines
    }

    fn inner(&self, steps: &[Step]) -> impl Iterator<Item = String> {
        let indent = self.language.indent();
        steps.iter().flat_map(|step| self.step(step)).map(move |line| format!("{indent}{line}"))
    }

    /// An expression.
    pub(super) fn expr(&self, expr: &Expr) -> String {
        self.bound(expr, 0)
    }

    /// What is divided in words.
    fn divided(&self, expr: &Expr) -> Option<String> {
        match expr {
            Expr::Binary(op @ (Op::Divide | Op::Remainder), left, right) if left.whole() => {
                self.language.divided(*op, &self.bound(left, op.binds()), &self.bound(right, TIGHT))
            }
            _ => None,
        }
    }

    /// An expression as a part of one that binds so tightly.
    fn bound(&self, expr: &Expr, tightly: u8) -> String {
        let l = self.language;
        match expr {
            Expr::Real(value) if value.is_sign_negative() && tightly > 0 => format!("({})", l.real(*value)),
            Expr::Real(value) => l.real(*value),
            Expr::Whole(value) => l.whole(*value),
            Expr::Limit(limit) => l.limit(*limit),
            Expr::Variable(name, _) => l.place(&Place { root: name.clone(), path: Vec::new(), index: None }, self),
            Expr::Constant(block, name, index) => {
                l.constant(&self.program.blocks[*block], name, index.as_deref(), self)
            }
            Expr::At(place) | Expr::Part(place) => l.place(place, self),
            Expr::Call(name, arguments) if name == "real" => l.to_real(self.expr(&arguments[0])),
            Expr::Call(name, arguments) if name == "whole" => l.to_whole(self.expr(&arguments[0])),
            Expr::Call(name, arguments) => l.call(name, arguments, self),
            Expr::Negative(inner) => {
                let text = format!("-{}", self.bound(inner, TIGHT));
                if tightly > 0 { format!("({text})") } else { text }
            }
            Expr::Binary(op, left, right) => {
                if let Some(text) = self.divided(expr) {
                    return text;
                }
                // What is compared or joined stands in brackets of its own, whatever binds tighter.
                let logical = op.binds() < Op::Add.binds();
                let simple = |e: &Expr| !matches!(e, Expr::Binary(..) | Expr::Negative(_)) || self.divided(e).is_some();
                let side = |e: &Expr, least: u8| match (logical, simple(e)) {
                    (true, false) => format!("({})", self.bound(e, 0)),
                    _ => self.bound(e, least),
                };
                let between = l.between(*op, left.whole());
                // A sign before a product is as good as one before its first factor.
                let first = match &**left {
                    Expr::Negative(_) | Expr::Real(_) if !logical => self.bound(left, 0),
                    left => side(left, op.binds()),
                };
                let text = format!("{first} {between} {}", side(right, op.binds() + 1));
                if op.binds() < tightly { format!("({text})") } else { text }
            }
        }
    }
}

/// `expr` less one.
pub(super) fn less_one(expr: &Expr) -> Expr {
    match expr {
        Expr::Whole(n) => Expr::Whole(n.saturating_sub(1)),
        expr => Expr::Binary(Op::Subtract, Box::new(expr.clone()), Box::new(Expr::Whole(1))),
    }
}

/// Tighter than any operator.
const TIGHT: u8 = 9;
