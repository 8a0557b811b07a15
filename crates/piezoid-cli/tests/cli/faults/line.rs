//! A line between a client and a controller that has one fault: at a moment, or at a command.

use super::plan::{After, Kind, Moment, Place, Plan, Stall};
use rustix::process::{Pid, Signal, kill_process};
use socket2::SockRef;
use std::collections::BTreeMap;
use std::io::{ErrorKind, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicU32, AtomicUsize, Ordering::SeqCst};
use std::sync::{Arc, Mutex};
use std::thread::{sleep, spawn};
use std::time::{Duration, Instant};

/// Time between two bytes of a line that drips.
const DRIP: Duration = Duration::from_secs(1);

/// Pause if nothing passes.
const IDLE: Duration = Duration::from_micros(400);

/// Time in which what was sent before the end of a line still arrives.
const DRAIN: Duration = Duration::from_millis(100);

pub(super) struct Line {
    pub(super) port: u16,
    pub(super) shared: Arc<Shared>,
}

pub(super) struct Shared {
    plan: Plan,
    /// Port of the controller.
    controller: u16,
    begin: Instant,
    /// Processes of the client and of the controller, for signals.
    pub(super) client: AtomicU32,
    server: u32,
    /// When the fault came.
    pub(super) fired: Mutex<Option<Instant>>,
    /// How often each command came.
    pub(super) counts: Mutex<BTreeMap<String, usize>>,
    /// Connections that pass bytes.
    pub(super) open: AtomicUsize,
    /// True once a line that stalled has delivered what waited on it.
    pub(super) is_delivered: AtomicBool,
    is_over: AtomicBool,
}

impl Line {
    pub(super) fn new(plan: Plan, controller: u16, server: u32) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        let shared = Arc::new(Shared {
            plan,
            controller,
            begin: Instant::now(),
            client: AtomicU32::new(0),
            server,
            fired: Mutex::default(),
            counts: Mutex::default(),
            open: AtomicUsize::new(0),
            is_delivered: AtomicBool::new(false),
            is_over: AtomicBool::new(false),
        });
        let line = shared.clone();
        spawn(move || {
            for client in listener.incoming().flatten() {
                if line.is_over.load(SeqCst) {
                    return;
                }
                let line = line.clone();
                spawn(move || line.accepted(client));
            }
        });
        Line { port, shared }
    }
}

impl Drop for Line {
    fn drop(&mut self) {
        self.shared.is_over.store(true, SeqCst);
        drop(TcpStream::connect(("127.0.0.1", self.port)));
    }
}

/// Why a connection passes nothing any more.
enum Over {
    Ends,
    Stalls,
}

/// A connection that passes bytes.
struct Pass {
    client: TcpStream,
    controller: TcpStream,
    /// The beginning of a command.
    up: Vec<u8>,
    /// Bytes of an answer until the fault comes.
    until: Option<usize>,
    /// Garbage in place of the next answer, and whether an answer is replaced.
    garbage: Option<Vec<u8>>,
    is_replaced: bool,
    /// When the next byte of a line that drips may pass, and what waits for that.
    drips: Option<(Instant, Vec<u8>)>,
}

impl Shared {
    pub(super) fn fired(&self) -> Option<Instant> {
        *self.fired.lock().unwrap()
    }

    /// A signal for the client, if that runs.
    pub(super) fn signal(&self, signal: Signal) {
        signal_to(self.client.load(SeqCst), signal);
    }

    fn is_over(&self) -> bool {
        self.is_over.load(SeqCst)
    }

