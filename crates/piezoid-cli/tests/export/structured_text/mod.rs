//! A reader and interpreter of the part of structured text that exports use.
//!
//! It is as strict as controllers: names are case-insensitive, are declared once and are no keywords; integers and
//! reals do not mix; `AND` and `OR` evaluate both sides; an index out of range is an error. A variable that a function
//! changes is copied in and copied back.

mod read;
mod run;

use std::collections::BTreeMap;

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Value {
    Real(f64),
    ExportedProgram(i64),
    Truth(bool),
    Array(Vec<Value>),
    /// A structure of this type.
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

/// A name, followed by fields and indices.
type Path = (String, Vec<Access>);

#[derive(Debug, Clone)]
enum Access {
    Field(String),
    Index(Expr),
}

/// An argument: by position, by name, or an output by name.
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
    /// The kind of each variable, its name, and its initial value.
    variables: Vec<(String, String, Value)>,
    steps: Vec<Step>,
}

/// Everything that was read.
pub(crate) struct Library {
    units: BTreeMap<String, Unit>,
    single: bool,
}

impl Library {
    /// Reads `text`, with numbers of single or double precision.
    pub(crate) fn read(text: &str, single: bool) -> Self {
        let mut library = Library { units: BTreeMap::new(), single };
        read::units(text, &mut library);
        library
    }

    /// A structure, a function block or a program with its initial values.
    pub(crate) fn instance(&self, name: &str) -> Value {
        let unit = self.units.get(name).unwrap_or_else(|| panic!("there is no `{name}`"));
        Value::Struct(
            name.into(),
            unit.variables.iter().map(|(_, name, value)| (name.clone(), value.clone())).collect(),
        )
    }

    /// Runs one cycle of a program.
    pub(crate) fn cycle(&self, instance: &mut Value) {
        let Value::Struct(name, room) = instance else { panic!("no program") };
        self.run(&self.units[name].steps, room);
    }

    fn round(&self, value: f64) -> f64 {
        if self.single { f64::from(value as f32) } else { value }
    }
}
