//! Runs the statements.

use super::{Access, Expr, Given, Library, Path, Room, Step, Value};

impl Library {
    pub(super) fn run(&self, steps: &[Step], room: &mut Room) {
        for step in steps {
            match step {
                Step::Set(path, value) => {
                    let value = self.value(value, room);
                    self.set(path, value, room);
                }
                Step::Call(name, arguments) => {
                    let Some(Value::Struct(block, mut inner)) = room.remove(name) else {
                        panic!("`{name}` is no block")
                    };
                    for arguments in arguments {
                        let Given::Named(input, value) = arguments else { panic!("{arguments:?} of {name}") };
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
                        Value::ExportedProgram(value) => value,
                        other => panic!("a loop to {other:?}"),
                    });
                    let mut k = from;
                    while (by > 0 && k <= to) || (by < 0 && k >= to) {
                        room.insert(name.clone(), Value::ExportedProgram(k)).unwrap();
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

    /// The current indices of a path.
    fn indices(&self, path: &Path, room: &mut Room) -> Vec<usize> {
        let mut index = |access: &Access| match access {
            Access::Field(_) => None,
            Access::Index(expr) => Some(match self.value(expr, room) {
                Value::ExportedProgram(k) => usize::try_from(k).unwrap(),
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
                Value::ExportedProgram(v) => Value::ExportedProgram(-v),
                other => panic!("-{other:?}"),
            },
            Expr::Binary(sign, left, right) => {
                let (left, right) = (self.value(left, room), self.value(right, room));
                self.joined(sign, &left, &right)
            }
            Expr::Call(name, arguments) => self.call(name, arguments, room),
        }
    }

    fn call(&self, name: &str, arguments: &[Given], room: &mut Room) -> Value {
        if let ("trunc" | "dint_to_lreal" | "dint_to_real", [Given::Next(value)]) = (name, arguments) {
            return match (name, self.value(value, room)) {
                ("trunc", Value::Real(v)) => Value::ExportedProgram(v as i64),
                ("dint_to_lreal" | "dint_to_real", Value::ExportedProgram(v)) => Value::Real(self.round(v as f64)),
                (name, value) => panic!("{name} of {value:?}"),
            };
        }
        let Value::Struct(_, mut inner) = self.instance(name) else { panic!("`{name}` is no function") };
        let variables = &self.units[name].variables;
        let kind = |name: &str| variables.iter().find(|(_, known, _)| known == name).map_or("", |(kind, ..)| kind);
        let mut inputs = variables.iter().filter(|(kind, ..)| kind == "var_input").map(|(_, name, _)| name.clone());
        let mut results: Vec<(String, &Path)> = Vec::new();
        for arguments in arguments {
            let (own, value) = match arguments {
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
        let expected = variables.iter().filter(|(kind, ..)| kind == "var_input" || kind == "var_in_out").count();
        let outputs = arguments.iter().filter(|arguments| matches!(arguments, Given::Result(..))).count();
        assert_eq!(arguments.len() - outputs, expected, "{name} takes {expected}");
        self.run(&self.units[name].steps, &mut inner);
        for (own, path) in results {
            let value = inner.remove(&own).unwrap();
            self.set(path, value, room);
        }
        inner.remove(name).unwrap()
    }

    fn joined(&self, sign: &str, left: &Value, right: &Value) -> Value {
        use Value::{ExportedProgram, Real, Truth};
        match (sign, left, right) {
            ("and", Truth(a), Truth(b)) => Truth(*a && *b),
            ("or", Truth(a), Truth(b)) => Truth(*a || *b),
            ("+", Real(a), Real(b)) => Real(self.round(a + b)),
            ("-", Real(a), Real(b)) => Real(self.round(a - b)),
            ("*", Real(a), Real(b)) => Real(self.round(a * b)),
            ("/", Real(a), Real(b)) => Real(self.round(a / b)),
            ("+", ExportedProgram(a), ExportedProgram(b)) => ExportedProgram(a + b),
            ("-", ExportedProgram(a), ExportedProgram(b)) => ExportedProgram(a - b),
            ("*", ExportedProgram(a), ExportedProgram(b)) => ExportedProgram(a * b),
            ("/", ExportedProgram(a), ExportedProgram(b)) => ExportedProgram(a / b),
            ("mod", ExportedProgram(a), ExportedProgram(b)) => ExportedProgram(a % b),
            (_, Real(a), Real(b)) => Truth(holds(sign, a, b)),
            (_, ExportedProgram(a), ExportedProgram(b)) => Truth(holds(sign, a, b)),
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
