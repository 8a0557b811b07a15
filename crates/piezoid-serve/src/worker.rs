//! The process of one call: request on stdin, lines of progress and the answer on stdout.
//!
//! Why: docs/decisions/front-ends-and-serve.md, "A call of the server is a process".

use piezoid::progress::Stage;
use serde_json::json;
use std::io::{Error, ErrorKind, Read, Write, stdin, stdout};
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

/// Progress is reported so often at most, unless a new task begins or something was found.
const PAUSE: Duration = Duration::from_millis(50);

/// Once nobody waits for the answer any more, work that moves an instrument has so long to stop it.
pub(crate) const STOPPING: Duration = Duration::from_secs(6);

static LEFT: AtomicBool = AtomicBool::new(false);

/// Answers one request. On stdin are its length (8 bytes, little-endian) and the request; when stdin ends, nobody waits
/// for the answer any more, and the process ends. On stdout are lines `{"what": ..., "done": ..., "total": ...,
/// "figures": {...}, "model": "...", "best": true}`, an empty line, and the packed answer.
///
/// # Errors
/// Returns the error of stdin or stdout.
pub fn answer() -> Result<(), Error> {
    let mut length = [0; 8];
    stdin().read_exact(&mut length)?;
    let (length, mut request) = (u64::from_le_bytes(length), Vec::new());
    stdin().lock().take(length).read_to_end(&mut request)?;
    if request.len() as u64 != length {
        return Err(Error::other(format!("the request has {} bytes of {length}", request.len())));
    }
    let moves = piezoid_operations::moves(&request);
    std::thread::spawn(move || {
        while stdin().read(&mut [0]).is_ok_and(|count| count > 0) {}
        LEFT.store(true, Ordering::Relaxed);
        if moves {
            std::thread::sleep(STOPPING);
        }
        std::process::exit(1);
    });
    let mut message: Option<(String, Instant)> = None;
    let mut tell = |stage: Stage| {
        if LEFT.load(Ordering::Relaxed) {
            return ControlFlow::Break(());
        }
        let soon = |(last, at): &(String, Instant)| last == stage.what && at.elapsed() < PAUSE;
        if stage.figures.is_empty() && stage.model.is_none() && message.as_ref().is_some_and(soon) {
            return ControlFlow::Continue(());
        }
        message = Some((stage.what.to_string(), Instant::now()));
        let line = format!("{}\n", json!(stage));
        match stdout().lock().write_all(line.as_bytes()).and_then(|()| stdout().flush()) {
            Ok(()) => ControlFlow::Continue(()),
            Err(_) => ControlFlow::Break(()),
        }
    };
    let answer = piezoid_operations::answered(&request, &mut tell);
    let mut out = stdout().lock();
    let written = out.write_all(b"\n").and_then(|()| out.write_all(&answer)).and_then(|()| out.flush());
    // It is no error if nobody reads it any more.
    written.or_else(|e| if e.kind() == ErrorKind::BrokenPipe { Ok(()) } else { Err(e) })
}
