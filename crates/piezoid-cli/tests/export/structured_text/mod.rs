//! A reader of structured text, as far as exports use it, that runs what it reads.
//!
//! It is strict where controllers are: names are one whatever their capitals, are declared once and are no words of the
//! language; whole and real numbers do not mix; `AND` and `OR` look at both sides; an index out of range is an error.
//! What functions change, they are handed as a copy, and the copy goes back.

mod read;
mod run;

use std::collections::BTreeMap;

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Value {
    Real(f64),
    ExportedProgram(i64),
    Truth(bool),
    Array(Vec<Value>),
    /// Of this type.
    Struct(String, Room),
}

/// Variables by name.
pub(crate) type Room = BTreeMap<String, Value>;

#[derive(Debug, Clone)]
enum Expr {
    Constant(Value),
    At(Path),
    Call(String, Vec<Given>),
    Negative(Box<Expr>),
    Binary(String, Box<Expr>, Box<Expr>),
}

/// A name, and what is said of it: fields and indices.
type Path = (String, Vec<Access>);

#[derive(Debug, Clone)]
enum Access {
    Field(String),
    Index(Expr),
}

/// An argument: by the order, by name, or a result by name.
#[derive(Debug, Clone)]
enum Given {
    Next(Expr),
    Named(String, Expr),
    Result(String, Path),
}

#[derive(Debug, Clone)]
enum Step {
    Set(Path, Expr),
    Call(String, Vec<Given>),
    If(Vec<(Expr, Vec<Step>)>, Vec<Step>),
    For(String, [Expr; 3], Vec<Step>),
    While(Expr, Vec<Step>),
}

/// A function, a function block, a program, or a structure without steps.
#[derive(Debug, Clone, Default)]
struct Unit {
    /// The kind of each variable, its name, and what it begins with.
    variables: Vec<(String, String, Value)>,
    steps: Vec<Step>,
}

/// All that was read.
pub(crate) struct Library {
    units: BTreeMap<String, Unit>,
    single: bool,
}

impl Library {
    /// What stands in `text`, with numbers of single or double precision.
    pub(crate) fn read(text: &str, single: bool) -> Self {
        let mut library = Library { units: BTreeMap::new(), single };
        read::units(text, &mut library);
        library
    }

    /// A structure, a function block or a program as it begins.
    pub(crate) fn instance(&self, name: &str) -> Value {
        let unit = self.units.get(name).unwrap_or_else(|| panic!("there is no `{name}`"));
        Value::Struct(
            name.into(),
            unit.variables.iter().map(|(_, name, value)| (name.clone(), value.clone())).collect(),
        )
    }

    /// One cycle of a program.
    pub(crate) fn cycle(&self, instance: &mut Value) {
        let Value::Struct(name, room) = instance else { panic!("no program") };
        self.run(&self.units[name].steps, room);
    }

    fn round(&self, value: f64) -> f64 {
        if self.single { f64::from(value as f32) } else { value }
    }
}
