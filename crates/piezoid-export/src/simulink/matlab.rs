//! MATLAB and GNU Octave.
//!
//! States are structs that functions take and return: `[x, y] = bender_creep(x, z)`. Functions are local functions
//! after the class. Octave 7 accepts them there as MATLAB does, they hide nothing on the path, and calls are faster
//! than those of static methods (in Octave 7.3 by a sixth). Each function keeps its constants in a persistent variable,
//! because a class looks up a property in every access.
//!
//! Integers are doubles, also in single precision. There every literal is converted to `single`: MATLAB's literals are
//! doubles, and two of them would be combined in double precision.

use super::extract_calls::{CallExtractor, fresh, known};
use crate::c::{shortest, wrapped};
use crate::exported::{Entry, ExportedProgram};
use crate::language::{Keywords, Language, Printer, less_one};
use crate::template::{Value, blocks, context, template_context};
use crate::vectors::UNKNOWN_RANGE;
use crate::{ExportRequest, named};
use piezoid::Model;
use piezoid::error::Error;
use piezoid_models::program::{Block, Constant, Expr, Field, FieldValue, Function, Op, Place, Program, ValueType};
use std::collections::BTreeMap;

/// Keywords of MATLAB and Octave.
const WORDS: &str = "break case catch classdef continue do else elseif end endfor endfunction endif endwhile \
    enumeration events for function global if methods otherwise parfor persistent properties return spmd switch try \
    until unwind_protect while";

/// Names of the class and of the functions that it calls.
const TAKEN: &str = "abs add_block add_line ans close_system control_reset control_simulate control_state control_step \
    double error exist ff_reset ff_simulate ff_state ff_step fileparts floor fprintf fullfile handle isempty isscalar \
    load_system mat2str max mex mfilename mod nargin new_system numel onCleanup repmat reset set_param sim simulate \
    single size sprintf state step strjoin struct sum Ts typecast uint32 uint64 units zeros";

/// Names that the printed functions use: a variable of this name would hide them.
const CALLED: &str = "constants double floor isempty mod repmat single zeros";

/// A name of the program as MATLAB can have it: reserved words get an underscore, so that no two names become equal.
fn allowed(name: &str) -> String {
    let word = name.trim_end_matches('_');
    let is_taken = WORDS.split_whitespace().chain(CALLED.split_whitespace()).any(|taken| taken == word);
    if is_taken { format!("{name}_") } else { name.into() }
}

/// Number of significant characters in a MATLAB name.
const LONGEST: usize = 63;

/// The printer, with the functions of a program in the form that MATLAB needs.
pub(super) struct Matlab<'m> {
    program: Program,
    name: &'m str,
    single: bool,
}

impl<'m> Matlab<'m> {
    /// The printer for an export.
    ///
    /// # Errors
    /// Returns an error for a name that MATLAB or Octave uses, or with which function names are too long.
    pub(super) fn of(whole: &ExportedProgram, request: &'m ExportRequest) -> Result<Self, Error> {
        named(request.name(), &format!("{WORDS} {TAKEN}"))?;
        let mut program = whole.program.clone();
        for function in &mut program.functions {
            // Entry functions return their state even if it never changes.
            let outside = whole.entries.iter().any(|entry| entry.step == function.name);
            let states = function.takes.iter_mut().filter(|p| matches!(p.kind, ValueType::Part(_)));
            states.for_each(|p| p.changed |= outside);
        }
        program.functions = program.functions.iter().map(|function| CallExtractor::of(function, &program)).collect();
        let constants = program.blocks.iter().map(|block| constants_of(&block.name).len());
        let added = program.functions.iter().map(|f| f.name.len()).chain(constants).max().unwrap_or(0) + 1;
        if request.name().len() + added > LONGEST {
            let most = LONGEST - added;
            let rule = format!("must have at most {most} characters: MATLAB uses {LONGEST} of a function name");
            return Err(Error::parameter("name", format!("`{}`", request.name()), rule));
        }
        Ok(Matlab { program, name: request.name(), single: request.options.float })
    }

