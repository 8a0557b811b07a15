//! Names that structured text takes.

/// What may not be a name: words of the language, and types, functions and blocks that are always there.
#[rustfmt::skip]
pub(super) const RESERVED: &[&str] = &[
    "abs", "abstract", "acos", "action", "add", "adr", "and", "and_then", "andn", "any", "array", "asin", "at",
    "atan", "atan2", "begin", "bit", "bitadr", "bool", "by", "byte", "cal", "calc", "calcn", "case", "ceil", "char",
    "class", "concat", "configuration", "constant", "continue", "cos", "ctd", "ctu", "ctud", "date", "date_and_time",
    "delete", "dint", "div", "divtime", "do", "dt", "dword", "else", "elsif", "end_action", "end_case", "end_for",
    "end_function", "end_if", "end_program", "end_repeat", "end_struct", "end_type", "end_var", "end_while", "eq",
    "exit", "exp", "expt", "extends", "f_edge", "f_trig", "false", "final", "find", "floor", "for", "from",
    "function", "function_block", "ge", "get", "global", "goto", "gt", "if", "implements", "in", "indexof", "ini",
    "initial_step", "insert", "int", "interface", "internal", "interval", "jmp", "jmpc", "jmpcn", "ld", "ldate",
    "ldn", "ldt", "le", "left", "len", "limit", "lint", "ln", "log", "lower", "lreal", "lt", "ltime", "ltod", "lword",
    "max", "method", "mid", "min", "mod", "move", "mul", "mux", "namespace", "ne", "non_retain", "not", "null", "of",
    "on", "or", "or_else", "orn", "overlap", "override", "pointer", "priority", "private", "program", "property",
    "protected", "public", "r_edge", "r_trig", "read_only", "read_write", "real", "ref", "ref_to", "reference",
    "repeat", "replace", "resource", "ret", "retain", "retc", "retcn", "return", "right", "rol", "ror", "round", "rs",
    "rtc", "sel", "sema", "set", "shl", "shr", "sign", "sin", "single", "sint", "sizeof", "sqrt", "sr", "st", "step",
    "stn", "string", "struct", "sub", "super", "tan", "task", "then", "this", "time", "time_of_day", "to", "tod",
    "tof", "ton", "tp", "transition", "true", "trunc", "type", "udint", "uint", "ulint", "union", "until", "upper",
    "using", "usint", "var", "var_access", "var_config", "var_external", "var_global", "var_in_out", "var_input",
    "var_inst", "var_output", "var_stat", "var_temp", "wchar", "while", "with", "word", "wstring", "xor", "xorn",
];

/// Names as structured text has them: none a reserved word, none twice, whatever its capitals.
#[derive(Debug, Clone, Default)]
pub(super) struct Names {
    /// What names may not be, in small letters.
    pub(super) taken: Vec<String>,
    /// Names of the program, and those they have here.
    pub(super) known: Vec<(String, String)>,
}

impl Names {
    pub(super) fn without(taken: &[String]) -> Self {
        Names { taken: taken.to_vec(), known: Vec::new() }
    }

    /// A name for `key`: that which is wished, with a number where that is taken.
    pub(super) fn add(&mut self, key: &str, wish: &str) {
        if self.known.iter().any(|(known, _)| known == key) {
            return;
        }
        let wish = wish.split('_').filter(|part| !part.is_empty()).collect::<Vec<_>>().join("_");
        let free = |name: &String| {
            let name = name.to_lowercase();
            !self.taken.contains(&name) && !RESERVED.contains(&name.as_str())
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_that_differ_in_capitals_alone_or_are_words_of_the_language_get_a_number() {
        let mut names = Names::without(&["bender".into()]);
        for name in ["h", "H", "left", "two__lines_", "Bender", "h"] {
            names.add(name, name);
        }
        let found: Vec<&str> = names.known.iter().map(|(_, name)| name.as_str()).collect();
        assert_eq!(found, ["h", "H_1", "left_1", "two_lines", "Bender_1"]);
    }
}
