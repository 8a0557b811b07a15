//! Tables with aligned numbers, which scroll sideways on a phone.

use super::text::Text;

/// One cell of a table.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Cell {
    text: Text,
    /// Empty, or a class after a space.
    class: &'static str,
}

impl Cell {
    /// The best value of its column, or one that meets a requirement.
    pub fn best(self) -> Self {
        Cell { class: " best", ..self }
    }

    /// A value that fails a requirement.
    pub fn bad(self) -> Self {
        Cell { class: " bad", ..self }
    }

    /// A value given for comparison only.
    pub fn muted(self) -> Self {
        Cell { class: " muted", ..self }
    }
}

/// A plain cell.
impl<T: Into<Text>> From<T> for Cell {
    fn from(text: T) -> Self {
        Cell { text: text.into(), class: "" }
    }
}

/// A table with its number, title and notes.
///
/// ```
/// use piezoid_report::page::{Cell, PageTable};
/// let table = PageTable::new("Error of the paper's rule")
///     .number("f [Hz]")
///     .number("MSE [mm²]")
///     .text("verdict")
///     .row(["5", "0.0129", "as printed"])
///     .row([Cell::from("20"), Cell::from("0.0004").best(), Cell::from("direction held")])
///     .note("MSE over the second half of the record.");
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PageTable {
    title: Text,
    /// Heading, and true for a column of numbers.
    columns: Vec<(Text, bool)>,
    rows: Vec<Vec<Cell>>,
    notes: Vec<Text>,
}

impl PageTable {
    /// An empty table.
    pub fn new(title: impl Into<Text>) -> Self {
        PageTable { title: title.into(), columns: Vec::new(), rows: Vec::new(), notes: Vec::new() }
    }

    /// Adds a column of text, aligned to the left.
    pub fn text(mut self, heading: impl Into<Text>) -> Self {
        self.columns.push((heading.into(), false));
        self
    }

    /// Adds a column of numbers, aligned to the right, with digits of equal width. Units go in the heading, in
    /// brackets.
    pub fn number(mut self, heading: impl Into<Text>) -> Self {
        self.columns.push((heading.into(), true));
        self
    }

    /// Adds a row, its cells in the order of the columns. Missing cells stay empty; additional cells get columns
    /// without a heading.
    pub fn row<C: Into<Cell>>(mut self, cells: impl IntoIterator<Item = C>) -> Self {
        self.rows.push(cells.into_iter().map(Into::into).collect());
        self
    }

    /// Adds rows.
    pub fn rows<C: Into<Cell>, R: IntoIterator<Item = C>>(self, rows: impl IntoIterator<Item = R>) -> Self {
        rows.into_iter().fold(self, PageTable::row)
    }

    /// A note below the table.
    pub fn note(mut self, text: impl Into<Text>) -> Self {
        self.notes.push(text.into());
        self
    }

    /// The markup of the table with this number.
    pub(super) fn html(&self, number: usize) -> String {
        let wide = self.rows.iter().map(Vec::len).chain([self.columns.len()]).max().unwrap_or(0);
        let class = |column: usize| if self.columns.get(column).is_some_and(|c| c.1) { "num" } else { "txt" };
        let heading = |column: usize| {
            let heading = self.columns.get(column).map_or("", |c| c.0.html());
            format!("<th scope=\"col\" class=\"{}\">{heading}</th>", class(column))
        };
        let empty = Cell::default();
        let row = |row: &Vec<Cell>| {
            let cell = |column: usize| {
                let Cell { text, class: mark } = row.get(column).unwrap_or(&empty);
                format!("<td class=\"{}{mark}\">{}</td>", class(column), text.html())
            };
            format!("<tr>{}</tr>\n", (0..wide).map(cell).collect::<String>())
        };
        let headings: String = (0..wide).map(heading).collect();
        let rows: String = self.rows.iter().map(row).collect();
        let notes: String = self.notes.iter().map(|note| format!("<p class=\"note\">{}</p>\n", note.html())).collect();
        let title = self.title.html();
        // Focusable, so that it can be scrolled with the keyboard.
        format!(
            "<figure class=\"table\" id=\"table-{number}\">\n\
             <figcaption><span class=\"no\">Table {number}</span> <span class=\"what\">{title}</span></figcaption>\n\
             <div class=\"scroll\" tabindex=\"0\" role=\"region\" aria-label=\"Table {number}\"><table>\n<thead><tr>\n\
             {headings}</tr></thead>\n<tbody>\n{rows}</tbody></table></div>\n{notes}</figure>\n"
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_of_any_length_give_a_rectangle() {
        let table = PageTable::new("t").text("a").number("b").row(["-1"]).row(["1", "2", "3"]).row(["1", "-2e-3"]);
        let out = table.html(1);
        assert_eq!((out.matches("<td").count(), out.matches("<th ").count()), (9, 3));
        for cell in ["num\">2<", "txt\">\u{2212}1<", "num\">\u{2212}2e\u{2212}3<"] {
            assert!(out.contains(cell), "{cell}: {out}");
        }
    }
}
