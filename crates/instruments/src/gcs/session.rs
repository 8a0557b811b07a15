//! A controller with GCS 2.0 as an [`Instrument`]: one axis, one wave generator, two tables of the recorder.

use super::closed::travel;
use super::controller::{Axis, Controller, MOVING, RUNNING};
use super::recording::{Sources, read};
use super::rest::Before;
use super::run::Run;
use crate::checks::{cycles, range};
use crate::moves::Moves;
use crate::{Drive, Instrument, InstrumentOptions, Left, Rest, Setup};
use piezoid::progress::Progress;
use piezoid::{Error, Record};

/// A connection, with its axis.
pub(crate) struct Gcs<'a> {
    run: Run<'a>,
    setup: Setup,
    /// The axis before anything moved, once the loop is open or the drive is positions.
    before: Option<Before>,
    /// The last voltage or position that was requested, and least time of a slow move [s].
    last: f64,
    ramp: f64,
}

impl<'a> Gcs<'a> {
    /// Connects, and checks that nothing else uses the controller. Nothing moves.
    pub(crate) fn open(
        options: &InstrumentOptions,
        is_closed: bool,
        progress: &'a mut Progress<'_>,
    ) -> Result<Self, Error> {
        let limits = options.limits.limits()?.unwrap_or_default();
        let (mut line, controller) = Controller::open(&options.connection, progress)?;
        if let Some(signs) = controller.in_use() {
            return Err(in_use(&signs));
        }
        let (axis, number) = axis(options, &controller)?;
        let cycle = options.cycle.or(controller.cycle).ok_or_else(|| {
            let message = "must be given, because the controller does not report it (parameter 0x0E000200)";
            Error::parameter("cycle", "(not given)", message)
        })?;
        let (range, limits) = match is_closed {
            true => travel(&mut line, &axis, options)?,
            false => (range(&limits, axis.range)?, limits),
        };
        let held = [("a wave table", controller.table), ("a table of the recorder", controller.recorder)];
        let setup = Setup {
            identity: controller.identity,
            axis: axis.name.clone(),
            unit: if is_closed { axis.unit.clone() } else { "V".into() },
            range,
            limits,
            cycle,
            holds: held.into_iter().filter_map(|(what, points)| Some((what, points?))).collect(),
            joins: true,
            servo: axis.servo,
        };
        let (channel, fastest) = (options.channel.unwrap_or(number), limits.fastest());
        let run = Run { line, axis, is_closed, channel, gain: options.gain, range, fastest };
        Ok(Gcs { run, setup, before: None, last: 0.0, ramp: options.ramp })
    }
}

impl Instrument for Gcs<'_> {
    fn setup(&self) -> &Setup {
        &self.setup
    }

    fn prepare(&mut self, drive: &Drive) -> Result<(), Error> {
        self.setup.check(drive)?;
        self.run.line.watch.enter(drive.what);
        // A place that is requested does not change by noise.
        let is_requested = self.run.is_closed || self.setup.servo != Some(true);
        let run = &mut self.run;
        let sources = Sources::of(&mut run.line)?;
        let place = run.place()?;
        run.upload(drive)?;
        run.configure(drive, cycles(drive.ts, self.setup.cycle)?, &sources)?;
        let has_moved = run.line.bits(MOVING)? != 0 || is_requested && self.before.is_none() && run.place()? != place;
        if has_moved || run.line.bits(RUNNING)? != 0 {
            return Err(in_use("it moves while it is being set"));
        }
        Ok(())
    }

    fn play(&mut self, drive: &Drive) -> Result<Record, Error> {
        let run = &mut self.run;
        if self.before.is_none() {
            let (start, first) = if run.is_closed { (run.arrive()?, None) } else { run.open_loop()? };
            if let Some(first) = first {
                run.check_gain(drive, start, first)?;
            }
            (self.before, self.last) = (Some(Before { start, first }), start);
        }
        run.ramp(self.last, drive.u[0], drive.ramp)?;
        run.settle(drive.u[0], drive.settle)?;
        if run.is_closed {
            run.arrive()?;
        }
        run.play(drive)?;
        if run.is_closed {
            run.check_servo()?;
        }
        (self.last, self.ramp) = (drive.u.last().copied().unwrap_or_default(), drive.ramp);
        read(&mut run.line, drive.u.len(), &run.axis.unit, &self.setup.identity)
    }

    fn rest(&mut self, rest: Rest) -> Result<Left, Error> {
        self.run.line.watch.enter("");
        match &self.before {
            Some(before) if self.run.is_closed => self.run.return_to(rest, before.start, self.last, self.ramp),
            Some(before) => self.run.reach(rest, before, self.last, self.ramp),
            None => self.run.left(),
        }
    }

    fn stop(&mut self) -> (Left, String) {
        self.run.stop()
    }
}

/// The axis, and its number: its name if that is one, otherwise its place.
fn axis(options: &InstrumentOptions, controller: &Controller) -> Result<(Axis, usize), Error> {
    let axes = &controller.axes;
    if axes.is_empty() {
        return Err(Error::Content("the controller reports no axes: configure its stages first".into()));
    }
    let k = options.axis.as_ref().map_or(Some(0), |name| axes.iter().position(|axis| axis.name == *name));
    let unknown = || {
        let name = options.axis.as_deref().unwrap_or_default();
        Error::unknown("axis", name, axes.iter().map(|axis| &*axis.name))
    };
    let k = k.ok_or_else(unknown)?;
    let number = axes[k].name.parse().ok().filter(|number| (1..=64).contains(number));
    Ok((axes[k].clone(), number.unwrap_or(k + 1)))
}

fn in_use(signs: &str) -> Error {
    let advice = "end the program that uses it, then try again";
    Error::Content(format!("the controller is in use: {signs}; nothing has moved: {advice}"))
}
