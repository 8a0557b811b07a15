//! A reader of structured text, as far as exports use it, that runs what it reads.
//!
//! It is strict where controllers are: names are one whatever their capitals, are declared once and are no words of the language;
//! whole and real numbers do not mix; `AND` and `OR` look at both sides; an index out of range is an error. What functions change, they
//! are handed as a copy, and the copy goes back.

use std::collections::BTreeMap;

#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Value {
    Real(f64),
    Whole(i64),
    Truth(bool),
    Array(Vec<Value>),
    /// Of this type.
    Struct(String, Room),
}

/// Variables by name.
pub(crate) type Room = BTreeMap<String, Value>;

#[derive(Debug, Clone, PartialEq)]
enum Word {
    Name(String),
    Real(f64),
    Whole(i64),
    Sign(String),
}

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

const WORDS: [&str; 30] = [
    "and", "array", "bool", "by", "dint", "do", "else", "elsif", "end_if", "exp", "false", "for", "function", "if",
    "left", "len", "limit", "ln", "lreal", "mod", "of", "or", "real", "right", "step", "then", "to", "true", "trunc",
    "while",
];

fn words(text: &str) -> Vec<Word> {
    let (mut words, mut rest) = (Vec::new(), text.trim_start());
    while let Some(first) = rest.chars().next() {
        let length = |ends: &dyn Fn(char) -> bool| rest.find(|c| !ends(c)).unwrap_or(rest.len());
        let taken = if rest.starts_with("(*") {
            rest.find("*)").unwrap() + 2
        } else if rest.starts_with("REAL#") {
            5
        } else if first.is_ascii_alphabetic() {
            let n = length(&|c| c.is_ascii_alphanumeric() || c == '_');
            assert!(!rest[..n].contains("__") && !rest[..n].ends_with('_'), "{}", &rest[..n]);
            words.push(Word::Name(rest[..n].to_lowercase()));
            n
        } else if first.is_ascii_digit() {
            let mut n = length(&|c| c.is_ascii_digit());
            if rest[n..].starts_with('.') && !rest[n..].starts_with("..") {
                n = rest.find(|c: char| !c.is_ascii_digit() && !".E-".contains(c)).unwrap_or(rest.len());
                // A minus belongs to it only after E.
                n = rest[..n].match_indices('-').find(|(k, _)| !rest[..*k].ends_with('E')).map_or(n, |(k, _)| k);
                words.push(Word::Real(rest[..n].parse().unwrap()));
            } else {
                words.push(Word::Whole(rest[..n].parse().unwrap()));
            }
            n
        } else {
            let signs = [":=", "=>", "<=", ">=", "<>", ".."];
            let n = if signs.iter().any(|sign| rest.starts_with(sign)) { 2 } else { 1 };
            words.push(Word::Sign(rest[..n].into()));
            n
        };
        rest = rest[taken..].trim_start();
    }
    words
}

struct Reader<'r> {
    library: &'r mut Library,
    words: Vec<Word>,
    at: usize,
}

