//! An NV200 as an [`Instrument`]: its axis, its generator, and both channels of its recorder.

use super::look::{AXIS, check, connect, target};
use super::run::Run;
use crate::checks::{at_place, cycles, range};
use crate::instrument::measured_by_controller;
use crate::moves::Moves;
use crate::{Drive, Instrument, InstrumentOptions, Left, Rest, Setup};
use piezoid::progress::Progress;
use piezoid::{Error, Record, Units};

/// Servo cycle [s].
pub(crate) const CYCLE: f64 = 5e-5;

/// Values that the generator and a channel of the recorder hold, and most servo cycles a value.
pub(crate) const WAVE: usize = 1024;
pub(crate) const RECORDER: usize = 6144;
const MOST_CYCLES: u64 = 65535;

/// Error of a voltage that says nothing [V], and as a share of the range.
const NOISE: f64 = 0.05;
const ERROR: f64 = 2e-3;

/// A connection.
pub(crate) struct Nv200<'a> {
    run: Run<'a>,
    setup: Setup,
    /// The voltage before anything moved [V].
    start: Option<f64>,
    /// The last voltage that was requested [V], and least time of a slow move [s].
    last: f64,
    ramp: f64,
}

impl<'a> Nv200<'a> {
    /// Connects, and checks that nothing else uses the controller. Nothing moves.
    pub(crate) fn open(options: &InstrumentOptions, progress: &'a mut Progress<'_>) -> Result<Self, Error> {
        let limits = options.limits.limits()?.unwrap_or_default();
        fixed(options)?;
        let (mut line, controller) = connect(&options.connection, progress)?;
        check(&mut line, &controller)?;
        let identity = controller.identity;
        let axis = controller.axes.into_iter().next();
        let (unit, output) = axis.and_then(|axis| Some((axis.unit, axis.range?))).unwrap_or_default();
        let range = range(&limits, Some(output))?;
        let setup = Setup {
            identity,
            axis: AXIS.into(),
            unit: "V".into(),
            range,
            limits,
            cycle: CYCLE,
            holds: vec![("the generator", WAVE), ("the recorder", RECORDER)],
            joins: false,
            servo: Some(false),
        };
        let run = Run { line, output, range, fastest: limits.fastest(), unit };
        Ok(Nv200 { run, setup, start: None, last: 0.0, ramp: options.ramp })
    }

    /// Error of a voltage that is allowed [V].
    fn allowed(&self) -> f64 {
        NOISE + ERROR * (self.run.output.1 - self.run.output.0)
    }
}

/// Returns an error for options whose value an NV200 does not have.
fn fixed(options: &InstrumentOptions) -> Result<(), Error> {
    let wrong = |name, value: String, rule: &str| Err(Error::parameter(name, value, format!("{rule} on an NV200")));
    match options {
        InstrumentOptions { axis: Some(axis), .. } if axis != AXIS => wrong("axis", axis.clone(), "can only be 1"),
        InstrumentOptions { channel: Some(k), .. } if *k != 1 => wrong("channel", k.to_string(), "can only be 1"),
        InstrumentOptions { gain: Some(gain), .. } if *gain != 1.0 => {
            wrong("gain", gain.to_string(), "can only be 1 V")
        }
        InstrumentOptions { cycle: Some(cycle), .. } if (cycle / CYCLE - 1.0).abs() > 1e-9 => {
            wrong("cycle", cycle.to_string(), "can only be 5e-5 s")
        }
        _ => Ok(()),
    }
}

impl Instrument for Nv200<'_> {
    fn setup(&self) -> &Setup {
        &self.setup
    }

    fn prepare(&mut self, drive: &Drive) -> Result<(), Error> {
        self.run.line.wire.watch.enter(drive.what);
        self.setup.check(drive)?;
        if drive.joined {
            let message = "an NV200 holds each voltage for a sampling period, and cannot join them by lines: sample \
                           this drive as often as others, without --join";
            return Err(Error::Content(message.into()));
        }
        if cycles(drive.ts, CYCLE)? > MOST_CYCLES {
            let most = MOST_CYCLES as f64 * CYCLE;
            return Err(Error::Content(format!("the drive is sampled every {} s, more than {most:.5} s", drive.ts)));
        }
        self.run.take_over()?;
        at_place(AXIS, self.run.line.number("set")?, self.run.range, NOISE)?;
        self.run.upload(drive)
    }

    fn play(&mut self, drive: &Drive) -> Result<Record, Error> {
        let allowed = self.allowed();
        let run = &mut self.run;
        if self.start.is_none() {
            let start = run.line.number("set")?;
            run.expect(start, allowed, "before the first move")?;
            (self.start, self.last) = (Some(start), start);
        }
        let first = drive.u[0];
        run.ramp(self.last, first, drive.ramp)?;
        run.settle(first, drive.settle)?;
        run.expect(first, allowed, "after the move to the first voltage of the drive")?;
        run.follow_generator()?;
        run.expect(first, allowed, "as the generator gives the setpoint")?;
        run.configure(drive, cycles(drive.ts, CYCLE)? as usize)?;
        run.play(drive)?;
        let last = drive.u.last().copied().unwrap_or_default();
        run.hand_over(last)?;
        (self.last, self.ramp) = (last, drive.ramp);
        let (u, y) = (run.read(0, drive.u.len())?, run.read(1, drive.u.len())?);
        let units = Units { u: "V".into(), y: self.run.unit.clone() };
        let record = Record::new(drive.ts, u, y)?.with_units(units);
        Ok(measured_by_controller(&self.setup.identity, record))
    }

    fn rest(&mut self, rest: Rest) -> Result<Left, Error> {
        self.run.line.wire.watch.enter("");
        let allowed = self.allowed();
        if let Some(target) = self.start.and_then(|start| target(rest, start)) {
            self.run.ramp(self.last, target, self.ramp)?;
            self.last = target;
            self.run.expect(target, allowed, "after the move to rest")?;
        }
        self.run.left()
    }

    fn stop(&mut self) -> (Left, String) {
        self.run.stop()
    }
}
