//! `POST /api/call`: a packed request is given to a process, whose output is the answer.
//!
//! As many calls are at work as there are cores, [`WAITING`] more wait, and others are refused. Requests in memory have
//! at most [`TOGETHER`] bytes together. A call ends when its client goes; one that moves an instrument also when it is
//! stopped ([`Stops`]).
//!
//! Why: docs/decisions/front-ends-and-serve.md, "A call of the server is a process".

use crate::Shared;
use crate::body::{self, PATIENCE};
use crate::failure::Failure;
use crate::stops::{Stop, Stops};
use crate::worker::STOPPING;
use axum::body::{Body, Bytes};
use axum::extract::{Request, State};
use axum::http::{StatusCode, header};
use axum::response::{IntoResponse, Response};
use futures_util::stream::unfold;
use std::path::PathBuf;
use std::process::Stdio;
use std::sync::Arc;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::process::{Child, ChildStdin, Command};
use tokio::sync::{AcquireError, Semaphore, mpsc};
use tokio::time::timeout;

/// How many calls may wait.
const WAITING: usize = 32;

/// Requests that are in memory or arrive have at most so many bytes together, unless one alone may have more.
const TOGETHER: u64 = 1 << 30;

/// Bytes of a piece of an answer.
const PIECE: usize = 1 << 16;

/// The calls that are at work or wait.
pub(crate) struct Calls {
    worker: (PathBuf, Vec<String>),
    places: Arc<Semaphore>,
    cores: Arc<Semaphore>,
    /// In KiB.
    memory: Arc<Semaphore>,
    /// Those that move an instrument.
    pub(crate) stops: Stops,
}

impl Calls {
    pub(crate) fn new(worker: (PathBuf, Vec<String>), limit: u64) -> Self {
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let [places, cores, memory] = [cores + WAITING, cores, kib(limit.max(TOGETHER)) as usize]
            .map(|count| Arc::new(Semaphore::new(count.min(Semaphore::MAX_PERMITS))));
        Calls { worker, places, cores, memory, stops: Stops::default() }
    }

    /// Starts a process. Its input stays open as long as it is wanted: it ends when the server ends, however that does.
    /// It is in a group of its own, so that Ctrl-C in the terminal of the server does not end it: one that moves an
    /// instrument must stop that first.
    fn start(&self, moves: bool) -> std::io::Result<(Child, ChildStdin)> {
        let (program, arguments) = &self.worker;
        let mut command = Command::new(program);
        #[cfg(unix)]
        command.arg0("piezoid").process_group(0);
        command.args(arguments).stdin(Stdio::piped()).stdout(Stdio::piped()).kill_on_drop(!moves);
        let mut child = command.spawn()?;
        let input = child.stdin.take().ok_or_else(|| std::io::Error::other("it has no input"))?;
        Ok((child, input))
    }
}

fn kib(bytes: u64) -> u32 {
    u32::try_from(bytes.div_ceil(1 << 10)).unwrap_or(u32::MAX)
}

/// Answers a packed request.
pub(crate) async fn call(State(server): Shared, request: Request) -> Result<Response, Failure> {
    let internal = |e: &dyn std::fmt::Display| Failure::new(StatusCode::INTERNAL_SERVER_ERROR, e.to_string());
    let closed = |e: AcquireError| internal(&e);
    let (parts, mut body) = request.into_parts();
    let calls = &server.calls;
    let length = body::length(&parts.headers, &mut body, server.limit).await?;
    let place = calls.places.clone().try_acquire_owned().map_err(|_| {
        let why = format!("{WAITING} calls wait already: try again when some are done");
        Failure::new(StatusCode::SERVICE_UNAVAILABLE, why)
    })?;
    let memory = calls.memory.clone().acquire_many_owned(kib(length)).await.map_err(closed)?;
    let mut request = Vec::new();
    request.try_reserve_exact(length as usize).map_err(|e| internal(&e))?;
    while let Some(piece) = body::piece(&mut body).await? {
        request.extend_from_slice(&piece);
    }
    body::whole(length, request.len() as u64)?;
    let moves = piezoid_operations::moves(&request);
    let stop = moves.then(|| calls.stops.call(&parts.headers));
    let core = calls.cores.clone().acquire_owned().await.map_err(closed)?;
    let (mut child, mut input) =
        calls.start(moves).map_err(|e| internal(&format!("the work cannot be started: {e}")))?;
    // A process that ends early is noticed by its output.
    if input.write_all(&length.to_le_bytes()).await.is_ok() {
        drop(input.write_all(&request).await);
    }
    drop((request, memory));
    let (pieces, arguments) = mpsc::channel(4);
    tokio::spawn(async move {
        let mut input = Some(input);
        relay(&mut child, &pieces, stop.as_ref(), &mut input).await;
        // If it still runs, nobody waits for it.
        drop(input);
        if !moves || timeout(STOPPING, child.wait()).await.is_err() {
            drop(child.kill().await);
        }
        drop((core, place, stop));
    });
    let arguments = unfold(arguments, async |mut arguments| Some((arguments.recv().await?, arguments)));
    Ok(([(header::CONTENT_TYPE, "application/octet-stream")], Body::from_stream(arguments)).into_response())
}

