//! The line of the controller: clients over TCP, each in a thread of its own.
//!
//! A command is answered under a lock, and the answer is written without it: a client that is idle or never reads
//! holds no other. Clients beyond those that the model serves are refused with a line. With a real clock, a thread
//! brings the state up to date while something moves.

use super::Behaviour;
#[cfg(test)]
use super::Log;
use super::log::LogFile;
use std::io::{BufRead, BufReader, ErrorKind, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::thread::{Builder, sleep};
use std::time::{Duration, Instant};

/// A line has at most so many bytes, and so many with blocks.
const LONGEST: usize = 1 << 16;
const LONGEST_WITH_BLOCKS: usize = 1 << 24;

/// Time between two updates while something moves, and between two looks whether it does.
const TICK: Duration = Duration::from_millis(5);
const IDLE: Duration = Duration::from_millis(50);

/// Looks after which a controller at rest is brought up to date too: a stand-in has all samples of that time to make up
/// for, and the next client would wait for them.
const LOOKS: u32 = 40;

/// Time in which a client must read some of its answer.
const PATIENCE: Duration = Duration::from_secs(5);

/// Time in which a place may become free, time in which a refused client may read why it is, and number of clients that
/// wait so.
const SOON: Duration = Duration::from_secs(1);
const WORD: Duration = Duration::from_millis(500);
const WAITING: usize = 64;

/// A simulated controller.
#[derive(Debug)]
pub struct Simulated {
    pub(crate) device: Arc<Mutex<dyn Behaviour>>,
    /// What it was given, for tests.
    #[cfg(test)]
    pub(crate) log: Log,
}

pub(crate) fn locked<'a>(device: &'a Mutex<dyn Behaviour>) -> MutexGuard<'a, dyn Behaviour + 'static> {
    device.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Simulated {
    pub(crate) fn new(#[cfg_attr(not(test), expect(unused_mut))] mut device: impl Behaviour) -> Self {
        Simulated {
            #[cfg(test)]
            log: device.time().log.clone(),
            device: Arc::new(Mutex::new(device)),
        }
    }

    /// Writes a line for each command that it is given from now on: the state of the first axis before it.
    ///
    /// # Errors
    /// Returns the error of writing the first line, which names the columns.
    pub fn logged(self, to: impl Write + Send + 'static) -> std::io::Result<Self> {
        let mut device = locked(&*self.device);
        let (voltage, ..) = device.state();
        device.time().file = Some(LogFile::new(Box::new(to), voltage)?);
        drop(device);
        Ok(self)
    }

    /// Answers clients, several at once if the model does so. It goes on until the listener fails.
    ///
    /// # Errors
    /// Returns the error of the listener.
    pub fn serve(&self, listener: &TcpListener) -> std::io::Result<()> {
        self.serve_port(0, listener)
    }

    /// Answers clients of the oscilloscope, on the model that has one.
    ///
    /// # Errors
    /// Returns the error of the listener.
    pub fn serve_oscilloscope(&self, listener: &TcpListener) -> std::io::Result<()> {
        self.serve_port(1, listener)
    }

    fn serve_port(&self, port: usize, listener: &TcpListener) -> std::io::Result<()> {
        let (served, waiting) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicUsize::new(0)));
        let (most, is_real) = {
            let mut device = locked(&*self.device);
            (device.clients(), device.time().clock.is_real())
        };
        if is_real && port == 0 {
            let device = Arc::downgrade(&self.device);
            Builder::new().spawn(move || tick(&device))?;
        }
        loop {
            let client = match listener.accept() {
                Ok((client, _)) => client,
                Err(e) if matches!(e.kind(), ErrorKind::ConnectionAborted | ErrorKind::Interrupted) => continue,
                Err(e) => return Err(e),
            };
            let place = Place::of(&served, most);
            let waits = if place.is_some() { None } else { Place::of(&waiting, WAITING) };
            if place.is_none() && waits.is_none() {
                continue;
            }
            let (device, served) = (self.device.clone(), served.clone());
            // A client for which there is no thread is dropped.
            drop(Builder::new().spawn(move || {
                let place = place.or_else(|| Place::soon(&served, most));
                let waits = waits.filter(|_| place.is_none());
                // One that goes in the middle of a line has ended.
                drop(if place.is_some() { converse(&*device, port, &client) } else { refuse(&client, most) });
                // Free before the client sees the end, because it may connect again at once.
                drop((place, waits));
            }));
        }
    }
}

/// One of a number of places, which is free again when it is dropped.
struct Place(Arc<AtomicUsize>);

