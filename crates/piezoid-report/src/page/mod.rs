//! Reports as one HTML file: text, figures and tables for desktop, phone and print.
//!
//! A [`Page`] is a title and [`Section`]s. A section is text, [`Figure`](crate::plot::Figure)s, [`PageTable`]s,
//! callouts and [`Fact`]s in the order they are added. Figures, tables and sections are numbered, and longer pages get
//! a table of contents. The file needs no network and works without scripts. It follows the system's choice of light or
//! dark, and a button, if scripts are on, selects the other. With scripts, figures are interactive plots of data that
//! the file contains; the static drawings are kept for print.
//!
//! The same page gives the same bytes: it contains dates, paths and versions only if the caller adds them.
//!
//! ```
//! use piezoid_report::page::{Fact, Page, Section, PageTable};
//! let page = Page::new("Hammerstein model of a bender").subtitle("identified from a record at 5 Hz")
//!     .section(Section::new("Result")
//!         .facts([Fact::new("0.84", "%", "rms error of the test, of peak-to-peak")])
//!         .text("The model follows the test record.")
//!         .table(PageTable::new("Poles").number("f [Hz]").number("damping").row(["146.7", "0.061"])));
//! assert!(page.html().starts_with("<!DOCTYPE html>"));
//! ```

mod address;
mod section;
mod table;
mod text;

pub use address::Address;
pub use section::{Fact, Section};
pub use table::{Cell, PageTable};
pub use text::Text;
pub(crate) use text::sentence;

use crate::plot::{Figure, escape, shown};
use section::Numbering;
use std::fmt::Write;

/// The button for light and dark; hidden without scripts.
const TOGGLE: &str = include_str!("toggle.js");

/// The plots of figures: web/src/report.ts, written by `cargo xtask generate page`. Hidden from readers of XML, whose
/// markup it would be.
const PLOTS: &str = concat!("<script>//<![CDATA[\n", include_str!("figures.js"), "//]]></script>\n");

/// A report: one self-contained HTML document.
#[derive(Debug, Clone, PartialEq)]
pub struct Page {
    title: String,
    subtitle: String,
    project: Option<Address>,
    sections: Vec<Section>,
}

impl Page {
    /// An empty page.
    pub fn new(title: impl Into<String>) -> Self {
        Page { title: title.into(), subtitle: String::new(), project: None, sections: Vec::new() }
    }

    /// A line under the title: the subject of the report.
    pub fn subtitle(self, text: impl Into<String>) -> Self {
        Page { subtitle: text.into(), ..self }
    }

    /// With a link that opens the project of the report, if there is an address of it.
    pub fn of_project(self, address: Option<Address>) -> Self {
        Page { project: address, ..self }
    }

    /// The sections of another page after those of this one.
    pub fn followed_by(mut self, other: Page) -> Self {
        self.sections.extend(other.sections);
        self
    }

    /// One more section.
    pub fn section(mut self, section: Section) -> Self {
        self.sections.push(section);
        self
    }

    /// The document.
    pub fn html(&self) -> String {
        let (title, subtitle) = (shown(&self.title), shown(&self.subtitle));
        let mut out = format!(
            "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\"/>\n\
             <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>\n<title>{title}</title>\n\
             <style>\n{}{}</style>\n</head>\n<body>\n",
            Figure::style(),
            include_str!("style.css")
        );
        let subtitle = if subtitle.is_empty() { subtitle } else { format!("<p class=\"subtitle\">{subtitle}</p>\n") };
        let project = self.project.as_ref().map_or_else(String::new, |address| {
            format!("<p class=\"project\"><a href=\"{}\">Open the project</a></p>\n", escape(address.as_ref()))
        });
        let _ =
            writeln!(out, "<header>\n<p class=\"mark\">piezoid</p>\n<h1>{title}</h1>\n{subtitle}{project}</header>");
        self.contents(&mut out);
        out.push_str("<main>\n");
        let (mut numbers, mut n) = (Numbering::default(), 0);
        for section in &self.sections {
            if section.title().is_empty() {
                out.push_str("<div class=\"section\">\n");
                section.write(&mut out, &mut numbers);
                out.push_str("</div>\n");
                continue;
            }
            n += 1;
            let title = shown(section.title());
            let _ = writeln!(out, "<section id=\"section-{n}\" class=\"section\">");
            let _ = writeln!(out, "<h2><span class=\"no\">{n}</span> {title}</h2>");
            section.write(&mut out, &mut numbers);
            out.push_str("</section>\n");
        }
        let plots = if numbers.plots > 0 { PLOTS } else { "" };
        let _ = write!(out, "</main>\n<script>\n{TOGGLE}</script>\n{plots}</body>\n</html>\n");
        out
    }

