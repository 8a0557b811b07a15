//! The drives of a plan on a simulated actuator: the displacement to expect, and whether a resonance is excited.
//!
//! ```text
//! G(f) = |Y(f)| / |U(f)| of the small signal;    f0 is where G is largest, if that is twice its lowest lines or more
//! vibration = largest |y| between f0 / sqrt(2) and sqrt(2) f0
//! ```
//! Each drive begins after the demagnetisation, as it is measured. The sensor is without noise. The stroke is the
//! displacement of the slowest sine. It does not do: creep before a drive, several resonances, one above the band of
//! the small signal, limits of the driver of a stand-in.

use super::{OVER_RESONANCE, Plan, PlanOptions, PlannedDrive, STATIC_RESONANCE_RATIO};
use piezoid_control::feedback::SimulatedActuator;
use piezoid_models::hammerstein::Model;
use piezoid_numerics::complex::modulus;
use piezoid_numerics::error::Error;
use piezoid_numerics::fourier::{Transform, windowed};
use piezoid_numerics::number::{quantity, round, short};
use piezoid_numerics::series::{ends, largest, quantile, range, upsampled};
use serde::Serialize;
use std::f64::consts::SQRT_2;

/// Vibration over the stroke from which a resonance counts as excited.
const EXCITED: f64 = 0.1;

/// Gain over that of the lowest lines from which a resonance is one, and number of these lines.
const RESONANT: f64 = 2.0;
const LOWEST: usize = 10;

/// Share of the largest line of the small signal from which a line counts.
const LINE: f64 = 0.1;

/// Excess over the range and band of the records without a note, as a share of them.
const BEYOND: f64 = 0.02;

/// The drives of a plan on a simulated actuator.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Rehearsal {
    /// Name of the actuator.
    pub plant: String,
    /// Unit of its displacement.
    pub unit: String,
    /// Displacement of the slowest sine, peak to peak [unit].
    pub stroke: f64,
    /// The resonance; `None` if the small signal shows none [Hz].
    pub resonance_hz: Option<f64>,
    /// The drives, in the order of the plan.
    pub drives: Vec<RehearsedDrive>,
}

/// One drive of a [`Rehearsal`].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RehearsedDrive {
    /// Name of its record.
    pub name: &'static str,
    /// Lowest and highest displacement [unit].
    pub displacement: [f64; 2],
    /// Largest rate of the displacement [unit/s].
    pub rate: f64,
    /// Largest displacement about the resonance [unit]; `None` without one.
    pub vibration: Option<f64>,
    /// True if that is more than a tenth of the stroke.
    pub excites: bool,
}

impl PlanOptions {
    /// The drives, played on a simulated actuator and its name. Without a range they have that of the records of a
    /// stand-in or of the driver of a twin, and without a sampling period a multiple of that of a stand-in.
    ///
    /// # Errors
    /// Those of [`PlanOptions::run`] and [`SimulatedActuator::played`], and one for a sampling period that is no
    /// multiple of that of a stand-in.
    pub fn rehearsed(&self, model: Option<&Model>, plant: (&str, &SimulatedActuator)) -> Result<Plan, Error> {
        let own = match plant.1 {
            _ if self.actuator.is_some() || self.range.is_some() => None,
            SimulatedActuator::Twin(_) => Some(plant.1.voltages()?),
            SimulatedActuator::StandIn(stand_in) => stand_in.model().known_inputs(),
        };
        let is_free = self.ts.is_none() && self.cycle.is_none() && model.is_none();
        let cycle = if is_free { plant.1.period() } else { self.cycle };
        let mut plan = PlanOptions { range: self.range.or(own), cycle, ..self.clone() }.run(model)?;
        let rehearsal = Rehearsal::of(plant, &plan)?;
        let notes = rehearsal.notes(plant.1, &plan);
        plan.notes.extend(notes);
        Ok(Plan { rehearsal: Some(rehearsal), ..plan })
    }
}

