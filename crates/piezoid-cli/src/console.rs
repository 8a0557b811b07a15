//! The terminal: text on stdout, progress and messages on stderr, Ctrl-C.

use crate::flags::failed;
use crate::layout::table;
use crate::values::{CANCELLED, Ended};
use anyhow::{Context, Result};
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressState, ProgressStyle};
use piezoid::progress::{Progress, Stage};
use piezoid_numerics::words::wrapped;
use std::cell::RefCell;
use std::io::{ErrorKind, IsTerminal, Write};
use std::ops::ControlFlow;
use std::sync::OnceLock;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Set by the first signal.
static INTERRUPTED: AtomicBool = AtomicBool::new(false);

/// True while work checks for a signal and ends in an orderly way.
static WATCHED: AtomicBool = AtomicBool::new(false);

/// Maximum length of a line, even in a wider terminal: longer lines are hard to read.
const WIDEST: usize = 100;

/// Length of a line if the output is not a terminal.
const USUAL: usize = 80;

/// Minimum width of a terminal for a progress bar beside its text.
const ROOM_FOR_A_BAR: usize = 72;

/// Output of the verbs.
pub(crate) struct Console {
    bar: RefCell<ProgressBar>,
    shows_progress: bool,
}

impl Console {
    pub(crate) fn new(quiet: bool) -> Self {
        Console { bar: RefCell::new(ProgressBar::hidden()), shows_progress: !quiet && std::io::stderr().is_terminal() }
    }

    /// Prints text or bytes on stdout. It is not an error if the reader has closed the pipe (`| head`).
    pub(crate) fn print(&self, content: &(impl AsRef<[u8]> + ?Sized)) -> Result<()> {
        let mut out = std::io::stdout().lock();
        match out.write_all(content.as_ref()).and_then(|()| out.flush()) {
            Err(e) if e.kind() == ErrorKind::BrokenPipe => Ok(()),
            other => other.context("cannot write to stdout"),
        }
    }

    /// Maximum length of a line on stdout; `None` if stdout is not a terminal.
    pub(crate) fn room(&self) -> Option<usize> {
        terminal_size::terminal_size_of(std::io::stdout()).map(|(width, _)| usize::from(width.0))
    }

    /// A table for stdout.
    pub(crate) fn table(&self, header: &[&str], rows: impl IntoIterator<Item = Vec<String>>) -> String {
        table(header, &rows.into_iter().collect::<Vec<_>>(), self.room())
    }

    /// A paragraph for stdout; all lines except the first are indented.
    pub(crate) fn paragraph(&self, text: &str, indent: &str) -> String {
        wrapped(text, self.room().unwrap_or(USUAL).min(WIDEST), indent) + "\n"
    }

    /// Prints a sentence on stdout, to which a full stop is added.
    pub(crate) fn sentence(&self, text: &str) -> Result<()> {
        self.print(&self.paragraph(&format!("{text}."), ""))
    }

    /// Prints a remark on stderr, even with `--quiet`.
    pub(crate) fn remark(&self, text: &str) {
        self.bar.borrow().suspend(|| say(&format!("note: {text}")));
    }

    /// Prints each of these remarks.
    pub(crate) fn remarks(&self, texts: impl IntoIterator<Item = impl AsRef<str>>) {
        texts.into_iter().for_each(|text| self.remark(text.as_ref()));
    }

    /// Does work of the library. Its progress is a bar if stderr is a terminal. A signal ends the work in an orderly
    /// way; one that comes later ends the process.
    pub(crate) fn work<T>(&self, work: impl FnOnce(&mut Progress) -> Result<T, piezoid::Error>) -> Result<T> {
        let (result, is_cancelled) = self.work_until_cancelled(work)?;
        match is_cancelled {
            true => Err(Ended::Cancelled("cancelled at the end of the work: nothing was written".into()).into()),
            false => Ok(result),
        }
    }

    /// The same for work that may have a result when a signal ends it; true if one came.
    pub(crate) fn work_until_cancelled<T>(
        &self,
        work: impl FnOnce(&mut Progress) -> Result<T, piezoid::Error>,
    ) -> Result<(T, bool)> {
        let outcome = self.work_on_instrument(work);
        WATCHED.store(false, Ordering::SeqCst);
        outcome
    }

