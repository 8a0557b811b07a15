//! The drives that identify an actuator, within the limits of its driver, and a page that says why each is measured.
//!
//! All drives start and end at the middle of the range: a hysteresis loop about it contains the loops of every smaller
//! amplitude, and a unipolar actuator is never driven below its range.

mod advice;
mod drives;
mod page;
mod rehearsal;
#[cfg(test)]
mod tests;

pub use advice::{UncertainParameter, Uncertainty};
pub use rehearsal::{Rehearsal, RehearsedDrive};

use super::File;
use piezoid_models::hammerstein::Model;
use piezoid_numerics::error::Error;
use piezoid_numerics::number::{quantity, round};
use piezoid_numerics::options::{OptionKind, OptionRow, options};
use piezoid_numerics::system::System;
use piezoid_records::excitation::{Actuator, Amplifier, LimitOptions, Limits, Usage};
use piezoid_records::formats::Table;
use piezoid_records::record::Record;
use serde_json::{Value, json};

/// Samples of the longest drive at the sampling period of the plan: identification takes minutes beyond it.
const MAX_SAMPLES: usize = 200_000;

/// Sampling rate over bandwidth: half of it, the Nyquist frequency, is ten times the bandwidth.
const OVER_BANDWIDTH: f64 = 20.0;

/// Sampling rate over resonance: the Nyquist frequency is 2.5 times the resonance.
const OVER_RESONANCE: f64 = 5.0;

/// Resonance over bandwidth from which the resonance does not set the sampling period, because the actuator follows
/// statically.
const STATIC_RESONANCE_RATIO: f64 = 100.0;

options! {
    /// How to plan: the range and bandwidth of the application, the actuator, and its driver.
    ///
    /// ```
    /// use piezoid_numerics::options::Options;
    /// use piezoid_verbs::PlanOptions;
    /// let options = serde_json::json!({"range": [0, 100], "bandwidth": 20, "driver": "e-610", "capacitance": 1.5e-6});
    /// let plan = PlanOptions::from_json(options)?.run(None)?;
    /// let names: Vec<&str> = plan.drives.iter().map(|drive| drive.name).collect();
    /// assert_eq!(names, ["small", "rise1", "rise2", "rise3", "creep", "path"]);
    /// assert!(plan.ts == 0.002 && plan.drives.iter().all(|drive| drive.u[0] == 50.0));
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    pub struct PlanOptions {
        /// Lowest and highest voltage of the application.
        range: Option<(f64, f64)> = None, OptionRow { unit: "V", ..OptionRow::new(OptionKind::Pair) }.absent("those of \
            the actuator");
        /// Highest frequency of the application.
        bandwidth: f64 = 50.0, OptionRow::positive("Hz").required();
        /// The actuator, for its range, capacitance and resonance (see {list}).
        actuator: Option<String> = None, OptionRow::new(OptionKind::Text("NAME")).list("actuators");
        /// Sampling period; drives with too many samples have a multiple of it.
        ts: Option<f64> = None, OptionRow::positive("s").absent("from bandwidth and resonance");
        /// Samples that the controller holds of a drive and of a record.
        points: usize = MAX_SAMPLES, OptionRow::new(OptionKind::Integer(500, MAX_SAMPLES as u64));
        /// True if it joins voltages by straight lines: drives that have too many samples are then sampled less often,
        /// otherwise they are shortened.
        joins: bool = true, OptionRow::new(OptionKind::Switch);
        /// Servo cycle of the controller: sampling periods are multiples of it.
        cycle: Option<f64> = None, OptionRow::positive("s").absent("any sampling period");
    } with limits: LimitOptions
}

/// The drives for an identification.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// Sampling period of the model [s]; drives that would have too many samples have a multiple of it.
    pub ts: f64,
    /// What brings the hysteresis to the middle of its loop before each record.
    pub demagnetisation: PlannedDrive,
    /// The drives, in the order in which they are measured.
    pub drives: Vec<PlannedDrive>,
    /// What was shortened or reduced, and what to watch; one sentence each.
    pub notes: Vec<String>,
    /// Which drive would lower the error of prediction of a first model most, or that none would lower it by much;
    /// `None` without a model.
    pub advice: Option<String>,
    /// The error of prediction that the uncertain parameters of this model cause; `None` without a model.
    pub uncertainty: Option<Uncertainty>,
    /// The drives on a simulated actuator; `None` without one.
    pub rehearsal: Option<Rehearsal>,
    rig: Rig,
}

