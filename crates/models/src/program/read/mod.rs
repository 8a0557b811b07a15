//! Reading functions: statements and expressions from tokens; each name must be known before it is used.

mod expressions;

use expressions::number_at;

use super::tokens::{Token, tokens};
use super::{Argument, Expr, Function, Op, Program, Statement, ValueType};
use piezoid_numerics::error::Error;

/// Reads `text` into the last block of `program`.
pub(super) fn functions(program: &mut Program, text: &str) -> Result<(), Error> {
    let tokens = tokens(text)?;
    let mut at = 0;
    while at < tokens.len() {
        let mut reader =
            Reader { program, tokens: &tokens, at, names: Vec::new(), changed: Vec::new(), within: String::new() };
        let function = reader.function()?;
        at = reader.at;
        program.functions.push(function);
    }
    Ok(())
}

struct Reader<'r> {
    program: &'r Program,
    tokens: &'r [Token],
    at: usize,
    /// Types of the known names, the innermost last.
    names: Vec<(String, ValueType)>,
    /// Names of changed variables and states.
    changed: Vec<String>,
    /// Name of the present function.
    within: String,
}

type Read<T> = Result<T, Error>;

impl Reader<'_> {
    fn wrong<T>(&self, what: impl std::fmt::Display) -> Read<T> {
        let near: Vec<String> =
            self.tokens[self.at.saturating_sub(3)..].iter().take(6).map(|t| format!("{t:?}")).collect();
        Err(Error::Content(format!("program, fn {}: {what}, near {}", self.within, near.join(" "))))
    }

    fn is(&self, sign: &str) -> bool {
        match self.tokens.get(self.at) {
            Some(Token::Sign(s)) => *s == sign,
            Some(Token::Name(name)) => name == sign,
            _ => false,
        }
    }

    /// Consumes `sign` if it comes next.
    fn pass(&mut self, sign: &str) -> bool {
        let is = self.is(sign);
        self.at += usize::from(is);
        is
    }

    fn expect(&mut self, sign: &str) -> Read<()> {
        if self.pass(sign) { Ok(()) } else { self.wrong(format!("`{sign}` is missing")) }
    }

    fn name(&mut self) -> Read<String> {
        match self.tokens.get(self.at) {
            Some(Token::Name(name)) => {
                self.at += 1;
                Ok(name.clone())
            }
            _ => self.wrong("a name is missing"),
        }
    }

    fn kind(&self, name: &str) -> Option<&ValueType> {
        self.names.iter().find(|(known, _)| known == name).map(|(_, kind)| kind)
    }

    fn introduce(&mut self, name: &str, kind: ValueType) -> Read<()> {
        if self.kind(name).is_some() {
            return self.wrong(format!("`{name}` hides another name"));
        }
        self.names.push((name.into(), kind));
        Ok(())
    }

    fn function(&mut self) -> Read<Function> {
        let mut about = Vec::new();
        while let Some(Token::Note(note)) = self.tokens.get(self.at) {
            about.push(note.clone());
            self.at += 1;
        }
        self.expect("fn")?;
        let name = self.name()?;
        self.within = name.clone();
        if self.program.function(&name).is_some() {
            return self.wrong("there is already a function with this name");
        }
        self.expect("(")?;
        let mut takes = Vec::new();
        while !self.pass(")") {
            let name = self.name()?;
            let kind = match self.pass(":").then(|| self.name()).transpose()? {
                None => ValueType::Real,
                Some(whole) if whole == "whole" => ValueType::Integer,
                Some(block) if self.program.block(&block).is_some() => ValueType::Part(block),
                Some(block) => return self.wrong(format!("there is no block `{block}`")),
            };
            self.introduce(&name, kind.clone())?;
            takes.push(Argument { name, kind, changed: false });
            if !self.is(")") {
                self.expect(",")?;
            }
        }
        self.expect("{")?;
        let mut steps = Vec::new();
        while !self.is("return") && !self.is("}") {
            steps.push(self.step()?);
        }
        let mut returns = Vec::new();
        if self.pass("return") {
            returns.push(self.expr()?);
            while self.pass(",") {
                returns.push(self.expr()?);
            }
            self.expect(";")?;
        }
        self.expect("}")?;
        if returns.len() > 2 {
            return self.wrong("a function may return at most two numbers");
        }
        for parameter in &mut takes {
            parameter.changed = self.changed.contains(&parameter.name);
        }
        Ok(Function { block: self.program.blocks.len() - 1, about, name, takes, steps, returns })
    }

    fn steps(&mut self) -> Read<Vec<Statement>> {
        self.expect("{")?;
        let known = self.names.len();
        let mut steps = Vec::new();
        while !self.pass("}") {
            steps.push(self.step()?);
        }
        self.names.truncate(known);
        Ok(steps)
    }

    fn step(&mut self) -> Read<Statement> {
        if let Some(Token::Note(note)) = self.tokens.get(self.at) {
            self.at += 1;
            return Ok(Statement::Note(note.clone()));
        }
        if self.pass("let") {
            return self.new_names();
        }
        if self.is("if") {
            return self.choice();
        }
        if self.pass("while") {
            let (holds, most) = (self.condition()?, self.most()?);
            let Some(most) = most else {
                return self.wrong("a loop with a condition must say `at most` how many passes it takes");
            };
            return Ok(Statement::While(holds, most, self.steps()?));
        }
        if self.pass("for") {
            let name = self.name()?;
            self.expect("in")?;
            let (from, _, to) = (self.expr()?, self.expect("..")?, self.expr()?);
            if !from.whole() || !to.whole() {
                return self.wrong("the ends of a loop must be integers");
            }
            let (down, most) = (self.pass("down"), self.most()?);
            let known = self.names.len();
            self.introduce(&name, ValueType::Integer)?;
            let steps = self.steps()?;
            self.names.truncate(known);
            return Ok(Statement::For { name, from, to, down, most, steps });
        }
        if matches!(self.tokens.get(self.at + 1), Some(Token::Sign("("))) {
            let name = self.name()?;
            self.expect("(")?;
            let call = self.call(name)?;
            self.expect(";")?;
            return Ok(Statement::Do(call));
        }
        self.change()
    }

    /// The largest number of passes of a loop, if it is stated.
    fn most(&mut self) -> Read<Option<usize>> {
        if !self.pass("at") {
            return Ok(None);
        }
        self.expect("most")?;
        let most = self.expr()?;
        match super::bound::value(&most, &[]) {
            None => self.wrong("the largest number of passes must be constant"),
            most => Ok(most),
        }
    }

    fn new_names(&mut self) -> Read<Statement> {
        let mut names = vec![self.name()?];
        while self.pass(",") {
            names.push(self.name()?);
        }
        self.expect("=")?;
        if self.pass("[") {
            self.expr()?;
            self.expect(";")?;
            let Expr::Integer(n) = self.expr()? else { return self.wrong("the length of an array must be constant") };
            self.expect("]")?;
            self.expect(";")?;
            self.introduce(&names[0], ValueType::Array(n))?;
            return Ok(Statement::Array(names[0].clone(), n));
        }
        for (function, zero) in [("copy", false), ("zero", true)] {
            if self.is(function) {
                self.at += 1;
                self.expect("(")?;
                let of = self.place()?;
                self.expect(")")?;
                self.expect(";")?;
                let ValueType::Part(block) = self.kind_at(&of)? else {
                    return self.wrong("only a state can be copied");
                };
                let name = names[0].clone();
                self.introduce(&name, ValueType::Part(block.clone()))?;
                return Ok(Statement::Copy { name, of, block, zero });
            }
        }
        let value = self.expr()?;
        self.expect(";")?;
        let kind = if value.whole() { ValueType::Integer } else { ValueType::Real };
        for name in &names {
            self.introduce(name, kind.clone())?;
        }
        let gives = match &value {
            Expr::Call(name, _) => self.program.function(name).map_or(1, |f| f.returns.len()),
            _ => 1,
        };
        if gives != names.len() {
            return self.wrong(format!("{} names for {gives} values", names.len()));
        }
        Ok(Statement::Let(names, value))
    }

    /// A condition, which must not have side effects.
    fn condition(&mut self) -> Read<Expr> {
        let changed = self.changed.len();
        let holds = self.expr()?;
        if self.changed.len() > changed { self.wrong("a condition changes a state") } else { Ok(holds) }
    }

    fn choice(&mut self) -> Read<Statement> {
        self.expect("if")?;
        let (holds, yes) = (self.condition()?, self.steps()?);
        let no = match self.pass("else") {
            false => Vec::new(),
            true if self.is("if") => vec![self.choice()?],
            true => self.steps()?,
        };
        Ok(Statement::If(holds, yes, no))
    }

    fn change(&mut self) -> Read<Statement> {
        let place = self.place()?;
        let kind = self.kind_at(&place)?;
        if !matches!(kind, ValueType::Integer | ValueType::Real) {
            return self.wrong("only a number can be assigned");
        }
        let op = [("+=", Op::Add), ("-=", Op::Subtract), ("*=", Op::Multiply), ("/=", Op::Divide)];
        let op = op.into_iter().find(|(sign, _)| self.pass(sign));
        if op.is_none() {
            self.expect("=")?;
        }
        let value = self.expr()?;
        self.expect(";")?;
        if value.whole() != (kind == ValueType::Integer) {
            return self.wrong(format!("the assignment to `{}` mixes an integer and a real number", place.root));
        }
        self.changed.push(place.root.clone());
        let value = match op {
            None => value,
            Some((_, op)) => Expr::Binary(op, Box::new(number_at(place.clone(), &kind)), Box::new(value)),
        };
        Ok(Statement::Set(place, value))
    }
}