impl Rehearsal {
    fn of((name, actuator): (&str, &SimulatedActuator), plan: &Plan) -> Result<Self, Error> {
        let period = actuator.period().unwrap_or(plan.ts);
        let multiple = plan.ts / period;
        if multiple < 0.5 || (multiple - multiple.round()).abs() > 1e-6 * multiple {
            let rule = format!("must be a multiple of {period} s, the sampling period of the stand-in");
            return Err(Error::parameter("ts", format!("{} s", plan.ts), rule));
        }
        let (plant, unit) = actuator.clone().without_noise().played(period, 0)?;
        let mut rest = plant.settled(plan.middle());
        plant.resume(&mut rest, &played(&plan.demagnetisation, plan.ts, period));
        let runs: Vec<(&PlannedDrive, Vec<f64>, Vec<f64>)> = (plan.drives.iter())
            .map(|drive| {
                let u = played(drive, plan.ts, period);
                let y = plant.resume(&mut rest.clone(), &u);
                (drive, u, y)
            })
            .collect();
        let run_of = |name: &str| runs.iter().find(|(drive, ..)| drive.name == name);
        let stroke = run_of("rise1").map_or(0.0, |(_, _, y)| range(y));
        let resonance = run_of("small").and_then(|(_, u, y)| resonance(u, y)).map(|share| share / period);
        let one = |(drive, _, y): &(&PlannedDrive, Vec<f64>, Vec<f64>)| {
            let (low, high) = ends(y.iter().copied());
            let steps: Vec<f64> = y.windows(2).map(|w| w[1] - w[0]).collect();
            let vibration = resonance.map(|f0| vibration(y, f0 * period));
            let excites = vibration.is_some_and(|vibration| vibration > EXCITED * stroke);
            let (displacement, rate) = ([low, high], largest(&steps) / period);
            RehearsedDrive { name: drive.name, displacement, rate, vibration, excites }
        };
        let drives = runs.iter().map(one).collect();
        Ok(Rehearsal { plant: name.into(), unit, stroke, resonance_hz: resonance, drives })
    }

    /// What to watch, one sentence each.
    fn notes(&self, actuator: &SimulatedActuator, plan: &Plan) -> Vec<String> {
        let mut notes = Vec::new();
        let needed = self.resonance_hz.filter(|f0| *f0 <= STATIC_RESONANCE_RATIO * plan.rig.bandwidth);
        let needed = needed.map(|f0| 1.0 / (OVER_RESONANCE * f0));
        for drive in self.drives.iter().filter(|drive| drive.excites) {
            let vibration = drive.vibration.unwrap_or_default();
            let percent = short(100.0 * vibration / self.stroke);
            let (vibration, unit, hz) = (short(vibration), &self.unit, quantity(self.hz(), "Hz"));
            let remedy = match drive.name {
                // The model needs the resonance, which a longer sampling period would leave out.
                "small" if needed.is_some() => "scale its voltages down",
                "small" => "give a longer sampling period, so that it ends below the resonance",
                "creep" => "lower the bandwidth, so that its moves are slower",
                _ => "lower the bandwidth",
            };
            notes.push(format!(
                "{}_u.csv: on {} it vibrates by {vibration} {unit} about the resonance of {hz}, {percent} % of the \
                 stroke: {remedy}, unless the actuator bears it",
                drive.name, self.plant
            ));
        }
        if let Some(longest) = needed.filter(|longest| plan.ts > *longest) {
            let (ts, hz, longest) = (quantity(plan.ts, "s"), quantity(self.hz(), "Hz"), quantity(longest, "s"));
            notes.push(format!(
                "The sampling period of {ts} does not resolve the resonance of {hz} on {}: take {longest} or less",
                self.plant
            ));
        }
        let (known, whose) = match actuator {
            SimulatedActuator::Twin(_) => (actuator.voltages().ok(), "the driver of the plant gives"),
            SimulatedActuator::StandIn(stand_in) => {
                (stand_in.model().known_inputs(), "the records of the stand-in have")
            }
        };
        let (from, to) = plan.range();
        let is_beyond = |(low, high): &(f64, f64)| (low - from).max(to - high) > BEYOND * (high - low);
        if let Some((low, high)) = known.filter(is_beyond) {
            let [from, to, low, high] = [from, to, low, high].map(round);
            notes.push(format!(
                "The rehearsal from {from} to {to} V goes beyond the {low} to {high} V that {whose}: there it is no \
                 measure of the actuator"
            ));
        }
        let SimulatedActuator::StandIn(stand_in) = actuator else { return notes };
        let highest = stand_in.model().identified().and_then(|domain| domain.hz).map(|hz| hz[1]);
        if let Some(highest) = highest.filter(|highest| plan.rig.bandwidth > (1.0 + BEYOND) * highest) {
            let [bandwidth, highest] = [plan.rig.bandwidth, highest].map(|hz| quantity(hz, "Hz"));
            notes.push(format!(
                "The rehearsal up to {bandwidth} goes beyond the records of the stand-in, which end at {highest}: \
                 there it is no measure of the actuator"
            ));
        }
        notes
    }

    /// The resonance with three digits [Hz].
    fn hz(&self) -> f64 {
        self.resonance_hz.map_or(f64::NAN, |hz| format!("{hz:.2e}").parse().unwrap_or(hz))
    }

