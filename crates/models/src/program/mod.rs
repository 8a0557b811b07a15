//! Programs: a small language for steps, whose operations exist in every target language.
//!
//! ```text
//! // What the play of threshold r holds back.
//! fn play(p, u, r) {
//!     return clamp(p, u - r, u + r);
//! }
//! fn hysteresis(x: hysteresis, u) {
//!     let z = w[0] * u;
//!     for k in 0..n {
//!         x.play[k] = play(x.play[k], u, r[k]);
//!         z += w[k + 1] * x.play[k];
//!     }
//!     return z;
//! }
//! ```
//! A block has fields (its state), constants, and functions. A parameter is a real number, an integer (`whole`), or the
//! state of a block, given by the name of the block. There are no early returns, no recursion, and no shadowed names: a
//! construct that one target language lacks, or that MISRA rules forbid, is no part of the language. A function returns
//! up to two numbers. Conditions have no side effects. `let t = copy(x);` copies a state, `let t = zero(x);` makes one
//! of zeros, `[0.0; n]` is an array of n numbers. `real(i)` converts an integer; `whole(v)` truncates a number that is
//! not negative. A loop whose ends are not constant says how often it runs `at most`. `epsilon`, `least` and `most` are
//! those of the precision in use, `measurable` is the largest size of a reading. Some target languages evaluate both
//! sides of `&&` and `||`. A comment before a function or a statement is printed in every language.
//!
//! A program is read ([`Program::new`]), differentiated ([`Program::slope`]), run ([`Machine`]) in single or double
//! precision, and printed by the export. [`Program::bound`] gives the largest number of its operations. The order of
//! the arithmetic is the same everywhere, so results are bit-identical.
//!
//! Why: docs/decisions/hysteresis-laws.md, "A law is written twice, to run and to export".

mod bound;
mod counted;
mod read;
mod resolve;
mod run;
mod slope;
mod tokens;
mod tree;

pub use run::{Counts, Machine};
pub use tree::{Argument, Expr, Function, Limit, Op, Place, Statement, ValueType};

use piezoid_numerics::error::Error;

/// A part of a program: a state, constants, and functions.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Block {
    /// Name, also of the type of its state.
    pub name: String,
    /// Description in one or two lines.
    pub about: String,
    /// The state, in order.
    pub fields: Vec<Field>,
    /// Constants.
    pub constants: Vec<Constant>,
    /// Integers that are inserted as literals, for example lengths.
    pub counts: Vec<(String, usize)>,
    /// The functions.
    pub text: String,
}

/// A part of a state.
#[derive(Debug, Clone, PartialEq)]
pub struct Field {
    /// Name.
    pub name: String,
    /// Value at rest.
    pub holds: FieldValue,
}

/// The value of a field at rest.
#[derive(Debug, Clone, PartialEq)]
pub enum FieldValue {
    /// One number.
    Number(f64),
    /// An array.
    Numbers(Vec<f64>),
    /// The state of the block with this name.
    Block(String),
}

/// A constant or a table of constants.
#[derive(Debug, Clone, PartialEq)]
pub struct Constant {
    /// Name.
    pub name: String,
    /// Values.
    pub values: Vec<f64>,
    /// True for a table, even one of one number.
    pub table: bool,
}

impl Block {
    /// A block without state, constants or functions.
    pub fn new(name: &str, about: impl Into<String>) -> Self {
        Block { name: name.into(), about: about.into(), ..Block::default() }
    }

    /// Adds a number to the state.
    pub fn number(self, name: &str, at_rest: f64) -> Self {
        self.field(name, FieldValue::Number(at_rest))
    }

    /// Adds an array to the state; an empty array adds nothing.
    pub fn numbers(self, name: &str, at_rest: Vec<f64>) -> Self {
        if at_rest.is_empty() { self } else { self.field(name, FieldValue::Numbers(at_rest)) }
    }

    /// Adds the state of another block to the state.
    pub fn part(self, name: &str, block: &str) -> Self {
        self.field(name, FieldValue::Block(block.into()))
    }

    fn field(mut self, name: &str, holds: FieldValue) -> Self {
        self.fields.push(Field { name: name.into(), holds });
        self
    }

