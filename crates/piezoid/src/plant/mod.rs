//! Twins of piezo benders, from catalogue data and physics: the truth that models are tried on.
//!
//! ```text
//! u [V] -> driver -> v [V] -> hysteresis -> w [m] -> creep -> L [m] -> beam -> tip [m] -> sensor -> y [m]
//! ```
//! Each stage has its own file, which opens with its law. Here they are put together: every stage is exact for an
//! input held over an inner step h, and they are coupled by the midpoint rule: the driver advances h/2, the ceramic
//! sees the voltage of mid-step, the beam advances h, the driver advances h/2. That is of second order in h, and
//! without creep exact for an ideal driver. Between two samples the voltage runs one way only, so showing the ceramic
//! its last value at the end of the sample lets no reversal be missed.
//!
//! The plant must never be the model: nothing here may come from the library's linear or hysteresis blocks.
//!
//! Reference: G. Strang, "On the construction and comparison of difference schemes", SIAM J. Numer. Anal. 5, 506
//! (1968), DOI 10.1137/0705041 (symmetric splitting). Not here: load, temperature, several axes.

mod beam;
mod bouc_wen;
mod catalogue;
mod creep;
mod driver;
mod everett;
mod material;
mod preisach;
mod presets;
mod saturation;
mod sensor;
pub(crate) mod spec;

pub use presets::{PLANTS, Preset};
pub use saturation::Saturation;
pub use spec::Spec;
pub(crate) use spec::{BeamSpec, HysteresisSpec, Logged};

use crate::error::{Error, positive};
use crate::system::System;
use beam::Beam;
use creep::CreepStage;
use driver::DriverStage;
use material::Material;
use sensor::Sensor;

/// A simulated bender with its driver and sensor: u [V] about mid-voltage in, y [m] out.
///
/// State, in this order: samples taken; samples clamped, current-limited, sensor-clipped; driver voltage [V]; tip
/// displacement [m]; sensor's lag [m]; then creep, beam and hysteresis as their files say.
///
/// ```
/// use piezoid::plant::{Plant, Preset};
///
/// let plant = Plant::named("pl140", 5e-4)?.with_seed(7);
/// let run = plant.run(&[30.0; 200]);
/// assert!(run.y[199] > 0.9e-3);
/// assert_eq!(run.saturation.to_string(), "1 sample slowed by the driver's current limit");
/// # Ok::<(), piezoid::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Plant {
    ts: f64,
    inner_steps: usize,
    logged: Logged,
    driver: DriverStage,
    material: Material,
    creep: CreepStage,
    beam: Beam,
    sensor: Sensor,
}

const TAKEN: usize = 0;
const CLAMPED: usize = 1;
const LIMITED: usize = 2;
const CLIPPED: usize = 3;
const VOLTAGE: usize = 4;
const TIP: usize = 5;
const LAGGED: usize = 6;
const HEAD: usize = 7;

/// A simulated measurement.
#[derive(Debug, Clone, PartialEq)]
pub struct PlantRun {
    /// What the sensor read [m].
    pub y: Vec<f64>,
    /// What limits were reached.
    pub saturation: Saturation,
}

impl Plant {
    /// The plant of [`PLANTS`] of this name, sampled every `ts` [s].
    ///
    /// # Errors
    /// No such plant, or a `ts` that is not positive.
    pub fn named(name: &str, ts: f64) -> Result<Self, Error> {
        Plant::new(&(Preset::find(name)?.spec)(), ts)
    }

    /// The plant sampled every `ts` [s], its noise drawn from seed 0.
    ///
    /// # Errors
    /// Refuses a parameter outside its domain, by the name it has in the specification.
    pub fn new(spec: &Spec, ts: f64) -> Result<Self, Error> {
        positive("ts", ts, "seconds")?;
        if !(1..=10_000).contains(&spec.inner_steps) {
            return Err(Error::parameter("inner_steps", spec.inner_steps, "must be from 1 to 10000"));
        }
        let h = ts / spec.inner_steps as f64;
        Ok(Plant {
            ts,
            inner_steps: spec.inner_steps,
            logged: spec.logged,
            driver: DriverStage::new(&spec.driver, 0.5 * h)?,
            material: Material::new(&spec.hysteresis)?,
            creep: CreepStage::new(spec.creep_per_decade, h)?,
            beam: Beam::new(&spec.beam, h)?,
            sensor: Sensor::new(&spec.sensor, h, 0)?,
        })
    }

    /// The same plant with its noise drawn from `seed`.
    pub fn with_seed(self, seed: u64) -> Self {
        Plant { sensor: self.sensor.with_seed(seed), ..self }
    }

