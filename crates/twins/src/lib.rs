//! Digital twins of piezo actuators from catalogue data and physics: the reference that models are tested on.
//!
//! ```text
//! u [V] -> driver -> v [V] -> hysteresis -> w [m] -> creep -> L [m] -> beam -> tip [m] -> sensor -> y [um]
//!                                  ^---------- coupling k * (tip - L) ---------'
//! ```
//! Each stage has its own file with its law. Every stage is exact for an input held over an inner step h. They are
//! coupled by the midpoint rule: the driver advances h/2, the ceramic gets the voltage of mid-step, the beam advances
//! h, the driver advances h/2. This is of second order in h, and exact for an ideal driver without creep. Between two
//! samples the voltage is monotonic, so no reversal is missed if the ceramic also gets the last voltage of the sample.
//! The physics is in SI units. Readings are in micrometres, as in a record.
//!
//! The plant must be independent of the model: nothing here may use the library's linear or hysteresis blocks.
//!
//! Reference: G. Strang, "On the construction and comparison of difference schemes", SIAM J. Numer. Anal. 5, 506
//! (1968), DOI 10.1137/0705041 (symmetric splitting). Not modelled: load, temperature, several axes.

// Tests compare with the C library.
#![cfg_attr(test, allow(clippy::disallowed_methods))]

mod actuators;
mod beam;
mod bouc_wen;
mod catalogue;
mod creep;
mod drawn;
mod driver;
mod everett;
mod material;
mod mechanics;
mod oscillator;
mod preisach;
mod presets;
mod saturation;
mod sensor;
pub mod spec;

pub use presets::{PLANTS, Preset};
pub use saturation::Saturation;
pub use spec::Spec;
pub use spec::{BeamSpec, HysteresisSpec, Logged};

use creep::CreepStage;
use driver::DriverStage;
use material::Material;
use mechanics::Mechanics;
use piezoid_numerics::error::{Error, positive};
use piezoid_numerics::system::System;
use sensor::Sensor;
use spec::require;

/// A simulated actuator with its driver and sensor: u [V] in, y [um] out.
///
/// At rest it is at 0 V and its displacement is 0. For a bender, 0 V is the middle of the supply. A unipolar actuator
/// (a stack, a stage) came to 0 V from the middle of its range, as after use.
///
/// State, in this order: number of samples; numbers of clamped, current-limited and sensor-clipped samples; driver
/// voltage [V]; tip displacement [m]; lagged displacement of the sensor [m]; strain of vibration [m]; then creep, beam
/// and hysteresis as in their files.
///
/// ```
/// use piezoid::plant::{Plant, Preset};
///
/// let plant = Plant::named("pl140", 5e-4)?.with_seed(7);
/// let run = plant.run(&[30.0; 200]);
/// assert!(run.y[199] > 900.0);
/// assert_eq!(run.saturation.to_string(), "1 sample limited by the driver's current");
/// # Ok::<(), piezoid::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Plant {
    ts: f64,
    inner_steps: usize,
    logged: Logged,
    driver: DriverStage,
    /// Voltage that a strain of vibration takes away [V/m].
    coupling: f64,
    material: Material,
    /// Voltage in the middle of the major loop [V].
    middle: f64,
    /// What the ceramic's law gives at rest [m].
    rest: f64,
    creep: CreepStage,
    beam: Mechanics,
    sensor: Sensor,
}

/// Micrometres per metre.
const UM: f64 = 1e6;

const SAMPLE_COUNT: usize = 0;
const CLAMPED: usize = 1;
const LIMITED: usize = 2;
const CLIPPED: usize = 3;
const VOLTAGE: usize = 4;
const TIP: usize = 5;
const LAGGED: usize = 6;
const STRAIN: usize = 7;
const HEAD: usize = 8;

/// A simulated measurement.
#[derive(Debug, Clone, PartialEq)]
pub struct PlantRun {
    /// Sensor readings [um].
    pub y: Vec<f64>,
    /// Limits that were reached.
    pub saturation: Saturation,
}

