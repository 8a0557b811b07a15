//! Templates: files beside the backends that look like their output. Program code is printed in Rust
//! ([`language`](super::language)) and inserted; so are long lists of numbers.
//!
//! Blocks (`{% .. %}`) remove their own line, `+%}` keeps its end. A name missing in the context is an error. Filters:
//! `short`, `round` and `exact` print a number, `titled` capitalises the first letter, `line` joins lines, `quoted`
//! adds MATLAB quotes; `c`, `st` and `plain` remove what would end a comment of C or structured text, or has a meaning
//! in printf.
//!
//! Why: docs/decisions/export.md, "An exported file is a template".

use super::ExportRequest;
use super::exported::{Entry, ExportedProgram, Port};
use super::guard::farthest;
use minijinja::syntax::SyntaxConfig;
use minijinja::{AutoEscape, Environment, Output, State, UndefinedBehavior};
pub(super) use minijinja::{Value, context};
use piezoid::{Error, System};
use piezoid_models::program::{Block, Function, Program};
use piezoid_numerics::number::{round, short};
use std::fmt::Display;
use std::sync::LazyLock;

/// A template: its path and its text. If the path ends in `.xml.j2` or `.html.j2`, all values are escaped.
pub(super) type Template = (&'static str, &'static str);

/// The template at a path below `src`.
macro_rules! template {
    ($path:literal) => {
        ($path, include_str!(concat!(env!("CARGO_MANIFEST_DIR"), "/src/", $path)))
    };
}
pub(super) use template;

/// Included templates.
const INCLUDED: [Template; 7] = [
    template!("readme/opening.md.j2"),
    template!("readme/calls.md.j2"),
    template!("readme/inputs.md.j2"),
    template!("readme/refused.md.j2"),
    template!("readme/operations.md.j2"),
    template!("fixed/counts.c.j2"),
    template!("fmu/units.xml.j2"),
];

/// Renders a template with this context.
///
/// # Errors
/// Returns an error for a wrong template, for any input.
pub(super) fn render((path, text): Template, context: Value) -> Result<String, Error> {
    let wrong = |error: &dyn Display| Error::Content(format!("template {path}: {error:#}"));
    let environment = ENVIRONMENT.as_ref().map_err(|error| wrong(error))?;
    environment.render_named_str(path, text, context).map_err(|error| wrong(&error))
}

/// Syntax, filters and what templates include.
static ENVIRONMENT: LazyLock<Result<Environment<'static>, minijinja::Error>> = LazyLock::new(|| {
    let mut templates = Environment::new();
    let syntax = SyntaxConfig::builder().trim_blocks(true).lstrip_blocks(true).keep_trailing_newline(true).build();
    templates.set_syntax(syntax?);
    templates.set_undefined_behavior(UndefinedBehavior::Strict);
    templates.set_auto_escape_callback(|path| match path.ends_with(".xml.j2") || path.ends_with(".html.j2") {
        true => AutoEscape::Custom("markup".into()),
        false => AutoEscape::None,
    });
    templates.set_formatter(|out: &mut Output, state: &mut State, value: &Value| {
        let text = value.to_string();
        Ok(out.write_str(&if *state.auto_escape() == AutoEscape::None { text } else { escaped(&text) })?)
    });
    templates.add_filter("short", short);
    templates.add_filter("round", round);
    templates.add_filter("exact", |value: f64| format!("{value:?}"));
    templates.add_filter("titled", titled);
    templates.add_filter("line", line);
    templates.add_filter("quoted", |text: &str| format!("'{}'", line(text).replace('\'', "''")));
    templates.add_filter("st", quiet);
    templates.add_filter("c", |text: &str| text.replace("*/", "* /"));
    templates.add_filter("plain", |text: &str| text.replace(['%', '\\', '"', '?'], ""));
    for (path, text) in INCLUDED {
        templates.add_template(path, text)?;
    }
    Ok(templates)
});

