//! Prints functions in any language: one tree walk, with the syntax of a [`Language`].

use piezoid_models::program::{Block, Expr, Function, Limit, Op, Place, Program, Statement};

/// The syntax of a language. Lines are printed without their indentation.
pub(super) trait Language {
    fn keywords(&self) -> &'static Keywords;

    /// A real number.
    fn real(&self, value: f64) -> String;

    /// A property of its numbers.
    fn limit(&self, limit: Limit, printer: &Printer) -> String {
        self.real(limit.value(printer.single))
    }

    /// A constant of `block`, or an element of a table.
    fn constant(&self, block: &Block, name: &str, index: Option<&Expr>, printer: &Printer) -> String;

    /// A number in a state or array, or an inner state.
    fn place(&self, place: &Place, printer: &Printer) -> String;

    /// A call of a function.
    fn call(&self, name: &str, arguments: &[Expr], printer: &Printer) -> String;

    /// Converts an integer to a real number.
    fn to_real(&self, value: String) -> String;

    /// Converts a real number to an integer.
    fn to_whole(&self, value: String) -> String;

    /// A quotient or remainder of two integers, if the language has no operator for it.
    fn divided(&self, _op: Op, _left: &str, _right: &str) -> Option<String> {
        None
    }

    /// A comment.
    fn note(&self, text: &str) -> String;

    /// Declares variables for the results of an expression.
    fn fresh(&self, names: &[String], value: &Expr, printer: &Printer) -> Vec<String>;

    /// A copy of a state, or a state of zeros.
    fn copy(&self, name: &str, of: &Place, block: &str, zero: bool, printer: &Printer) -> Vec<String>;

    /// An array of `n` zeros.
    fn room(&self, name: &str, n: usize) -> Vec<String>;

    /// An assignment.
    fn assign(&self, place: &Place, value: &Expr, printer: &Printer) -> String {
        format!("{} {} {};", self.place(place, printer), self.keywords().set, printer.expr(value))
    }

    /// A call as a statement.
    fn done(&self, call: &Expr, printer: &Printer) -> String;

    /// The head of a loop over integers.
    fn counting(&self, name: &str, from: &Expr, to: &Expr, down: bool, printer: &Printer) -> String;
}

/// Syntax of conditions, loops and operators; `?` stands for a condition.
pub(super) struct Keywords {
    pub(super) choice: &'static str,
    pub(super) other_choice: &'static str,
    pub(super) otherwise: &'static str,
    /// The lines after the last `else if` if there is no `else`.
    pub(super) nothing: &'static [&'static str],
    pub(super) repeat: &'static str,
    /// The ends of a condition, a counting loop, and a while loop.
    pub(super) ends: [&'static str; 3],
    pub(super) set: &'static str,
    /// In the order of [`Op`].
    pub(super) operators: [&'static str; 13],
}

/// The syntax of C.
pub(super) const KEYWORDS: Keywords = Keywords {
    choice: "if (?) {",
    other_choice: "} else if (?) {",
    otherwise: "} else {",
    nothing: &["} else {", "    /* all stays as it is */"],
    repeat: "while (?) {",
    ends: ["}"; 3],
    set: "=",
    operators: ["+", "-", "*", "/", "%", "<", "<=", ">", ">=", "==", "!=", "&&", "||"],
};

impl Keywords {
    /// The text of an operator.
    pub(super) fn between(&self, op: Op) -> &'static str {
        self.operators[op as usize]
    }
}

/// Prints one function in a language.
pub(super) struct Printer<'w> {
    pub(super) program: &'w Program,
    pub(super) function: &'w Function,
    pub(super) language: &'w dyn Language,
    /// True for single precision.
    pub(super) single: bool,
}

