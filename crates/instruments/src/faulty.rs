//! A simulated controller behind a line that is cut, goes silent or drips, for tests. The controller keeps what it was
//! given, as a witness.

use crate::measuring::run;
use crate::simulated::Log;
use crate::{AcquireOptions, Model, Simulation};
use piezoid::plant::Plant;
use piezoid::progress::Stage;
use piezoid::{Error, Record, System};
use piezoid_verbs::DataFile;
use std::io::{Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::ops::ControlFlow::{Break, Continue};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::thread::{sleep, spawn};
use std::time::{Duration, Instant};

#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Fault {
    None,
    Cut,
    Silent,
    Drip,
}

/// A simulated controller, and a line to it whose first connection has a fault.
pub(crate) struct Bench {
    /// Port of the line.
    pub(crate) port: u16,
    /// Port of the controller itself.
    pub(crate) direct: u16,
    /// Port of the oscilloscope beside it, if there is one.
    pub(crate) oscilloscope: u16,
    pub(crate) log: Log,
    /// Answers that have passed on the first connection.
    pub(crate) answers: Arc<AtomicUsize>,
    pub(crate) is_faulty: Arc<AtomicBool>,
}

impl Bench {
    /// A line whose fault comes in place of this answer, from 0.
    pub(crate) fn new(simulation: &Simulation, fault: Fault, at: usize) -> Self {
        let controller = Arc::new(simulation.controller().unwrap());
        let second = TcpListener::bind("127.0.0.1:0").unwrap();
        let oscilloscope = if simulation.model == Model::Scpi { second.local_addr().unwrap().port() } else { 0 };
        if oscilloscope > 0 {
            let controller = controller.clone();
            spawn(move || controller.serve_oscilloscope(&second));
        }
        let log = controller.log.clone();
        let (direct, line) = (TcpListener::bind("127.0.0.1:0").unwrap(), TcpListener::bind("127.0.0.1:0").unwrap());
        let [inside, port] = [&direct, &line].map(|listener| listener.local_addr().unwrap().port());
        spawn(move || controller.serve(&direct));
        let bench =
            Bench { port, direct: inside, oscilloscope, log, answers: Arc::default(), is_faulty: Arc::default() };
        pass(line, inside, fault, at, (bench.answers.clone(), bench.is_faulty.clone()));
        bench
    }

    /// The port of a line before another port, whose fault comes in place of this answer, from 0.
    pub(crate) fn before(inside: u16, fault: Fault, at: usize) -> u16 {
        let line = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = line.local_addr().unwrap().port();
        pass(line, inside, fault, at, Default::default());
        port
    }
}

/// Passes the clients of a line on to a port. The first of them has a fault.
fn pass(
    line: TcpListener,
    inside: u16,
    fault: Fault,
    at: usize,
    (answers, is_faulty): (Arc<AtomicUsize>, Arc<AtomicBool>),
) {
    spawn(move || {
        for (k, client) in line.incoming().flatten().enumerate() {
            let controller = TcpStream::connect(("127.0.0.1", inside)).unwrap();
            for stream in [&client, &controller] {
                stream.set_nodelay(true).unwrap();
            }
            let dead = Arc::new(AtomicBool::new(false));
            let (to, from) = (controller.try_clone().unwrap(), client.try_clone().unwrap());
            let dead_too = dead.clone();
            spawn(move || commands(from, to, &dead_too));
            let fault = if k == 0 { fault } else { Fault::None };
            let (answers, is_faulty) = (answers.clone(), is_faulty.clone());
            spawn(move || {
                if passed(&controller, &client, (fault != Fault::None || k == 0).then_some((at, &*answers)), fault) {
                    return;
                }
                is_faulty.store(true, Ordering::SeqCst);
                dead.store(true, Ordering::SeqCst);
                match fault {
                    Fault::Cut => {
                        drop(client.shutdown(Shutdown::Both));
                        drop(controller.shutdown(Shutdown::Both));
                    }
                    Fault::Drip => {
                        while (&client).write_all(b"2").is_ok() {
                            sleep(Duration::from_millis(50));
                        }
                    }
                    _ => (),
                }
            });
        }
    });
}

/// Passes commands on, until the line is dead.
pub(crate) fn commands(mut from: TcpStream, mut to: TcpStream, is_dead: &AtomicBool) {
    let mut piece = [0; 4096];
    while let Ok(count) = from.read(&mut piece) {
        if count == 0 || !is_dead.load(Ordering::SeqCst) && to.write_all(&piece[..count]).is_err() {
            break;
        }
    }
    drop(to.shutdown(Shutdown::Both));
}

/// Passes answers on, and counts them. False if the fault comes.
pub(crate) fn passed(
    mut from: &TcpStream,
    mut to: &TcpStream,
    count: Option<(usize, &AtomicUsize)>,
    fault: Fault,
) -> bool {
    let (mut byte, mut before) = ([0], b' ');
    while from.read(&mut byte).is_ok_and(|count| count == 1) {
        if fault != Fault::None && count.is_some_and(|(at, done)| done.load(Ordering::SeqCst) == at) {
            return false;
        }
        if to.write_all(&byte).is_err() {
            break;
        }
        if let Some((_, done)) = count.filter(|_| byte[0] == b'\n' && before != b' ') {
            done.fetch_add(1, Ordering::SeqCst);
        }
        before = byte[0];
    }
    drop(to.shutdown(Shutdown::Both));
    true
}

