//! The body of a function in Rust.

use super::{RESERVED, Rust, constant_of, type_of};
use crate::c::shortest;
use crate::language::{self, Keywords, Language, Printer};
use piezoid_models::program::{Block, Expr, Function, Limit, Op, Place, Statement};

/// A function and its printer.
pub(super) struct RustBody<'i> {
    pub(super) rust: &'i Rust<'i>,
    pub(super) function: &'i Function,
    /// True for a method.
    pub(super) own: bool,
}

impl RustBody<'_> {
    /// A name that is neither a keyword nor a function; it begins with `_` if nothing reads it.
    pub(super) fn local(&self, name: &str) -> String {
        if self.own && self.function.takes.first().is_some_and(|p| p.name == name) {
            return "self".into();
        }
        let function = self.rust.whole.program.function(name).is_some() || ["real", "whole"].contains(&name);
        let taken = function || RESERVED.split(' ').any(|word| word == name);
        format!("{}{name}{}", if self.reads(name) { "" } else { "_" }, if taken { "_value" } else { "" })
    }

    fn reads(&self, name: &str) -> bool {
        let mut reads = false;
        self.function.expressions(&mut |expr| match expr {
            Expr::Variable(known, _) => reads |= known == name,
            Expr::At(place) | Expr::Part(place) => reads |= place.root == name,
            _ => {}
        });
        let mut look = |step: &Statement| match step {
            Statement::Set(place, _) | Statement::Copy { of: place, .. } => reads |= place.root == name,
            _ => {}
        };
        self.function.steps.iter().for_each(|step| step.all(&mut look));
        reads
    }

    /// True if a state or array of this name is changed after its declaration.
    fn changes(&self, name: &str) -> bool {
        let program = &self.rust.whole.program;
        let mut changes = false;
        self.function.steps.iter().for_each(|step| {
            step.all(&mut |step| changes |= matches!(step, Statement::Set(place, _) if place.root == name));
        });
        self.function.expressions(&mut |expr| {
            if let Expr::Call(called, arguments) = expr {
                let takes = program.function(called).map_or(&[][..], |f| &f.takes);
                let part = |a: &Expr| matches!(a, Expr::Part(place) if place.root == name);
                changes |= takes.iter().zip(arguments).any(|(p, a)| p.changed && part(a));
            }
        });
        changes
    }

    fn variable(&self, name: &str) -> String {
        format!("let {}{}", if self.changes(name) { "mut " } else { "" }, self.local(name))
    }
}

const KEYWORDS: Keywords = Keywords {
    choice: "if ? {",
    other_choice: "} else if ? {",
    nothing: &[],
    repeat: "while ? {",
    ..language::KEYWORDS
};

impl Language for RustBody<'_> {
    fn keywords(&self) -> &'static Keywords {
        &KEYWORDS
    }

    fn real(&self, value: f64) -> String {
        shortest(value, self.rust.single)
    }

    fn limit(&self, limit: Limit, _: &Printer) -> String {
        let name = match limit {
            Limit::Epsilon => "EPSILON",
            Limit::Least => "MIN_POSITIVE",
            Limit::Most => "MAX",
            Limit::Measurable => return self.real(limit.value(self.rust.single)),
        };
        format!("{}::{name}", self.rust.number())
    }

    fn constant(&self, block: &Block, name: &str, index: Option<&Expr>, printer: &Printer) -> String {
        let name = constant_of(block, name);
        index.map_or(name.clone(), |index| format!("{name}[{}]", printer.expr(index)))
    }

    fn place(&self, place: &Place, printer: &Printer) -> String {
        let mut text = self.local(&place.root);
        place.path.iter().for_each(|field| text += &format!(".{field}"));
        place.index.iter().for_each(|index| text += &format!("[{}]", printer.expr(index)));
        text
    }

    fn call(&self, name: &str, arguments: &[Expr], printer: &Printer) -> String {
        let takes = printer.program.function(name).map_or(&[][..], |f| &f.takes);
        let argument = |(k, a): (usize, &Expr)| match a {
            // Parameters are already references.
            Expr::Part(place) if place.path.is_empty() && self.function.takes.iter().any(|p| p.name == place.root) => {
                self.local(&place.root)
            }
            Expr::Part(place) => {
                let changed = takes.get(k).is_some_and(|p| p.changed);
                format!("&{}{}", if changed { "mut " } else { "" }, self.place(place, printer))
            }
            a => printer.expr(a),
        };
        let values: Vec<String> = arguments.iter().enumerate().map(argument).collect();
        match (self.rust.stepped(name), values.split_first()) {
            (Some(_), Some((state, rest))) => {
                format!("{}.step({})", state.trim_start_matches("&mut "), rest.join(", "))
            }
            _ => format!("{name}({})", values.join(", ")),
        }
    }

    fn to_real(&self, value: String) -> String {
        format!("real({value})")
    }

    fn to_whole(&self, value: String) -> String {
        format!("whole({value})")
    }

    fn note(&self, text: &str) -> String {
        format!("// {text}")
    }

    fn fresh(&self, names: &[String], value: &Expr, printer: &Printer) -> Vec<String> {
        let name = |name: &String| {
            let changes = if self.function.changes(name) { "mut " } else { "" };
            format!("{changes}{}", self.local(name))
        };
        let names: Vec<String> = names.iter().map(name).collect();
        // The type of a lone integer cannot be inferred.
        let kind = if matches!(value, Expr::Integer(_)) { ": usize" } else { "" };
        vec![match &names[..] {
            [one] => format!("let {one}{kind} = {};", printer.expr(value)),
            more => format!("let ({}) = {};", more.join(", "), printer.expr(value)),
        }]
    }

    fn copy(&self, name: &str, of: &Place, block: &str, zero: bool, printer: &Printer) -> Vec<String> {
        let reference = of.path.is_empty() && self.function.takes.iter().any(|p| p.name == of.root);
        let value = match (zero, self.place(of, printer)) {
            (true, _) => format!("{}::ZERO", type_of(block)),
            (false, of) => format!("{}{of}", if reference { "*" } else { "" }),
        };
        vec![format!("{} = {value};", self.variable(name))]
    }

    fn room(&self, name: &str, n: usize) -> Vec<String> {
        vec![format!("{} = [0.0; {n}];", self.variable(name))]
    }

    fn assign(&self, place: &Place, value: &Expr, printer: &Printer) -> String {
        let itself = |expr: &Expr| match expr {
            Expr::At(now) => now == place,
            Expr::Variable(name, _) => *name == place.root && place.path.is_empty() && place.index.is_none(),
            _ => false,
        };
        let (onto, with) = match value {
            Expr::Binary(op, left, right) if op.precedence() >= Op::Add.precedence() && itself(left) => {
                (Some(*op), right)
            }
            Expr::Binary(op @ (Op::Add | Op::Multiply), left, right) if itself(right) => (Some(*op), left),
            _ => return format!("{} = {};", self.place(place, printer), printer.expr(value)),
        };
        let between = onto.map_or("", |op| KEYWORDS.between(op));
        format!("{} {between}= {};", self.place(place, printer), printer.expr(with))
    }

    fn done(&self, call: &Expr, printer: &Printer) -> String {
        format!("{};", printer.expr(call))
    }

    fn counting(&self, name: &str, from: &Expr, to: &Expr, down: bool, printer: &Printer) -> String {
        let (name, from, to) = (self.local(name), printer.expr(from), printer.expr(to));
        match down {
            false => format!("for {name} in {from}..{to} {{"),
            true => format!("for {name} in ({from}..{to}).rev() {{"),
        }
    }
}
