//! Scales of fixed-point numbers: a power of two for every named number, from its largest value in a run.

use piezoid_models::program::{Expr, FieldValue, Function, Machine, Op, Place, Program, Statement, ValueType};
use std::collections::HashMap;

/// A named number, or a result of a function.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(crate) enum Key {
    /// A variable, parameter or array of a function.
    Local(String, String),
    /// A field of a block.
    Field(String, String),
    /// A result of a function, by its position.
    Gives(String, usize),
}

/// The formats of a program.
#[derive(Debug, Default)]
pub(crate) struct Formats {
    largest: HashMap<Key, f64>,
    expressions: HashMap<*const Expr, f64>,
    /// Accumulating fields, which have 64 bits: their change per sample may be far less than a count.
    long: Vec<(String, String)>,
}

/// Functions that only compare and pass on numbers, independent of their scale.
pub(crate) const PLAIN: &[&str] = &["clamp", "magnitude", "way"];

/// Additional bits of accumulating fields.
pub(crate) const MORE: i32 = 20;

/// The exponent for which numbers up to `largest` are at most 2^30, so that twice as large ones still fit in 32 bits.
pub(crate) fn fitting(largest: f64) -> i32 {
    if largest > 0.0 { above(largest) - 30 } else { -30 }
}

/// The smallest power of two above `v` > 0.
pub(crate) fn above(v: f64) -> i32 {
    ((v.to_bits() >> 52) & 0x7FF) as i32 - 1022
}

impl Formats {
    /// The formats by the largest values in the runs of these machines.
    pub(crate) fn of(program: &Program, machines: &[Machine]) -> Self {
        let mut formats = Formats { long: adding(program), ..Default::default() };
        for function in program.functions.iter().filter(|f| !PLAIN.contains(&f.name.as_str())) {
            function.expressions(&mut |expr| {
                let observed = machines.iter().filter_map(|m| m.largest(expr)).reduce(f64::max);
                observed.map(|observed| formats.expressions.insert(expr, observed));
            });
        }
        for block in &program.blocks {
            for field in &block.fields {
                let at_rest = match &field.holds {
                    FieldValue::Number(v) => v.abs(),
                    FieldValue::Numbers(values) => values.iter().fold(0.0, |most, v| v.abs().max(most)),
                    FieldValue::Block(_) => continue,
                };
                formats.raise(Key::Field(block.name.clone(), field.name.clone()), at_rest);
            }
        }
        // The results of a function with several results have the same format inside and outside.
        for _ in 0..3 {
            program.functions.iter().for_each(|function| formats.gather(program, function));
        }
        formats
    }

    fn gather(&mut self, program: &Program, function: &Function) {
        let local = |name: &str| Key::Local(function.name.clone(), name.to_owned());
        for (k, expr) in function.returns.iter().enumerate() {
            self.raise(Key::Gives(function.name.clone(), k), self.observed(expr));
        }
        let mut steps = |step: &Statement| match step {
            Statement::Let(names, Expr::Call(called, _)) if names.len() > 1 => {
                for (k, name) in names.iter().enumerate() {
                    let (inside, outside) = (Key::Gives(called.clone(), k), local(name));
                    let most = self.most(&inside).max(self.most(&outside));
                    self.raise(inside, most);
                    self.raise(outside, most);
                }
            }
            Statement::Let(names, expr) if !expr.whole() => self.raise(local(&names[0]), self.observed(expr)),
            Statement::Set(place, expr) if !expr.whole() => {
                self.raise(key(program, function, place), self.observed(expr));
            }
            _ => {}
        };
        function.steps.iter().for_each(|step| step.all(&mut steps));
        function.expressions(&mut |expr| {
            let Expr::Call(name, arguments) = expr else { return };
            for (takes, values) in program.function(name).iter().flat_map(|f| f.takes.iter().zip(arguments)) {
                if takes.kind == ValueType::Real {
                    self.raise(Key::Local(name.clone(), takes.name.clone()), self.observed(values));
                }
            }
        });
    }

    /// Extends the range of a number to `most`.
    pub(crate) fn raise(&mut self, key: Key, most: f64) {
        let largest = self.largest.entry(key).or_insert(0.0);
        *largest = largest.max(most);
    }

    /// The largest known value of a number.
    pub(crate) fn most(&self, key: &Key) -> f64 {
        self.largest.get(key).copied().unwrap_or(0.0)
    }

    /// The exponent of a number.
    pub(crate) fn exponent(&self, key: &Key) -> i32 {
        fitting(self.most(key)) - if matches!(key, Key::Field(b, f) if self.is_long(b, f)) { MORE } else { 0 }
    }

    /// The exponent of the result of an expression, if it was ever evaluated.
    pub(crate) fn stated(&self, expr: &Expr) -> Option<i32> {
        self.expressions.get(&std::ptr::from_ref(expr)).map(|largest| fitting(*largest))
    }

    fn observed(&self, expr: &Expr) -> f64 {
        self.expressions.get(&std::ptr::from_ref(expr)).copied().unwrap_or(0.0)
    }

    /// True if a field has 64 bits.
    pub(crate) fn is_long(&self, block: &str, field: &str) -> bool {
        self.long.iter().any(|(b, f)| b == block && f == field)
    }
}

/// The number at a place of a function.
pub(crate) fn key(program: &Program, function: &Function, place: &Place) -> Key {
    let Some((last, path)) = place.path.split_last() else {
        return Key::Local(function.name.clone(), place.root.clone());
    };
    let mut block = function.takes.iter().find_map(|p| match &p.kind {
        ValueType::Part(of) if p.name == place.root => Some(of),
        _ => None,
    });
    function.steps.iter().for_each(|step| {
        step.all(&mut |step| match step {
            Statement::Copy { name, block: of, .. } if *name == place.root => block = Some(of),
            _ => {}
        });
    });
    let mut block = block.map_or("", String::as_str);
    for name in path {
        let field = program.block(block).and_then(|b| b.fields.iter().find(|f| f.name == *name));
        if let Some(FieldValue::Block(inner)) = field.map(|f| &f.holds) {
            block = inner;
        }
    }
    Key::Field(block.to_owned(), last.clone())
}

/// The accumulating fields.
pub(crate) fn adding(program: &Program) -> Vec<(String, String)> {
    let mut long = Vec::new();
    for function in &program.functions {
        let mut look = |step: &Statement| {
            if let Statement::Set(place, Expr::Binary(Op::Add, left, _)) = step
                && **left == Expr::At(place.clone())
                && let Key::Field(block, field) = key(program, function, place)
            {
                long.push((block, field));
            }
        };
        function.steps.iter().for_each(|step| step.all(&mut look));
    }
    long
}

/// The block and field of each number in the state of a block, in order.
pub(crate) fn fields(program: &Program, block: &str) -> Vec<(String, String)> {
    let fields = program.block(block).map_or(&[][..], |b| &b.fields);
    let own = |name: &str| (block.to_owned(), name.to_owned());
    let each = fields.iter().flat_map(|field| match &field.holds {
        FieldValue::Number(_) => vec![own(&field.name)],
        FieldValue::Numbers(values) => vec![own(&field.name); values.len()],
        FieldValue::Block(inner) => self::fields(program, inner),
    });
    each.collect()
}