    pub(super) fn template_context(&self, whole: &ExportedProgram, request: &ExportRequest) -> Value {
        let block = |(block, functions): (&Block, Vec<(usize, &Function)>)| {
            let constant = |c: &Constant| match c.table {
                false => format!("{} = {}", allowed(&c.name), self.real(c.values[0])),
                true => format!("{} = {}", allowed(&c.name), self.column(&c.values, "    ")),
            };
            let constants: Value = block.constants.iter().map(constant).collect();
            let functions: Value = functions.into_iter().map(|(_, f)| self.function(f)).collect();
            context! { name => &block.name, about => &block.about, constants, functions }
        };
        // The example covers the whole input range of the model.
        let (low, high) = request.model.known_inputs().unwrap_or(UNKNOWN_RANGE);
        let simulate = |e: &Entry| (e.kind(), format!("{}_simulate", e.kind()).trim_start_matches('_').to_owned());
        let rest = |e: &Entry| (e.state, self.rest(e.state, "s", false));
        let own = context! {
            number => if self.single { "single" } else { "double" },
            feedthrough => feedthrough(request.model),
            middle => 0.5 * (low + high), half => 0.5 * (high - low),
            simulate => whole.entries.iter().map(simulate).collect::<BTreeMap<_, _>>(),
            rest => whole.entries.iter().map(rest).collect::<BTreeMap<_, _>>(),
            blocks => blocks(&self.program).map(block).collect::<Value>(),
        };
        context! { ..own, ..template_context(request, whole, &|values| self.column(values, "    ")) }
    }

    fn function(&self, function: &Function) -> String {
        let printer = Printer { program: &self.program, function, language: self, single: self.single };
        let mut known = known(function);
        let mut gives: Vec<String> = function.takes.iter().filter(|p| p.changed).map(|p| allowed(&p.name)).collect();
        let mut last = String::new();
        for expr in &function.returns {
            match expr {
                // A variable needs no second name.
                Expr::Variable(name, _) if !gives.contains(&allowed(name)) => gives.push(allowed(name)),
                expr => {
                    let name = fresh("result", &mut known);
                    last += &format!("    {name} = {};\n", printer.expr(expr));
                    gives.push(name);
                }
            }
        }
        let takes: Vec<String> = function.takes.iter().map(|p| allowed(&p.name)).collect();
        let mut out = format!("function {}{}({})\n", handed(&gives), self.own(&function.name), takes.join(", "));
        out += &function.about.iter().map(|about| format!("    % {about}\n")).collect::<String>();
        let mut reads = false;
        function.expressions(&mut |expr| reads |= matches!(expr, Expr::Constant(..)));
        if reads {
            let name = self.own(&constants_of(&self.program.blocks[function.block].name));
            out += "    persistent constants\n    if isempty(constants)\n";
            out += &format!("        constants = {name}();\n    end\n");
        }
        out + &printer.steps(&function.steps, 1) + &last + "end\n"
    }

    /// Lines that set the state of a block to rest, or to zero.
    fn rest(&self, block: &str, prefix: &str, zero: bool) -> Vec<String> {
        let fields = self.program.block(block).map_or(&[][..], |b| &b.fields);
        let line = |field: &Field| match (&field.holds, format!("{prefix}.{}", allowed(&field.name))) {
            (FieldValue::Block(inner), name) => self.rest(inner, &name, zero),
            (FieldValue::Number(_), name) if zero => vec![format!("{name} = {};", self.real(0.0))],
            (FieldValue::Number(value), name) => vec![format!("{name} = {};", self.real(*value))],
            (FieldValue::Numbers(_), name) if zero => vec![format!("{name}(:) = 0;")],
            (FieldValue::Numbers(values), name) => match values.iter().all(|v| v.to_bits() == values[0].to_bits()) {
                true if values[0].to_bits() == 0 => vec![format!("{name} = {};", self.zeros(values.len()))],
                true => vec![format!("{name} = repmat({}, {}, 1);", self.real(values[0]), values.len())],
                false => format!("{name} = {};", self.column(values, "")).lines().map(str::to_owned).collect(),
            },
        };
        fields.iter().flat_map(line).collect()
    }

    /// A name with the prefix of the export.
    fn own(&self, name: &str) -> String {
        format!("{}_{name}", self.name)
    }