    fn accepted(&self, client: TcpStream) {
        let is_of_the_line = self.plan.kind.is_of_the_line();
        match (self.fired(), self.plan.after) {
            (Some(fired), After::Later(pause)) if fired.elapsed() < pause => return,
            (Some(_), After::Closed) if is_of_the_line => return,
            (Some(_), After::Silent) if is_of_the_line => {
                while !self.is_over() {
                    sleep(DRAIN);
                }
                return;
            }
            // Its port may be that of another controller by now.
            (Some(_), _) if self.plan.kind == Kind::KillController => return,
            _ => (),
        }
        let Ok(controller) = TcpStream::connect(("127.0.0.1", self.controller)) else { return };
        for stream in [&client, &controller] {
            stream.set_nodelay(true).unwrap();
            stream.set_nonblocking(true).unwrap();
        }
        let (up, until, garbage, is_replaced, drips) = (Vec::new(), None, None, false, None);
        let mut pass = Pass { client, controller, up, until, garbage, is_replaced, drips };
        self.open.fetch_add(1, SeqCst);
        let over = self.passed(&mut pass);
        self.open.fetch_sub(1, SeqCst);
        if let Over::Stalls = over {
            self.stall(&mut pass);
        }
    }

    /// Passes bytes both ways until the line ends or stalls.
    fn passed(&self, pass: &mut Pass) -> Over {
        while !self.is_over() {
            if let Err(over) = self.pass(pass) {
                return over;
            }
        }
        Over::Ends
    }

    fn pass(&self, pass: &mut Pass) -> Result<(), Over> {
        let mut piece = [0; 4096];
        let is_due = matches!(self.plan.moment, Moment::After(time) if self.begin.elapsed() >= time);
        if is_due && self.fired().is_none() {
            self.fire(pass)?;
        }
        let Ok(sent) = arrived(&pass.client, &mut piece) else {
            pass.close();
            return Err(Over::Ends);
        };
        for k in 0..sent {
            self.command(pass, piece[k]).inspect_err(|_| pass.up.extend_from_slice(&piece[k + 1..sent]))?;
        }
        let Ok(answered) = arrived(&pass.controller, &mut piece) else { return Err(Over::Ends) };
        for byte in &piece[..answered] {
            pass.answer(*byte);
            self.fire_if_due(pass)?;
        }
        pass.drip();
        if sent + answered == 0 {
            sleep(IDLE);
        }
        Ok(())
    }

    /// A byte from the client.
    fn command(&self, pass: &mut Pass, byte: u8) -> Result<(), Over> {
        pass.up.push(byte);
        if byte >= 32 || byte == b'\r' {
            return Ok(());
        }
        let name = name(&pass.up);
        let count = {
            let mut counts = self.counts.lock().unwrap();
            let count = counts.entry(name.clone()).or_default();
            *count += 1;
            *count
        };
        let place = match &self.plan.moment {
            Moment::Command(of, nth, place) if *of == name && *nth == count && self.fired().is_none() => Some(*place),
            _ => None,
        };
        match place {
            Some(Place::Before) => self.fire(pass)?,
            Some(Place::Torn) => {
                let begin: Vec<u8> = pass.up.drain(..pass.up.len() / 2).collect();
                put(&pass.controller, &begin);
                self.fire(pass)?;
            }
            Some(Place::Answer(bytes)) => pass.until = Some(bytes),
            None => (),
        }
        put(&pass.controller, &std::mem::take(&mut pass.up));
        self.fire_if_due(pass)
    }

    /// The fault comes if enough of an answer has passed.
    fn fire_if_due(&self, pass: &mut Pass) -> Result<(), Over> {
        if pass.until == Some(0) { self.fire(pass) } else { Ok(()) }
    }

    fn fire(&self, pass: &mut Pass) -> Result<(), Over> {
        *self.fired.lock().unwrap() = Some(Instant::now());
        pass.until = None;
        match self.plan.kind {
            Kind::Cut => {
                drop(pass.client.shutdown(Shutdown::Both));
                drop(pass.controller.shutdown(Shutdown::Both));
                return Err(Over::Ends);
            }
            Kind::Reset => {
                reset(&pass.client);
                reset(&pass.controller);
                return Err(Over::Ends);
            }
            Kind::Stall(_) => return Err(Over::Stalls),
            Kind::Drip => pass.drips = Some((Instant::now() + DRIP, Vec::new())),
            Kind::Garbage { replaces: true } => pass.garbage = Some(self.plan.garbage.clone()),
            Kind::Garbage { replaces: false } => put(&pass.client, &self.plan.garbage),
            Kind::Signal(signal) => self.signal(signal),
            Kind::Twice(_, stalls) => {
                self.signal(Signal::INT);
                if stalls {
                    return Err(Over::Stalls);
                }
            }
            Kind::KillController => signal_to(self.server, Signal::KILL),
        }
        Ok(())
    }

