//! The terminal: text and tables on stdout, progress and complaints on stderr, Ctrl-C.

use anyhow::{Context, Result};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use piezoid::progress::Stage;
use std::cell::RefCell;
use std::io::{ErrorKind, IsTerminal, Write};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};

/// Set by the first Ctrl-C; work that watches it ends in good order. The second ends the process at once.
static CANCELLED: AtomicBool = AtomicBool::new(false);

/// Where the verbs write.
pub(crate) struct Console {
    bar: RefCell<ProgressBar>,
    shows_progress: bool,
}

impl Console {
    pub(crate) fn new(quiet: bool) -> Self {
        // Without a handler Ctrl-C ends the process, which is right too.
        let _ = ctrlc::set_handler(|| {
            if CANCELLED.swap(true, Ordering::Relaxed) {
                std::process::exit(1);
            }
        });
        Console { bar: RefCell::new(ProgressBar::hidden()), shows_progress: !quiet && std::io::stderr().is_terminal() }
    }

    /// Text on stdout. A reader that has gone away (`| head`) is no failure.
    pub(crate) fn print(&self, text: &str) -> Result<()> {
        let mut out = std::io::stdout().lock();
        match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
            Err(e) if e.kind() == ErrorKind::BrokenPipe => Ok(()),
            other => other.context("cannot write to stdout"),
        }
    }

    /// A remark on stderr, even when quiet.
    pub(crate) fn remark(&self, text: &str) {
        self.bar.borrow().suspend(|| {
            let _ = writeln!(std::io::stderr(), "note: {text}");
        });
    }

    /// The library's progress as a bar on stderr when that is a terminal; breaks after Ctrl-C.
    pub(crate) fn progress(&self) -> impl FnMut(Stage) -> ControlFlow<()> + '_ {
        move |stage| {
            if self.shows_progress {
                self.show(stage);
            }
            if CANCELLED.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        }
    }

    fn show(&self, stage: Stage) {
        let mut bar = self.bar.borrow_mut();
        if bar.message() != stage.what || bar.length() != Some(stage.total as u64) {
            bar.finish_and_clear();
            *bar = ProgressBar::with_draw_target(Some(stage.total as u64), ProgressDrawTarget::stderr());
            if let Ok(style) = ProgressStyle::with_template("{wide_msg} {bar:24} {pos:>5}/{len}") {
                bar.set_style(style.progress_chars("━╸ "));
            }
            bar.set_message(stage.what.to_string());
        }
        bar.set_position(stage.done as u64);
    }

    /// Takes the progress bar away.
    pub(crate) fn done(&self) {
        self.bar.borrow().finish_and_clear();
    }
}

/// One message on stderr, causes behind colons.
pub(crate) fn complain(error: &anyhow::Error) {
    let _ = writeln!(std::io::stderr(), "error: {error:#}");
}

/// Rows in columns as wide as they need: the first column to the left, the others to the right.
pub(crate) fn table(header: &[&str], rows: &[Vec<String>]) -> String {
    let width = |k: usize| {
        let cells = rows.iter().filter_map(|r| r.get(k)).map(|c| c.chars().count());
        cells.chain([header[k].chars().count()]).max().unwrap_or(0)
    };
    let widths: Vec<usize> = (0..header.len()).map(width).collect();
    let line = |cells: Vec<&str>| {
        let padded = cells.iter().zip(&widths).enumerate().map(|(k, (cell, &w))| match k {
            0 => format!("{cell:<w$}"),
            _ => format!("{cell:>w$}"),
        });
        padded.collect::<Vec<_>>().join("  ").trim_end().to_string() + "\n"
    };
    let head = line(header.to_vec());
    let rule = "-".repeat(widths.iter().sum::<usize>() + 2 * widths.len().saturating_sub(1)) + "\n";
    let body = rows.iter().map(|r| line(r.iter().map(String::as_str).collect()));
    [head, rule].into_iter().chain(body).collect()
}

/// A number with four significant digits, as people write it.
pub(crate) fn number(x: f64) -> String {
    match x.abs() {
        _ if !x.is_finite() => "-".into(),
        0.0 => "0".into(),
        a if (1e-3..1e5).contains(&a) => {
            let decimals = (3 - a.log10().floor() as i32).max(0) as usize;
            format!("{x:.decimals$}")
        }
        _ => format!("{x:.3e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_keep_four_digits() {
        let shown: Vec<String> = [0.0, 0.01289, 146.72, 1e-7, -33.333333, 123456.0, f64::NAN].map(number).to_vec();
        assert_eq!(shown, ["0", "0.01289", "146.7", "1.000e-7", "-33.33", "1.235e5", "-"]);
    }

    #[test]
    fn columns_line_up() {
        let text = table(&["f", "mse"], &[vec!["5 Hz".into(), "1".into()], vec!["x".into(), "0.25".into()]]);
        assert_eq!(text, "f      mse\n----------\n5 Hz     1\nx     0.25\n");
    }
}
