//! Elements of XML, indented, all text escaped.

/// What markup claims for itself, replaced; control characters that XML forbids are left out.
pub(super) fn escape(text: &str) -> String {
    let allowed = |c: char| !(c.is_control() && !"\t\n\r".contains(c) || matches!(c, '\u{fffe}' | '\u{ffff}'));
    let text: String = text.chars().filter(|c| allowed(*c)).collect();
    let claimed = [("&", "&amp;"), ("<", "&lt;"), (">", "&gt;"), ("\"", "&quot;"), ("'", "&#39;")];
    claimed.iter().fold(text, |text, (character, entity)| text.replace(character, entity))
}

/// An element with attributes and what stands in it.
pub(super) struct Element {
    open: String,
    name: &'static str,
    inner: Vec<Element>,
}

impl Element {
    /// One without attributes.
    pub(super) fn new(name: &'static str) -> Self {
        Element { open: format!("<{name}"), name, inner: Vec::new() }
    }

    /// With an attribute.
    pub(super) fn with(mut self, name: &str, value: impl ToString) -> Self {
        self.open += &format!(" {name}=\"{}\"", escape(&value.to_string()));
        self
    }

    /// With an attribute, if there is a value.
    pub(super) fn maybe(self, name: &str, value: Option<impl ToString>) -> Self {
        match value {
            Some(value) => self.with(name, value),
            None => self,
        }
    }

    /// With more elements in it.
    pub(super) fn hold(mut self, inner: impl IntoIterator<Item = Element>) -> Self {
        self.inner.extend(inner);
        self
    }

    /// As a document.
    pub(super) fn document(&self) -> String {
        let mut out = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
        self.print(0, &mut out);
        out
    }

    fn print(&self, depth: usize, out: &mut String) {
        let indent = "  ".repeat(depth);
        if self.inner.is_empty() {
            *out += &format!("{indent}{}/>\n", self.open);
            return;
        }
        *out += &format!("{indent}{}>\n", self.open);
        self.inner.iter().for_each(|element| element.print(depth + 1, out));
        *out += &format!("{indent}</{}>\n", self.name);
    }
}
