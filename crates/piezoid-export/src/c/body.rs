//! The body of a function in C99.

use super::{C, shortest};
use crate::language::{KEYWORDS, Keywords, Language, Printer, less_one};
use piezoid_models::program::{Block, Expr, Function, Place};

impl C<'_> {
    /// True for a parameter; only states among them have fields.
    fn pointed(&self, function: &Function, root: &str) -> bool {
        function.takes.iter().any(|p| p.name == root)
    }

    /// True for a state that is passed by address.
    fn addressed(&self, function: &Function, place: &Place) -> bool {
        self.pointed(function, &place.root) && place.path.is_empty()
    }

    fn arguments(&self, arguments: &[Expr], printer: &Printer) -> Vec<String> {
        let argument = |a: &Expr| match a {
            Expr::Part(place) if self.addressed(printer.function, place) => place.root.clone(),
            Expr::Part(place) => format!("&{}", self.place(place, printer)),
            a => printer.expr(a),
        };
        arguments.iter().map(argument).collect()
    }
}

impl Language for C<'_> {
    fn keywords(&self) -> &'static Keywords {
        &KEYWORDS
    }

    fn real(&self, value: f64) -> String {
        if self.counts.is_some() {
            return format!("{}", value as i64);
        }
        let single = self.request.options.float;
        format!("{}{}", shortest(value, single), if single { "f" } else { "" })
    }

    fn constant(&self, block: &Block, name: &str, index: Option<&Expr>, printer: &Printer) -> String {
        let name = self.own(&format!("{}_{name}", block.name));
        index.map_or(name.clone(), |index| format!("{name}[{}]", printer.expr(index)))
    }

    fn place(&self, place: &Place, printer: &Printer) -> String {
        let mut text = place.root.clone();
        for (k, field) in place.path.iter().enumerate() {
            text += if k == 0 && self.pointed(printer.function, &place.root) { "->" } else { "." };
            text += field;
        }
        place.index.iter().for_each(|index| text += &format!("[{}]", printer.expr(index)));
        text
    }

    fn call(&self, name: &str, arguments: &[Expr], printer: &Printer) -> String {
        if self.counts.is_some() && name == "wide" {
            return format!("(int64_t){}", printer.expr(&arguments[0]));
        }
        format!("{}({})", self.own(name), self.arguments(arguments, printer).join(", "))
    }

    fn to_real(&self, value: String) -> String {
        format!("({})({value})", self.number())
    }

    fn to_whole(&self, value: String) -> String {
        format!("(int)({value})")
    }

    fn note(&self, text: &str) -> String {
        format!("/* {} */", text.replace("*/", "* /"))
    }

    fn fresh(&self, names: &[String], value: &Expr, printer: &Printer) -> Vec<String> {
        let Some((first, rest)) = names.split_first() else { return Vec::new() };
        let kind = if value.whole() { "int" } else { self.number_in(printer.function) };
        let zero = self.real(0.0);
        let mut lines: Vec<String> = rest.iter().map(|name| format!("{kind} {name} = {zero};")).collect();
        let value = match value {
            Expr::Call(function, arguments) if !rest.is_empty() => {
                let mut values = self.arguments(arguments, printer);
                values.extend(rest.iter().map(|name| format!("&{name}")));
                format!("{}({})", self.own(function), values.join(", "))
            }
            value => printer.expr(value),
        };
        // C99 does not need `const` for local variables, but readers benefit.
        let changed = printer.function.changes(first);
        lines.push(format!("{}{kind} {first} = {value};", if changed { "" } else { "const " }));
        lines
    }

    fn copy(&self, name: &str, of: &Place, block: &str, zero: bool, printer: &Printer) -> Vec<String> {
        let from = if self.addressed(printer.function, of) { format!("*{}", of.root) } else { self.place(of, printer) };
        let copy = format!("{} {name} = {from};", self.state(block));
        if !zero {
            return vec![copy];
        }
        // No aggregate initialiser: compilers disagree on the braces.
        let clear = self.rest(block, &format!("{name}."), true);
        std::iter::once(format!("{} {name};", self.state(block))).chain(clear).collect()
    }

    fn room(&self, name: &str, n: usize) -> Vec<String> {
        vec![format!("{} {name}[{n}] = {{{}}};", self.number(), self.real(0.0))]
    }

    fn done(&self, call: &Expr, printer: &Printer) -> String {
        let gives = printer.gives(call);
        format!("{}{};", if gives { "(void)" } else { "" }, printer.expr(call))
    }

    fn counting(&self, name: &str, from: &Expr, to: &Expr, down: bool, printer: &Printer) -> String {
        let (first, last, to) = (printer.expr(from), printer.expr(&less_one(to)), printer.expr(to));
        match down {
            false => format!("for (int {name} = {first}; {name} < {to}; {name}++) {{"),
            true => format!("for (int {name} = {last}; {name} >= {first}; {name}--) {{"),
        }
    }
}