impl Place {
    fn of(taken: &Arc<AtomicUsize>, most: usize) -> Option<Self> {
        let place = Place(taken.clone());
        (taken.fetch_add(1, Ordering::SeqCst) < most).then_some(place)
    }

    /// The same after a moment: a client that has just gone may not be noticed yet.
    fn soon(taken: &Arc<AtomicUsize>, most: usize) -> Option<Self> {
        let begin = Instant::now();
        loop {
            let place = Place::of(taken, most);
            if place.is_some() || begin.elapsed() > SOON {
                return place;
            }
            sleep(TICK);
        }
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        self.0.fetch_sub(1, Ordering::SeqCst);
    }
}

/// Updates a controller, often while something moves, until it is dropped.
fn tick(device: &Weak<Mutex<dyn Behaviour>>) {
    let mut looks = 0;
    while let Some(device) = device.upgrade() {
        let mut now = locked(&*device);
        let is_calm = now.time().is_calm();
        looks = if is_calm { looks + 1 } else { LOOKS };
        if looks >= LOOKS {
            looks = 0;
            now.update();
        }
        drop(now);
        drop(device);
        sleep(if is_calm { IDLE } else { TICK });
    }
}

/// Writes why a client is refused, and lets it read that.
fn refuse(mut client: &TcpStream, most: usize) -> std::io::Result<()> {
    client.set_write_timeout(Some(WORD))?;
    client.set_read_timeout(Some(WORD))?;
    writeln!(client, "the controller serves {most} at a time: end the other program, then connect again")?;
    client.shutdown(Shutdown::Write)?;
    // What is unread at the end would destroy the word.
    client.read(&mut [0; LONGEST]).map(|_| ())
}

fn converse(device: &Mutex<dyn Behaviour>, port: usize, client: &TcpStream) -> std::io::Result<()> {
    client.set_nodelay(true)?;
    client.set_write_timeout(Some(PATIENCE))?;
    let (mut input, mut output) = (BufReader::new(client), client);
    let (at_return, has_blocks) = {
        let device = locked(device);
        (device.ends_at_return(), device.has_blocks())
    };
    let longest = if has_blocks { LONGEST_WITH_BLOCKS } else { LONGEST };
    // Bytes of a block that are still to come.
    let mut block = 0;
    let (mut line, mut is_too_long, mut before) = (Vec::new(), false, 0);
    loop {
        let ready = input.fill_buf()?;
        let Some(&byte) = ready.first() else { return Ok(()) };
        input.consume(1);
        if block > 0 {
            block -= 1;
            line.push(byte);
            continue;
        }
        let after = std::mem::replace(&mut before, byte);
        let is_end = if at_return { byte == b'\r' || byte == b'\n' && after != b'\r' } else { byte == b'\n' };
        if is_end {
            let text: String = line.drain(..).map(char::from).collect();
            // What came of a line that is too long is not obeyed.
            let is_too_long = std::mem::take(&mut is_too_long);
            let answer = if is_too_long {
                locked(device).too_long()
            } else {
                locked(device).answer_at(port, if has_blocks { text.trim_start() } else { text.trim() })
            };
            output.write_all(&answer)?;
            continue;
        }
        match byte {
            b'\n' | b'\r' => (),
            0..32 => {
                let answer = locked(device).answer_byte(byte);
                output.write_all(&answer)?;
            }
            _ if is_too_long || line.len() == longest => is_too_long = true,
            _ => {
                line.push(byte);
                if has_blocks {
                    block = length(&line).filter(|length| line.len() + length <= longest).unwrap_or(0);
                }
            }
        }
    }
}

/// The bytes of the block whose head a line ends with.
fn length(line: &[u8]) -> Option<usize> {
    // A head has at most eleven bytes.
    let tail = &line[line.len().saturating_sub(11)..];
    let begin = tail.iter().rposition(|byte| *byte == b'#')?;
    head(&tail[begin..]).filter(|(head, _)| begin + head == tail.len()).map(|(_, length)| length)
}

/// Bytes of the head of a block, `#`, the number of digits and the number of bytes, and bytes of the block. `None` for
/// what does not begin with a whole head.
pub(crate) fn head(bytes: &[u8]) -> Option<(usize, usize)> {
    let digits = char::from(*bytes.get(1)?).to_digit(10).filter(|digits| *digits > 0)? as usize;
    let number = bytes.get(2..2 + digits).filter(|_| bytes[0] == b'#')?;
    Some((2 + digits, std::str::from_utf8(number).ok()?.parse().ok()?))
}