    /// The rehearsal in one sentence, without the drives.
    pub fn text(&self) -> String {
        let (stroke, unit, plant) = (short(self.stroke), &self.unit, &self.plant);
        let resonance = match self.resonance_hz {
            Some(_) => format!("its resonance is at {}", quantity(self.hz(), "Hz")),
            None => "the small signal shows no resonance".into(),
        };
        let most = format!("{} %", 100.0 * EXCITED);
        let excited: Vec<&str> = self.drives.iter().filter(|drive| drive.excites).map(|drive| drive.name).collect();
        let verdict = match &excited[..] {
            _ if self.resonance_hz.is_none() => String::new(),
            [] => format!(", and no drive excites it beyond {most} of that"),
            names => format!(", and {} excite it beyond {most} of that", names.join(", ")),
        };
        format!("On {plant}, the slowest sine moves by {stroke} {unit}; {resonance}{verdict}.")
    }

    /// The cells of a drive: displacement, rate and vibration.
    pub fn cells(&self, drive: &RehearsedDrive) -> [String; 3] {
        let [low, high] = drive.displacement.map(short);
        [format!("{low} to {high}"), short(drive.rate), drive.vibration.map_or("-".into(), short)]
    }

    /// What they are, with units.
    pub fn header(&self) -> [String; 3] {
        let unit = &self.unit;
        [format!("displacement [{unit}]"), format!("rate [{unit}/s]"), format!("vibration [{unit}]")]
    }
}

/// The voltages of a drive every `period`, of which its sampling period is a multiple: held, or joined by straight
/// lines if it is sampled less often than the plan.
fn played(drive: &PlannedDrive, ts: f64, period: f64) -> Vec<f64> {
    let every = (drive.ts / period).round().max(1.0) as usize;
    upsampled(&drive.u, every, drive.ts > 1.5 * ts)
}

/// The frequency of the largest gain, as a share of the sampling rate; `None` if it is no resonance.
fn resonance(u: &[f64], y: &[f64]) -> Option<f64> {
    let n = u.len() as f64;
    let [u, y] = [u, y].map(|x| windowed(&level(x), |_| 1.0).0);
    let most = u.iter().map(|c| modulus(*c)).fold(0.0, f64::max);
    let lines = u.iter().zip(&y).enumerate().skip(1).filter(|(_, (u, _))| modulus(**u) > LINE * most);
    let gains: Vec<(usize, f64)> = lines.map(|(k, (u, y))| (k, modulus(*y) / modulus(*u))).collect();
    let lowest = quantile(gains.iter().take(LOWEST).map(|(_, gain)| *gain).collect(), 0.5);
    let (k, gain) = gains.iter().copied().reduce(|a, b| if b.1 > a.1 { b } else { a })?;
    (gain >= RESONANT * lowest).then(|| k as f64 / n)
}

/// The largest value of the part about this frequency, a share of the sampling rate.
fn vibration(y: &[f64], f0: f64) -> f64 {
    let n = y.len();
    let transform = Transform::new(n);
    let mut bins: Vec<_> = level(y).into_iter().map(Into::into).collect();
    transform.process(&mut bins);
    for (k, bin) in bins.iter_mut().enumerate() {
        let f = k.min(n - k) as f64 / n as f64;
        *bin = if (f0 / SQRT_2..=f0 * SQRT_2).contains(&f) { bin.conj() } else { 0.0.into() };
    }
    transform.process(&mut bins);
    bins.iter().fold(0.0, |most: f64, c| most.max(c.re.abs())) / n as f64
}

