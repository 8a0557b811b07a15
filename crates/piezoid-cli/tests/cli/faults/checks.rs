//! What must be true after each fault: the time, the exit status, the files, every step of the voltage, and what is
//! stated.

use super::line::Line;
use super::plan::{After, Kind, Stall};
use super::table::Row;
use super::witness::Entry;
use super::{Case, End, LIMITS, Protocol, SAMPLES, STEP, value};
use crate::bench::Run;
use serde_json::Value;
use std::os::unix::process::ExitStatusExt;
use std::sync::atomic::Ordering::SeqCst;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Time in which a client ends after a fault: the answer that it awaits, an attempt to stop on the same line of 1 s,
/// attempts to connect again for 3 s, the last of which may take 1 s more.
const DEADLINE: Duration = Duration::from_secs(1 + 1 + 3 + 1);

/// Time in which it ends after a signal, where the line is sound: it stops at once.
const AT_ONCE: Duration = Duration::from_secs(1);

/// A second signal within this time counts as the first; that it is sent takes time, too.
const BOUNCE: Duration = Duration::from_millis(280);

/// What a machine that is busy may add.
const BUSY: Duration = Duration::from_secs(5);

/// Largest change of the drive from sample to sample [V], and of those of a campaign, whose small signal has steps.
const WAVE_STEP: f64 = 1.0;
const CAMPAIGN_STEP: f64 = 6.0;

/// Largest change of the voltage in a servo cycle at the usual speed of a simulated controller of PI [V].
const SLEW_STEP: f64 = 0.16;

/// Error of a voltage that is stated [V]: its digits, and creep of a closed loop.
const STATED: f64 = 6e-4;
const CREEP: f64 = 0.05;

/// By so much a servo changes the voltage in a second, to hold the position while the creep of the drive decays [V].
const SERVO: f64 = 0.3;

impl Case {
    /// Checks all of it, and counts what came of it.
    pub(super) fn check(&self, end: &End, line: &Line) -> Row {
        self.check_time(end);
        self.check_status(end);
        let is_new = self.check_files(end);
        self.check_moves(&end.log);
        let is_alive = self.plan.kind != Kind::KillController || end.took.is_none();
        let is_served = end.status.code().is_some() && !self.ends_abruptly(end);
        let is_whole = end.status.code() == Some(0);
        let is_stopped = if is_served && !is_whole { self.check_stop(end, is_alive) } else { None };
        if is_served && is_new {
            self.check_document(end);
        }
        let is_stated = is_served && is_alive && self.check_place(end, line);
        let title = if self.is_campaign() { "in a campaign, all of these" } else { self.plan.kind.title() };
        Row { title, took: end.took, is_whole, is_stopped, is_stated }
    }

    /// True if a second Ctrl-C may have ended it at once.
    pub(super) fn ends_abruptly(&self, end: &End) -> bool {
        matches!(self.plan.kind, Kind::Twice(pause, _) if pause >= BOUNCE) && end.run.err.is_empty()
    }

    fn check_time(&self, end: &End) {
        let Some(took) = end.took else { return };
        let most = match self.plan.kind {
            // On a line that stalls, only a second signal ends it at once.
            Kind::Twice(pause, true) if pause >= BOUNCE => pause + AT_ONCE,
            Kind::Twice(_, false) | Kind::Signal(_) => AT_ONCE,
            _ => DEADLINE,
        };
        // Where nothing came of the fault, the measurement went on.
        let is_whole = end.status.code() == Some(0);
        assert!(is_whole || took <= most + BUSY, "{}: it ended after {took:?}: {:?}", self.what, end.run);
    }

    fn check_status(&self, end: &End) {
        let (code, signal) = (end.status.code(), end.status.signal());
        let (kind, what) = (self.plan.kind, &self.what);
        let err = &end.run.err;
        let errors = err.lines().filter(|line| line.starts_with("error: ")).count();
        let is_right = match (code, signal) {
            (Some(0), _) => errors == 0 && (self.is_campaign() || end.run.out.contains("axis 1 is at")),
            (Some(1), _) => !kind.is_signal() && !kind.kills() && errors == 1,
            // Before it watches for signals, it ends at once.
            (Some(130), _) => kind.is_signal() && (errors == 1 || end.log.is_empty() || self.ends_abruptly(end)),
            (None, Some(9)) => kind.kills(),
            // Before the process handles signals, it ends as others do.
            (None, Some(_)) => kind.is_signal() && end.log.is_empty() && err.is_empty(),
            _ => false,
        };
        assert!(is_right && !err.contains("panicked"), "{what}: {code:?} {signal:?}: {:?}", end.run);
        if end.took.is_none() {
            assert_eq!(code, Some(0), "{what}: no fault came: {:?}", end.run);
        }
    }