impl Plant {
    /// The plant of [`PLANTS`] of this name, sampled every `ts` [s].
    ///
    /// # Errors
    /// Returns an error if there is no such plant or `ts` is not positive.
    pub fn named(name: &str, ts: f64) -> Result<Self, Error> {
        Plant::new(&Preset::find(name)?.spec(), ts)
    }

    /// The plant sampled every `ts` [s], with noise of seed 0.
    ///
    /// # Errors
    /// Returns an error if a parameter is outside its domain, with its name in the specification.
    pub fn new(spec: &Spec, ts: f64) -> Result<Self, Error> {
        positive("ts", ts, "seconds")?;
        if !(1..=10_000).contains(&spec.inner_steps) {
            return Err(Error::parameter("inner_steps", spec.inner_steps, "must be from 1 to 10000"));
        }
        require((0.0..0.9).contains(&spec.coupling), "coupling", spec.coupling, "must be from 0 to 0.9")?;
        let rule = "must be a number of volts, 0 for a bipolar drive";
        require(spec.middle_v.is_finite(), "middle_v", spec.middle_v, rule)?;
        let material = Material::new(&spec.hysteresis)?;
        let rest = material.displacement(&mut vec![0.0; material.order()], -spec.middle_v);
        let h = ts / spec.inner_steps as f64;
        Ok(Plant {
            ts,
            inner_steps: spec.inner_steps,
            logged: spec.logged,
            driver: DriverStage::new(&spec.driver, 0.5 * h)?,
            coupling: spec.coupling * spec.hysteresis.volts_per_m(),
            material,
            middle: spec.middle_v,
            rest,
            creep: CreepStage::new(spec.creep_per_decade, spec.creep_from_s, h)?,
            beam: Mechanics::new(&spec.beam, h)?,
            sensor: Sensor::new(&spec.sensor, h, 0)?,
        })
    }

    /// The same plant with noise of `seed`.
    pub fn with_seed(self, seed: u64) -> Self {
        Plant { sensor: self.sensor.with_seed(seed), ..self }
    }

    /// Simulates a measurement from rest.
    pub fn run(&self, u: &[f64]) -> PlantRun {
        let mut x = self.initial();
        let y = self.resume(&mut x, u);
        PlantRun { y, saturation: self.saturation(&x) }
    }

    /// The limits that were reached up to state `x`.
    pub fn saturation(&self, x: &[f64]) -> Saturation {
        let [clamped, current_limited, sensor_clipped] = [CLAMPED, LIMITED, CLIPPED].map(|i| x[i] as usize);
        Saturation { clamped, current_limited, sensor_clipped }
    }

    /// The true tip displacement in state `x` [um], without the errors of the sensor.
    pub fn tip(&self, x: &[f64]) -> f64 {
        UM * x[TIP]
    }

    /// Advances one sampling period with the held input `u` [V].
    fn advance(&self, x: &mut [f64], u: f64) {
        let (head, x) = x.split_at_mut(HEAD);
        let (creep, x) = x.split_at_mut(CreepStage::ORDER);
        let (beam, ceramic) = x.split_at_mut(self.beam.order());
        let mut v = head[VOLTAGE];

        let (u, clamped) = self.driver.clamp(u);
        let mut limited = false;
        for _ in 0..self.inner_steps {
            limited |= self.driver.advance(&mut v, u);
            let w = self.strained(ceramic, v - self.coupling * head[STRAIN]);
            let l = self.creep.advance(creep, w);
            let start = self.beam.tip(beam, l);
            self.beam.advance(beam, l);
            let tip = self.beam.tip(beam, l);
            head[STRAIN] = tip - l;
            self.sensor.advance(&mut head[LAGGED], 0.5 * (start + tip));
            limited |= self.driver.advance(&mut v, u);
        }
        let l = self.creep.output(creep, self.strained(ceramic, v - self.coupling * head[STRAIN]));

        head[TIP] = self.beam.tip(beam, l);
        head[VOLTAGE] = v;
        head[CLAMPED] += f64::from(clamped);
        head[LIMITED] += f64::from(limited);
    }