/// One drive of a [`Plan`].
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedDrive {
    /// Name of its measured record, without extension: the record of `small_u.csv` is `small.csv`.
    pub name: &'static str,
    /// What it is measured for.
    pub purpose: &'static str,
    /// Sampling period, a multiple of that of the plan [s]. Straight lines join the voltages of a longer one.
    pub ts: f64,
    /// The voltages [V].
    pub u: Vec<f64>,
    /// Use of the limits.
    pub usage: Usage,
}

impl PlannedDrive {
    /// Name of the file of the drive.
    pub fn file(&self) -> String {
        format!("{}_u.csv", self.name)
    }

    /// Its file: CSV with the columns `t_s` and `u_V`.
    ///
    /// # Errors
    /// The errors of [`Table::write`].
    pub fn written(&self) -> Result<File, Error> {
        let name = self.file();
        let bytes = Table::write(&name, self.ts, &[("u_V", &self.u)])?;
        Ok(File::new(name, bytes))
    }

    /// The largest used share of a limit [%]; `None` without limits.
    pub fn percent(&self) -> Option<f64> {
        self.usage.peaks().filter_map(|peak| peak.share).reduce(f64::max).map(|share| 100.0 * share)
    }
}

/// What the drives are made for.
#[derive(Debug, Clone, PartialEq)]
struct Rig {
    ts: f64,
    /// Most samples of a drive.
    points: usize,
    joins: bool,
    low: f64,
    high: f64,
    bandwidth: f64,
    resonance: Option<f64>,
    limits: Limits,
    /// The slew, rms, that the driver gives continuously [V/s]; infinite if that is unknown.
    continuous: f64,
    driver: Option<String>,
    actuator: Option<&'static Actuator>,
}

/// Rounding of a quotient of decimal numbers.
const ROUNDING: f64 = 1e-9;

impl Rig {
    fn middle(&self) -> f64 {
        0.5 * self.low + 0.5 * self.high
    }

    /// Half of the range [V].
    fn half(&self) -> f64 {
        0.5 * self.high - 0.5 * self.low
    }
}

impl PlanOptions {
    /// The drives. With a first `model` they have its sampling period, and the plan contains advice.
    ///
    /// # Errors
    /// Returns an error for a range that is missing, empty, or beyond that of driver or actuator; for a bandwidth that
    /// is not below a tenth of the sampling rate; for limits that leave no amplitude; for invalid limits; and for a
    /// model with another sampling period, or without standard errors.
    pub fn run(&self, model: Option<&Model>) -> Result<Plan, Error> {
        let mut notes = Vec::new();
        let rig = self.rig(model, &mut notes)?;
        let drives = drives::all(&rig, &mut notes)?;
        let demagnetisation = drives::demagnetisation(&rig, &mut Vec::new())?;
        let (advice, uncertainty, rehearsal) = (None, None, None);
        let mut plan = Plan { ts: rig.ts, demagnetisation, drives, notes, advice, uncertainty, rehearsal, rig };
        plan.uncertainty = model.map(|model| advice::uncertainty(model, &plan)).transpose()?;
        plan.advice = plan.uncertainty.as_ref().map(Uncertainty::advice);
        Ok(plan)
    }

    /// What brings the hysteresis to the middle of its loop, alone.
    ///
    /// # Errors
    /// Those of [`run`](Self::run) for range, sampling period, bandwidth and limits.
    pub fn demagnetisation(&self) -> Result<PlannedDrive, Error> {
        drives::demagnetisation(&self.rig(None, &mut Vec::new())?, &mut Vec::new())
    }

