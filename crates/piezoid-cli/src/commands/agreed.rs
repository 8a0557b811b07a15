//! The question before an actuator moves.

use crate::console::is_interrupted;
use piezoid::Error;
use std::io::{BufRead, IsTerminal, Write, stderr, stdin};
use std::sync::mpsc;
use std::time::Duration;

/// Returns an error unless the user agrees to what is to move, or did so in advance.
pub(super) fn agreed(text: &str, in_advance: bool) -> Result<(), Error> {
    if in_advance {
        return Ok(());
    }
    if !stdin().is_terminal() {
        return Err(Error::Content(format!("{text} Add --yes to agree to it; nothing has moved")));
    }
    let mut err = stderr().lock();
    drop(write!(err, "{text} Continue? [y/N] ").and_then(|()| err.flush()));
    drop(err);
    match answer().as_deref() {
        Some("y" | "Y" | "yes") => Ok(()),
        _ => Err(Error::Content("nothing has moved".into())),
    }
}

/// A line of stdin; `None` at its end, and after Ctrl-C.
fn answer() -> Option<String> {
    let (to, from) = mpsc::channel();
    std::thread::spawn(move || {
        let mut line = String::new();
        let read = stdin().lock().read_line(&mut line);
        drop(to.send(read.map(|_| line.trim().to_string())));
    });
    loop {
        match from.recv_timeout(Duration::from_millis(20)) {
            Ok(line) => return line.ok().filter(|line| !line.is_empty()),
            Err(mpsc::RecvTimeoutError::Timeout) if !is_interrupted() => (),
            Err(_) => return None,
        }
    }
}