    /// Static displacement of the ceramic from rest [m], moved to the voltage `v` [V].
    #[inline]
    fn strained(&self, ceramic: &mut [f64], v: f64) -> f64 {
        self.material.displacement(ceramic, v - self.middle) - self.rest
    }

    /// Reads the sensor [um].
    fn read(&self, x: &mut [f64]) -> f64 {
        let (y, clipped) = self.sensor.read(self.sensor.sees(x[TIP], x[LAGGED]), x[SAMPLE_COUNT] as u64);
        x[SAMPLE_COUNT] += 1.0;
        x[CLIPPED] += f64::from(clipped);
        UM * y
    }
}

impl System for Plant {
    fn ts(&self) -> f64 {
        self.ts
    }

    fn order(&self) -> usize {
        HEAD + CreepStage::ORDER + self.beam.order() + self.material.order()
    }

    fn initial(&self) -> Vec<f64> {
        let mut x = vec![0.0; self.order()];
        self.strained(&mut x[HEAD + CreepStage::ORDER + self.beam.order()..], 0.0);
        x
    }

    /// The ceramic went monotonically from rest to the clamped `u`; motion and creep have ended.
    fn settled(&self, u: f64) -> Vec<f64> {
        let mut x = self.initial();
        let (v, _) = self.driver.clamp(u);
        let (head, rest) = x.split_at_mut(HEAD);
        let (creep, rest) = rest.split_at_mut(CreepStage::ORDER);
        let (beam, ceramic) = rest.split_at_mut(self.beam.order());
        let w = self.strained(ceramic, v);
        creep.fill(w);
        let l = self.creep.output(creep, w);
        self.beam.settle(beam, l);
        head[VOLTAGE] = v;
        head[TIP] = self.beam.tip(beam, l);
        head[LAGGED] = head[TIP];
        x
    }

    fn step(&self, x: &mut [f64], u: f64) -> f64 {
        if self.logged == Logged::After {
            self.advance(x, u);
        }
        let y = self.read(x);
        if self.logged == Logged::Before {
            self.advance(x, u);
        }
        y
    }
}

#[cfg(test)]
mod tests {
    use super::spec::{DriverSpec, SensorSpec};
    use super::*;
    use piezoid_testing::assert_close;
    use std::f64::consts::TAU;

    const TS: f64 = 5e-4;

    #[test]
    fn every_settled_plant_stays_settled() {
        for preset in PLANTS {
            let quiet = Spec { sensor: SensorSpec::default(), ..preset.spec() };
            let plant = Plant::new(&quiet, TS).unwrap();
            for u in [20.0, -7.0, 45.0] {
                let y = plant.resume(&mut plant.settled(u), &[u; 400]);
                assert_close(&y, &[y[0]; 400], 1e-9, 0.0);
            }
        }
    }

    fn spec(name: &str) -> Spec {
        Preset::find(name).unwrap().spec()
    }

    fn plant(spec: &Spec) -> Plant {
        Plant::new(spec, TS).unwrap()
    }

    fn sine(amplitude: f64, hertz: f64, n: usize) -> Vec<f64> {
        (0..n).map(|i| amplitude * (TAU * hertz * i as f64 * TS).sin()).collect()
    }

    /// The specification without noise, converter and creep.
    fn quiet(spec: Spec) -> Spec {
        Spec { sensor: SensorSpec::default(), creep_per_decade: 0.0, ..spec }
    }

    #[test]
    fn the_pl140_moves_one_millimetre_in_either_direction() {
        let plant = plant(&quiet(spec("pl140")));
        // Up, down, up, each held for 2 s.
        let u: Vec<f64> = [30.0, -30.0, 30.0].iter().flat_map(|&v| [v; 4000]).collect();
        let y = plant.run(&u).y;
        assert_close(&[y[7999] - y[3999], y[11_999] - y[7999]], &[-2e3, 2e3], 1e-12, 0.0);
    }