    fn zeros(&self, n: usize) -> String {
        format!("zeros({n}, 1{})", if self.single { ", 'single'" } else { "" })
    }

    /// A column vector.
    fn column(&self, values: &[f64], indent: &str) -> String {
        let values: Vec<String> = values.iter().map(|v| shortest(*v, self.single)).collect();
        let rows: String = wrapped(&values).replace(',', ";").lines().map(|row| format!("{indent}{row}\n")).collect();
        let column = format!("[\n{rows}{indent}]");
        if self.single { format!("single({column})") } else { column }
    }

    /// The results of a call: the states that it changes, then `names`.
    fn targets(&self, function: &Function, arguments: &[Expr], names: &[String], printer: &Printer) -> Vec<String> {
        let changed = function.takes.iter().zip(arguments).filter(|(parameter, _)| parameter.changed);
        changed.map(|(_, argument)| printer.expr(argument)).chain(names.iter().map(|name| allowed(name))).collect()
    }
}

/// True if an input acts on the output of the same sample: with hysteresis in feedback on what is read at its end, of
/// blocks in series unless b0 = 0.
fn feedthrough(model: &Model) -> bool {
    let of_blocks = || model.linear().b().first().is_some_and(|b0| *b0 != 0.0);
    model.feedback().map_or_else(of_blocks, |feedback| feedback.dynamics().delay == 0)
}

/// The function that returns the constants of a block.
fn constants_of(block: &str) -> String {
    format!("{block}_constants")
}

/// The left side of a call with these results.
fn handed(names: &[String]) -> String {
    match names {
        [] => String::new(),
        [one] => format!("{one} = "),
        several => format!("[{}] = ", several.join(", ")),
    }
}

/// The MATLAB index of the zero-based `index`.
fn from_one(index: &Expr) -> Expr {
    let sum = |left: &Expr, n: usize| Expr::Binary(Op::Add, Box::new(left.clone()), Box::new(Expr::Integer(n)));
    match index {
        Expr::Integer(n) => Expr::Integer(n + 1),
        Expr::Binary(Op::Add, left, right) if let Expr::Integer(n) = **right => sum(left, n + 1),
        Expr::Binary(Op::Subtract, left, right) if **right == Expr::Integer(1) => (**left).clone(),
        index => sum(index, 1),
    }
}

const KEYWORDS: Keywords = Keywords {
    choice: "if ?",
    other_choice: "elseif ?",
    otherwise: "else",
    nothing: &[],
    repeat: "while ?",
    ends: ["end"; 3],
    set: "=",
    // Remainders are printed by `divided`.
    operators: ["+", "-", "*", "/", "/", "<", "<=", ">", ">=", "==", "~=", "&&", "||"],
};