/// Hands on what the process prints, until its end or until nobody takes it. If it is to stop, its input ends.
async fn relay(
    child: &mut Child,
    pieces: &mpsc::Sender<std::io::Result<Bytes>>,
    stop: Option<&Stop>,
    input: &mut Option<ChildStdin>,
) {
    let Some(mut output) = child.stdout.take() else { return };
    let mut head = Head::default();
    loop {
        let mut piece = Vec::with_capacity(PIECE);
        let read = tokio::select! {
            () = pieces.closed() => return,
            () = requested(stop), if input.is_some() => {
                *input = None;
                continue;
            }
            read = output.read_buf(&mut piece) => read,
        };
        if !read.is_ok_and(|count| count > 0) {
            break;
        }
        head.pass(&piece);
        if !matches!(timeout(PATIENCE, pieces.send(Ok(piece.into()))).await, Ok(Ok(()))) {
            return;
        }
    }
    let ended = tokio::select! {
        () = pieces.closed() => return,
        ended = child.wait() => ended,
    };
    let why = match ended {
        Ok(status) if status.success() => return,
        Ok(status) => std::io::Error::other(status.to_string()),
        Err(e) => e,
    };
    let last = match head {
        Head::Begin => {
            let message = format!(
                "the work ended without an answer ({why}): there was not enough memory, or this is a bug in \
                 piezoid. The terminal of `piezoid serve` shows more. No file was changed"
            );
            Ok([b"\n", &*piezoid_operations::refused(&message)].concat().into())
        }
        // Part of an answer is none: the connection breaks.
        _ => Err(why),
    };
    drop(timeout(PATIENCE, pieces.send(last)).await);
}

/// Waits until a call is to stop; for ever if it cannot.
async fn requested(stop: Option<&Stop>) {
    match stop {
        Some(stop) => stop.requested().await,
        None => std::future::pending().await,
    }
}

/// What was handed on: whole lines of progress, part of a line, or the empty line and part of the answer too.
#[derive(Debug, Default, PartialEq)]
enum Head {
    #[default]
    Begin,
    Line,
    Passed,
}

impl Head {
    fn pass(&mut self, piece: &[u8]) {
        for byte in piece {
            *self = match (&self, byte) {
                (Head::Passed, _) => return,
                (Head::Begin, b'\n') => Head::Passed,
                (Head::Line, b'\n') => Head::Begin,
                _ => Head::Line,
            };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_answer_begins_after_an_empty_line() {
        let after = |pieces: &[&str]| {
            let mut head = Head::default();
            pieces.iter().for_each(|piece| head.pass(piece.as_bytes()));
            head
        };
        assert_eq!(after(&[]), Head::Begin);
        assert_eq!(after(&["{}\n{", "}\n"]), Head::Begin);
        assert_eq!(after(&["{}\n{"]), Head::Line);
        assert_eq!(after(&["\n"]), Head::Passed);
        assert_eq!(after(&["{}\n", "\nanswer\n"]), Head::Passed);
    }
}
