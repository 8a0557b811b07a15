//! A line between a client and a controller that has one fault: at a moment, or at a command.

use super::plan::{After, Garbage, Kind, Moment, Place, Plan};
use socket2::SockRef;
use std::collections::BTreeMap;
use std::io::{ErrorKind, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
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
    pub(super) server: AtomicU32,
    pub(super) fired: Mutex<Option<Instant>>,
    /// How often each command came.
    pub(super) counts: Mutex<BTreeMap<String, usize>>,
    /// Bytes that a stalled line has delivered after all, once it has.
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
            server: AtomicU32::new(server),
            fired: Mutex::default(),
            counts: Mutex::default(),
            is_delivered: AtomicBool::new(false),
            is_over: AtomicBool::new(false),
        });
        let line = shared.clone();
        spawn(move || {
            for client in listener.incoming().flatten() {
                if line.is_over.load(Ordering::SeqCst) {
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
        self.shared.is_over.store(true, Ordering::SeqCst);
        drop(TcpStream::connect(("127.0.0.1", self.port)));
    }
}

/// What a connection does after a fault.
enum Now {
    Passes,
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
    /// True while the rest of an answer is swallowed.
    swallows: bool,
    /// Garbage in place of the next answer.
    garbage: Option<Vec<u8>>,
    /// When the next byte of a line that drips may pass, and what waits for that.
    drips: Option<(Instant, Vec<u8>)>,
}

impl Shared {
    fn fired(&self) -> Option<Instant> {
        *self.fired.lock().unwrap()
    }

    /// A process gets a signal.
    fn signal(&self, signal: rustix::process::Signal, process: &AtomicU32) {
        let process = process.load(Ordering::SeqCst);
        if let Some(process) = rustix::process::Pid::from_raw(process.cast_signed()) {
            let _ = rustix::process::kill_process(process, signal);
        }
    }

    /// Ctrl-C once more.
    pub(super) fn interrupt(&self) {
        self.signal(rustix::process::Signal::INT, &self.client);
    }

    /// True if the line may be had again by now.
    fn is_back(&self) -> bool {
        match (self.fired(), self.plan.after) {
            (None, _) | (_, After::Back) => true,
            (Some(fired), After::Later(pause)) => fired.elapsed() >= pause,
            (Some(_), After::Closed | After::Silent) => !self.plan.kind.is_of_the_line(),
        }
    }

    fn accepted(&self, client: TcpStream) {
        if !self.is_back() {
            if let After::Silent = self.plan.after {
                self.hold();
            }
            return;
        }
        let Ok(controller) = TcpStream::connect(("127.0.0.1", self.controller)) else { return };
        for stream in [&client, &controller] {
            stream.set_nodelay(true).unwrap();
            stream.set_nonblocking(true).unwrap();
        }
        let mut pass =
            Pass { client, controller, up: Vec::new(), until: None, swallows: false, garbage: None, drips: None };
        match self.passed(&mut pass) {
            Now::Stalls => self.stall(pass),
            _ => drop(pass),
        }
    }

    /// Waits for the end of the case.
    fn hold(&self) {
        while !self.is_over.load(Ordering::SeqCst) {
            sleep(DRAIN);
        }
    }

    /// Passes bytes both ways until the line ends or stalls.
    fn passed(&self, pass: &mut Pass) -> Now {
        let mut piece = [0; 4096];
        while !self.is_over.load(Ordering::SeqCst) {
            let is_due = matches!(self.plan.moment, Moment::After(time) if self.begin.elapsed() >= time);
            if is_due && self.fired().is_none() {
                match self.fire(pass) {
                    Now::Passes => (),
                    other => return other,
                }
            }
            let mut is_idle = true;
            match pass.client.read(&mut piece) {
                Ok(0) => return pass.close(),
                Ok(count) => {
                    is_idle = false;
                    for (k, byte) in piece[..count].iter().enumerate() {
                        match self.command(pass, *byte) {
                            Now::Passes => (),
                            other => {
                                pass.up.extend_from_slice(&piece[k + 1..count]);
                                return other;
                            }
                        }
                    }
                }
                Err(e) if e.kind() == ErrorKind::WouldBlock => (),
                Err(_) => return Now::Ends,
            }
            match pass.controller.read(&mut piece) {
                Ok(0) => return Now::Ends,
                Ok(count) => {
                    is_idle = false;
                    for byte in &piece[..count] {
                        pass.answer(*byte);
                        if pass.is_due() {
                            match self.fire(pass) {
                                Now::Passes => (),
                                other => return other,
                            }
                        }
                    }
                }
                Err(e) if e.kind() == ErrorKind::WouldBlock => (),
                Err(_) => return Now::Ends,
            }
            pass.drip();
            if is_idle {
                sleep(IDLE);
            }
        }
        Now::Ends
    }

    /// A byte from the client.
    fn command(&self, pass: &mut Pass, byte: u8) -> Now {
        pass.up.push(byte);
        let is_own = byte < 32 && byte != b'\r' && byte != b'\n';
        if byte != b'\n' && !is_own {
            return Now::Passes;
        }
        let line = std::mem::take(&mut pass.up);
        let name = name(&line);
        let count = {
            let mut counts = self.counts.lock().unwrap();
            let count = counts.entry(name.clone()).or_default();
            *count += 1;
            *count
        };
        let place = match &self.plan.moment {
            Moment::Command { name: of, nth, place } if *of == name && *nth == count && self.fired().is_none() => {
                *place
            }
            _ => {
                pass.to_controller(&line);
                return Now::Passes;
            }
        };
        match place {
            Place::Before => {
                let now = self.fire(pass);
                pass.go_on(&line, now)
            }
            Place::Torn => {
                let (begin, rest) = line.split_at(line.len() / 2);
                pass.to_controller(begin);
                let now = self.fire(pass);
                pass.go_on(rest, now)
            }
            Place::Between => {
                pass.to_controller(&line);
                self.fire(pass)
            }
            Place::Within(bytes) => {
                pass.to_controller(&line);
                pass.until = Some(bytes);
                Now::Passes
            }
        }
    }

    /// The fault comes.
    fn fire(&self, pass: &mut Pass) -> Now {
        use rustix::process::Signal;
        *self.fired.lock().unwrap() = Some(Instant::now());
        pass.until = None;
        let plan = &self.plan;
        match plan.kind {
            Kind::Cut => {
                drop(pass.client.shutdown(Shutdown::Both));
                drop(pass.controller.shutdown(Shutdown::Both));
                return Now::Ends;
            }
            Kind::Reset => {
                reset(&pass.client);
                reset(&pass.controller);
                return Now::Ends;
            }
            Kind::Stall(_) => return Now::Stalls,
            Kind::Drip => pass.drips = Some((Instant::now() + DRIP, Vec::new())),
            Kind::Garbage(Garbage::InPlace) => pass.garbage = Some(plan.garbage.clone()),
            Kind::Garbage(Garbage::Between) => pass.to_client(&plan.garbage),
            Kind::KillClient => self.signal(Signal::KILL, &self.client),
            Kind::KillController => self.signal(Signal::KILL, &self.server),
            Kind::Interrupt => self.signal(Signal::INT, &self.client),
            Kind::Twice(_, stalls) => {
                self.signal(Signal::INT, &self.client);
                if stalls {
                    return Now::Stalls;
                }
            }
            Kind::Terminate => self.signal(Signal::TERM, &self.client),
            Kind::Hangup => self.signal(Signal::HUP, &self.client),
        }
        Now::Passes
    }

    /// Nothing passes any more.
    fn stall(&self, mut pass: Pass) {
        use super::plan::Stall;
        let (begin, mut held, mut end) = (Instant::now(), std::mem::take(&mut pass.up), None);
        let mut piece = [0; 4096];
        while !self.is_over.load(Ordering::SeqCst) {
            if end.is_none() {
                match pass.client.read(&mut piece) {
                    Ok(0) => end = Some(false),
                    Ok(count) => held.extend_from_slice(&piece[..count]),
                    Err(e) if e.kind() == ErrorKind::WouldBlock => (),
                    Err(_) => end = Some(true),
                }
            }
            match self.plan.kind {
                // The controller notices that the client has gone.
                Kind::Stall(Stall::Closes) if end.is_some() => return,
                // What waits in the client arrives when the line is there again, unless the client has withdrawn it.
                Kind::Stall(Stall::Late(pause)) if begin.elapsed() >= pause => {
                    match end {
                        Some(true) => reset(&pass.controller),
                        _ => {
                            pass.to_controller(&held);
                            pass.close();
                        }
                    }
                    drop(pass);
                    self.is_delivered.store(true, Ordering::SeqCst);
                    return;
                }
                _ => (),
            }
            sleep(Duration::from_millis(5));
        }
    }
}

/// The end of a connection is a reset.
fn reset(stream: &TcpStream) {
    SockRef::from(stream).set_linger(Some(Duration::ZERO)).unwrap();
}

/// The name of a command: with GCS the first word or the byte, of an NV200 with the number of its arguments.
pub(super) fn name(line: &[u8]) -> String {
    let text: String = line.iter().map(|byte| char::from(*byte)).collect();
    match line {
        [byte] if *byte < 32 && *byte != b'\n' => format!("#{byte}"),
        _ if text.ends_with("\r\n") => {
            let mut words = text.trim().split(',');
            format!("{}/{}", words.next().unwrap_or_default(), words.count())
        }
        _ => text.split_whitespace().next().unwrap_or_default().to_string(),
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

impl Pass {
    fn to_controller(&self, bytes: &[u8]) {
        put(&self.controller, bytes);
    }

    fn to_client(&self, bytes: &[u8]) {
        put(&self.client, bytes);
    }

    /// A command after a fault, which passes or waits.
    fn go_on(&mut self, command: &[u8], now: Now) -> Now {
        match now {
            Now::Passes => self.to_controller(command),
            _ => self.up.extend_from_slice(command),
        }
        now
    }

    /// True if enough of an answer has passed.
    fn is_due(&self) -> bool {
        self.until == Some(0)
    }

    /// A byte from the controller.
    fn answer(&mut self, byte: u8) {
        if let Some(garbage) = self.garbage.take() {
            self.to_client(&garbage);
            self.swallows = true;
        }
        if self.swallows {
            self.swallows = byte != b'\n';
            return;
        }
        match &mut self.drips {
            Some((_, waiting)) => waiting.push(byte),
            None => self.to_client(&[byte]),
        }
        self.until = self.until.map(|left| left.saturating_sub(1));
    }

    fn drip(&mut self) {
        if let Some((due, waiting)) = &mut self.drips
            && Instant::now() >= *due
            && !waiting.is_empty()
        {
            let byte = waiting.remove(0);
            *due = Instant::now() + DRIP;
            self.to_client(&[byte]);
        }
    }

    /// What was sent arrives, then the client has gone.
    fn close(&mut self) -> Now {
        self.to_controller(&self.up);
        drop(self.controller.shutdown(Shutdown::Write));
        let (begin, mut piece) = (Instant::now(), [0; 4096]);
        while begin.elapsed() < DRAIN && !matches!(self.controller.read(&mut piece), Ok(0)) {
            sleep(IDLE);
        }
        Now::Ends
    }
}