    #[test]
    fn a_slow_loop_is_thirteen_percent_wide() {
        for name in ["paper", "pl140", "pl140-bouc-wen"] {
            let plant = plant(&Spec { logged: Logged::After, ..quiet(spec(name)) });
            let y = plant.run(&sine(30.0, 0.5, 12_000)).y;
            // The third period, at zero crossings and extremes.
            let [rising, top, falling, bottom] = [8000, 9000, 10_000, 11_000].map(|i| y[i]);
            // Half a sample minus the delays of driver and beam, relative to the period of 2 s: 0.05 %.
            assert_close(&[(falling - rising) / (top - bottom)], &[0.13], 0.0, 1e-3);
        }
    }

    #[test]
    fn the_paper_plant_has_the_poles_of_table_2() {
        // A small signal is nearly linear, so the free oscillation after a step has the poles of Table 2.
        let plant = plant(&spec("paper"));
        let y = plant.run(&[0.1; 4000]).y;
        let (w, zeta) = (TAU * 146.7, 0.061);
        let still = y[3999];
        for (i, y) in y.iter().enumerate().take(200) {
            let t = (i + 1) as f64 * TS; // logged after the step
            let wd = w * f64::sqrt(1.0 - zeta * zeta);
            let oscillation = (wd * t).cos() + zeta * w / wd * (wd * t).sin();
            assert_close(&[*y / still], &[1.0 - (-zeta * w * t).exp() * oscillation], 0.0, 1e-9);
        }
    }

    #[test]
    fn the_coupling_stiffens_the_mode_and_damps_it_by_hysteresis() {
        let step = |coupling: f64| {
            let spec = Spec { coupling, ..spec("paper") };
            let y = plant(&spec).run(&[vec![10.0; 400], vec![-10.0; 400]].concat()).y;
            let still = y[799];
            let ringing: Vec<f64> = y[400..800].iter().map(|y| y - still).collect();
            let falls = ringing.windows(2).enumerate().filter(|(_, w)| w[0] > 0.0 && w[1] <= 0.0);
            let falls: Vec<usize> = falls.map(|(t, _)| t).take(5).collect();
            let peak = |part: &[f64]| part.iter().fold(0.0f64, |m, y| m.max(y.abs()));
            ((falls[4] - falls[0]) as f64, peak(&ringing[40..54]) / peak(&ringing[..14]))
        };
        let ((free, rings), (coupled, damped)) = (step(0.0), step(0.3));
        // w / sqrt(1 - 0.3), if the ceramic were linear.
        assert_close(&[coupled / free], &[0.7f64.sqrt()], 0.1, 0.0);
        assert!(damped < 0.95 * rings, "{damped}, without coupling {rings}");
    }

    #[test]
    fn logging_before_is_logging_after_delayed_by_one_sample() {
        let after = Spec { logged: Logged::After, ..quiet(spec("pl140")) };
        let before = Spec { logged: Logged::Before, ..after.clone() };
        let u = sine(30.0, 40.0, 300);
        let (before, after) = (plant(&before).run(&u).y, plant(&after).run(&u).y);
        assert_eq!(before[1..], after[..299]);
        assert_eq!(before[0], 0.0);
    }

    #[test]
    fn the_midpoint_rule_is_of_second_order_in_the_inner_step() {
        for name in ["pl140", "pl140-bouc-wen"] {
            let mut spec = Spec { creep_per_decade: 0.015, ..quiet(spec(name)) };
            spec.driver = DriverSpec { lag_s: 3e-4, ..DriverSpec::default() };
            spec.sensor.lag_s = 2e-4;
            let u = sine(25.0, 110.0, 100);
            let mut run = |inner_steps| {
                spec.inner_steps = inner_steps;
                plant(&spec).run(&u).y
            };
            let (coarse, fine, truth) = (run(20), run(40), run(1280));
            let worst = |y: &[f64]| y.iter().zip(&truth).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            let (coarse, fine) = (worst(&coarse), worst(&fine));
            assert!(coarse < 1.0, "{name}: off by {coarse:e} um");
            assert!((3.5..4.6).contains(&(coarse / fine)), "{name}: half of h divides the error by {}", coarse / fine);
        }
    }