    /// Checks the files. True if there is a new record.
    fn check_files(&self, end: &End) -> bool {
        let (what, files) = (&self.what, self.bench.files());
        let is_killed = end.status.signal() == Some(9);
        if self.is_campaign() {
            return self.check_folder(is_killed);
        }
        let known = |name: &str| ["u.csv", "log", "r.csv", "r.json"].contains(&name);
        for name in files.keys().filter(|name| !known(name)) {
            let is_left = name.starts_with(".piezoid-tmp-") || name == "piezoid-unfinished.txt";
            assert!(is_killed && is_left, "{what}: {name} is left: {:?}", end.run);
        }
        let is_old = |name: &str, k: usize| files.get(name).map(Vec::as_slice) == self.old.map(|old| old[k].as_bytes());
        let [record, document] = [is_old("r.csv", 0), is_old("r.json", 1)];
        let is_named = files.contains_key("piezoid-unfinished.txt");
        assert!(record == document || is_named, "{what}: one file is old, the other new: {:?}", end.run);
        if !record {
            let text = self.bench.text("r.csv");
            let rows = text.lines().skip_while(|line| !line.starts_with("t_s")).skip(1);
            let rows: Vec<Vec<f64>> = rows.map(|row| row.split(',').map(|x| x.parse().unwrap()).collect()).collect();
            assert_eq!((rows.len(), text.ends_with('\n')), (SAMPLES, true), "{what}: {text}");
            for (k, row) in rows.iter().enumerate() {
                let u = value(k);
                assert!(row.len() == 3 && (row[1] - u).abs() < 0.5, "{what}: {row:?} for {u} V");
            }
        }
        let code = end.status.code();
        assert!(code != Some(0) || !record, "{what}: nothing is written: {:?}", end.run);
        if code == Some(1) || code == Some(130) && !end.run.err.is_empty() {
            assert_eq!(!record, end.run.err.contains("the record is written"), "{what}: {:?}", end.run);
        }
        !record && !document
    }

    /// Checks the files of a campaign. False: it has no document of a record.
    fn check_folder(&self, is_killed: bool) -> bool {
        for (name, bytes) in self.bench.files().iter().filter(|(name, _)| name.starts_with("all/")) {
            let is_left = name.contains("/.piezoid-tmp-") || name.ends_with("/piezoid-unfinished.txt");
            assert!(!is_left || is_killed, "{}: {name} is left", self.what);
            let text = String::from_utf8_lossy(bytes);
            if is_left || !name.ends_with(".csv") {
                continue;
            }
            let mut rows = text.lines().skip_while(|line| !line.starts_with("t_s")).map(|row| row.split(',').count());
            let columns = rows.next().unwrap_or_default();
            assert!(columns > 1 && text.ends_with('\n'), "{}: {name} is torn", self.what);
            assert!(rows.all(|count| count == columns), "{}: {name} is torn", self.what);
        }
        false
    }

    /// Checks every change of the voltage.
    fn check_moves(&self, log: &[Entry]) {
        let ((low, high), what) = (LIMITS, &self.what);
        let slow = if self.protocol == Protocol::Gcs { SLEW_STEP } else { STEP + STATED };
        let (mut is_played, mut is_source) = (false, self.protocol == Protocol::Gcs);
        for entry in log {
            let Entry { time, voltage, lowest, highest, step, command, .. } = entry;
            assert!(*lowest >= low - 1e-6 && *highest <= high + 1e-6, "{what}: {lowest} to {highest} V at {time} s");
            let wave = if self.is_campaign() { CAMPAIGN_STEP } else { WAVE_STEP };
            let most = if is_played { slow.max(wave) } else { slow };
            assert!(*step <= most, "{what}: a step of {step} V before `{command}` at {time} s");
            if let Some(target) = entry.target() {
                let step = (target - voltage).abs();
                assert!(step <= STEP + STATED + CREEP, "{what}: `{command}` from {voltage} V at {time} s");
                assert!(!entry.runs || self.protocol == Protocol::Nv200, "{what}: `{command}` in a wave");
            }
            is_source |= command == "modsrc,3";
            if entry.starts() && is_source && !self.is_campaign() {
                assert!((voltage - value(0)).abs() < 0.1, "{what}: the wave begins at {voltage} V at {time} s");
            }
            is_played = entry.runs || entry.starts();
        }
    }

    /// True if a line could be had again after the fault.
    fn has_line(&self) -> bool {
        match self.plan.kind {
            Kind::KillController => false,
            // It serves one client, and does not notice that the other has gone.
            Kind::Stall(Stall::Silent | Stall::Late(_)) | Kind::Twice(_, true) if self.protocol == Protocol::Nv200 => {
                false
            }
            kind if kind.is_of_the_line() => !matches!(self.plan.after, After::Closed | After::Silent),
            _ => true,
        }
    }