/// A client whose measurements are disturbed.
pub(crate) struct Disturbed<'t> {
    /// A bench with this fault in place of this answer.
    pub(crate) bench: &'t (dyn Fn(Fault, usize) -> Bench + Sync),
    /// Options for its line, with this time for an answer [s].
    pub(crate) options: &'t (dyn Fn(&Bench, f64) -> AcquireOptions + Sync),
    pub(crate) drive: DataFile,
    /// So long must nothing take, even on a machine that is busy.
    pub(crate) longest: Duration,
    /// Answers whose number depends on the clock.
    pub(crate) by_the_clock: usize,
    /// So many answers before the last one a fault may come without effect.
    pub(crate) unnoticed: usize,
    /// An error of a line that is lost has one of these.
    pub(crate) errors: &'t [&'t str],
    /// Checks what the client states, the second, against what the bench was given. True if a wave ran as it was
    /// stopped.
    pub(crate) witness: &'t (dyn Fn(&Bench, &str, &str) -> bool + Sync),
}

impl Disturbed<'_> {
    /// Answers of a measurement without a fault.
    pub(crate) fn answers(&self) -> usize {
        let bench = (self.bench)(Fault::None, 0);
        let (outcome, ..) = run(&(self.options)(&bench, 10.0), &self.drive, &mut Stage::ignore);
        assert_eq!(outcome.unwrap().unfinished, None);
        bench.answers.load(Ordering::SeqCst)
    }

    /// Tries a fault in place of each answer.
    pub(crate) fn at_every_answer(&self, fault: Fault, timeout: f64) {
        let (running, last) = (AtomicUsize::new(0), self.answers());
        each(last, |at: usize| {
            let bench = (self.bench)(fault, at);
            let begin = Instant::now();
            let (outcome, text, kept) = run(&(self.options)(&bench, timeout), &self.drive, &mut Stage::ignore);
            let what = format!("{fault:?} at answer {at} of {last}");
            assert!(begin.elapsed() < self.longest, "{what}: {:?}", begin.elapsed());
            if !bench.is_faulty.load(Ordering::SeqCst) {
                assert!(outcome.unwrap().unfinished.is_none() && at + self.by_the_clock > last, "{what}: {text}");
                return;
            }
            match outcome {
                Ok(acquired) if acquired.unfinished.is_none() => {
                    return assert!(at + self.unnoticed > last, "{what}: {text}");
                }
                Ok(acquired) => assert_eq!(kept.unwrap().record, acquired.record, "{what}"),
                Err(error) => {
                    let is_lost = self.errors.iter().any(|one| error.to_string().contains(one));
                    assert!(is_lost && kept.is_none(), "{what}: {error}");
                }
            }
            running.fetch_add(usize::from((self.witness)(&bench, &text, &what)), Ordering::SeqCst);
        });
        // A line that is silent is noticed only after the drive.
        let is_tried = fault == Fault::Silent || running.load(Ordering::SeqCst) > 0;
        assert!(is_tried, "no fault came while the drive was played");
    }

    /// Cancels a measurement at thirty moments, which are so many milliseconds apart. True if a wave ran then.
    pub(crate) fn cancelled_at_any_moment(&self, apart: u64) -> bool {
        let mut was_running = false;
        for moment in (0..30).map(|k| Duration::from_millis(7 + apart * k)) {
            let bench = (self.bench)(Fault::None, 0);
            let begin = Instant::now();
            let mut after = |_: Stage| if begin.elapsed() > moment { Break(()) } else { Continue(()) };
            let (outcome, text, kept) = run(&(self.options)(&bench, 10.0), &self.drive, &mut after);
            match outcome {
                Err(Error::Cancelled { .. }) => assert!(kept.is_none(), "{text}"),
                Ok(acquired) if acquired.unfinished.is_none() => continue,
                Ok(acquired) => assert_eq!(kept.unwrap().record, acquired.record),
                Err(other) => panic!("{other}"),
            }
            was_running |= (self.witness)(&bench, &text, &format!("cancelled after {moment:?}"));
        }
        was_running
    }
}

/// Tries each of so many cases, several at once.
fn each(count: usize, one: impl Fn(usize) + Sync) {
    let next = AtomicUsize::new(0);
    std::thread::scope(|scope| {
        for _ in 0..32 {
            scope.spawn(|| {
                loop {
                    let k = next.fetch_add(1, Ordering::SeqCst);
                    if k >= count {
                        break;
                    }
                    one(k);
                }
            });
        }
    });
}

/// The record of a drive that the plant `paper` answers from rest, each voltage held for twenty servo cycles.
pub(crate) fn assert_response_of_the_plant(record: &Record, u: &[f64]) {
    let plant = Plant::named("paper", 5e-5).unwrap();
    let held: Vec<f64> = u.iter().flat_map(|u| [*u; 20]).collect();
    let y = plant.resume(&mut plant.initial(), &held);
    let stroke = 2.0 * y.iter().fold(0.0, |peak: f64, y| peak.max(y.abs()));
    let error = record.y().iter().zip(y.iter().step_by(20)).map(|(had, y)| (had - y).abs()).fold(0.0, f64::max);
    assert!(error < 0.02 * stroke, "{error} um of {stroke} um");
}