impl Language for Matlab<'_> {
    fn keywords(&self) -> &'static Keywords {
        &KEYWORDS
    }

    fn real(&self, value: f64) -> String {
        let text = shortest(value, self.single);
        if self.single { format!("single({text})") } else { text }
    }

    fn constant(&self, _: &Block, name: &str, index: Option<&Expr>, printer: &Printer) -> String {
        let index = index.map_or(String::new(), |index| format!("({})", printer.expr(&from_one(index))));
        format!("constants.{}{index}", allowed(name))
    }

    fn place(&self, place: &Place, printer: &Printer) -> String {
        let mut text = allowed(&place.root);
        place.path.iter().for_each(|field| text += &format!(".{}", allowed(field)));
        place.index.iter().for_each(|index| text += &format!("({})", printer.expr(&from_one(index))));
        text
    }

    fn call(&self, name: &str, arguments: &[Expr], printer: &Printer) -> String {
        let arguments: Vec<String> = arguments.iter().map(|a| printer.expr(a)).collect();
        format!("{}({})", self.own(name), arguments.join(", "))
    }

    fn to_real(&self, value: String) -> String {
        let simple = value.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
        match (self.single, simple) {
            (true, _) => format!("single({value})"),
            (false, true) => value,
            (false, false) => format!("({value})"),
        }
    }

    fn to_whole(&self, value: String) -> String {
        if self.single { format!("double(floor({value}))") } else { format!("floor({value})") }
    }

    fn divided(&self, op: Op, left: &str, right: &str) -> Option<String> {
        Some(if op == Op::Remainder { format!("mod({left}, {right})") } else { format!("floor({left} / {right})") })
    }

    fn note(&self, text: &str) -> String {
        format!("% {text}")
    }

    fn fresh(&self, names: &[String], value: &Expr, printer: &Printer) -> Vec<String> {
        let called = match value {
            Expr::Call(name, arguments) => self.program.function(name).map(|function| (function, arguments)),
            _ => None,
        };
        let plain = || names.iter().map(|name| allowed(name)).collect();
        let names =
            called.map_or_else(plain, |(function, arguments)| self.targets(function, arguments, names, printer));
        vec![format!("{}{};", handed(&names), printer.expr(value))]
    }

    fn copy(&self, name: &str, of: &Place, block: &str, zero: bool, printer: &Printer) -> Vec<String> {
        let name = allowed(name);
        let copy = format!("{name} = {};", self.place(of, printer));
        let clear = if zero { self.rest(block, &name, true) } else { Vec::new() };
        std::iter::once(copy).chain(clear).collect()
    }

    fn room(&self, name: &str, n: usize) -> Vec<String> {
        vec![format!("{} = {};", allowed(name), self.zeros(n))]
    }

    fn done(&self, call: &Expr, printer: &Printer) -> String {
        self.fresh(&[], call, printer).concat()
    }

    fn counting(&self, name: &str, from: &Expr, to: &Expr, down: bool, printer: &Printer) -> String {
        let bound = |expr: &Expr| match expr {
            Expr::Binary(..) => format!("({})", printer.expr(expr)),
            expr => printer.expr(expr),
        };
        let (name, first, last) = (allowed(name), bound(from), bound(&less_one(to)));
        if down { format!("for {name} = {last}:-1:{first}") } else { format!("for {name} = {first}:{last}") }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid::hysteresis::OPERATORS;
    use piezoid::linear::Arx;

    /// The printed functions of a block `tank`.
    fn printed(text: &str, single: bool) -> String {
        let tank =
            Block::new("tank", "a tank").number("level", 0.0).numbers("past", vec![0.0; 3]).table("gain", &[0.5, -2.0]);
        let program = Program::new(vec![tank.text(text)]).unwrap();
        let functions = program.functions.iter().map(|function| CallExtractor::of(function, &program)).collect();
        let matlab = Matlab { program: Program { functions, ..program }, name: "my", single };
        matlab.program.functions.iter().map(|f| matlab.function(f)).collect()
    }

    #[test]
    fn a_call_that_changes_a_state_is_a_statement_of_its_own() {
        let text = "fn fill(x: tank, u) { x.level += u; return x.level; }
            fn both(x: tank, t: tank, u) { return -fill(x, fill(t, u)) + fill(t, 2.0 * u); }
            fn empty(x: tank) { fill(x, -x.level); }";
        let expected = "\
function [x, result] = my_fill(x, u)
    x.level = x.level + u;
    result = x.level;
end
function [x, t, result] = my_both(x, t, u)
    [t, from_fill] = my_fill(t, u);
    [x, from_fill_2] = my_fill(x, from_fill);
    [t, from_fill_3] = my_fill(t, 2.0 * u);
    result = -from_fill_2 + from_fill_3;
end
function x = my_empty(x)
    x = my_fill(x, -x.level);
end
";
        assert_eq!(printed(text, false), expected);
    }

    #[test]
    fn reserved_words_get_an_underscore_and_names_stay_different() {
        let text = "fn f(end, end_) {
                let case = end * 2.0;
                for global in 0..2 { case = case + real(global); }
                return case - end_;
            }";
        let expected = "\
function result = my_f(end_, end__)
    case_ = end_ * 2.0;
    for global_ = 0:1
        case_ = case_ + global_;
    end
    result = case_ - end__;
end
";
        assert_eq!(printed(text, false), expected);
    }

    #[test]
    fn indices_count_from_one_and_integers_divide_as_integers() {
        let text = "fn f(x: tank, n: whole) {
                let sum = 0.0;
                for k in 1..n down { sum += gain[k] * x.past[k - 1] + x.past[0] - x.past[k + 1]; }
                if n % 2 == 1 && sum != 0.0 { sum = real(n / 2 + 1); }
                else if sum > 1.0 { x.past[whole(sum)] = most; }
                let t = zero(x);
                let more = [0.0; 4];
                return sum, more[2] + t.level;
            }";
        let expected = "\
function [x, sum, result] = my_f(x, n)
    persistent constants
    if isempty(constants)
        constants = my_tank_constants();
    end
    sum = 0.0;
    for k = (n - 1):-1:1
        sum = sum + (constants.gain(k + 1) * x.past(k) + x.past(1) - x.past(k + 2));
    end
    if (mod(n, 2) == 1) && (sum ~= 0.0)
        sum = (floor(n / 2) + 1);
    elseif sum > 1.0
        x.past(floor(sum) + 1) = 1.7976931348623157e308;
    end
    t = x;
    t.level = 0.0;
    t.past(:) = 0;
    more = zeros(4, 1);
    result = more(3) + t.level;