    /// Checks what a client that failed states against the log: whether the generator is stopped, if anything moved.
    fn check_stop(&self, end: &End, is_alive: bool) -> Option<bool> {
        let (what, err, log) = (&self.what, &end.run.err, &end.log);
        let moved = log.iter().rposition(Entry::moves);
        // The first of these only fills the generator of an NV200, while `set` gives the setpoint.
        let is_moved = log.iter().any(|entry| entry.moves() && !entry.starts());
        if !is_moved {
            let place = log.last().map_or(self.before, |entry| entry.voltage);
            assert!((place - self.before).abs() < CREEP, "{what}: it is at {place} V: {:?}", end.run);
            return None;
        }
        let is_stopped = err.contains("is stopped");
        if is_stopped {
            let stopped = log.iter().rposition(Entry::stops);
            assert!(stopped.is_some() && stopped > moved, "{what}: moved {moved:?}, stopped {stopped:?}: {err}");
            let runs = log[stopped.unwrap_or(0) + 1..].iter().any(|entry| entry.runs);
            assert!(!runs, "{what}: the wave goes on: {err}");
        } else {
            assert!(err.contains("could not be stopped, and may run on"), "{what}: {:?}", end.run);
            assert!(!is_alive || !self.has_line(), "{what}: a line could be had: {:?}", end.run);
        }
        Some(is_stopped)
    }

    /// Checks the document beside a record.
    fn check_document(&self, end: &End) {
        let document: Value = self.bench.json("r.json");
        let unfinished = &document["unfinished"];
        assert_eq!(unfinished.is_null(), end.status.code() == Some(0), "{}: {document}: {:?}", self.what, end.run);
        if let Some(why) = unfinished.as_str() {
            assert!(end.run.err.contains(why), "{}: {why}: {:?}", self.what, end.run);
        }
    }

    /// Checks the place that is stated, if one is, as the client ends and once all has arrived that may.
    fn check_place(&self, end: &End, line: &Line) -> bool {
        let Run { out, err, .. } = &end.run;
        let Some((stated, is_closed)) = place(&format!("{out}{err}")) else {
            let is_whole = end.run.code == Some(0) && !self.is_campaign();
            let may_be_unknown = !is_whole && !err.contains("is stopped");
            assert!(may_be_unknown, "{}: no voltage is stated: {:?}", self.what, end.run);
            return false;
        };
        let last = end.log.last().unwrap();
        let allowed = if is_closed { CREEP } else { STATED };
        let what = format!("{}: {stated} V is stated", self.what);
        assert!((last.voltage - stated).abs() <= allowed, "{what}, not {}: {:?}", last.voltage, end.run);
        assert_eq!((last.servo, last.runs), (is_closed, false), "{what}: {:?}", end.run);
        if end.run.code == Some(0) {
            assert_eq!(is_closed, self.is_closed, "{what}");
            assert!((stated - self.before).abs() < 0.2, "{what}, it was at {} V", self.before);
        }
        if let Kind::Stall(Stall::Late(_)) = self.plan.kind {
            let begin = Instant::now();
            while !line.shared.is_delivered.load(SeqCst) && begin.elapsed() < DEADLINE {
                sleep(Duration::from_millis(10));
            }
        }
        sleep(Duration::from_millis(100));
        if self.has_line() {
            self.controller.text(self.protocol.words()[2]);
            let later = self.log().pop().unwrap();
            let what = format!("{what}, later it is at {} V", later.voltage);
            let allowed = if is_closed { SERVO } else { STATED };
            assert!((later.voltage - stated).abs() <= allowed, "{what}: {:?}", end.run);
            assert_eq!((later.servo, later.runs), (is_closed, false), "{what}: {:?}", end.run);
        }
        true
    }

    /// Checks that the next measurement works, or says why it does not.
    pub(super) fn check_next(&self) {
        let line = self.line(self.controller.port());
        let begin = Instant::now();
        loop {
            let run = self.bench.run(&line);
            if run.code == Some(0) {
                return;
            }
            let is_named = run.code == Some(1) && run.err.contains("the controller is in use");
            assert!(is_named, "{}: the next measurement: {run:?}", self.what);
            assert!(begin.elapsed() < Duration::from_secs(5), "{}: the next is never served: {run:?}", self.what);
            sleep(Duration::from_millis(300));
        }
    }
}

/// The voltage that a text states, and whether the loop is closed.
fn place(text: &str) -> Option<(f64, bool)> {
    let (_, rest) = text.rsplit_once("axis 1 is at ")?;
    let (voltage, rest) = rest.split_once(" V, in ")?;
    Some((voltage.parse().ok()?, rest.starts_with("closed")))
}
