//! Running text: plain, emphasised and other pieces, all escaped.

use crate::plot::{escape, shown};

/// A line or paragraph of text. No piece can become markup.
///
/// ```
/// use piezoid_report::page::Text;
/// let text = Text::from("The swarm is called with ").code("--seed 1").plain(".");
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
    pub fn plain(mut self, text: impl AsRef<str>) -> Self {
        self.html += &shown(text.as_ref());
        self
    }

    /// Code, file names, options: exactly as they are written, with `um` for µm.
    pub fn code(mut self, text: impl AsRef<str>) -> Self {
        self.html += &format!("<code>{}</code>", escape(text.as_ref()));
        self
    }

    /// The markup.
    pub(super) fn html(&self) -> &str {
        &self.html
    }
}

/// Plain text.
impl<T: AsRef<str>> From<T> for Text {
    fn from(text: T) -> Self {
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
        let text = Text::from("a < b ").plain("<i>").code("x && y").plain("\"");
        assert_eq!(text.html(), "a &lt; b &lt;i&gt;<code>x &amp;&amp; y</code>&quot;");
    }
}