    /// Adds a constant.
    pub fn constant(mut self, name: &str, value: f64) -> Self {
        self.constants.push(Constant { name: name.into(), values: vec![value], table: false });
        self
    }

    /// Adds a table of constants; an empty table adds nothing.
    pub fn table(mut self, name: &str, values: &[f64]) -> Self {
        if !values.is_empty() {
            self.constants.push(Constant { name: name.into(), values: values.to_vec(), table: true });
        }
        self
    }

    /// Adds a named integer.
    pub fn count(mut self, name: &str, value: usize) -> Self {
        self.counts.push((name.into(), value));
        self
    }

    /// Adds functions.
    pub fn text(mut self, text: &str) -> Self {
        self.text += text;
        self
    }
}

/// Blocks and their functions.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Program {
    /// The blocks, each after its parts.
    pub blocks: Vec<Block>,
    /// The functions, each after those it calls.
    pub functions: Vec<Function>,
}

impl Program {
    /// Reads the functions of `blocks`, which must be in the order of use.
    ///
    /// # Errors
    /// [`Error::Content`] with the function and the position if a text is not in the language.
    pub fn new(blocks: Vec<Block>) -> Result<Self, Error> {
        let mut program = Program::default();
        for block in blocks {
            program.add(block)?;
        }
        Ok(program)
    }

    /// Adds a block.
    ///
    /// # Errors
    /// The errors of [`Program::new`].
    pub fn add(&mut self, block: Block) -> Result<(), Error> {
        let text = block.text.clone();
        self.blocks.push(block);
        self.extend(&text)
    }

    /// Adds functions to the last block.
    ///
    /// # Errors
    /// The errors of [`Program::new`].
    pub fn extend(&mut self, text: &str) -> Result<(), Error> {
        read::functions(self, text)
    }

    /// The block with this name.
    pub fn block(&self, name: &str) -> Option<&Block> {
        self.blocks.iter().find(|b| b.name == name)
    }

    /// The function with this name.
    pub fn function(&self, name: &str) -> Option<&Function> {
        self.functions.iter().find(|f| f.name == name)
    }

    /// Length of the state of the block with this name.
    pub fn order(&self, block: &str) -> usize {
        self.at_rest(block).len()
    }

    /// Offset and type of the field at `path`, in a value of type `kind`.
    fn within(&self, mut kind: ValueType, path: &[String]) -> Result<(usize, ValueType), String> {
        let mut before = 0;
        for name in path {
            let ValueType::Part(block) = &kind else { return Err(format!("`{name}` is not a field")) };
            let fields = self.block(block).map_or(&[][..], |b| &b.fields);
            let Some(k) = fields.iter().position(|f| f.name == *name) else {
                return Err(format!("block `{block}` has no field `{name}`"));
            };
            before += fields[..k].iter().map(|f| self.resting(&f.holds).len()).sum::<usize>();
            kind = match &fields[k].holds {
                FieldValue::Number(_) => ValueType::Real,
                FieldValue::Numbers(values) => ValueType::Array(values.len()),
                FieldValue::Block(name) => ValueType::Part(name.clone()),
            };
        }
        Ok((before, kind))
    }

    /// The state at rest of the block with this name, as one vector.
    pub fn at_rest(&self, block: &str) -> Vec<f64> {
        let fields = self.block(block).map_or(&[][..], |b| &b.fields);
        fields.iter().flat_map(|field| self.resting(&field.holds)).collect()
    }

    fn resting(&self, holds: &FieldValue) -> Vec<f64> {
        match holds {
            FieldValue::Number(value) => vec![*value],
            FieldValue::Numbers(values) => values.clone(),
            FieldValue::Block(name) => self.at_rest(name),
        }
    }

