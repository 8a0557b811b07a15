//! Types of the catalogue for the page: those of its lists, inferred from their content, and the options of each call.

use piezoid_numerics::words::capitalised;
use serde_json::{Map, Value};
use std::collections::BTreeSet;

const HEAD: &str =
    "// The lists of the library and the options of its calls. Written by `cargo xtask generate bindings`.\n";

/// The content of `catalogue.ts`.
pub(crate) fn catalogue() -> String {
    let lists = serde_json::json!(piezoid_operations::catalogue());
    let rows = |value: &Value| value.as_array().cloned().unwrap_or_default();
    let calls = rows(&lists["operations"]);
    let excitations = rows(&lists["excitations"]);
    let own = calls.iter().chain(&excitations).flat_map(|call| rows(&call["options"]));
    let options: Vec<Value> = own.chain(rows(&lists["columns"])).collect();
    let mut text = HEAD.to_string();
    text += "\n/** An option. */\nexport interface OptionRow<Name extends string = string> ";
    let row = typed(&options.iter().collect::<Vec<_>>(), "", &[]);
    text += &row.replace("  name: string;", "  name: Name;");
    text += "\n\n/** A member of a family. */\nexport interface Member ";
    text += &typed(&[&lists["plants"][0]], "", &[]);
    text += "\n\n/** All lists. */\nexport interface Lists ";
    let known = [(names_of(&options[..1]), "OptionRow"), (names_of(&[lists["plants"][0].clone()]), "Member")];
    text += &typed(&[&lists], "", &known);
    text += "\n\n/** The options of each call by name. */\nexport interface CallOptions {\n";
    for (k, call) in calls.iter().enumerate() {
        let name = text_of(&call["name"]);
        let name = if name.contains('-') { format!("\"{name}\"") } else { name.into() };
        text += &format!("  /** {}. */\n  {name}: ", capitalised(text_of(&call["summary"])));
        let is_same = |other: &&Value| other["options"] == call["options"] && !rows(&call["options"]).is_empty();
        if let Some(other) = calls[..k].iter().find(is_same) {
            text += &format!("CallOptions[{}];\n", other["name"]);
            continue;
        }
        text += "{\n";
        for row in rows(&call["options"]) {
            let unit = text_of(&row["unit"]);
            let unit = if unit.is_empty() { String::new() } else { format!(" [{unit}]") };
            let mark = if row["required"] == true { "" } else { "?" };
            let (name, help) = (text_of(&row["name"]), text_of(&row["help"]));
            text += &format!("    /** {help}{unit} */\n    {name}{mark}: {};\n", value_of(&row));
        }
        text += "  };\n";
    }
    text + "}\n\nexport type CallName = keyof CallOptions;\n"
}

/// The type of the value of an option. A number may be a text with its unit.
fn value_of(row: &Value) -> String {
    let choices = row["choices"].as_array();
    match row["kind"].as_str().unwrap_or_default() {
        "switch" => "boolean".into(),
        "integer" => "number".into(),
        "number" => "number | string".into(),
        "pair" => "[number, number]".into(),
        "numbers" => "number[]".into(),
        "texts" => "string[]".into(),
        "choice" => choices.into_iter().flatten().map(|c| c[0].to_string()).collect::<Vec<_>>().join(" | "),
        _ => "string".into(),
    }
}

/// Names of members, and the interface with these members.
type Known = [(Vec<String>, &'static str)];

fn names_of(objects: &[Value]) -> Vec<String> {
    objects.iter().filter_map(Value::as_object).flat_map(Map::keys).cloned().collect()
}

/// The type of all these values. Members of objects that some lack are optional; an object whose members are no
/// identifiers is a map; arrays within an array that all have two members are pairs; the values of `kind` are named.
fn typed(values: &[&Value], indent: &str, known: &Known) -> String {
    let mut types = BTreeSet::new();
    let arrays: Vec<&Vec<Value>> = values.iter().filter_map(|value| value.as_array()).collect();
    let objects: Vec<&Map<String, Value>> = values.iter().filter_map(|value| value.as_object()).collect();
    for value in values {
        match value {
            Value::Null => types.insert("null".into()),
            Value::Bool(_) => types.insert("boolean".into()),
            Value::Number(_) => types.insert("number".into()),
            Value::String(_) => types.insert("string".into()),
            Value::Array(_) | Value::Object(_) => false,
        };
    }
    if !arrays.is_empty() {
        let members: Vec<&Value> = arrays.iter().copied().flatten().collect();
        let pairs = !members.is_empty() && members.iter().all(|one| one.as_array().is_some_and(|pair| pair.len() == 2));
        types.insert(match pairs {
            true => {
                let inner: Vec<&Value> = members.iter().filter_map(|one| one.as_array()).flatten().collect();
                let inner = typed(&inner, indent, known);
                format!("[{inner}, {inner}][]")
            }
            false => format!("{}[]", grouped(typed(&members, indent, known))),
        });
    }
    if !objects.is_empty() {
        types.insert(members(&objects, indent, known));
    }
    union(types)
}

fn union(types: BTreeSet<String>) -> String {
    types.into_iter().collect::<Vec<_>>().join(" | ")
}

fn members(objects: &[&Map<String, Value>], indent: &str, known: &Known) -> String {
    let mut names: Vec<&str> = Vec::new();
    for name in objects.iter().flat_map(|object| object.keys()) {
        if !names.contains(&name.as_str()) {
            names.push(name);
        }
    }
    if let Some((_, name)) = known.iter().find(|(of, _)| *of == names) {
        return (*name).into();
    }
    let is_identifier = |name: &&str| name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_');
    if !names.iter().all(is_identifier) {
        let all: Vec<&Value> = objects.iter().flat_map(|object| object.values()).collect();
        return format!("Record<string, {}>", typed(&all, indent, known));
    }
    let deeper = format!("{indent}  ");
    let mut text = String::from("{\n");
    for name in names {
        let values: Vec<&Value> = objects.iter().filter_map(|object| object.get(name)).collect();
        let mark = if values.len() < objects.len() { "?" } else { "" };
        let own = match name {
            "kind" => union(values.iter().map(|value| value.to_string()).collect()),
            _ => typed(&values, &deeper, known),
        };
        text += &format!("{deeper}{name}{mark}: {own};\n");
    }
    text + indent + "}"
}

fn grouped(own: String) -> String {
    if own.contains(" | ") && !own.starts_with('{') { format!("({own})") } else { own }
}

fn text_of(value: &Value) -> &str {
    value.as_str().unwrap_or_default()
}