    /// Measures from rest: the readings, and the limits that were reached.
    pub fn run(&self, u: &[f64]) -> PlantRun {
        let mut x = self.initial();
        let y = self.resume(&mut x, u);
        PlantRun { y, saturation: self.saturation(&x) }
    }

    /// The limits that were reached on the way to state `x`.
    pub fn saturation(&self, x: &[f64]) -> Saturation {
        let [clamped, current_limited, sensor_clipped] = [CLAMPED, LIMITED, CLIPPED].map(|i| x[i] as usize);
        Saturation { clamped, current_limited, sensor_clipped }
    }

    /// Where the tip truly is in state `x` [m]: what a perfect sensor would read after the last step.
    pub fn tip(&self, x: &[f64]) -> f64 {
        x[TIP]
    }

    /// One sampling period under the held input `u` [V].
    fn advance(&self, x: &mut [f64], u: f64) {
        let (head, x) = x.split_at_mut(HEAD);
        let (creep, x) = x.split_at_mut(CreepStage::ORDER);
        let (beam, ceramic) = x.split_at_mut(self.beam.order());
        let mut v = head[VOLTAGE];

        let (u, clamped) = self.driver.clamp(u);
        let mut limited = false;
        for _ in 0..self.inner_steps {
            limited |= self.driver.advance(&mut v, u);
            let l = self.creep.advance(creep, self.material.displacement(ceramic, v));
            let start = self.beam.tip(beam, l);
            self.beam.advance(beam, l);
            self.sensor.advance(&mut head[LAGGED], 0.5 * (start + self.beam.tip(beam, l)));
            limited |= self.driver.advance(&mut v, u);
        }
        let l = self.creep.output(creep, self.material.displacement(ceramic, v));

        head[TIP] = self.beam.tip(beam, l);
        head[VOLTAGE] = v;
        head[CLAMPED] += f64::from(clamped);
        head[LIMITED] += f64::from(limited);
    }

    /// Reads the sensor.
    fn read(&self, x: &mut [f64]) -> f64 {
        let (y, clipped) = self.sensor.read(self.sensor.sees(x[TIP], x[LAGGED]), x[TAKEN] as u64);
        x[TAKEN] += 1.0;
        x[CLIPPED] += f64::from(clipped);
        y
    }
}

impl System for Plant {
    fn ts(&self) -> f64 {
        self.ts
    }

    fn order(&self) -> usize {
        HEAD + CreepStage::ORDER + self.beam.order() + self.material.order()
    }

    /// The ceramic has gone straight from rest to the clamped `u`; all that moves or creeps has come to its end.
    fn settled(&self, u: f64) -> Vec<f64> {
        let mut x = self.initial();
        let (v, _) = self.driver.clamp(u);
        let (head, rest) = x.split_at_mut(HEAD);
        let (creep, rest) = rest.split_at_mut(CreepStage::ORDER);
        let (beam, ceramic) = rest.split_at_mut(self.beam.order());
        let w = self.material.displacement(ceramic, v);
        creep.fill(w);
        let l = self.creep.output(creep, w);
        self.beam.settle(beam, l);
        head[VOLTAGE] = v;
        head[TIP] = self.beam.tip(beam, l);
        head[LAGGED] = head[TIP];
        x
    }