    /// The table of contents, for more than one section.
    fn contents(&self, out: &mut String) {
        let titles = self.sections.iter().map(Section::title).filter(|t| !t.is_empty());
        let items: Vec<String> = (1..)
            .zip(titles)
            .map(|(n, t)| format!("<li><a href=\"#section-{n}\"><span class=\"no\">{n}</span> {}</a></li>\n", shown(t)))
            .collect();
        if items.len() > 1 {
            let _ = writeln!(out, "<nav aria-label=\"Contents\">\n<ol>\n{}</ol>\n</nav>", items.concat());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::{Axes, Figure, Series};

    fn page() -> Page {
        let figure = || {
            Figure::new("Loop <1>", "It & that").panel(Axes::new("u", "z").with(Series::line(&[0.0, 1.0], &[0.0, 1.0])))
        };
        let table = || PageTable::new("T & t").text("a<b").number("n").row(["<", "1"]).note("n & m");
        Page::new("A < B & \"C\"")
            .subtitle("<script>alert(1)</script>")
            .section(Section::new("").facts([Fact::new("<1", "&", "what")]))
            .section(Section::new("First & foremost").text("a < b").heading("h").figure(figure()).table(table()))
            .section(
                Section::new("Second")
                    .figures(3, "Loops", "Three", [figure(), figure(), figure()])
                    .list(["one", "two"])
                    .listing("piezoid study > out && echo 'x'")
                    .note("Note", "x")
                    .warning("Beware", "y")
                    .table(table()),
            )
    }

    #[test]
    fn the_project_is_linked_only_at_an_address_of_the_web() {
        let address = "http://127.0.0.1:7440/?a=1&b=\"2\"#workbench";
        let html = page().of_project(Some(address.parse().unwrap())).html();
        let options = roxmltree::ParsingOptions { allow_dtd: true, ..Default::default() };
        let document = roxmltree::Document::parse_with_options(&html, options).unwrap();
        let mut links = document.descendants().filter_map(|n| n.attribute("href"));
        assert!(links.any(|link| link == address));
        assert_eq!(page().of_project(None), page());
        for wrong in ["javascript:alert(1)", "", "/tmp/a", "http://a b"] {
            let error = wrong.parse::<Address>().unwrap_err().to_string();
            assert!(error.contains("project") && error.contains("must begin with http://"), "{error}");
        }
    }

    #[test]
    fn a_page_is_well_formed_and_its_text_is_escaped() {
        let html = page().html();
        let options = roxmltree::ParsingOptions { allow_dtd: true, ..Default::default() };
        let document = roxmltree::Document::parse_with_options(&html, options).unwrap();
        let of = |name: &str| document.descendants().filter(|n| n.has_tag_name(name)).count();
        assert_eq!((of("table"), of("section"), of("nav"), of("li")), (2, 2, 1, 4));
        let title = document.descendants().find(|n| n.has_tag_name("h1")).and_then(|n| n.text());
        assert_eq!(title, Some("A < B & \"C\""));
    }

    #[test]
    fn every_figure_has_its_data_and_the_script_of_the_plots_stands_once() {
        let html = page().html();
        let options = roxmltree::ParsingOptions { allow_dtd: true, ..Default::default() };
        let document = roxmltree::Document::parse_with_options(&html, options).unwrap();
        let scripts = || document.descendants().filter(|n| n.has_tag_name("script"));
        let data: Vec<_> = scripts().filter(|n| n.attribute("type") == Some("application/json")).collect();
        assert_eq!((data.len(), scripts().count(), html.matches("IntersectionObserver(").count()), (4, 6, 1));
        for script in data {
            assert!(script.parent_element().unwrap().children().any(|n| n.has_tag_name("svg")));
            let plots: serde_json::Value = serde_json::from_str(script.text().unwrap()).unwrap();
            assert_eq!((&plots[0]["title"], &plots[0]["x"]["label"]), (&"Loop <1>".into(), &"u".into()));
            assert_eq!(plots[0]["panels"][0]["series"][0]["y"].to_string(), "[0.0,1.0]");
        }
    }

    #[test]
    fn a_page_without_figures_has_no_plots() {
        let html = Page::new("").section(Section::new("").text("a")).html();
        assert_eq!((html.matches("<script").count(), html.contains("IntersectionObserver")), (1, false));
        let empty = Figure::new("", "").panel(Axes::new("u", "z"));
        assert_eq!(Page::new("").section(Section::new("").figure(empty)).html().matches("<script").count(), 1);
    }

    #[test]
    fn figures_and_tables_are_numbered_through_the_page() {
        let html = page().html();
        for id in ["figure-1", "figure-2", "table-1", "table-2", "section-1", "section-2"] {
            assert_eq!(html.matches(&format!("id=\"{id}\"")).count(), 1, "{id}");
        }
    }

    #[test]
    fn figures_side_by_side_share_one_legend() {
        let figure = |k: u8| {
            let series = |name| Series::line(&[0.0, 1.0], &[0.0, f64::from(k)]).named(name);
            Figure::new("", "").panel(Axes::new("u [V]", "y [um]").with(series("measured")).with(series("model")))
        };
        let html = Page::new("").section(Section::new("").figures(2, "Loops", "", (0..8).map(figure))).html();
        assert_eq!((html.matches(">model<").count(), html.matches("</svg>model</li>").count()), (1, 1), "{html}");
        assert_eq!((html.matches("y [µm]").count(), html.matches("um]").count()), (8, 0), "units as people read them");
    }

    #[test]
    fn a_page_needs_nothing_from_outside_and_is_reproducible() {
        let html = page().html();
        // Plots clip by parts of their own document.
        let other = html.replace("url(#", "");
        for outside in [" src=", "@import", "url(", "<link", "fetch(", "import("] {
            assert!(!other.contains(outside), "{outside}");
        }
        assert_eq!(html, page().html());
    }
}
