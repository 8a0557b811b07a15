//! A section of a page: a heading and elements in the order they are added.

use super::table::PageTable;
use super::text::Text;
use crate::plot::{Figure, escape, shown};
use std::fmt::Write;

#[derive(Debug, Clone, PartialEq)]
enum Element {
    /// What needs no number.
    Plain(String),
    Figure(Figure),
    Figures {
        columns: usize,
        title: Text,
        caption: Text,
        figures: Vec<Figure>,
    },
    Table(PageTable),
    /// What is shown on demand.
    Details {
        title: Text,
        blocks: Vec<Element>,
    },
}

/// A number shown large: its value, its unit and its meaning.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fact {
    /// The value as text: `0.84`.
    pub value: String,
    /// Its unit; may be empty.
    pub unit: String,
    /// Its meaning.
    pub what: String,
}

impl Fact {
    /// A number to show large.
    pub fn new(value: impl Into<String>, unit: impl Into<String>, what: impl Into<String>) -> Self {
        Fact { value: value.into(), unit: unit.into(), what: what.into() }
    }
}

/// A section. Figures and tables are numbered through the page.
#[derive(Debug, Clone, PartialEq)]
pub struct Section {
    title: String,
    blocks: Vec<Element>,
}

/// Numbers of figures and tables on a page so far.
#[derive(Debug, Default)]
pub(super) struct Numbering {
    figures: usize,
    tables: usize,
    /// Figures with data for plots.
    pub(super) plots: usize,
}

impl Section {
    /// An empty section. Without a title it has no number and no entry in the table of contents.
    pub fn new(title: impl Into<String>) -> Self {
        Section { title: title.into(), blocks: Vec::new() }
    }

    fn with(mut self, block: Element) -> Self {
        self.blocks.push(block);
        self
    }

    fn plain(self, line: String) -> Self {
        self.with(Element::Plain(line))
    }

    /// A heading within the section.
    pub fn heading(self, text: impl Into<Text>) -> Self {
        self.plain(format!("<h3>{}</h3>", text.into().html()))
    }

    /// A paragraph.
    pub fn text(self, text: impl Into<Text>) -> Self {
        self.plain(format!("<p>{}</p>", text.into().html()))
    }

    /// A list with bullets.
    pub fn list<T: Into<Text>>(self, items: impl IntoIterator<Item = T>) -> Self {
        let items: String = items.into_iter().map(|item| format!("<li>{}</li>\n", item.into().html())).collect();
        self.plain(format!("<ul>\n{items}</ul>"))
    }

    /// Preformatted lines: commands, code, printed output.
    pub fn listing(self, lines: impl AsRef<str>) -> Self {
        self.plain(format!("<pre tabindex=\"0\"><code>{}</code></pre>", escape(lines.as_ref())))
    }

    /// A note.
    pub fn note(self, title: impl Into<Text>, text: impl Into<Text>) -> Self {
        self.callout("", title.into(), text.into())
    }

    /// A warning.
    pub fn warning(self, title: impl Into<Text>, text: impl Into<Text>) -> Self {
        self.callout(" warning", title.into(), text.into())
    }

    fn callout(self, class: &str, title: Text, text: Text) -> Self {
        let (title, text) = (title.html(), text.html());
        self.plain(format!(
            "<div class=\"callout{class}\" role=\"note\"><p class=\"name\">{title}</p><p>{text}</p></div>"
        ))
    }

    /// A row of large numbers.
    pub fn facts(self, facts: impl IntoIterator<Item = Fact>) -> Self {
        let facts: String = facts.into_iter().map(|fact| fact.html()).collect();
        self.plain(format!("<dl class=\"facts\">\n{facts}</dl>"))
    }

    /// A figure with its own title and caption.
    pub fn figure(self, figure: Figure) -> Self {
        self.with(Element::Figure(figure))
    }

    /// Figures side by side with one title, caption and legend: 2 to 4 columns on a desktop, one on a phone.
    pub fn figures(
        self,
        columns: usize,
        title: impl Into<Text>,
        caption: impl Into<Text>,
        figures: impl IntoIterator<Item = Figure>,
    ) -> Self {
        let (title, caption, figures) = (title.into(), caption.into(), figures.into_iter().collect());
        self.with(Element::Figures { columns: columns.clamp(2, 4), title, caption, figures })
    }

    /// A table.
    pub fn table(self, table: PageTable) -> Self {
        self.with(Element::Table(table))
    }

    /// The elements of another section, shown on demand under this title.
    pub fn details(self, title: impl Into<Text>, inner: Section) -> Self {
        self.with(Element::Details { title: title.into(), blocks: inner.blocks })
    }

    pub(super) fn title(&self) -> &str {
        &self.title
    }

    /// Writes its elements.
    pub(super) fn write(&self, out: &mut String, numbers: &mut Numbering) {
        self.blocks.iter().for_each(|block| block.write(out, numbers));
    }
}

impl Element {
    fn write(&self, out: &mut String, numbers: &mut Numbering) {
        let _ = match self {
            Element::Plain(line) => writeln!(out, "{line}"),
            Element::Figure(figure) => {
                numbers.figures += 1;
                let (number, drawn) = (numbers.figures, figure.inline() + &plots(figure, &[], numbers));
                let caption = caption(number, &shown(figure.title()), &shown(figure.caption()));
                let drawn = format!("<div class=\"drawing\">\n{drawn}</div>\n");
                writeln!(out, "<figure class=\"plate\" id=\"figure-{number}\">\n{drawn}{caption}</figure>")
            }
            Element::Figures { columns, title, caption: text, figures } => {
                numbers.figures += 1;
                let caption = caption(numbers.figures, title.html(), text.html());
                let legend = Figure::legend(figures);
                let mut one = |f: &Figure| {
                    let drawn = f.clone().without_legend().inline() + &plots(f, figures, numbers);
                    format!("<div class=\"drawing\">\n{drawn}</div>\n")
                };
                let figures: String = figures.iter().map(&mut one).collect();
                let grid = format!("{legend}<div class=\"grid\">\n{figures}</div>\n");
                let number = numbers.figures;
                writeln!(out, "<figure class=\"plates of-{columns}\" id=\"figure-{number}\">\n{grid}{caption}</figure>")
            }
            Element::Table(table) => {
                numbers.tables += 1;
                out.write_str(&table.html(numbers.tables))
            }
            Element::Details { title, blocks } => {
                let _ = writeln!(out, "<details>\n<summary>{}</summary>", title.html());
                blocks.iter().for_each(|block| block.write(out, numbers));
                writeln!(out, "</details>")
            }
        };
    }
}

impl Fact {
    fn html(&self) -> String {
        let [value, unit, what] = [&self.value, &self.unit, &self.what].map(|t| shown(t));
        format!("<div><dt>{what}</dt><dd>{value}<span class=\"unit\"> {unit}</span></dd></div>\n")
    }
}

/// The data of the plots that take the place of a drawing.
fn plots(figure: &Figure, beside: &[Figure], numbers: &mut Numbering) -> String {
    let Some(data) = figure.data(beside) else { return String::new() };
    numbers.plots += 1;
    format!("<script type=\"application/json\">{data}</script>\n")
}

/// Number, title and, if given, the paragraph of a caption.
fn caption(number: usize, title: &str, text: &str) -> String {
    let text = if text.is_empty() { String::new() } else { format!("<p>{text}</p>") };
    let title = format!("<span class=\"no\">Figure {number}</span> <span class=\"what\">{title}</span>");
    format!("<figcaption>{title}{text}</figcaption>\n")
}