    fn step(&self, x: &mut [f64], u: f64) -> f64 {
        match self.logged {
            Logged::Before => {
                let y = self.read(x);
                self.advance(x, u);
                y
            }
            Logged::After => {
                self.advance(x, u);
                self.read(x)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::spec::{DriverSpec, SensorSpec};
    use super::*;
    use crate::testing::assert_close;
    use std::f64::consts::TAU;

    const TS: f64 = 5e-4;

    #[test]
    fn every_plant_that_has_settled_stays_where_it_is() {
        for preset in PLANTS {
            let quiet = Spec { sensor: SensorSpec::default(), ..(preset.spec)() };
            let plant = Plant::new(&quiet, TS).unwrap();
            for u in [20.0, -7.0, 45.0] {
                let y = plant.resume(&mut plant.settled(u), &[u; 400]);
                assert_close(&y, &[y[0]; 400], 1e-9, 0.0);
            }
        }
    }

    fn spec(name: &str) -> Spec {
        (Preset::find(name).unwrap().spec)()
    }

    fn plant(spec: &Spec) -> Plant {
        Plant::new(spec, TS).unwrap()
    }

    fn sine(amplitude: f64, hertz: f64, n: usize) -> Vec<f64> {
        (0..n).map(|i| amplitude * (TAU * hertz * i as f64 * TS).sin()).collect()
    }

    /// The spec without noise, converter and creep.
    fn quiet(spec: Spec) -> Spec {
        Spec { sensor: SensorSpec::default(), creep_per_decade: 0.0, ..spec }
    }

    #[test]
    fn the_pl140_moves_a_millimetre_to_either_side() {
        let plant = plant(&quiet(spec("pl140")));
        // Up, down, up, each held for 2 s.
        let u: Vec<f64> = [30.0, -30.0, 30.0].iter().flat_map(|&v| [v; 4000]).collect();
        let y = plant.run(&u).y;
        assert_close(&[y[7999] - y[3999], y[11_999] - y[7999]], &[-2e-3, 2e-3], 1e-12, 0.0);
    }

    #[test]
    fn a_slow_loop_is_thirteen_percent_wide() {
        for name in ["paper", "pl140", "pl140-bouc-wen"] {
            let plant = plant(&Spec { logged: Logged::After, ..quiet(spec(name)) });
            let y = plant.run(&sine(30.0, 0.5, 12_000)).y;
            // The third period, at zero crossings and extremes.
            let [rising, top, falling, bottom] = [8000, 9000, 10_000, 11_000].map(|i| y[i]);
            // Half a sample less the delays of driver and beam, of 2 s: 0.05 %.
            assert_close(&[(falling - rising) / (top - bottom)], &[0.13], 0.0, 1e-3);
        }
    }

    #[test]
    fn the_paper_plant_is_the_mode_behind_the_ceramic() {
        // A small signal: nearly linear, so the free oscillation after a step tells the poles of Table 2.
        let plant = plant(&spec("paper"));
        let y = plant.run(&[0.1; 4000]).y;
        let (w, zeta) = (TAU * 146.7, 0.061);
        let still = y[3999];
        for (i, y) in y.iter().enumerate().take(200) {
            let t = (i + 1) as f64 * TS; // logged after the step
            let wd = w * f64::sqrt(1.0 - zeta * zeta);
            let swing = (wd * t).cos() + zeta * w / wd * (wd * t).sin();
            assert_close(&[*y / still], &[1.0 - (-zeta * w * t).exp() * swing], 0.0, 1e-9);
        }
    }

    #[test]
    fn before_the_step_is_after_it_one_sample_later() {
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
            assert!(coarse < 1e-6, "{name}: off by {coarse:e} m");
            assert!((3.5..4.6).contains(&(coarse / fine)), "{name}: halving h divides the error by {}", coarse / fine);
        }
    }

    #[test]
    fn with_an_ideal_driver_the_inner_step_does_not_matter() {
        let mut spec = quiet(spec("paper"));
        let u = sine(30.0, 60.0, 500);
        let fine = plant(&spec).run(&u).y;
        spec.inner_steps = 1;
        assert_close(&plant(&spec).run(&u).y, &fine, 0.0, 1e-15);
    }

    #[test]
    fn a_run_that_is_split_equals_the_whole_to_the_bit() {
        for preset in PLANTS {
            let plant = plant(&(preset.spec)()).with_seed(3);
            let u = sine(31.0, 37.0, 600);
            let mut x = plant.initial();
            let mut y = plant.resume(&mut x, &u[..251]);
            y.extend(plant.resume(&mut x.clone(), &u[251..]));
            assert_eq!(y, plant.simulate(&u), "{}", preset.name);
        }
    }

    #[test]
    fn noise_depends_on_the_seed_alone() {
        let run = |seed| plant(&spec("pl140")).with_seed(seed).run(&[0.0; 100]).y;
        assert_eq!(run(1), run(1));
        assert_ne!(run(1), run(2));
        assert_eq!(run(0), plant(&spec("pl140")).run(&[0.0; 100]).y);
    }

    #[test]
    fn without_dynamics_only_the_order_of_voltages_matters() {
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
    fn every_limit_that_is_reached_is_counted() {
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
            let y = plant(&(preset.spec)()).run(&[1.0, f64::NAN, 2.0, f64::INFINITY, -1.0, f64::NEG_INFINITY]).y;
            assert_eq!(y.len(), 6);
            assert!(y[5].is_nan(), "{}: a poisoned state says so", preset.name);
        }
    }

    #[test]
    fn what_cannot_be_built_is_refused_by_its_name() {
        let refused = |change: fn(&mut Spec)| {
            let mut spec = spec("pl140");
            change(&mut spec);
            Plant::new(&spec, TS).unwrap_err().to_string()
        };
        assert!(refused(|s| s.inner_steps = 0).starts_with("inner_steps = 0"));
        assert!(refused(|s| s.driver.lag_s = -1.0).starts_with("driver.lag_s = -1"));
        assert!(refused(|s| s.creep_per_decade = f64::NAN).starts_with("creep_per_decade = NaN"));
        assert!(refused(|s| s.sensor.bits = Some(64)).starts_with("sensor.bits = 64"));
        assert!(Plant::new(&spec("pl140"), 0.0).unwrap_err().to_string().starts_with("ts = 0"));
    }
}