    #[test]
    fn with_an_ideal_driver_the_inner_step_does_not_matter() {
        let mut spec = quiet(spec("paper"));
        let u = sine(30.0, 60.0, 500);
        let fine = plant(&spec).run(&u).y;
        spec.inner_steps = 1;
        assert_close(&plant(&spec).run(&u).y, &fine, 0.0, 1e-9);
    }

    #[test]
    fn a_split_run_is_bit_identical_to_the_whole() {
        for preset in PLANTS {
            let plant = plant(&preset.spec()).with_seed(3);
            let u = sine(31.0, 37.0, 600);
            let mut x = plant.initial();
            let mut y = plant.resume(&mut x, &u[..251]);
            y.extend(plant.resume(&mut x.clone(), &u[251..]));
            assert_eq!(y, plant.simulate(&u), "{}", preset.name);
        }
    }

    #[test]
    fn noise_depends_only_on_the_seed() {
        let run = |seed| plant(&spec("pl140")).with_seed(seed).run(&[0.0; 100]).y;
        assert_eq!(run(1), run(1));
        assert_ne!(run(1), run(2));
        assert_eq!(run(0), plant(&spec("pl140")).run(&[0.0; 100]).y);
    }

    #[test]
    fn without_dynamics_the_timing_does_not_matter() {
        for name in ["pl140", "pl140-bouc-wen"] {
            let statics = Spec {
                beam: BeamSpec::Modes(vec![]),
                driver: DriverSpec::default(),
                logged: Logged::After,
                ..quiet(spec(name))
            };
            let fast = sine(30.0, 50.0, 200);
            let slow: Vec<f64> = fast.iter().flat_map(|&u| [u; 5]).collect();
            let y: Vec<f64> = plant(&statics).run(&slow).y.into_iter().step_by(5).collect();
            assert_eq!(y, plant(&statics).run(&fast).y, "{name}");
        }
    }

    #[test]
    fn reached_limits_are_counted() {
        let mut spec = spec("pl140");
        spec.sensor.range_m = Some(0.5e-3);
        let plant = plant(&spec);
        let quiet = plant.run(&[0.5; 50]).saturation;
        assert!(!quiet.any(), "{quiet}");
        let loud = plant.run(&[[29.0; 50], [31.0; 50]].concat()).saturation;
        assert_eq!((loud.clamped, loud.current_limited), (50, 1));
        assert!(loud.sensor_clipped > 80, "{loud}");
    }

    #[test]
    fn a_nan_cannot_panic() {
        for preset in PLANTS {
            let y = plant(&preset.spec()).run(&[1.0, f64::NAN, 2.0, f64::INFINITY, -1.0, f64::NEG_INFINITY]).y;
            assert_eq!(y.len(), 6);
            assert!(y[5].is_nan(), "{}: NaN stays in the state", preset.name);
        }
    }

    #[test]
    fn the_errors_about_bad_parameters_have_their_names() {
        let error = |change: fn(&mut Spec)| {
            let mut spec = spec("pl140");
            change(&mut spec);
            Plant::new(&spec, TS).unwrap_err().to_string()
        };
        assert!(error(|s| s.inner_steps = 0).starts_with("inner_steps = 0"));
        assert!(error(|s| s.driver.lag_s = -1.0).starts_with("driver.lag_s = -1"));
        assert!(error(|s| s.creep_per_decade = f64::NAN).starts_with("creep_per_decade = NaN"));
        assert!(error(|s| s.middle_v = f64::INFINITY).starts_with("middle_v = inf"));
        assert!(error(|s| s.coupling = 1.0).starts_with("coupling = 1"));
        assert!(error(|s| s.creep_from_s = 0.0).starts_with("creep_from_s = 0"));
        assert!(error(|s| s.sensor.bits = Some(64)).starts_with("sensor.bits = 64"));
        assert!(Plant::new(&spec("pl140"), 0.0).unwrap_err().to_string().starts_with("ts = 0"));
    }
}
