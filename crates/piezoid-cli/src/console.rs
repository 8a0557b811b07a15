//! The terminal: text on stdout, progress and complaints on stderr, Ctrl-C.

use crate::flags::failed;
use crate::layout::wrapped;
use anyhow::{Context, Result, anyhow};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use piezoid::progress::Stage;
use std::cell::RefCell;
use std::io::{ErrorKind, IsTerminal, Write};
use std::ops::ControlFlow;
use std::sync::Once;
use std::sync::atomic::{AtomicBool, Ordering};

/// Set by the first Ctrl-C; work that watches it ends in good order. The second ends the process at once.
static CANCELLED: AtomicBool = AtomicBool::new(false);

/// Lines are never longer than this, however wide the terminal: nobody reads them.
const WIDEST: usize = 100;

/// Width of text that goes into a file.
const USUAL: usize = 80;

/// Narrowest terminal in which a progress bar has a place beside its words.
const ROOM_FOR_A_BAR: usize = 72;

/// Where the verbs write.
pub(crate) struct Console {
    bar: RefCell<ProgressBar>,
    shows_progress: bool,
}

impl Console {
    pub(crate) fn new(quiet: bool) -> Self {
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

    /// How long a line of stdout may be; no matter when it is not a terminal.
    pub(crate) fn room(&self) -> Option<usize> {
        terminal_size::terminal_size_of(std::io::stdout()).map(|(width, _)| usize::from(width.0))
    }

    /// A paragraph on stdout, its further lines indented.
    pub(crate) fn paragraph(&self, text: &str, indent: &str) -> String {
        wrapped(text, self.room().unwrap_or(USUAL).min(WIDEST), indent) + "\n"
    }

    /// A remark on stderr, even when quiet.
    pub(crate) fn remark(&self, text: &str) {
        self.bar.borrow().suspend(|| say(&format!("note: {text}")));
    }

    /// The library's progress as a bar on stderr when that is a terminal; breaks after Ctrl-C. From here on Ctrl-C no
    /// longer ends the process by itself.
    pub(crate) fn progress(&self) -> impl FnMut(Stage) -> ControlFlow<()> + '_ {
        static WATCH: Once = Once::new();
        WATCH.call_once(|| {
            // Without a handler Ctrl-C ends the process, which is right too.
            let _ = ctrlc::set_handler(|| {
                if CANCELLED.swap(true, Ordering::Relaxed) {
                    std::process::exit(1);
                }
            });
        });
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
            let width = terminal_size::terminal_size_of(std::io::stderr()).map_or(USUAL, |(width, _)| width.0.into());
            let template = match width {
                ..ROOM_FOR_A_BAR => "{percent:>3} % {msg}",
                _ => "{msg}  {bar:20}  {pos}/{len}",
            };
            if let Ok(style) = ProgressStyle::with_template(template) {
                bar.set_style(style.progress_chars("━╸ "));
            }
            bar.set_message(stage.what.to_string());
        }
        bar.set_position(stage.done as u64);
    }

    /// Takes the progress bar away, and hands on what the work came to.
    pub(crate) fn done<T>(&self, outcome: Result<T, piezoid::Error>) -> Result<T> {
        self.bar.borrow().finish_and_clear();
        outcome.map_err(|error| match error {
            piezoid::Error::Cancelled { .. } => anyhow!("{error}: nothing was written"),
            other => failed(other),
        })
    }
}

/// One message on stderr, causes behind colons.
pub(crate) fn complain(error: &anyhow::Error) {
    say(&format!("error: {error:#}"));
}

/// A line on stderr, in several where a terminal is narrower.
fn say(text: &str) {
    let text = match terminal_size::terminal_size_of(std::io::stderr()) {
        Some((width, _)) => wrapped(text, usize::from(width.0).min(WIDEST), "  "),
        None => text.into(),
    };
    let _ = writeln!(std::io::stderr(), "{text}");
}
