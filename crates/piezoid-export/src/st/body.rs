//! The body of a function in structured text.

use super::names::Names;
use super::{COUNTER, DONE, St, TABLES, UNUSED, also, comment, constant, zeros};
use crate::language::{Keywords, Language, Printer, less_one};
use piezoid_models::program::{Block, Expr, Place, ValueType};

/// A function and its printer.
pub(super) struct StBody<'i> {
    pub(super) st: &'i St<'i>,
    pub(super) names: &'i Names,
}

impl StBody<'_> {
    /// A call; further results go to `results`. Functions with a state or a second result are called with named
    /// parameters.
    fn called(&self, name: &str, arguments: &[Expr], results: &[String], printer: &Printer) -> String {
        let program = &self.st.whole.program;
        let own = self.st.globals.get(name);
        let Some((k, function)) = program.functions.iter().enumerate().find(|(_, f)| f.name == name) else {
            return format!("{own}()");
        };
        let inner = &self.st.inner[k].0;
        let reading = self.st.reading.iter().any(|known| known == name);
        let part = function.takes.iter().any(|p| matches!(p.kind, ValueType::Part(_)));
        if !part && !reading && function.returns.len() < 2 {
            let values: Vec<String> = arguments.iter().map(|a| printer.expr(a)).collect();
            return format!("{own}({})", values.join(", "));
        }
        let values =
            function.takes.iter().zip(arguments).map(|(p, a)| format!("{} := {}", inner.get(&p.name), printer.expr(a)));
        let tables = reading.then(|| format!("{} := {}", inner.get(TABLES), self.names.get(TABLES)));
        let results = results.iter().enumerate().map(|(k, to)| format!("{} => {to}", inner.get(&also(k + 1))));
        format!("{own}({})", values.chain(tables).chain(results).collect::<Vec<_>>().join(", "))
    }
}

const KEYWORDS: Keywords = Keywords {
    choice: "IF ? THEN",
    other_choice: "ELSIF ? THEN",
    otherwise: "ELSE",
    nothing: &[],
    repeat: "WHILE ? DO",
    ends: ["END_IF;", "END_FOR;", "END_WHILE;"],
    set: ":=",
    operators: ["+", "-", "*", "/", "MOD", "<", "<=", ">", ">=", "=", "<>", "AND", "OR"],
};

impl Language for StBody<'_> {
    fn keywords(&self) -> &'static Keywords {
        &KEYWORDS
    }

    fn real(&self, value: f64) -> String {
        // A number without a type may be double precision, and so would be the result.
        format!("{}{}", if self.st.single { "REAL#" } else { "" }, self.st.plain(value))
    }

    fn constant(&self, block: &Block, name: &str, index: Option<&Expr>, printer: &Printer) -> String {
        let key = constant(&block.name, name);
        match index {
            None => self.names.get(&key).into(),
            Some(index) => format!("{}.{}[{}]", self.names.get(TABLES), self.st.fields.get(&key), printer.expr(index)),
        }
    }

    fn place(&self, place: &Place, printer: &Printer) -> String {
        let mut text = self.names.get(&place.root).to_owned();
        place.path.iter().for_each(|field| text += &format!(".{}", self.st.fields.get(field)));
        place.index.iter().for_each(|index| text += &format!("[{}]", printer.expr(index)));
        text
    }

    fn call(&self, name: &str, arguments: &[Expr], printer: &Printer) -> String {
        self.called(name, arguments, &[], printer)
    }

    fn to_real(&self, value: String) -> String {
        format!("DINT_TO_{}({value})", self.st.number())
    }

    fn to_whole(&self, value: String) -> String {
        format!("TRUNC({value})")
    }

    fn note(&self, text: &str) -> String {
        comment(&[text.into()]).trim_end().into()
    }

    fn fresh(&self, names: &[String], value: &Expr, printer: &Printer) -> Vec<String> {
        let names: Vec<String> = names.iter().map(|name| self.names.get(name).into()).collect();
        let value = match value {
            Expr::Call(function, arguments) if names.len() > 1 => {
                self.called(function, arguments, &names[1..], printer)
            }
            value => printer.expr(value),
        };
        vec![format!("{} := {value};", names[0])]
    }

    fn copy(&self, name: &str, of: &Place, block: &str, zero: bool, printer: &Printer) -> Vec<String> {
        let name = self.names.get(name);
        match zero {
            true => self.st.cleared(block, name, self.names.get(COUNTER)),
            false => vec![format!("{name} := {};", self.place(of, printer))],
        }
    }

    fn room(&self, name: &str, n: usize) -> Vec<String> {
        zeros(self.names.get(name), n, self.names.get(COUNTER))
    }

    fn done(&self, call: &Expr, printer: &Printer) -> String {
        // Not every edition allows calls without using the result.
        let gives = printer.gives(call);
        format!("{} := {};", self.names.get(if gives { UNUSED } else { DONE }), printer.expr(call))
    }

    fn counting(&self, name: &str, from: &Expr, to: &Expr, down: bool, printer: &Printer) -> String {
        let (name, first, last) = (self.names.get(name), printer.expr(from), printer.expr(&less_one(to)));
        match down {
            false => format!("FOR {name} := {first} TO {last} DO"),
            true => format!("FOR {name} := {last} TO {first} BY -1 DO"),
        }
    }
}
