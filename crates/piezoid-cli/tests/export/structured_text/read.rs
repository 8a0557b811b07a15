//! Tokens, declarations and statements.

use super::{Access, Expr, Given, Library, Path, Step, Unit, Value};

#[derive(Debug, Clone, PartialEq)]
enum Word {
    Name(String),
    Real(f64),
    ExportedProgram(i64),
    Sign(String),
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
                // A minus belongs to the number only after E.
                n = rest[..n].match_indices('-').find(|(k, _)| !rest[..*k].ends_with('E')).map_or(n, |(k, _)| k);
                words.push(Word::Real(rest[..n].parse().unwrap()));
            } else {
                words.push(Word::ExportedProgram(rest[..n].parse().unwrap()));
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

/// Reads `text` into the library.
pub(super) fn units(text: &str, library: &mut Library) {
    Reader { library, words: words(text), at: 0 }.units();
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
                let input = if self.is("[") { self.list() } else { self.signed() };
                match (&value, &input) {
                    (Value::Array(a), Value::Array(b)) => assert_eq!(a.len(), b.len(), "{name}"),
                    (Value::Real(_), Value::Real(_)) => {}
                    _ => panic!("{name} begins with {input:?}"),
                }
                value = input;
            }
            self.expect(";");
            unit.variables.push((kind.into(), name, value));
        }
    }

    /// Initial value of a variable of the type that comes next.
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
            "dint" => Value::ExportedProgram(0),
            "bool" => Value::Truth(false),
            "array" => {
                for word in ["[", "..", "]", "of"] {
                    if word == ".." || word == "]" {
                        self.at += 1;
                    }
                    self.expect(word);
                }
                let Word::ExportedProgram(last) = self.words[self.at - 3] else { panic!("an array without end") };
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
            let by = if self.pass("by") { self.expr(1) } else { Expr::Constant(Value::ExportedProgram(1)) };
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
            return Step::Call(path.0, self.input());
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

    fn input(&mut self) -> Vec<Given> {
        self.expect("(");
        let mut input = Vec::new();
        loop {
            let sign = self.words.get(self.at + 1).cloned();
            input.push(if sign == Some(Word::Sign(":=".into())) {
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
                return input;
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
            Word::ExportedProgram(value) => {
                self.at += 1;
                Expr::Constant(Value::ExportedProgram(value))
            }
            Word::Name(name) if name == "true" || name == "false" => {
                self.at += 1;
                Expr::Constant(Value::Truth(name == "true"))
            }
            _ => {
                let path = self.path();
                if self.is("(") { Expr::Call(path.0, self.input()) } else { Expr::At(path) }
            }
        }
    }
}