/// The same without the straight line from the first to the last value: a jump at the ends would seem to vibrate.
fn level(x: &[f64]) -> Vec<f64> {
    let [first, last] = [x.first(), x.last()].map(|x| x.copied().unwrap_or_default());
    let most = x.len().saturating_sub(1).max(1) as f64;
    x.iter().enumerate().map(|(t, x)| x - first - t as f64 / most * (last - first)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_control::feedback::StandIn;
    use piezoid_models::hammerstein::Domain;
    use piezoid_models::hysteresis::Proportional;
    use piezoid_models::linear::Arx;
    use piezoid_numerics::options::Options;
    use piezoid_testing::assert_close;
    use piezoid_twins::Preset;
    use serde_json::{Value, json};
    use std::f64::consts::TAU;
    use std::sync::Arc;

    const TS: f64 = 1e-3;

    /// A gain of 2 um/V with a mode of 1 % damping, if any, from records of -10 to 10 V up to 90 Hz.
    fn stand_in(mode_hz: Option<f64>) -> SimulatedActuator {
        let pole = mode_hz.map(|hz| {
            let radius = (-0.01 * TAU * hz * TS).exp();
            (2.0 * radius * (TAU * hz * TS).cos(), -radius * radius)
        });
        let linear = match pole {
            Some((a1, a2)) => Arx::new(TS, vec![a1, a2], vec![0.0, 2.0 * (1.0 - a1 - a2)]),
            None => Arx::gain(TS, 2.0),
        };
        let model = Model::new(Arc::new(Proportional::new(TS, 1.0).unwrap()), linear.unwrap(), 0.0).unwrap();
        let domain = Domain { u: [-10.0, 10.0], hz: Some([0.0, 90.0]), slew: 1e4, mean: [0.0, 0.0] };
        let model = model.with_identified(domain);
        StandIn::new(model.clone(), (model, Vec::new()), (0.0, 0.0), 0.0).unwrap().into()
    }

    fn rehearsed(input: Value, actuator: &SimulatedActuator) -> Result<Plan, Error> {
        PlanOptions::from_json(input)?.rehearsed(None, ("stand-in", actuator))
    }

    #[test]
    fn without_a_mode_each_drive_moves_as_its_voltages_do() {
        let plan = rehearsed(json!({"bandwidth": 20}), &stand_in(None)).unwrap();
        let rehearsal = plan.rehearsal.as_ref().unwrap();
        assert_eq!((plan.range(), rehearsal.resonance_hz), ((-10.0, 10.0), None));
        for (drive, planned) in rehearsal.drives.iter().zip(&plan.drives) {
            let [low, high] = [&planned.usage.lowest, &planned.usage.highest].map(|peak| 2.0 * peak.value);
            assert_close(&drive.displacement, &[low, high], 1e-9, 1e-9);
            // A drive that is held for several periods of the stand-in steps faster than it changes.
            assert_close(&[drive.rate * TS], &[2.0 * planned.usage.slew.value * planned.ts], 1e-6, 1e-9);
            assert!(drive.vibration.is_none() && !drive.excites, "{drive:?}");
        }
        assert_close(&[rehearsal.stroke], &[38.0], 0.01, 0.0);
        let page = plan.page();
        assert!(page.contains("## Rehearsal") && page.contains("the slowest sine moves by 38.00 um"), "{page}");
    }

    /// A sine of 80 Hz below a mode of 100 Hz is amplified by 1 / (1 - 0.64).
    #[test]
    fn a_drive_that_excites_the_resonance_is_named_with_its_vibration() {
        let options = |hz: f64| json!({"bandwidth": hz, "ts": TS});
        let near = rehearsed(options(80.0), &stand_in(Some(100.0))).unwrap();
        let rehearsal = near.rehearsal.as_ref().unwrap();
        assert_close(&[rehearsal.resonance_hz.unwrap()], &[100.0], 0.02, 0.0);
        let drive = |name: &str| rehearsal.drives.iter().find(|drive| drive.name == name).unwrap();
        let fast = drive("rise3");
        assert_close(&[fast.vibration.unwrap()], &[19.0 / 0.36], 0.1, 0.0);
        assert!(fast.excites && !drive("rise1").excites && !drive("creep").excites, "{rehearsal:?}");
        let notes = near.notes.join("\n");
        assert!(notes.contains("rise3_u.csv: on stand-in it vibrates by") && notes.contains("resonance of 100 Hz"));
        let far = rehearsed(options(20.0), &stand_in(Some(100.0))).unwrap();
        let excited: Vec<&str> = (far.rehearsal.as_ref().unwrap().drives.iter())
            .filter(|drive| drive.excites)
            .map(|drive| drive.name)
            .collect();
        assert_eq!(excited, ["small"], "{:?}", far.rehearsal);
        assert!(!far.notes.join("\n").contains("does not resolve"), "{:?}", far.notes);
        let coarse = rehearsed(json!({"bandwidth": 20}), &stand_in(Some(150.0))).unwrap();
        let notes = coarse.notes.join("\n");
        assert!(!notes.contains("longer sampling period"), "{notes}");
        assert!(notes.contains("The sampling period of 2 ms does not resolve the resonance of 15"), "{notes}");
    }

    #[test]
    fn what_the_plant_cannot_say_is_a_note_or_an_error() {
        let stand_in = stand_in(None);
        let notes = rehearsed(json!({"range": [-10, 20], "bandwidth": 95}), &stand_in).unwrap().notes.join("\n");
        assert!(notes.contains("from -10 to 20 V goes beyond the -10 to 10 V that the records"), "{notes}");
        assert!(notes.contains("up to 95 Hz goes beyond the records of the stand-in, which end at 90 Hz"), "{notes}");
        let error = rehearsed(json!({"bandwidth": 20, "ts": 1.5e-3}), &stand_in).unwrap_err().to_string();
        assert!(error.contains("must be a multiple of 0.001 s, the sampling period of the stand-in"), "{error}");
        let twin = Preset::find("p885").unwrap().spec().into();
        let notes = rehearsed(json!({"range": [0, 150], "bandwidth": 5}), &twin).unwrap().notes.join("\n");
        assert!(notes.contains("beyond the -20 to 120 V that the driver of the plant gives"), "{notes}");
    }
}
