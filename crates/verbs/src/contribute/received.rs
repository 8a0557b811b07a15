//! An archive that was received: its checksums, and its records as it states them.

use super::{Contributed, ContributedFile, DOCUMENT, Document, SCHEMA, SOURCE, sha256};
use crate::{File, Source};
use piezoid_numerics::error::Error;
use piezoid_records::formats;
use piezoid_records::record::Units;
use serde::Deserialize;
use serde_json::{Value, json};
use std::collections::BTreeSet;

/// What an archive states, read again.
pub(super) fn read(archive: &[u8]) -> Result<Contributed, Error> {
    let no = |why: String| Error::Content(format!("this is no contribution: {why}"));
    let is_zip = archive.starts_with(b"PK");
    let members = if is_zip { formats::unpacked(archive)? } else { Vec::new() };
    let document = members.iter().find(|(name, _)| name == DOCUMENT);
    let how = "give the archive that `contribute` wrote";
    let (_, text) = document.ok_or_else(|| no(format!("it has no {DOCUMENT}: {how}")))?;
    let stated: Value = serde_json::from_slice(text).map_err(|e| no(format!("{DOCUMENT}: {e}")))?;
    if stated["piezoid_contribution"] != json!(SCHEMA) {
        let schema = &stated["piezoid_contribution"];
        return Err(no(format!("its schema number is {schema}, and this version reads {SCHEMA}: use another version")));
    }
    let stated = Document::deserialize(stated).map_err(|e| no(format!("{DOCUMENT}: {e}")))?;
    let mut listed: BTreeSet<&str> = stated.files.iter().map(|file| &*file.file).chain([DOCUMENT, SOURCE]).collect();
    for (name, _) in &members {
        // Each name once: programs that unpack disagree on which of two files counts.
        if !listed.remove(&**name) {
            let what = format!("is in the archive twice, or {DOCUMENT} does not state it: ask for the archive again");
            return Err(Error::Content(what).of(name));
        }
    }
    let source = |file: &ContributedFile| {
        let (_, bytes) = members.iter().find(|(name, _)| *name == file.file).ok_or_else(|| missing(file))?;
        let found = sha256(bytes);
        if found != file.sha256 {
            let stated = &file.sha256;
            let what = format!("was changed: its SHA-256 is {found}, and {DOCUMENT} states {stated}");
            return Err(Error::Content(format!("{what}: ask for the archive again")).of(&file.file));
        }
        Ok(Source::new(File::new(&*file.file, bytes.clone()), file.columns.clone(), Vec::new()))
    };
    let sources = stated.files.iter().map(source).collect::<Result<_, Error>>()?;
    let mut read = stated.statement.run(sources)?;
    for (stated_file, file) in stated.files.iter().zip(&read.document.files) {
        same(stated_file, file, &stated.version)?;
    }
    read.document.version = stated.version;
    Ok(read)
}

fn missing(file: &ContributedFile) -> Error {
    let what = format!("{DOCUMENT} states this file, but the archive does not have it: ask for the archive again");
    Error::Content(what).of(&file.file)
}

/// Returns an error if a file is read in another way than it is stated.
fn same(stated: &ContributedFile, read: &ContributedFile, version: &str) -> Result<(), Error> {
    let facts = |file: &ContributedFile| {
        let Units { u, y } = &file.units;
        format!("{} bytes, {} samples every {} s, u in {u}, y in {y}", file.bytes, file.samples, file.ts)
    };
    let (stated_facts, facts) = (facts(stated), facts(read));
    if stated_facts == facts {
        return Ok(());
    }
    let this = env!("CARGO_PKG_VERSION");
    let what = format!("is read as {facts}, but {DOCUMENT} states {stated_facts}");
    let why = format!("it was changed, or read by another version ({version}; this is {this})");
    Err(Error::Content(format!("{what}: {why}")).of(&read.file))
}
