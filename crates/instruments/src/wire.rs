//! Bytes to a controller and back, over TCP.
//!
//! Every answer has a deadline as a whole. While it is awaited, the progress is checked every [`TICK`].

use crate::watch::{TICK, Watch};
use piezoid::Error;
use socket2::SockRef;
use std::fmt::Display;
use std::io::{ErrorKind, Read, Write};
use std::net::{Shutdown, TcpStream, ToSocketAddrs};
use std::sync::mpsc;
use std::time::{Duration, Instant};

/// Why nothing is sent or received before the next attempt to connect.
const NOT_CONNECTED: &str = "it is not connected";

/// Bytes that are read at once.
const PIECE: usize = 1 << 14;

/// A connection.
pub(crate) struct Wire<'a> {
    pub(crate) watch: Watch<'a>,
    /// None once it was lost and not yet connected again.
    stream: Option<TcpStream>,
    /// Bytes that were received and belong to no answer yet.
    received: Vec<u8>,
    /// True if the last command was sent in part only.
    is_partial: bool,
    host: (String, u16),
    /// The same, for messages.
    pub(crate) address: String,
    /// Time for an answer.
    patience: Duration,
    /// No answer is awaited beyond this moment.
    until: Option<Instant>,
}

impl<'a> Wire<'a> {
    /// Connects to an address.
    pub(crate) fn open(host: (&str, u16), patience: Duration, mut watch: Watch<'a>) -> Result<Self, Error> {
        Ok(Wire {
            stream: Some(connected(host, patience, &mut watch)?),
            watch,
            received: Vec::new(),
            is_partial: false,
            host: (host.0.into(), host.1),
            address: format!("{}:{}", host.0, host.1),
            patience,
            until: None,
        })
    }

    /// Limits the time for all that follows.
    pub(crate) fn limit(&mut self, time: Duration) {
        self.until = Some(Instant::now() + time);
    }

    /// Connects again. What was sent before and has not arrived is withdrawn: a line that comes back would deliver it
    /// after the commands of the new connection.
    pub(crate) fn reconnect(&mut self) -> Result<(), Error> {
        if let Some(stream) = self.stream.take() {
            drop(SockRef::from(&stream).set_linger(Some(Duration::ZERO)));
        }
        let patience = self.deadline().saturating_duration_since(Instant::now());
        self.stream = Some(connected((&self.host.0, self.host.1), patience, &mut self.watch)?);
        (self.is_partial, self.received) = (false, Vec::new());
        Ok(())
    }

    /// True if the last command was sent in part only, which is so only once.
    pub(crate) fn take_partial(&mut self) -> bool {
        std::mem::take(&mut self.is_partial)
    }

    fn deadline(&self) -> Instant {
        let own = Instant::now() + self.patience;
        self.until.map_or(own, |until| until.min(own))
    }

    /// Returns an error if the work was cancelled, or if it is too late for an answer.
    fn check(&mut self, deadline: Instant) -> Result<(), Error> {
        self.watch.check()?;
        if Instant::now() < deadline {
            return Ok(());
        }
        let time = self.patience.as_secs_f64();
        Err(self.lost(&format!("there was no whole answer within {time} s")))
    }

    /// Sends bytes as they are.
    pub(crate) fn send(&mut self, bytes: &[u8]) -> Result<(), Error> {
        let (deadline, mut left) = (self.deadline(), bytes);
        while !left.is_empty() {
            let Some(stream) = &mut self.stream else { return Err(self.lost(&NOT_CONNECTED)) };
            match stream.write(left) {
                Ok(count) => left = &left[count..],
                Err(e) if waits(&e) => (),
                Err(e) => return Err(self.lost(&e)),
            }
            self.is_partial = !left.is_empty();
            self.check(deadline)?;
        }
        Ok(())
    }

    /// The bytes of an answer of at most so many bytes, to its end: a byte for which `ends` is true, by its place.
    pub(crate) fn until(&mut self, longest: usize, ends: impl Fn(&[u8], usize) -> bool) -> Result<Vec<u8>, Error> {
        let (deadline, mut checked) = (self.deadline(), 0);
        loop {
            if let Some(end) = (checked..self.received.len()).find(|k| ends(&self.received, *k)) {
                return Ok(self.received.drain(..=end).collect());
            }
            checked = self.received.len();
            if checked > longest {
                return Err(self.lost(&"its answer does not end"));
            }
            self.receive(deadline)?;
        }
    }

    fn receive(&mut self, deadline: Instant) -> Result<(), Error> {
        let mut piece = [0; PIECE];
        loop {
            self.check(deadline)?;
            let Some(stream) = &mut self.stream else { return Err(self.lost(&NOT_CONNECTED)) };
            match stream.read(&mut piece) {
                Ok(0) => return Err(self.lost(&"it closed the connection")),
                Ok(count) => {
                    self.received.extend_from_slice(&piece[..count]);
                    return Ok(());
                }
                Err(e) if waits(&e) => (),
                Err(e) => return Err(self.lost(&e)),
            }
        }
    }

    pub(crate) fn lost(&self, e: &dyn Display) -> Error {
        let address = &self.address;
        Error::Content(format!("the controller at {address} does not answer: {e}; check the connection and try again"))
    }
}

impl Drop for Wire<'_> {
    fn drop(&mut self) {
        drop(self.stream.as_ref().map(|stream| stream.shutdown(Shutdown::Both)));
    }
}

/// True if a stream has nothing to read, or no room for what is written, at present.
fn waits(e: &std::io::Error) -> bool {
    matches!(e.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut | ErrorKind::Interrupted)
}

/// A connection, made by a thread of its own, because names and addresses can block for a long time.
fn connected((host, port): (&str, u16), patience: Duration, watch: &mut Watch) -> Result<TcpStream, Error> {
    let refused = |e: &dyn Display| {
        let advice = "check that it is switched on, its address, and that no other program is connected to it";
        Error::Content(format!("no controller answers at {host}:{port}: {e}; {advice}"))
    };
    let (deadline, name) = (Instant::now() + patience, host.to_string());
    let (sender, receiver) = mpsc::channel();
    std::thread::spawn(move || sender.send(first_of((&name, port), deadline)));
    loop {
        watch.check()?;
        match receiver.recv_timeout(TICK) {
            Ok(stream) => return stream.map_err(|e| refused(&e)),
            Err(_) if Instant::now() < deadline => (),
            Err(_) => return Err(refused(&"the connection timed out")),
        }
    }
}

/// A connection to the first of these addresses that takes it.
fn first_of(host: (&str, u16), deadline: Instant) -> std::io::Result<TcpStream> {
    let mut last = std::io::Error::other("the name has no address");
    for one in host.to_socket_addrs()? {
        let left = deadline.saturating_duration_since(Instant::now()).max(TICK);
        match TcpStream::connect_timeout(&one, left) {
            Ok(stream) => {
                stream.set_nodelay(true)?;
                stream.set_read_timeout(Some(TICK))?;
                stream.set_write_timeout(Some(TICK))?;
                return Ok(stream);
            }
            Err(e) => last = e,
        }
    }
    Err(last)
}