impl Reader<'_> {
    fn is(&self, word: &str) -> bool {
        matches!(self.words.get(self.at), Some(Word::Name(w) | Word::Sign(w)) if w == word)
    }

    fn pass(&mut self, word: &str) -> bool {
        let is = self.is(word);
        self.at += usize::from(is);
        is
    }

    fn expect(&mut self, word: &str) {
        let near = &self.words[self.at.saturating_sub(8)..(self.at + 3).min(self.words.len())];
        assert!(self.is(word), "`{word}` is missing near {near:?}");
        self.at += 1;
    }

    fn name(&mut self) -> String {
        let Word::Name(name) = self.words[self.at].clone() else { panic!("{:?} is no name", self.words[self.at]) };
        self.at += 1;
        name
    }

    fn units(&mut self) {
        while self.at < self.words.len() {
            let kind = self.name();
            let name = self.name();
            let mut unit = Unit::default();
            if kind == "type" {
                self.expect(":");
                self.expect("struct");
                self.variables("field", &mut unit);
                for word in ["end_struct", ";", "end_type"] {
                    self.expect(word);
                }
            } else {
                if self.pass(":") {
                    let value = self.kind();
                    unit.variables.push(("return".into(), name.clone(), value));
                }
                while let Some(section) = ["var_input", "var_in_out", "var_output", "var"].iter().find(|s| self.pass(s))
                {
                    let constant = self.pass("constant");
                    self.variables(if constant { "constant" } else { section }, &mut unit);
                    self.expect("end_var");
                }
                unit.steps = self.steps();
                self.expect(&format!("end_{kind}"));
            }
            assert!(self.library.units.insert(name.clone(), unit).is_none(), "there are two of `{name}`");
        }
    }

    fn variables(&mut self, kind: &str, unit: &mut Unit) {
        while !self.is("end_var") && !self.is("end_struct") {
            let name = self.name();
            assert!(!WORDS.contains(&name.as_str()), "`{name}` is a word of the language");
            assert!(unit.variables.iter().all(|(_, known, _)| *known != name), "`{name}` is declared twice");
            self.expect(":");
            let mut value = self.kind();
            if self.pass(":=") {
                let given = if self.is("[") { self.list() } else { self.signed() };
                match (&value, &given) {
                    (Value::Array(a), Value::Array(b)) => assert_eq!(a.len(), b.len(), "{name}"),
                    (Value::Real(_), Value::Real(_)) => {}
                    _ => panic!("{name} begins with {given:?}"),
                }
                value = given;
            }
            self.expect(";");
            unit.variables.push((kind.into(), name, value));
        }
    }

    /// What a variable of the type that comes next begins with.
    fn kind(&mut self) -> Value {
        match self.name().as_str() {
            "lreal" => {
                assert!(!self.library.single);
                Value::Real(0.0)
            }
            "real" => {
                assert!(self.library.single);
                Value::Real(0.0)
            }
            "dint" => Value::Whole(0),
            "bool" => Value::Truth(false),
            "array" => {
                for word in ["[", "..", "]", "of"] {
                    if word == ".." || word == "]" {
                        self.at += 1;
                    }
                    self.expect(word);
                }
                let Word::Whole(last) = self.words[self.at - 3] else { panic!("an array without end") };
                Value::Array(vec![self.kind(); 1 + last as usize])
            }
            name => self.library.instance(name),
        }
    }

    fn list(&mut self) -> Value {
        self.expect("[");
        let mut values = vec![self.signed()];
        while self.pass(",") {
            values.push(self.signed());
        }
        self.expect("]");
        Value::Array(values)
    }

    fn signed(&mut self) -> Value {
        let minus = self.pass("-");
        let Word::Real(value) = self.words[self.at] else { panic!("{:?} is no number", self.words[self.at]) };
        self.at += 1;
        Value::Real(self.library.round(if minus { -value } else { value }))
    }

    fn steps(&mut self) -> Vec<Step> {
        let mut steps = Vec::new();
        let ends =
            ["else", "elsif", "end_if", "end_for", "end_while", "end_function", "end_function_block", "end_program"];
        while !ends.iter().any(|end| self.is(end)) {
            steps.push(self.step());
            self.expect(";");
        }
        steps
    }

    fn step(&mut self) -> Step {
        if self.pass("if") {
            let mut ways = Vec::new();
            loop {
                let holds = self.expr(1);
                self.expect("then");
                ways.push((holds, self.steps()));
                if !self.pass("elsif") {
                    break;
                }
            }
            let no = if self.pass("else") { self.steps() } else { Vec::new() };
            self.expect("end_if");
            return Step::If(ways, no);
        }
        if self.pass("for") {
            let name = self.name();
            self.expect(":=");
            let from = self.expr(1);
            self.expect("to");
            let to = self.expr(1);
            let by = if self.pass("by") { self.expr(1) } else { Expr::Constant(Value::Whole(1)) };
            self.expect("do");
            let steps = self.steps();
            self.expect("end_for");
            return Step::For(name, [from, to, by], steps);
        }
        if self.pass("while") {
            let holds = self.expr(1);
            self.expect("do");
            let steps = self.steps();
            self.expect("end_while");
            return Step::While(holds, steps);
        }
        let path = self.path();
        if self.is("(") {
            return Step::Call(path.0, self.given());
        }
        self.expect(":=");
        Step::Set(path, self.expr(1))
    }

    fn path(&mut self) -> Path {
        let root = self.name();
        let mut path = Vec::new();
        loop {
            if self.pass(".") {
                path.push(Access::Field(self.name()));
            } else if self.pass("[") {
                path.push(Access::Index(self.expr(1)));
                self.expect("]");
            } else {
                return (root, path);
            }
        }
    }

    fn given(&mut self) -> Vec<Given> {
        self.expect("(");
        let mut given = Vec::new();
        loop {
            let sign = self.words.get(self.at + 1).cloned();
            given.push(if sign == Some(Word::Sign(":=".into())) {
                let name = self.name();
                self.at += 1;
                Given::Named(name, self.expr(1))
            } else if sign == Some(Word::Sign("=>".into())) {
                let name = self.name();
                self.at += 1;
                Given::Result(name, self.path())
            } else {
                Given::Next(self.expr(1))
            });
            if !self.pass(",") {
                self.expect(")");
                return given;
            }
        }
    }

    fn expr(&mut self, least: u8) -> Expr {
        const SIGNS: [(&str, u8); 13] = [
            ("or", 1),
            ("and", 2),
            ("=", 3),
            ("<>", 3),
            ("<", 4),
            ("<=", 4),
            (">", 4),
            (">=", 4),
            ("+", 5),
            ("-", 5),
            ("*", 6),
            ("/", 6),
            ("mod", 6),
        ];
        let mut left = self.unary();
        while let Some((sign, binds)) = SIGNS.into_iter().find(|(sign, binds)| *binds >= least && self.is(sign)) {
            self.at += 1;
            left = Expr::Binary(sign.into(), Box::new(left), Box::new(self.expr(binds + 1)));
        }
        left
    }

    fn unary(&mut self) -> Expr {
        if self.pass("-") {
            return Expr::Negative(Box::new(self.unary()));
        }
        if self.pass("(") {
            let inner = self.expr(1);
            self.expect(")");
            return inner;
        }
        match self.words[self.at].clone() {
            Word::Real(value) => {
                self.at += 1;
                Expr::Constant(Value::Real(self.library.round(value)))
            }
            Word::Whole(value) => {
                self.at += 1;
                Expr::Constant(Value::Whole(value))
            }
            Word::Name(name) if name == "true" || name == "false" => {
                self.at += 1;
                Expr::Constant(Value::Truth(name == "true"))
            }
            _ => {
                let path = self.path();
                if self.is("(") { Expr::Call(path.0, self.given()) } else { Expr::At(path) }
            }
        }
    }
}