    fn rig(&self, model: Option<&Model>, notes: &mut Vec<String>) -> Result<Rig, Error> {
        let actuator = self.actuator.as_deref().map(Actuator::find).transpose()?;
        let mut arguments = self.limits.clone();
        if arguments.driver.is_some() || arguments.own.current.is_some() {
            arguments.own.capacitance = arguments.own.capacitance.or(actuator.and_then(|a| a.capacitance));
        }
        let limits = arguments.limits()?;
        if limits.is_none_or(|limits| limits.fastest().is_infinite()) {
            notes.push("No limit of slew or current is known: name the driver, or check both yourself".into());
        }
        let (low, high) = match (self.range, actuator) {
            (Some(range), _) => range,
            (None, Some(actuator)) => (actuator.low, actuator.high),
            (None, None) => {
                let rule = "is needed: give the lowest and highest voltage, or the actuator";
                return Err(Error::parameter("range", "(not given)", rule));
            }
        };
        let range = format!("{} {}", round(low), round(high));
        if low >= high {
            return Err(Error::parameter("range", range, "must go from the lowest to the highest voltage"));
        }
        let mut limits = limits.unwrap_or_default();
        let driver = arguments.driver.as_ref().map_or("the driver".into(), |name| format!("driver `{name}`"));
        if let (Some(Actuator { kind: "bender", name, .. }), Some((least, most))) =
            (actuator, limits.low.zip(limits.high))
            && least != -most
        {
            let rule = format!(
                "is relative to mid-supply for the bender `{name}`, but {driver} gives {} to {} V: name a driver with \
                 limits relative to mid-supply, such as pl140, or give limits instead of a driver",
                round(least),
                round(most)
            );
            return Err(Error::parameter("range", range, rule));
        }
        let allowed = actuator.map(|a| (format!("actuator `{}` allows", a.name), Some(a.low), Some(a.high)));
        for (who, least, most) in [(format!("{driver} gives"), limits.low, limits.high)].into_iter().chain(allowed) {
            if least.is_some_and(|least| low < least) || most.is_some_and(|most| high > most) {
                let end = |end: Option<f64>| end.map_or("any".into(), round);
                let (least, most) = (end(least), end(most));
                let rule = format!("{who} {least} to {most} V: take a range within it, or another driver or actuator");
                return Err(Error::parameter("range", range, rule));
            }
            limits.low = [limits.low, least].into_iter().flatten().reduce(f64::max);
            limits.high = [limits.high, most].into_iter().flatten().reduce(f64::min);
        }
        // Data sheets of stacks state the resonance with both ends free; one is fixed in use.
        let resonance = actuator.and_then(|a| Some(if a.kind == "stack" { 0.5 } else { 1.0 } * a.resonance?));
        let ts = match (self.ts, model.map(System::ts)) {
            (Some(ts), Some(of_model)) => Record::same_sampling("the model", of_model, "the plan", ts).map(|()| ts)?,
            (Some(ts), None) | (None, Some(ts)) => ts,
            (None, None) => self.period(resonance, notes),
        };
        // A text of the product, not the product, is the decimal number.
        let cycles = self.cycle.map(|cycle| (ts / cycle, (ts / cycle + ROUNDING).floor().max(1.0), cycle));
        let ts = match cycles {
            Some((exact, whole, cycle)) if (self.ts.is_some() || model.is_some()) && (exact - whole).abs() > 1e-6 => {
                let rule =
                    format!("must be a multiple of the servo cycle of {cycle} s, such as {} s", round(whole * cycle));
                return Err(Error::parameter("ts", format!("{ts} s"), rule));
            }
            Some((_, whole, cycle)) => format!("{:.9e}", whole * cycle).parse().unwrap_or(whole * cycle),
            None => ts,
        };
        let highest = 0.1 / ts;
        if self.bandwidth >= highest {
            let rule = format!(
                "must be below {} Hz, a tenth of the sampling rate (ts = {ts} s): lower it, or sample faster",
                round(highest)
            );
            return Err(Error::parameter("bandwidth", format!("{} Hz", self.bandwidth), rule));
        }
        let (bandwidth, driver) = (self.bandwidth, arguments.driver);
        let amplifier = driver.as_deref().map(Amplifier::find).transpose()?;
        let current = amplifier.and_then(|amplifier| amplifier.continuous);
        let continuous = current.zip(limits.capacitance).map_or(f64::INFINITY, |(current, farad)| current / farad);
        Ok(Rig {
            ts,
            points: self.points,
            joins: self.joins,
            low,
            high,
            bandwidth,
            resonance,
            limits,
            continuous,
            driver,
            actuator,
        })
    }

