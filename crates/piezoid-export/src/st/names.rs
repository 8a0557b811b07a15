//! Names in structured text: each unique, and each declared once.

use super::{COUNTER, DONE, St, TABLES, UNUSED, Variable, also, constant};
use crate::ExportRequest;
use crate::exported::{ExportedProgram, state_of};
use piezoid::error::Error;
use piezoid_models::program::{Expr, FieldValue, Function, Statement};

/// Reserved names: keywords, and standard types, functions and blocks.
pub(super) const RESERVED: &str = include_str!("words.txt");

/// Unique names, none of them reserved; case-insensitive.
#[derive(Debug, Clone, Default)]
pub(super) struct Names {
    /// Names that are taken, in lower case.
    pub(super) taken: Vec<String>,
    /// Names of the program and their names here.
    pub(super) known: Vec<(String, String)>,
}

impl Names {
    pub(super) fn without(taken: &[String]) -> Self {
        Names { taken: taken.to_vec(), known: Vec::new() }
    }

    /// Adds a name for `key`: `wish`, with a number if that is taken.
    pub(super) fn add(&mut self, key: &str, wish: &str) {
        if self.known.iter().any(|(known, _)| known == key) {
            return;
        }
        let wish = wish.split('_').filter(|part| !part.is_empty()).collect::<Vec<_>>().join("_");
        let free = |name: &String| {
            let name = name.to_lowercase();
            !self.taken.contains(&name) && !RESERVED.split_whitespace().any(|word| word == name)
        };
        let found =
            std::iter::once(wish.clone()).chain((1..).map(|k| format!("{wish}_{k}"))).find(free).unwrap_or(wish);
        self.taken.push(found.to_lowercase());
        self.known.push((key.into(), found));
    }

    pub(super) fn get(&self, key: &str) -> &str {
        self.known.iter().find(|(known, _)| known == key).map_or("", |(_, name)| name)
    }
}

impl<'s> St<'s> {
    pub(super) fn new(whole: &'s ExportedProgram, request: &'s ExportRequest) -> Result<Self, Error> {
        let program = &whole.program;
        let (mut globals, mut fields) = (Names::default(), Names::default());
        let mut st = St {
            whole,
            single: request.options.float,
            globals: Names::default(),
            fields: Names::default(),
            inner: Vec::new(),
            reading: Vec::new(),
        };
        for entry in &whole.entries {
            globals.add(&format!("!{}", entry.step), &entry.named(request.name()));
        }
        for own in ["tables", "test"] {
            globals.add(&format!("!{own}"), &format!("{}_{own}", request.name()));
        }
        for block in &program.blocks {
            globals.add(&format!("!!{}", block.name), &format!("{}_{}", request.name(), state_of(&block.name)));
            block.fields.iter().for_each(|field| fields.add(&field.name, &field.name));
        }
        for block in &program.blocks {
            for c in block.constants.iter().filter(|c| c.table) {
                fields.add(&constant(&block.name, &c.name), &format!("{}_{}", block.name, c.name));
            }
        }
        for function in &program.functions {
            globals.add(&function.name, &format!("{}_{}", request.name(), function.name));
            let mut reads = false;
            function.expressions(&mut |expr| match expr {
                Expr::Constant(_, _, Some(_)) => reads = true,
                Expr::Call(name, _) => reads |= st.reading.contains(name),
                _ => {}
            });
            if reads {
                st.reading.push(function.name.clone());
            }
        }
        (st.globals, st.fields) = (globals, fields);
        st.inner = program.functions.iter().map(|f| st.named(f)).collect::<Result<_, _>>()?;
        Ok(st)
    }
}

impl St<'_> {
    /// The names of a function, and its variables, which are declared at its start.
    fn named(&self, function: &Function) -> Result<(Names, Vec<Variable>), Error> {
        let program = &self.whole.program;
        let mut names = Names::without(&self.globals.taken);
        let mut variables: Vec<Variable> = Vec::new();
        let mut twice = None;
        let number = self.number().to_owned();
        for parameter in &function.takes {
            names.add(&parameter.name, &parameter.name);
        }
        if self.reading.contains(&function.name) {
            names.add(TABLES, "tables");
        }
        (1..function.returns.len()).for_each(|k| names.add(&also(k), "also"));
        let mut declare = |key: &str, wish: &str, kind: String| {
            names.add(key, wish);
            match variables.iter().find(|(known, _)| known == key) {
                None => variables.push((key.into(), kind)),
                Some((_, known)) if *known != kind => twice = Some(key.to_owned()),
                Some(_) => {}
            }
        };
        let mut look = |step: &Statement| match step {
            Statement::Let(news, value) => {
                let kind = if value.whole() { "DINT".into() } else { number.clone() };
                news.iter().for_each(|name| declare(name, name, kind.clone()));
            }
            Statement::Copy { name, block, zero, .. } => {
                declare(name, name, self.state(block).into());
                if *zero && self.counted(block) {
                    declare(COUNTER, "k", "DINT".into());
                }
            }
            Statement::Array(name, n) => {
                declare(name, name, self.array(*n));
                declare(COUNTER, "k", "DINT".into());
            }
            Statement::For { name, .. } => declare(name, name, "DINT".into()),
            Statement::Do(Expr::Call(called, _)) => {
                match program.function(called).is_some_and(|f| f.returns.is_empty()) {
                    true => declare(DONE, "done", "BOOL".into()),
                    false => declare(UNUSED, "unused", number.clone()),
                }
            }
            _ => {}
        };
        function.steps.iter().for_each(|step| step.all(&mut look));
        function.expressions(&mut |expr| {
            if let Expr::Constant(block, name, None) = expr {
                names.add(&constant(&program.blocks[*block].name, name), name);
            }
        });
        match twice {
            None => Ok((names, variables)),
            Some(name) => Err(Error::Content(format!(
                "program, fn {}: `{name}` has two types, but structured text declares a name once per function: rename \
                one of them",
                function.name,
            ))),
        }
    }

    /// True if the state of a block contains an array.
    fn counted(&self, block: &str) -> bool {
        self.whole.program.block(block).is_some_and(|b| {
            b.fields.iter().any(|field| match &field.holds {
                FieldValue::Number(_) => false,
                FieldValue::Numbers(_) => true,
                FieldValue::Block(inner) => self.counted(inner),
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_differ_only_in_case_or_are_reserved_get_a_number() {
        let mut names = Names::without(&["bender".into()]);
        for name in ["h", "H", "left", "two__lines_", "Bender", "h"] {
            names.add(name, name);
        }
        let found: Vec<&str> = names.known.iter().map(|(_, name)| name.as_str()).collect();
        assert_eq!(found, ["h", "H_1", "left_1", "two_lines", "Bender_1"]);
    }
}
