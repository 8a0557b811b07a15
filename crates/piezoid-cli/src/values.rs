//! What arguments mean: numbers in their range, files that must differ.

use anyhow::{Result, bail};
use std::path::{Path, PathBuf};

/// A wrong command line that the parser cannot see: exit status 2.
#[derive(Debug)]
pub(crate) struct Misused(pub(crate) String);

impl std::fmt::Display for Misused {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.0)
    }
}

impl std::error::Error for Misused {}

/// What the library says of a value that came from the command line itself.
pub(crate) fn argument<T>(judged: Result<T, piezoid::Error>) -> Result<T> {
    judged.map_err(|e| Misused(e.to_string()).into())
}

/// A point in time or a length of it [s], not negative.
pub(crate) fn seconds(text: &str) -> Result<f64, String> {
    number(text, "a number of seconds, 0 or more, such as 0.5", |t| t >= 0.0)
}

/// A period or duration [s], positive.
pub(crate) fn period(text: &str) -> Result<f64, String> {
    number(text, "a positive number of seconds, such as 5e-4", |t| t > 0.0)
}

/// A capacitance [F], positive.
pub(crate) fn farads(text: &str) -> Result<f64, String> {
    number(text, "a positive number of farads, such as 8.2e-6", |c| c > 0.0)
}

/// A positive number.
pub(crate) fn positive(text: &str) -> Result<f64, String> {
    number(text, "a positive number", |x| x > 0.0)
}

/// A number that is not negative.
pub(crate) fn not_negative(text: &str) -> Result<f64, String> {
    number(text, "a number, 0 or more", |x| x >= 0.0)
}

/// A share in percent.
pub(crate) fn percent(text: &str) -> Result<f64, String> {
    number(text, "a percentage from 0 to below 100", |x| (0.0..100.0).contains(&x))
}

/// How many of something, at least one.
pub(crate) fn count(text: &str) -> Result<usize, String> {
    text.parse().ok().filter(|n| *n > 0).ok_or_else(|| "it must be a whole number, 1 or more".into())
}

fn number(text: &str, what: &str, fits: impl Fn(f64) -> bool) -> Result<f64, String> {
    text.parse().ok().filter(|x: &f64| x.is_finite() && fits(*x)).ok_or_else(|| format!("it must be {what}"))
}

/// Refuses results that would overwrite each other or what they are made from.
pub(crate) fn apart(outputs: &[Option<&Path>], inputs: &[&PathBuf]) -> Result<()> {
    let same = |a: &Path, b: &Path| {
        a == b || std::fs::canonicalize(a).is_ok_and(|a| std::fs::canonicalize(b).is_ok_and(|b| a == b))
    };
    let outputs: Vec<&Path> = outputs.iter().copied().flatten().collect();
    for (k, output) in outputs.iter().enumerate() {
        if outputs[..k].iter().any(|earlier| same(earlier, output)) {
            let place = if *output == Path::new("-") { "stdout".into() } else { output.display().to_string() };
            bail!(Misused(format!("two results cannot both go to {place}: name another file for one of them")));
        }
        if inputs.iter().any(|input| same(input, output)) && output.metadata().is_ok_and(|m| m.is_file()) {
            let output = output.display();
            bail!(Misused(format!("{output} is read and would be overwritten: name another file for the result")));
        }
    }
    Ok(())
}
