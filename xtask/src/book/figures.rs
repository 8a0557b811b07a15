//! The drawings of reports, each as a file of its own.

use std::path::Path;

/// Beginning of a drawing in a report.
const HEAD: &str = "<svg xmlns=\"http://www.w3.org/2000/svg\" class=\"pz-fig";

/// Margin around a drawing that stands alone.
const MARGIN: f64 = 14.0;

/// Copies the drawings of a folder to another one, and writes those of its reports into folders with their names.
pub(super) fn collect(from: &Path, to: &Path) -> Result<(), String> {
    let write = |file: &Path, text: &str| {
        let folder = file.parent().unwrap_or(file);
        let written = std::fs::create_dir_all(folder).and_then(|()| std::fs::write(file, text));
        written.map_err(|e| format!("{}: {e}", file.display()))
    };
    for file in crate::tidy::files(from, "svg") {
        write(&to.join(file.strip_prefix(from).unwrap_or(&file)), &crate::tidy::read(&file)?)?;
    }
    for file in crate::tidy::files(from, "html") {
        for (name, drawing) in drawings(&crate::tidy::read(&file)?) {
            let folder = file.strip_prefix(from).unwrap_or(&file).with_extension("");
            write(&to.join(folder).join(name + ".svg"), &drawing)?;
        }
    }
    Ok(())
}

/// The drawings of a report with their names, as documents with the style of the report.
fn drawings(report: &str) -> Vec<(String, String)> {
    let style = report.split("<style>\n").nth(1).and_then(|rest| rest.split("\n*{").next()).unwrap_or_default();
    let drawing = |part: &str| {
        let body = part.split("\n<script").next()?;
        let (class, rest) = body.split_once(" viewBox=\"0 0 ")?;
        let (size, rest) = rest.split_once('"')?;
        let (width, height) = size.split_once(' ')?;
        let [w, h] = [width, height].map(|s| s.parse::<f64>().map(|s| s + 2.0 * MARGIN));
        let (w, h) = (w.ok()?, h.ok()?);
        let title = rest.split_once("<title>")?.1.split_once("</title>")?.0.to_lowercase();
        let parts = title.split(|c: char| !c.is_ascii_alphanumeric()).filter(|part| !part.is_empty());
        let window = format!(" viewBox=\"-{MARGIN} -{MARGIN} {w} {h}\" width=\"{w}\" height=\"{h}\"");
        let (head, body) = rest.split_once("</desc>\n")?;
        let text = format!("{HEAD}{class}{window}{head}</desc>\n<style>\n{style}\n</style>\n{body}\n");
        Some((parts.collect::<Vec<_>>().join("-"), text))
    };
    report.split(HEAD).skip(1).filter_map(drawing).collect()
}
