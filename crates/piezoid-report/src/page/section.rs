//! A section of a page: a heading, and blocks under it in the order they are added.

use super::table::PageTable;
use super::text::Text;
use crate::plot::{Figure, escape};
use std::fmt::Write;

#[derive(Debug, Clone, PartialEq)]
enum StudyBlock {
    Heading(Text),
    Paragraph(Text),
    List(Vec<Text>),
    Listing(String),
    Callout { warning: bool, title: Text, text: Text },
    Facts(Vec<Fact>),
    Figure(Figure),
    Figures { columns: usize, title: Text, caption: Text, figures: Vec<Figure> },
    Table(PageTable),
}

/// A number worth showing large: its value, its unit and what it is.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fact {
    /// As it is read: `0.84`.
    pub value: String,
    /// Its unit; may be empty.
    pub unit: String,
    /// What it is.
    pub what: String,
}

impl Fact {
    /// A number worth showing large.
    pub fn new(value: impl Into<String>, unit: impl Into<String>, what: impl Into<String>) -> Self {
        Fact { value: value.into(), unit: unit.into(), what: what.into() }
    }
}

/// A section: figures and tables are numbered through the page by themselves.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    title: String,
    blocks: Vec<StudyBlock>,
}

/// How many figures and tables a page has shown so far.
#[derive(Debug, Default)]
pub(super) struct Numbering {
    figures: usize,
    tables: usize,
}

impl Section {
    /// An empty section. Without a title it has no number and stands in no table of contents.
    pub fn new(title: impl Into<String>) -> Self {
        Section { title: title.into(), blocks: Vec::new() }
    }

    fn with(mut self, block: StudyBlock) -> Self {
        self.blocks.push(block);
        self
    }

    /// A heading within the section.
    pub fn heading(self, text: impl Into<Text>) -> Self {
        self.with(StudyBlock::Heading(text.into()))
    }

    /// A paragraph.
    pub fn text(self, text: impl Into<Text>) -> Self {
        self.with(StudyBlock::Paragraph(text.into()))
    }

    /// A list with bullets.
    pub fn list<T: Into<Text>>(self, items: impl IntoIterator<Item = T>) -> Self {
        self.with(StudyBlock::List(items.into_iter().map(Into::into).collect()))
    }

    /// Lines kept as they are: commands, code, printed output.
    pub fn listing(self, lines: impl Into<String>) -> Self {
        self.with(StudyBlock::Listing(lines.into()))
    }

    /// Something to know.
    pub fn note(self, title: impl Into<Text>, text: impl Into<Text>) -> Self {
        self.with(StudyBlock::Callout { warning: false, title: title.into(), text: text.into() })
    }

    /// Something to beware of.
    pub fn warning(self, title: impl Into<Text>, text: impl Into<Text>) -> Self {
        self.with(StudyBlock::Callout { warning: true, title: title.into(), text: text.into() })
    }

    /// A row of large numbers.
    pub fn facts(self, facts: impl IntoIterator<Item = Fact>) -> Self {
        self.with(StudyBlock::Facts(facts.into_iter().collect()))
    }

    /// A figure with its own title and caption.
    pub fn figure(self, figure: Figure) -> Self {
        self.with(StudyBlock::Figure(figure))
    }

    /// Small figures side by side under one title and caption: 2 to 4 columns on a desk, one on a phone.
    pub fn figures(
        self,
        columns: usize,
        title: impl Into<Text>,
        caption: impl Into<Text>,
        figures: impl IntoIterator<Item = Figure>,
    ) -> Self {
        let figures = figures.into_iter().collect();
        self.with(StudyBlock::Figures {
            columns: columns.clamp(2, 4),
            title: title.into(),
            caption: caption.into(),
            figures,
        })
    }

    /// A table.
    pub fn table(self, table: PageTable) -> Self {
        self.with(StudyBlock::Table(table))
    }

    /// Its title.
    pub(super) fn title(&self) -> &str {
        &self.title
    }

    /// Writes its blocks.
    pub(super) fn write(&self, out: &mut String, numbers: &mut Numbering) {
        self.blocks.iter().for_each(|block| block.write(out, numbers));
    }
}

impl StudyBlock {
    fn write(&self, out: &mut String, numbers: &mut Numbering) {
        let _ = match self {
            StudyBlock::Heading(text) => writeln!(out, "<h3>{}</h3>", text.html()),
            StudyBlock::Paragraph(text) => writeln!(out, "<p>{}</p>", text.html()),
            StudyBlock::List(items) => {
                let items: String = items.iter().map(|i| format!("<li>{}</li>\n", i.html())).collect();
                writeln!(out, "<ul>\n{items}</ul>")
            }
            StudyBlock::Listing(lines) => writeln!(out, "<pre tabindex=\"0\"><code>{}</code></pre>", escape(lines)),
            StudyBlock::Callout { warning, title, text } => {
                let class = if *warning { " warning" } else { "" };
                let (title, text) = (title.html(), text.html());
                writeln!(
                    out,
                    "<div class=\"callout{class}\" role=\"note\"><p class=\"name\">{title}</p><p>{text}</p></div>"
                )
            }
            StudyBlock::Facts(facts) => {
                let facts: String = facts.iter().map(Fact::html).collect();
                writeln!(out, "<dl class=\"facts\">\n{facts}</dl>")
            }
            StudyBlock::Figure(figure) => {
                numbers.figures += 1;
                let caption = caption(numbers.figures, &escape(figure.title()), &escape(figure.caption()));
                writeln!(
                    out,
                    "<figure class=\"plate\" id=\"figure-{}\">\n{}{caption}</figure>",
                    numbers.figures,
                    figure.inline()
                )
            }
            StudyBlock::Figures { columns, title, caption: text, figures } => {
                numbers.figures += 1;
                let caption = caption(numbers.figures, title.html(), text.html());
                let figures: String = figures.iter().map(|f| format!("<div>\n{}</div>\n", f.inline())).collect();
                let grid = format!("<div class=\"grid\">\n{figures}</div>\n");
                let number = numbers.figures;
                writeln!(out, "<figure class=\"plates of-{columns}\" id=\"figure-{number}\">\n{grid}{caption}</figure>")
            }
            StudyBlock::Table(table) => {
                numbers.tables += 1;
                table.write(out, numbers.tables);
                Ok(())
            }
        };
    }
}

impl Fact {
    fn html(&self) -> String {
        let [value, unit, what] = [&self.value, &self.unit, &self.what].map(|t| escape(t));
        format!("<div><dt>{what}</dt><dd>{value}<span class=\"unit\"> {unit}</span></dd></div>\n")
    }
}

/// Number, title and, if there is one, the paragraph that says what is seen.
fn caption(number: usize, title: &str, text: &str) -> String {
    let text = if text.is_empty() { String::new() } else { format!("<p>{text}</p>") };
    let title = format!("<span class=\"no\">Figure {number}</span> <span class=\"what\">{title}</span>");
    format!("<figcaption>{title}{text}</figcaption>\n")
}
