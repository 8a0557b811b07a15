//! A function as an instrument: voltages in, displacements out. With it, five lines of a laboratory's own software take
//! the place of a controller.

use crate::checks;
use crate::instrument::measured_by;
use crate::moves::{half_cosine, way};
use crate::rest::{at_rest, nearest_to_zero};
use crate::simulated::CYCLE;
use crate::watch::within;
use crate::{Drive, Instrument, Left, Rest, Setup};
use piezoid::control::SimulatedActuator;
use piezoid::excitation::Limits;
use piezoid::progress::{Progress, Stage};
use piezoid::{Error, Record, Units};
use piezoid_numerics::series::upsampled;

/// Voltages [V], one a sampling period, in; the displacement at each of them out.
type Call<'f> = dyn FnMut(&[f64]) -> Result<Vec<f64>, Error> + 'f;

/// Seed of the noise of a simulated actuator.
const SEED: u64 = 1;

/// A function that plays voltages, as an [`Instrument`].
///
/// It is called with all voltages of a drive, after those of the slow move and of the wait before it, and returns the
/// displacement at each of them. Between two calls the voltage stays.
///
/// ```
/// use piezoid::progress::Stage;
/// use piezoid_instruments::{Drive, Function, Instrument};
/// let gain = |u: &[f64]| Ok(u.iter().map(|u| 2.0 * u).collect());
/// let mut ignore = Stage::ignore;
/// let mut function = Function::new((0.0, 100.0), 1e-3, Box::new(gain), &mut ignore)?;
/// let drive = Drive { what: "", u: &[50.0, 60.0], ts: 1e-3, ramp: 0.1, settle: 0.5, joined: false };
/// function.prepare(&drive)?;
/// assert_eq!(function.play(&drive)?.y(), [100.0, 120.0]);
/// # Ok::<(), piezoid::Error>(())
/// ```
pub struct Function<'f> {
    setup: Setup,
    call: Box<Call<'f>>,
    progress: &'f mut Progress<'f>,
    unit: String,
    /// The voltage at the start, and now [V].
    start: f64,
    at: f64,
    ramp: f64,
}

impl<'f> Function<'f> {
    /// A function for voltages within a range [V] and a sampling period [s]. The axis is at 0 V, or at the end of the
    /// range that is nearest to it.
    ///
    /// # Errors
    /// Returns an error for an empty range, and for a sampling period that is not positive.
    pub fn new(range: (f64, f64), ts: f64, call: Box<Call<'f>>, progress: &'f mut Progress<'f>) -> Result<Self, Error> {
        piezoid_numerics::error::positive("ts", ts, "seconds")?;
        let (low, high) = range;
        if !(low < high && low.is_finite() && high.is_finite()) {
            let rule = "must go from the lowest to the highest voltage";
            return Err(Error::parameter("range", format!("{low} {high}"), rule));
        }
        let setup = Setup {
            identity: "a function".into(),
            axis: "1".into(),
            unit: "V".into(),
            range,
            limits: Limits::default(),
            cycle: ts,
            holds: Vec::new(),
            joins: true,
            servo: None,
        };
        let start = nearest_to_zero(range);
        Ok(Function { setup, call, progress, unit: "um".into(), start, at: start, ramp: 0.0 })
    }

    /// A simulated actuator and its name, in place of a function: at rest, within limits, in time that no clock counts.
    /// A twin is played every servo cycle of a simulated controller.
    ///
    /// # Errors
    /// The errors of [`SimulatedActuator::voltages`], [`SimulatedActuator::played`] and [`Function::new`], and one for
    /// limits that leave no voltage.
    pub fn simulated(
        (name, actuator): (&str, &SimulatedActuator),
        limits: Limits,
        progress: &'f mut Progress<'f>,
    ) -> Result<Self, Error> {
        let range = checks::range(&limits, Some(actuator.voltages()?))?;
        let ts = actuator.period().unwrap_or(CYCLE);
        let (plant, unit) = actuator.played(ts, SEED)?;
        let (_, mut x) = at_rest(&*plant, range);
        let call = move |u: &[f64]| Ok(plant.resume(&mut x, u));
        let mut function = Function::new(range, ts, Box::new(call), progress)?.in_unit(unit).within(limits);
        // Records of one stand-in are none of another.
        function.setup.identity = match actuator {
            SimulatedActuator::Twin(_) => format!("{name}, simulated"),
            SimulatedActuator::StandIn(found) => format!("{name}, simulated. {found}"),
        };
        Ok(function)
    }

    /// The same with displacements in another unit.
    pub fn in_unit(self, unit: impl Into<String>) -> Self {
        Function { unit: unit.into(), ..self }
    }

    /// The same within limits of slew and current.
    pub fn within(mut self, limits: Limits) -> Self {
        self.setup.limits = limits;
        self
    }

    /// Voltages that lead from here to `to`: a half cosine, then a wait [s].
    fn lead(&self, to: f64, ramp: f64, settle: f64) -> Vec<f64> {
        let way = way(self.at, to);
        let [moves, waits] = [ramp.max(way / self.setup.limits.fastest()), settle].map(|time| time / self.setup.cycle);
        let moves = if way > 0.0 { moves.ceil().max(1.0) as usize } else { 0 };
        half_cosine(self.at, to, moves).chain(std::iter::repeat_n(to, waits.ceil() as usize)).collect()
    }

    /// Calls the function with these voltages.
    fn call(&mut self, what: &str, u: &[f64]) -> Result<Vec<f64>, Error> {
        if (self.progress)(Stage::new(what, 0, 1)).is_break() {
            return Err(Error::Cancelled { what: what.into(), done: 0, total: 1 });
        }
        let y = (self.call)(u)?;
        if y.len() != u.len() {
            let (n, expected) = (y.len(), u.len());
            return Err(Error::Content(format!(
                "the function returns {n} displacements for {expected} voltages: return one for each"
            )));
        }
        self.at = u.last().copied().unwrap_or(self.at);
        Ok(y)
    }
}

impl Instrument for Function<'_> {
    fn setup(&self) -> &Setup {
        &self.setup
    }

    fn prepare(&mut self, drive: &Drive) -> Result<(), Error> {
        self.setup.check(drive)
    }

    fn play(&mut self, drive: &Drive) -> Result<Record, Error> {
        let every = (drive.ts / self.setup.cycle).round().max(1.0) as usize;
        let first = drive.u.first().copied().unwrap_or(self.at);
        let mut u = self.lead(first, drive.ramp, drive.settle);
        let lead = u.len();
        u.extend(upsampled(drive.u, every, drive.joined));
        self.ramp = drive.ramp;
        let y = self.call(&within(drive.what, "the drive is played"), &u)?;
        let rows = lead..u.len();
        let [u, y] = [&u, &y].map(|x| x[rows.clone()].iter().step_by(every).copied().collect());
        let units = Units { u: "V".into(), y: self.unit.clone() };
        Ok(measured_by(&self.setup.identity, Record::new(drive.ts, u, y)?.with_units(units)))
    }

    fn rest(&mut self, rest: Rest) -> Result<Left, Error> {
        let to = match rest {
            Rest::Start => self.start,
            Rest::Zero => 0.0,
            Rest::Stay => self.at,
        };
        let u = self.lead(to, self.ramp, 0.0);
        if !u.is_empty() {
            self.call("slow move", &u)?;
        }
        Ok(Left { voltage: Some(self.at), servo: None })
    }

    fn stop(&mut self) -> (Left, String) {
        let left = Left { voltage: Some(self.at), servo: None };
        (left, format!("the last voltage of the function was {:.3} V", self.at))
    }
}