    /// The sampling period: 1, 2 or 5 times a power of ten, or a longer one if the slowest sine needs it.
    fn period(&self, resonance: Option<f64>, notes: &mut Vec<String>) -> f64 {
        let mut longest = 1.0 / (OVER_BANDWIDTH * self.bandwidth);
        match resonance {
            Some(f) if f > STATIC_RESONANCE_RATIO * self.bandwidth => {
                let (f, ts) = (quantity(f, "Hz"), quantity(1.0 / (OVER_RESONANCE * f), "s"));
                notes.push(format!(
                    "The resonance of {f} is more than {STATIC_RESONANCE_RATIO} times the bandwidth: the actuator follows statically, and \
                     the sampling period need not resolve the resonance ({ts} would)"
                ));
            }
            Some(f) => longest = longest.min(1.0 / (OVER_RESONANCE * f)),
            None => notes.push(
                "The resonance is unknown: if it is above a fifth of the sampling rate, give a shorter sampling period"
                    .into(),
            ),
        }
        // A product of 5 and a power of ten below 1 is not the decimal number; its text is.
        let power = (libm::log10(longest) + ROUNDING).floor();
        let mantissa = longest / libm::pow(10.0, power) * (1.0 + ROUNDING);
        let step = [5, 2, 1].into_iter().find(|step| f64::from(*step) <= mantissa).unwrap_or(1);
        let usual: f64 = format!("{step}e{power}").parse().unwrap_or(longest);
        let hz = drives::slowest(self.bandwidth);
        let unit = self.cycle.unwrap_or(0.1 * usual);
        let needed = (drives::shortest_period(hz, self.points) / unit - ROUNDING).ceil() * unit;
        if self.joins || needed <= usual || 0.1 / needed <= self.bandwidth {
            return usual;
        }
        notes.push(format!(
            "The sampling period is {} instead of {}: a drive has at most {} samples, too few otherwise for the slowest sine, \
             of {}. A higher bandwidth allows a shorter one",
            quantity(needed, "s"),
            quantity(usual, "s"),
            self.points,
            quantity(hz, "Hz")
        ));
        needed
    }
}

impl Plan {
    /// The drives as CSV files with the columns `t_s` and `u_V`, and the page `plan.md`.
    ///
    /// # Errors
    /// The errors of [`Table::write`].
    pub fn files(&self) -> Result<Vec<File>, Error> {
        let page = || Ok(File::new("plan.md", self.page()));
        let drives = std::iter::once(&self.demagnetisation).chain(&self.drives);
        drives.map(PlannedDrive::written).chain(std::iter::once_with(page)).collect()
    }

    /// The plan as a document, without the voltages.
    pub fn to_json(&self) -> Value {
        let one = |drive: &PlannedDrive| {
            json!({
                "name": drive.name, "file": drive.file(), "purpose": drive.purpose, "ts": drive.ts, "duration": self.duration(drive),
                "percent": drive.percent(), "usage": drive.usage,
            })
        };
        let drives: Vec<_> = self.drives.iter().map(one).collect();
        json!({
            "ts": self.ts, "demagnetisation": one(&self.demagnetisation), "drives": drives, "notes": self.notes,
            "advice": self.advice, "uncertainty": self.uncertainty, "rehearsal": self.rehearsal,
        })
    }

    /// The middle of the range, at which all drives start and end [V].
    pub fn middle(&self) -> f64 {
        self.rig.middle()
    }

    /// Lowest and highest voltage of the application [V].
    pub fn range(&self) -> (f64, f64) {
        (self.rig.low, self.rig.high)
    }

    /// The share of half of the range that a drive uses.
    pub fn used(&self, drive: &PlannedDrive) -> f64 {
        let farthest = (drive.usage.highest.value - self.middle()).max(self.middle() - drive.usage.lowest.value);
        farthest / self.rig.half()
    }

    /// Length of a drive [s].
    pub fn duration(&self, drive: &PlannedDrive) -> f64 {
        drive.u.len() as f64 * drive.ts
    }
}
