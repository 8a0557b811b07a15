//! Running text: plain, emphasised and other pieces, all escaped.

use crate::plot::{escape, shown};

/// A line or paragraph of text. No piece can become markup.
///
/// ```
/// use piezoid_report::page::Text;
/// let text = Text::from("The swarm is called with ").code("--seed 1").plain(" and ends ").em("early").plain(".");
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Text {
    html: String,
}

impl Text {
    /// Empty text.
    pub fn new() -> Self {
        Text::default()
    }

    /// Plain text.
    pub fn plain(self, text: impl AsRef<str>) -> Self {
        self.wrapped("", &shown(text.as_ref()), "")
    }

    /// Emphasised.
    pub fn em(self, text: impl AsRef<str>) -> Self {
        self.wrapped("<em>", &shown(text.as_ref()), "</em>")
    }

    /// Important.
    pub fn strong(self, text: impl AsRef<str>) -> Self {
        self.wrapped("<strong>", &shown(text.as_ref()), "</strong>")
    }

    /// Code, file names, options: exactly as they are written, with `um` for µm.
    pub fn code(self, text: impl AsRef<str>) -> Self {
        self.wrapped("<code>", &escape(text.as_ref()), "</code>")
    }

    /// A link to the web, to a place on the page (`#…`) or to a file beside it; any other target gives plain text.
    pub fn link(self, text: impl AsRef<str>, target: &str) -> Self {
        let scheme = target.split(['/', '?', '#']).next().is_some_and(|start| start.contains(':'));
        if scheme && !target.starts_with("https://") && !target.starts_with("http://") {
            return self.plain(text);
        }
        self.wrapped(&format!("<a href=\"{}\">", escape(target)), &shown(text.as_ref()), "</a>")
    }

    fn wrapped(mut self, before: &str, escaped: &str, after: &str) -> Self {
        self.html.push_str(before);
        self.html.push_str(escaped);
        self.html.push_str(after);
        self
    }

    /// The markup.
    pub(super) fn html(&self) -> &str {
        &self.html
    }
}

/// Plain text.
impl From<&str> for Text {
    fn from(text: &str) -> Self {
        Text::new().plain(text)
    }
}

/// Plain text.
impl From<String> for Text {
    fn from(text: String) -> Self {
        Text::new().plain(text)
    }
}

/// `text` as a sentence.
pub(crate) fn sentence(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().map(|first| first.to_uppercase().to_string()).unwrap_or_default();
    format!("{first}{}.", letters.as_str())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_piece_becomes_markup() {
        let text = Text::from("a < b ").em("<i>").code("x && y").strong("\"");
        assert_eq!(text.html(), "a &lt; b <em>&lt;i&gt;</em><code>x &amp;&amp; y</code><strong>&quot;</strong>");
    }

    #[test]
    fn links_lead_to_the_web_or_to_files_and_run_nothing() {
        assert_eq!(Text::new().link("x", "https://a.b/?c&d").html(), "<a href=\"https://a.b/?c&amp;d\">x</a>");
        assert_eq!(Text::new().link("x", "figures/loop.svg").html(), "<a href=\"figures/loop.svg\">x</a>");
        assert_eq!(Text::new().link("x", "javascript:alert(1)").html(), "x");
    }
}