    /// Nothing passes any more.
    fn stall(&self, pass: &mut Pass) {
        let (begin, mut end, mut piece) = (Instant::now(), None, [0; 4096]);
        while !self.is_over() {
            if end.is_none() {
                match arrived(&pass.client, &mut piece) {
                    Ok(count) => pass.up.extend_from_slice(&piece[..count]),
                    Err(is_reset) => end = Some(is_reset),
                }
            }
            match self.plan.kind {
                Kind::Stall(Stall::Closes) if end.is_some() => return,
                Kind::Stall(Stall::Late(pause)) if begin.elapsed() >= pause => {
                    match end {
                        Some(true) => reset(&pass.controller),
                        _ => pass.close(),
                    }
                    return self.is_delivered.store(true, SeqCst);
                }
                _ => sleep(Duration::from_millis(5)),
            }
        }
    }
}

fn signal_to(process: u32, signal: Signal) {
    if let Some(process) = Pid::from_raw(process.cast_signed()) {
        let _ = kill_process(process, signal);
    }
}

/// The end of a connection is a reset.
fn reset(stream: &TcpStream) {
    SockRef::from(stream).set_linger(Some(Duration::ZERO)).unwrap();
}

/// How many bytes have arrived. An error is the end of the connection: true if it was reset.
fn arrived(mut stream: &TcpStream, piece: &mut [u8]) -> Result<usize, bool> {
    match stream.read(piece) {
        Ok(0) => Err(false),
        Ok(count) => Ok(count),
        Err(e) if e.kind() == ErrorKind::WouldBlock => Ok(0),
        Err(_) => Err(true),
    }
}

/// Writes all, whatever becomes of it.
fn put(mut stream: &TcpStream, mut bytes: &[u8]) {
    let begin = Instant::now();
    while !bytes.is_empty() && begin.elapsed() < Duration::from_secs(5) {
        match stream.write(bytes) {
            Ok(count) => bytes = &bytes[count..],
            Err(e) if e.kind() == ErrorKind::WouldBlock => sleep(IDLE),
            Err(_) => return,
        }
    }
}

/// The name of a command: with GCS the first word or the byte, of an NV200 with the number of its arguments.
fn name(line: &[u8]) -> String {
    let text: String = line.iter().map(|byte| char::from(*byte)).collect();
    match line {
        [byte] if *byte < 32 && *byte != b'\n' => format!("#{byte}"),
        [.., b'\r', b'\n'] => {
            let mut words = text.trim().split(',');
            format!("{}/{}", words.next().unwrap_or_default(), words.count())
        }
        _ => text.split_whitespace().next().unwrap_or_default().to_string(),
    }
}

impl Pass {
    /// A byte from the controller.
    fn answer(&mut self, byte: u8) {
        if let Some(garbage) = self.garbage.take() {
            put(&self.client, &garbage);
            self.is_replaced = true;
        }
        if self.is_replaced {
            self.is_replaced = byte != b'\n';
            return;
        }
        match &mut self.drips {
            Some((_, waiting)) => waiting.push(byte),
            None => put(&self.client, &[byte]),
        }
        self.until = self.until.map(|left| left.saturating_sub(1));
    }

    fn drip(&mut self) {
        if let Some((due, waiting)) = &mut self.drips
            && Instant::now() >= *due
            && !waiting.is_empty()
        {
            *due = Instant::now() + DRIP;
            put(&self.client, &[waiting.remove(0)]);
        }
    }

    /// What was sent arrives, then the client has gone.
    fn close(&self) {
        put(&self.controller, &self.up);
        drop(self.controller.shutdown(Shutdown::Write));
        let (begin, mut piece) = (Instant::now(), [0; 4096]);
        while begin.elapsed() < DRAIN && arrived(&self.controller, &mut piece).is_ok() {
            sleep(IDLE);
        }
    }
}
