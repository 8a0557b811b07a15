//! `cargo xtask release`: everything that is handed out, in target/dist, from the tag of the version.
//!
//! The same commit gives the same bytes in whatever folder it is checked out: no path is part of a file, every time is
//! that of the commit, and the tools are of fixed versions.

mod build;
mod examples;
mod notes;

use crate::{root, step, target, web};
use build::{Release, TARGETS};

/// Makes the release. `--rehearsal` needs no tag; names of targets leave the others out.
pub(super) fn release() -> Result<(), String> {
    let words: Vec<String> = std::env::args().skip(2).collect();
    let (options, names): (Vec<_>, Vec<_>) = words.iter().partition(|word| word.starts_with("--"));
    if let Some(unknown) = options.iter().find(|option| **option != "--rehearsal") {
        return Err(format!("`{unknown}` is unknown: there is --rehearsal, for a commit without a tag"));
    }
    if let Some(unknown) = names.iter().find(|name| !TARGETS.iter().any(|target| target.triple == name.as_str())) {
        let known: Vec<_> = TARGETS.iter().map(|target| target.triple).collect();
        return Err(format!("`{unknown}` is no target of a release: {}", known.join(", ")));
    }
    let is_chosen = |triple: &str| names.is_empty() || names.iter().any(|name| *name == triple);
    let release = Release::of_this_commit(!options.is_empty())?;
    let first = &TARGETS[0];
    let others: Vec<_> = TARGETS[1..].iter().filter(|target| is_chosen(target.triple)).collect();
    release.materials(&[&[first], &others[..]].concat())?;
    // What the first program writes are the examples; the programs of other targets must write the same.
    let program = release.program(first)?;
    let examples = examples::write(&program)?;
    release.archive_program(first, &program, &program)?;
    let package = examples::try_package(&release.wheel(first)?, &examples)?;
    let mut handed_out = vec![(first, "on this machine".to_string(), package)];
    for other in others {
        let file = release.program(other)?;
        release.archive_program(other, &file, &program)?;
        release.wheel(other)?;
        handed_out.push((other, examples::compare(other, &file, &examples)?, "not run".into()));
    }
    release.archive("examples", &examples)?;
    web::handed_out(&release.catalogue(first)?)?;
    release.archive("page", &root().join("web/dist"))?;
    release.sources()?;
    notes::write(&release, &handed_out)
}