    /// The same for work that moves an axis: no first signal ends the process after it, before it is stated where the
    /// axis is.
    pub(crate) fn work_on_instrument<T>(
        &self,
        work: impl FnOnce(&mut Progress) -> Result<T, piezoid::Error>,
    ) -> Result<(T, bool)> {
        WATCHED.store(true, Ordering::SeqCst);
        let outcome = work(&mut |stage: Stage| {
            if self.shows_progress {
                self.show(stage);
            }
            if INTERRUPTED.load(Ordering::SeqCst) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        self.bar.borrow().finish_and_clear();
        let result = outcome.map_err(|error| match error {
            piezoid::Error::Cancelled { .. } => Ended::Cancelled(format!("{error}: nothing was written")).into(),
            other => failed(other),
        })?;
        Ok((result, INTERRUPTED.load(Ordering::SeqCst)))
    }

    fn show(&self, stage: Stage) {
        let mut bar = self.bar.borrow_mut();
        if bar.message() != stage.what || bar.length() != Some(stage.total as u64) {
            bar.finish_and_clear();
            *bar = ProgressBar::with_draw_target(Some(stage.total as u64), ProgressDrawTarget::stderr());
            let width = terminal_size::terminal_size_of(std::io::stderr()).map_or(USUAL, |(width, _)| width.0.into());
            let template = match width {
                ..ROOM_FOR_A_BAR => "{percent:>3} % {msg}",
                _ => "{msg}  {bar:20}  {pos}/{len}{left}",
            };
            if let Ok(style) = ProgressStyle::with_template(template) {
                let left = |state: &ProgressState, text: &mut dyn std::fmt::Write| {
                    let eta = state.eta().as_secs();
                    let _ = if eta > 0 { write!(text, "  {eta} s left") } else { Ok(()) };
                };
                bar.set_style(style.progress_chars("━╸ ").with_key("left", left));
            }
            bar.set_message(stage.what.to_string());
        }
        bar.set_position(stage.done as u64);
    }
}

/// True once a signal came.
pub(crate) fn is_interrupted() -> bool {
    INTERRUPTED.load(Ordering::SeqCst)
}

/// Signals within this time are one: programs that start others may pass Ctrl-C on a second time.
const BOUNCE: Duration = Duration::from_millis(300);

/// Ends the process on SIGINT, SIGTERM and SIGHUP: work that checks for a signal ends in an orderly way, all else at
/// once and so does a second signal; files that are being put in place are placed first, and temporary files are
/// removed.
pub(crate) fn handle_signals() {
    static FIRST: OnceLock<Instant> = OnceLock::new();
    let end = || {
        INTERRUPTED.store(true, Ordering::SeqCst);
        let is_second = FIRST.get_or_init(Instant::now).elapsed() > BOUNCE;
        if is_second || !WATCHED.load(Ordering::SeqCst) {
            piezoid_host::temporary::abandon();
            std::process::exit(CANCELLED.into());
        }
    };
    // Without a handler a signal ends the process too, but leaves temporary files.
    #[cfg(unix)]
    {
        use piezoid_host::signals::is_ignored;
        use signal_hook::consts::{SIGHUP, SIGINT, SIGTERM};
        let handled = [SIGHUP, SIGINT, SIGTERM].into_iter().filter(|signal| !is_ignored(*signal));
        if let Ok(mut signals) = signal_hook::iterator::Signals::new(handled) {
            let wait = move || signals.forever().for_each(|_| end());
            let _ = std::thread::Builder::new().spawn(wait);
        }
    }
    #[cfg(not(unix))]
    let _ = ctrlc::set_handler(end);
}

/// Prints one error message on stderr, with its causes after colons.
pub(crate) fn complain(error: &anyhow::Error) {
    say(&format!("error: {error:#}"));
}

/// Prints a message on stderr, wrapped to the width of the terminal.
pub(crate) fn say(text: &str) {
    let text = match terminal_size::terminal_size_of(std::io::stderr()) {
        Some((width, _)) => wrapped(text, usize::from(width.0).min(WIDEST), "  "),
        None => text.into(),
    };
    let _ = writeln!(std::io::stderr(), "{text}");
}