    /// Removes all functions except `kept` and those they call, and all constants that these do not read.
    pub fn keep(&mut self, kept: &[&str]) {
        let mut needed: Vec<String> = kept.iter().map(|name| (*name).to_owned()).collect();
        for function in self.functions.iter().rev() {
            if needed.contains(&function.name) {
                function.calls(&mut |name| needed.push(name.to_owned()));
            }
        }
        self.functions.retain(|f| needed.contains(&f.name));
        let mut read = Vec::new();
        for function in &self.functions {
            function.expressions(&mut |expr| {
                if let Expr::Constant(block, name, _) = expr {
                    read.push((*block, name.clone()));
                }
            });
        }
        for (number, block) in self.blocks.iter_mut().enumerate() {
            block.constants.retain(|c| read.contains(&(number, c.name.clone())));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;

    fn block(text: &str) -> Block {
        let block = Block::new("b", "").number("last", 0.5).numbers("room", vec![1.0, 2.0, 3.0]);
        block.constant("gain", 4.0).table("r", &[1.0, 10.0, 100.0]).count("n", 3).text(text)
    }

    /// The results of function `f` of a block for these arguments.
    fn call(text: &str, numbers: &[f64]) -> Vec<f64> {
        let program = Program::new(vec![block(text)]).unwrap();
        Machine::new(&program, "b", false).call("f", numbers).unwrap()
    }

    #[test]
    fn statements_and_expressions_give_the_right_values() {
        let choice =
            "fn f(u) { let z = 0.0; if u < 1.0 || u > 9.0 { z = 1.0; } else if u == 5.0 { z = 2.0; } return z; }";
        let room = "fn f(x: b, u) { let t = copy(x); let z = zero(x); let s = [0.0; n]; t.room[1] = u; s[2] = t.room[1] + x.room[1]; return s[2], z.room[2]; }";
        for (text, u, result) in [
            ("fn f(u) { return 2.0 + 3.0 * u - 8.0 / 4.0 / 2.0; }", 5.0, &[16.0][..]),
            ("fn f(u) { return -u * 2.0 - -1.0; }", 3.0, &[-5.0]),
            ("fn f(u) { let s = u; for k in 0..n { s = s * 2.0 + r[k]; } return s; }", 1.0, &[132.0]),
            ("fn f(u) { let s = u; for k in 0..n down { s = s * 2.0 + r[k]; } return s; }", 1.0, &[429.0]),
            (
                "fn f(u) { let k = 0; while k < n && real(k) < u at most n { k += 1; } return real(k * 10 % 7); }",
                2.0,
                &[6.0],
            ),
            ("fn g(u) { return u, gain; } fn f(u) { let a, b = g(u); return b, a; }", 7.0, &[4.0, 7.0]),
            (choice, 0.0, &[1.0]),
            (choice, 5.0, &[2.0]),
            (choice, 6.0, &[0.0]),
            (choice, 10.0, &[1.0]),
            (room, 7.0, &[9.0, 0.0]),
        ] {
            assert_eq!(call(text, &[u]), result, "{text}");
        }
    }

    #[test]
    fn errors_about_a_text_state_the_reason() {
        for (text, reason) in [
            ("fn f(u) { return v; }", "`v` is not known"),
            ("fn f(u) { return g(u); }", "no function `g`"),
            ("fn f(u) { let u = 1.0; return u; }", "hides"),
            ("fn f(u) { let k = 1; return u + k; }", "mixes an integer and a real number"),
            ("fn f(u) { return r; }", "is a table"),
            ("fn f(x: b) { return x.first; }", "no field `first`"),
            ("fn f(x: c) { return 1.0; }", "no block `c`"),
            ("fn f(u) { let a, b = f(u); return a; }", "no function `f`"),
            ("fn f(u) { return u, u, u; }", "at most two numbers"),
            ("fn g(x: b) { x.last = 1.0; } fn f(x: b) { return g(x); }", "returns nothing"),
            ("fn f(u) { return 1.0; } fn f(u) { return 2.0; }", "already a function with this name"),
            ("fn f(u) { return 1.0 }", "`;` is missing"),
            ("fn f(u) { while u > 1.0 { } return u; }", "must say `at most`"),
            ("fn f(u) { while u > 1.0 at most whole(u) { } return u; }", "must be constant"),
            ("fn f(u) { return u # 2.0; }", "unknown character `#`"),
        ] {
            let error = Program::new(vec![block(text)]).unwrap_err().to_string();
            assert!(error.contains(reason), "{text}: {error}");
        }
    }

    #[test]
    fn an_index_out_of_range_is_an_error_and_does_not_panic() {
        for text in [
            "fn f(u) { return r[whole(u)]; }",
            "fn f(u) { let k = whole(u); return r[k - 4]; }",
            "fn f(u) { while u != r[whole(u)] at most 9 { } return u; }",
            "fn f(x: b, u) { for k in 0..999999999 { x.room[k + whole(u)] = u; } return u; }",
            "fn f(u) { while u == u || u != u at most 9 { } return u; }",
            "fn f(u) { for k in 0..4 + whole(u) at most 4 { } return u; }",
        ] {
            let program = Program::new(vec![block(text)]).unwrap();
            let mut machine = Machine::new(&program, "b", false);
            for u in [3.0, -1.0, f64::NAN, 1e12] {
                assert!(machine.call("f", &[u]).is_err(), "{text} of {u}");
            }
        }
    }

    #[test]
    fn nested_calls_of_a_function_and_reused_names_do_not_interfere() {
        let text = "
            fn g(a, b) { let t = a * 10.0; return t + b; }
            fn f(u) { let s = 0.0; for k in 0..2 { let t = g(g(1.0, 2.0), g(u, s)); s = t; } if s > 0.0 { let t = 1; s += real(t); } return s; }";
        // 10 (10 + 2) + 10 u + s, twice, and 1.
        assert_eq!(call(text, &[3.0]), [301.0]);
    }

    #[test]
    fn a_watched_machine_records_the_largest_values_and_keeps_its_state() {
        let text = "fn f(x: b, u) { x.last += u; if u > 9.0 { x.last = 0.0; } return -x.last * gain; }";
        let program = Program::new(vec![block(text)]).unwrap();
        let mut machine = Machine::new(&program, "b", false);
        machine.call("f", &[1.0]).unwrap();
        let mut machine = machine.watched();
        assert_eq!([2.0, -5.0].map(|u| machine.call("f", &[u]).unwrap()[0]), [-14.0, 6.0]);
        let function = &program.functions[0];
        let Statement::If(_, yes, _) = &function.steps[1] else { panic!("a choice") };
        let Statement::Set(_, zero) = &yes[0] else { panic!("a new value") };
        assert_eq!((machine.largest(&function.returns[0]), machine.largest(zero)), (Some(14.0), None));
        assert_eq!((machine.counts.sums, machine.counts.products, machine.counts.comparisons), (3, 3, 3));
    }

    #[test]
    fn slopes_agree_with_finite_differences() {
        let text = "
            fn h(v, c) { let w = v / (c + v * v); if w > 0.1 { w = w * w; } return w; }
            fn f(x: b, u) {
                let s = gain * u;
                for k in 0..n { x.room[k] = x.room[k] * u - s / r[k]; s += x.room[k] * h(u, r[k]); }
                x.last = s;
                return s * x.last - u;
            }";
        let mut program = Program::new(vec![block(text)]).unwrap();
        program.slope("f").unwrap();
        program.extend("fn ahead(x: b, u) { let t = copy(x); let d = zero(x); let z, s = f_slope(t, d, u, 1.0); return z, s; }").unwrap();
        let at = |name: &str, u: f64| Machine::new(&program, "b", false).call(name, &[u]).unwrap();
        for u in [-2.0, -0.3, 0.2, 1.7] {
            let [z, slope] = at("ahead", u)[..] else { panic!("two numbers") };
            assert_eq!(z, at("f", u)[0]);
            let near = (at("f", u + 1e-6)[0] - at("f", u - 1e-6)[0]) / 2e-6;
            assert_close(&[slope], &[near], 1e-7, 1e-6);
        }
    }

    #[test]
    fn unused_functions_and_constants_are_removed() {
        let text = "fn a(u) { return u * gain; } fn g(u) { return u; } fn f(u) { return g(u) + r[1]; }";
        let mut program = Program::new(vec![block(text)]).unwrap();
        program.keep(&["f"]);
        assert_eq!(program.functions.iter().map(|f| &*f.name).collect::<Vec<_>>(), ["g", "f"]);
        assert_eq!(program.blocks[0].constants.iter().map(|c| &*c.name).collect::<Vec<_>>(), ["r"]);
    }
}