/// The common template context: the model, and the interface with its vectors as `table` prints numbers.
pub(super) fn template_context(
    request: &ExportRequest,
    whole: &ExportedProgram,
    table: &dyn Fn(&[f64]) -> String,
) -> Value {
    let (model, name) = (request.model, request.name());
    let signal = |signal: &Port, values: &[f64]| {
        let Port { name, unit, about } = signal;
        context! { name => *name, unit, about => *about, values => table(values) }
    };
    let entry = |entry: &Entry| {
        let (vectors, mean, bounds) = (&entry.vectors, entry.vectors.mean, entry.vectors.bounds);
        let input =
            |(k, input): (usize, &Port)| signal(input, &vectors.inputs.iter().map(|row| row[k]).collect::<Vec<_>>());
        context! {
            step => entry.step, reset => entry.reset, state => entry.state, about => &entry.about,
            kind => entry.kind(), called => entry.called(), named => entry.named(name),
            inputs => entry.inputs.iter().enumerate().map(input).collect::<Value>(),
            output => signal(&entry.output, &vectors.outputs), samples => vectors.outputs.len(),
            sums => mean.sums, products => mean.products, quotients => mean.quotients,
            comparisons => mean.comparisons, most => vectors.most, bound => vectors.bound, bound_sums => bounds.sums, bound_products => bounds.products,
            bound_quotients => bounds.quotients, bound_comparisons => bounds.comparisons, off => vectors.off, missed => vectors.missed,
        }
    };
    let mut called = Vec::new();
    whole.program.functions.iter().for_each(|function| function.calls(&mut |name| called.push(name.to_owned())));
    context! {
    called, name, farthest => farthest(model), range_is_known => model.known_inputs().is_some(), upper => name.to_uppercase(), single => request.options.float, ts => model.ts(),
    preview => request.preview(),
            hysteresis => model.hysteresis().operator().name, creep => model.creep().order(),
            order => model.linear().a().len(), u_unit => &model.units().u, y_unit => &model.units().y,
            entries => whole.entries.iter().map(entry).collect::<Value>(), notes => whole.notes.iter().collect::<Value>(),
        }
}

/// The blocks that have functions, with these and their positions.
pub(super) fn blocks(program: &Program) -> impl Iterator<Item = (&Block, Vec<(usize, &Function)>)> {
    let of = |number| program.functions.iter().enumerate().filter(move |(_, f)| f.block == number).collect::<Vec<_>>();
    let blocks = program.blocks.iter().enumerate().map(move |(number, block)| (block, of(number)));
    blocks.filter(|(_, functions)| !functions.is_empty())
}

/// `text` with a capital first letter.
pub(super) fn titled(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}

/// `text` in one line.
fn line(text: &str) -> String {
    text.replace(|c: char| c.is_control(), " ")
}

/// `text` without delimiters of comments in structured text.
pub(super) fn quiet(text: &str) -> String {
    text.replace("*)", "* )").replace("(*", "( *")
}

/// `text` with entities for markup characters, without control characters that XML forbids.
fn escaped(text: &str) -> String {
    let allowed = |c: char| !(c.is_control() && !"\t\n\r".contains(c) || matches!(c, '\u{fffe}' | '\u{ffff}'));
    let text: String = text.chars().filter(|c| allowed(*c)).collect();
    let claimed = [("&", "&amp;"), ("<", "&lt;"), (">", "&gt;"), ("\"", "&quot;"), ("'", "&#39;")];
    claimed.iter().fold(text, |text, (character, entity)| text.replace(character, entity))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_escaped_only_in_markup() {
        let text = |path| render((path, "<{{ unit }}>"), context! { unit => "<a>\u{1} & \"b\"" }).unwrap();
        assert_eq!(text("page.xml.j2"), "<&lt;a&gt; &amp; &quot;b&quot;>");
        assert_eq!(text("page.md.j2"), "<<a>\u{1} & \"b\">");
    }

    #[test]
    fn a_missing_name_is_an_error_with_the_name_of_the_template() {
        let error = render(("page.md.j2", "{{ missing }}"), context! {}).unwrap_err().to_string();
        assert!(error.starts_with("template page.md.j2: undefined value"), "{error}");
    }

    #[test]
    fn no_value_can_end_a_comment_or_a_string() {
        let text = "{{ it|c }} {{ it|st }} {{ it|line|quoted }} {{ it|plain }}";
        let it = context! { it => "*/ *)\n' %" };
        let expected = "* / *)\n' % */ * )\n' % '*/ *) '' %' */ *)\n' ";
        assert_eq!(render(("page.md.j2", text), it).unwrap(), expected);
    }
}