impl Library {
    /// What stands in `text`, with numbers of single or double precision.
    pub(crate) fn read(text: &str, single: bool) -> Self {
        let mut library = Library { units: BTreeMap::new(), single };
        let words = words(text);
        Reader { library: &mut library, words, at: 0 }.units();
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

    fn run(&self, steps: &[Step], room: &mut Room) {
        for step in steps {
            match step {
                Step::Set(path, value) => {
                    let value = self.value(value, room);
                    self.set(path, value, room);
                }
                Step::Call(name, given) => {
                    let Some(Value::Struct(block, mut inner)) = room.remove(name) else {
                        panic!("`{name}` is no block")
                    };
                    for given in given {
                        let Given::Named(input, value) = given else { panic!("{given:?} of {name}") };
                        let value = self.value(value, room);
                        assert!(inner.insert(input.clone(), value).is_some(), "`{block}` has no {input}");
                    }
                    self.run(&self.units[&block].steps, &mut inner);
                    room.insert(name.clone(), Value::Struct(block, inner));
                }
                Step::If(ways, no) => {
                    let way = ways.iter().find(|(holds, _)| self.value(holds, room) == Value::Truth(true));
                    self.run(way.map_or(no, |(_, steps)| steps), room);
                }
                Step::For(name, ends, steps) => {
                    let [from, to, by] = ends.each_ref().map(|end| match self.value(end, room) {
                        Value::Whole(value) => value,
                        other => panic!("a loop to {other:?}"),
                    });
                    let mut k = from;
                    while (by > 0 && k <= to) || (by < 0 && k >= to) {
                        room.insert(name.clone(), Value::Whole(k)).unwrap();
                        self.run(steps, room);
                        k += by;
                    }
                }
                Step::While(holds, steps) => {
                    while self.value(holds, room) == Value::Truth(true) {
                        self.run(steps, room);
                    }
                }
            }
        }
    }

    /// The indices of a path, as they are now.
    fn indices(&self, path: &Path, room: &mut Room) -> Vec<usize> {
        let mut index = |access: &Access| match access {
            Access::Field(_) => None,
            Access::Index(expr) => Some(match self.value(expr, room) {
                Value::Whole(k) => usize::try_from(k).unwrap(),
                other => panic!("{other:?} counts nothing off"),
            }),
        };
        path.1.iter().filter_map(&mut index).collect()
    }

    fn set(&self, path: &Path, value: Value, room: &mut Room) {
        let mut indices = self.indices(path, room).into_iter();
        let mut at = room.get_mut(&path.0).unwrap_or_else(|| panic!("`{}` is not declared", path.0));
        for access in &path.1 {
            at = match (access, at) {
                (Access::Field(name), Value::Struct(_, room)) => room.get_mut(name).unwrap(),
                (Access::Index(_), Value::Array(values)) => &mut values[indices.next().unwrap()],
                (access, at) => panic!("{access:?} of {at:?}"),
            };
        }
        assert_eq!(std::mem::discriminant(at), std::mem::discriminant(&value), "{path:?}");
        *at = value;
    }

    fn value(&self, expr: &Expr, room: &mut Room) -> Value {
        match expr {
            Expr::Constant(value) => value.clone(),
            Expr::At(path) => {
                let mut indices = self.indices(path, room).into_iter();
                let mut at = room.get(&path.0).unwrap_or_else(|| panic!("`{}` is not declared", path.0));
                for access in &path.1 {
                    at = match (access, at) {
                        (Access::Field(name), Value::Struct(_, room)) => &room[name],
                        (Access::Index(_), Value::Array(values)) => &values[indices.next().unwrap()],
                        (access, at) => panic!("{access:?} of {at:?}"),
                    };
                }
                at.clone()
            }
            Expr::Negative(inner) => match self.value(inner, room) {
                Value::Real(v) => Value::Real(-v),
                Value::Whole(v) => Value::Whole(-v),
                other => panic!("-{other:?}"),
            },
            Expr::Binary(sign, left, right) => {
                let (left, right) = (self.value(left, room), self.value(right, room));
                self.joined(sign, &left, &right)
            }
            Expr::Call(name, given) => self.call(name, given, room),
        }
    }

    fn call(&self, name: &str, given: &[Given], room: &mut Room) -> Value {
        if let ("trunc" | "dint_to_lreal" | "dint_to_real", [Given::Next(value)]) = (name, given) {
            return match (name, self.value(value, room)) {
                ("trunc", Value::Real(v)) => Value::Whole(v as i64),
                ("dint_to_lreal" | "dint_to_real", Value::Whole(v)) => Value::Real(self.round(v as f64)),
                (name, value) => panic!("{name} of {value:?}"),
            };
        }
        let Value::Struct(_, mut inner) = self.instance(name) else { panic!("`{name}` is no function") };
        let variables = &self.units[name].variables;
        let kind = |name: &str| variables.iter().find(|(_, known, _)| known == name).map_or("", |(kind, ..)| kind);
        let mut inputs = variables.iter().filter(|(kind, ..)| kind == "var_input").map(|(_, name, _)| name.clone());
        let mut results: Vec<(String, &Path)> = Vec::new();
        for given in given {
            let (own, value) = match given {
                Given::Next(value) => (inputs.next().unwrap(), value),
                Given::Named(own, value) => (own.clone(), value),
                Given::Result(own, path) => {
                    assert_eq!(kind(own), "var_output", "{own} of {name}");
                    results.push((own.clone(), path));
                    continue;
                }
            };
            match (kind(&own), value) {
                ("var_in_out", Expr::At(path)) => results.push((own.clone(), path)),
                ("var_input", _) => {}
                (kind, value) => panic!("{own} of {name}: {kind}, {value:?}"),
            }
            let value = self.value(value, room);
            let before = inner.insert(own.clone(), value.clone()).unwrap();
            assert_eq!(std::mem::discriminant(&before), std::mem::discriminant(&value), "{own} of {name}");
        }
        let wanted = variables.iter().filter(|(kind, ..)| kind == "var_input" || kind == "var_in_out").count();
        let outputs = given.iter().filter(|given| matches!(given, Given::Result(..))).count();
        assert_eq!(given.len() - outputs, wanted, "{name} takes {wanted}");
        self.run(&self.units[name].steps, &mut inner);
        for (own, path) in results {
            let value = inner.remove(&own).unwrap();
            self.set(path, value, room);
        }
        inner.remove(name).unwrap()
    }

    fn joined(&self, sign: &str, left: &Value, right: &Value) -> Value {
        use Value::{Real, Truth, Whole};
        match (sign, left, right) {
            ("and", Truth(a), Truth(b)) => Truth(*a && *b),
            ("or", Truth(a), Truth(b)) => Truth(*a || *b),
            ("+", Real(a), Real(b)) => Real(self.round(a + b)),
            ("-", Real(a), Real(b)) => Real(self.round(a - b)),
            ("*", Real(a), Real(b)) => Real(self.round(a * b)),
            ("/", Real(a), Real(b)) => Real(self.round(a / b)),
            ("+", Whole(a), Whole(b)) => Whole(a + b),
            ("-", Whole(a), Whole(b)) => Whole(a - b),
            ("*", Whole(a), Whole(b)) => Whole(a * b),
            ("/", Whole(a), Whole(b)) => Whole(a / b),
            ("mod", Whole(a), Whole(b)) => Whole(a % b),
            (_, Real(a), Real(b)) => Truth(holds(sign, a, b)),
            (_, Whole(a), Whole(b)) => Truth(holds(sign, a, b)),
            _ => panic!("{left:?} {sign} {right:?}"),
        }
    }
}

fn holds<T: PartialOrd>(sign: &str, a: &T, b: &T) -> bool {
    match sign {
        "=" => a == b,
        "<>" => a != b,
        "<" => a < b,
        "<=" => a <= b,
        ">" => a > b,
        ">=" => a >= b,
        _ => panic!("no sign {sign}"),
    }
}
