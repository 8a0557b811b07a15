//! Links of the book: each file, anchor and image of it exists. Of other sites only the form of the address is checked.

use crate::tidy::{files, read, shown};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Component, Path, PathBuf};

/// Pages that repeat others, or whose links begin elsewhere.
const APART: [&str; 3] = ["404.html", "print.html", "toc.html"];

/// The error lists the links of the pages that lead nowhere.
pub(super) fn check(book: &Path) -> Result<(), String> {
    let mut pages = BTreeMap::new();
    for file in files(book, "html") {
        pages.insert(file.clone(), read(&file)?);
    }
    let anchors: BTreeMap<&Path, BTreeSet<&str>> =
        pages.iter().map(|(file, text)| (file.as_path(), values(text, " id=\"").collect())).collect();
    let (mut dead, mut count) = (Vec::new(), 0);
    for (file, text) in &pages {
        if APART.iter().any(|name| file.ends_with(name)) {
            continue;
        }
        for link in values(text, " href=\"").chain(values(text, " src=\"")) {
            count += 1;
            if !leads(link, file, &anchors) {
                dead.push(format!("{}: {link}", shown(file)));
            }
        }
    }
    eprintln!("book: {} pages, {count} links", pages.len() - APART.len().min(pages.len()));
    if dead.is_empty() { Ok(()) } else { Err(format!("links that lead nowhere:\n  {}", dead.join("\n  "))) }
}

/// True if the target of a link of `file` exists.
fn leads(link: &str, file: &Path, anchors: &BTreeMap<&Path, BTreeSet<&str>>) -> bool {
    if let Some(address) = link.strip_prefix("https://").or(link.strip_prefix("http://")) {
        let host = address.split(['/', '#', '?']).next().unwrap_or_default();
        return (host.contains('.') || host.starts_with("localhost")) && !link.contains(char::is_whitespace);
    }
    let (path, anchor) = link.split_once('#').unwrap_or((link, ""));
    let target = match path {
        "" => file.to_path_buf(),
        path => plain(&file.parent().unwrap_or(file).join(path)),
    };
    match anchors.get(target.as_path()) {
        Some(ids) => anchor.is_empty() || ids.contains(anchor),
        None => anchor.is_empty() && target.is_file(),
    }
}

/// The same path without `..` and `.`.
fn plain(path: &Path) -> PathBuf {
    let mut parts = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => _ = parts.pop(),
            Component::CurDir => {}
            part => parts.push(part),
        }
    }
    parts
}

/// The values of an attribute.
fn values<'a>(text: &'a str, attribute: &'a str) -> impl Iterator<Item = &'a str> {
    text.split(attribute).skip(1).filter_map(|rest| rest.split('"').next())
}

/// The error lists the files that pages outside of the book name and that do not exist.
pub(super) fn check_sources(pages: &[&str]) -> Result<(), String> {
    let mut dead = Vec::new();
    for page in pages {
        let text = read(&crate::root().join(page))?;
        let links = text.split("](").skip(1).filter_map(|rest| rest.split([')', '#']).next());
        let here = links.filter(|link| !link.is_empty() && !link.starts_with("http"));
        dead.extend(here.filter(|link| !crate::root().join(link).exists()).map(|link| format!("{page}: {link}")));
    }
    if dead.is_empty() { Ok(()) } else { Err(format!("links that lead nowhere:\n  {}", dead.join("\n  "))) }
}

#[cfg(test)]
mod tests {
    use super::{leads, values};
    use std::collections::BTreeMap;
    use std::path::Path;

    #[test]
    fn a_link_leads_to_a_page_and_an_anchor_that_exist() {
        let text = "<h2 id=\"one\"><a href=\"b.html\">";
        let anchors = BTreeMap::from([(Path::new("/book/a.html"), values(text, " id=\"").collect())]);
        let from = |link| leads(link, Path::new("/book/a/b.html"), &anchors);
        assert!(from("../a.html#one") && from("../a.html") && from("https://doi.org/10.1"));
        assert!(!from("../a.html#two") && !from("c.html") && !from("https://doi org/"));
    }
}