end
";
        assert_eq!(printed(text, false), expected);
    }

    #[test]
    fn in_single_precision_no_literal_is_a_double() {
        let text =
            "fn f(n: whole) { let half = 0.5; let room = [0.0; 2]; return half + 0.1 * real(n) - room[whole(half)]; }";
        let expected = "\
function result = my_f(n)
    half = single(0.5);
    room = zeros(2, 1, 'single');
    result = half + single(0.1) * single(n) - room(double(floor(half)) + 1);
end
";
        assert_eq!(printed(text, true), expected);
    }

    #[test]
    fn a_condition_that_changes_a_state_is_an_error() {
        let text =
            "fn fill(x: tank, u) { x.level += u; return x.level; } fn f(x: tank) { while fill(x, 1.0) < 3.0 { } }";
        let tank = Block::new("tank", "a tank").number("level", 0.0);
        let error = Program::new(vec![tank.text(text)]).unwrap_err().to_string();
        assert!(error.contains("a condition changes a state"), "{error}");
    }

    #[test]
    fn no_operator_uses_a_name_that_hides_a_matlab_function() {
        const CALLED: [&str; 8] = ["constants", "double", "floor", "isempty", "mod", "repmat", "single", "zeros"];
        let keywords: Vec<&str> = WORDS.split_whitespace().chain(CALLED).collect();
        for operator in OPERATORS {
            let linear = Arx::new(5e-4, vec![1.6, -0.8], vec![0.1, 0.1]).unwrap();
            let model = Model::new((operator.example)(5e-4).unwrap(), linear, 2.0).unwrap();
            let Ok(whole) = ExportedProgram::new(&ExportRequest::new(&model, "bender")) else { continue };
            let fields =
                whole.program.blocks.iter().flat_map(|block| block.fields.iter().map(|field| field.name.clone()));
            let constants =
                whole.program.blocks.iter().flat_map(|block| block.constants.iter().map(|c| c.name.clone()));
            let names = whole.program.functions.iter().flat_map(known).chain(fields).chain(constants);
            for name in names {
                assert!(!keywords.contains(&name.as_str()), "{}: `{name}`", operator.name);
            }
        }
    }

    #[test]
    fn a_name_too_long_for_the_functions_is_an_error_with_the_allowed_length() {
        let plays = (piezoid::hysteresis::Operator::find("prandtl-ishlinskii").unwrap().example)(5e-4).unwrap();
        let model = Model::new(plays, Arx::new(5e-4, vec![], vec![1.0]).unwrap(), 0.0).unwrap();
        let mut whole = ExportedProgram::new(&ExportRequest::new(&model, "bender")).unwrap();
        let long = "fn a_function_of_a_name_that_is_too_long_for_matlab(v) { return v; }";
        whole.program.extend(long).unwrap();
        let error = Matlab::of(&whole, &ExportRequest::new(&model, "fifteen_letters")).err().unwrap().to_string();
        assert!(error.contains("must have at most 14 characters"), "{error}");
        assert!(Matlab::of(&whole, &ExportRequest::new(&model, "fourteen_chars")).is_ok());
    }
}