impl Printer<'_> {
    /// True if a call has a result, which a statement ignores.
    pub(super) fn gives(&self, call: &Expr) -> bool {
        match call {
            Expr::Call(name, _) => self.program.function(name).is_some_and(|f| !f.returns.is_empty()),
            _ => true,
        }
    }

    /// The statements, one line each, indented by `depth` levels.
    pub(super) fn steps(&self, steps: &[Statement], depth: usize) -> String {
        let indent = INDENT.repeat(depth);
        let mut out = String::new();
        for line in steps.iter().flat_map(|step| self.step(step)) {
            out += if line.is_empty() { "" } else { &indent };
            out += &line;
            out += "\n";
        }
        out
    }

    fn step(&self, step: &Statement) -> Vec<String> {
        let l = self.language;
        match step {
            Statement::Note(text) => vec![l.note(text)],
            Statement::Let(names, value) => l.fresh(names, value, self),
            Statement::Copy { name, of, block, zero } => l.copy(name, of, block, *zero, self),
            Statement::Array(name, n) => l.room(name, *n),
            Statement::Set(place, value) => vec![l.assign(place, value, self)],
            Statement::Do(call) => vec![l.done(call, self)],
            Statement::If(..) => self.choice(step, false),
            Statement::For { from: Expr::Integer(from), to: Expr::Integer(to), .. } if from >= to => Vec::new(),
            Statement::For { name, from, to, down, steps, .. } => {
                self.around(l.counting(name, from, to, *down, self), steps, l.keywords().ends[1])
            }
            Statement::While(holds, _, steps) => {
                let Keywords { repeat, ends, .. } = l.keywords();
                self.around(repeat.replacen('?', &self.expr(holds), 1), steps, ends[2])
            }
        }
    }

    fn choice(&self, step: &Statement, chained: bool) -> Vec<String> {
        let (Statement::If(holds, yes, no), printer) = (step, self.language.keywords()) else { return Vec::new() };
        let begin = if chained { printer.other_choice } else { printer.choice }.replacen('?', &self.expr(holds), 1);
        let rest = match &no[..] {
            [] if chained => printer.nothing.iter().chain([&printer.ends[0]]).map(|line| (*line).into()).collect(),
            [] => vec![printer.ends[0].into()],
            [next @ Statement::If(..)] => self.choice(next, true),
            no => self.around(printer.otherwise.into(), no, printer.ends[0]),
        };
        [self.inner(begin, yes), rest].concat()
    }

    fn around(&self, begin: String, steps: &[Statement], end: &str) -> Vec<String> {
        [self.inner(begin, steps), vec![end.into()]].concat()
    }

    fn inner(&self, begin: String, steps: &[Statement]) -> Vec<String> {
        let inner = steps.iter().flat_map(|step| self.step(step)).map(|line| format!("{INDENT}{line}"));
        std::iter::once(begin).chain(inner).collect()
    }

    /// An expression.
    pub(super) fn expr(&self, expr: &Expr) -> String {
        self.bound(expr, 0)
    }

    /// An integer quotient or remainder, if the language prints it by `divided`.
    fn divided(&self, expr: &Expr) -> Option<String> {
        match expr {
            Expr::Binary(op @ (Op::Divide | Op::Remainder), left, right) if left.whole() => {
                self.language.divided(*op, &self.bound(left, op.precedence()), &self.bound(right, TIGHT))
            }
            _ => None,
        }
    }

    /// An expression as an operand of an operator that binds with strength `tightly`.
    fn bound(&self, expr: &Expr, tightly: u8) -> String {
        let l = self.language;
        match expr {
            Expr::Real(value) if value.is_sign_negative() && tightly > 0 => format!("({})", l.real(*value)),
            Expr::Real(value) => l.real(*value),
            Expr::Integer(value) => value.to_string(),
            Expr::Limit(limit) => l.limit(*limit, self),
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
                // Operands of comparisons and logical operators always get brackets.
                let logical = op.precedence() < Op::Add.precedence();
                let simple = |e: &Expr| !matches!(e, Expr::Binary(..) | Expr::Negative(_)) || self.divided(e).is_some();
                let side = |e: &Expr, least: u8| match (logical, simple(e)) {
                    (true, false) => format!("({})", self.bound(e, 0)),
                    _ => self.bound(e, least),
                };
                let between = l.keywords().between(*op);
                // A sign before a product equals one before its first factor.
                let first = match &**left {
                    Expr::Negative(_) | Expr::Real(_) if !logical => self.bound(left, 0),
                    left => side(left, op.precedence()),
                };
                let text = format!("{first} {between} {}", side(right, op.precedence() + 1));
                if op.precedence() < tightly { format!("({text})") } else { text }
            }
        }
    }
}

/// `expr` minus one.
pub(super) fn less_one(expr: &Expr) -> Expr {
    match expr {
        Expr::Integer(n) => Expr::Integer(n.saturating_sub(1)),
        expr => Expr::Binary(Op::Subtract, Box::new(expr.clone()), Box::new(Expr::Integer(1))),
    }
}

/// Indentation of one level.
const INDENT: &str = "    ";

/// Binds tighter than any operator.
const TIGHT: u8 = 9;
