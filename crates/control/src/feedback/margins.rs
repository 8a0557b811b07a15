//! Stability margins of a loop: gain and phase margin, sensitivity peak, bandwidth, poles.
//!
//! ```text
//! L = C(q) k G(q) q^-(1+d),    S = 1 / (1 + L),    Ms = max |S|
//! ```
//! q^-1 is the sample between a measurement and the voltage that answers it; d is the sensor delay in samples. k is the
//! slope dz/du of the hysteresis block. It varies along a loop and in minor loops; the margins hold for all slopes if
//! they hold for the largest. Creep adds to slow slopes at most the sum of its gains; the largest slope includes it.
//! Frequency responses are computed on a logarithmic grid that is finer around every mode, and for a sensor delay at
//! high frequencies. Between its points L is interpolated linearly. Stability is checked with the poles, without a
//! grid.
//!
//! Reference: K. J. Astrom, R. M. Murray, Feedback Systems, 2008, ISBN 978-0-691-13576-2, chapter 9. It does not do:
//! limit cycles, the time-varying slope as such (see the circle criterion), delays of a fraction of a sample.
//!
//! Why: docs/decisions/control.md, "Margins hold at the largest slope and with detuned modes".

use super::Controller;
use super::filters::{plus, ratio, times};
use libm::{exp, log, log10, pow, sinh};
use nalgebra::Complex;
use piezoid_models::hammerstein::Model;
use piezoid_models::linear::Arx;
use piezoid_numerics::complex::{argument, modulus, polar};
use piezoid_numerics::error::Error;
use piezoid_numerics::series::ends;
use piezoid_numerics::system::System;
use serde::Serialize;

/// Number of grid points, and of points on each side of a mode.
const POINTS: usize = 500;
const AROUND: i32 = 60;

/// Grid points per sample of sensor delay: 6 degrees of its phase.
const TURN: usize = 32;

/// Share of the sampling rate above which a model counts as known at all frequencies.
const FULL_BAND_RATE_SHARE: f64 = 0.4;

/// Samples of each ramp on which the slope is computed.
const LEG: usize = 200;

/// A model as a controller sees it: slopes, linear block, voltage limits.
#[derive(Debug, Clone)]
pub struct ControlLoop {
    /// The model.
    pub model: Model,
    /// Smallest and largest slope dz/du; the largest includes all creep [z unit / V].
    pub slope: (f64, f64),
    /// Lowest and highest voltage [V].
    pub limits: (f64, f64),
    /// Largest rate of the voltage, infinite for no limit [V/s]. The margins do not depend on it.
    pub slew: f64,
    /// Sensor delay d [samples], at most [`ControlLoop::MAX_DELAY_SAMPLES`].
    pub delay_samples: usize,
}

/// Stability margins of a loop.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Margins {
    /// Gain margin [dB]; infinite if there is no limit.
    pub gain_db: f64,
    /// Phase margin in both directions [degrees]; infinite if |L| is never 1.
    pub phase_deg: f64,
    /// Ms, the largest |S| [-].
    pub peak: f64,
    /// Lowest frequency with |S| = -3 dB [Hz]; 0 if |S| is larger from the start.
    pub bandwidth_hz: f64,
    /// True if every pole of the closed loop lies inside the unit circle.
    pub stable: bool,
}

impl ControlLoop {
    /// Largest sensor delay for which controllers are tuned [samples].
    pub const MAX_DELAY_SAMPLES: usize = 20;

    /// The loop of a model between the lowest and the highest voltage [V], without sensor delay. A slew limit of the
    /// driver in the model is ignored.
    ///
    /// # Errors
    /// Returns an error for limits in the wrong order.
    pub fn of(model: &Model, limits: (f64, f64)) -> Result<Self, Error> {
        super::check(&[], limits)?;
        let crept: f64 = model.creep().lags().iter().map(|lag| lag.gain.max(0.0)).sum();
        let (least, largest) = slopes(model, limits);
        let slope = (least.max(0.0), largest * (1.0 + crept));
        Ok(ControlLoop { model: model.clone(), slope, limits, slew: f64::INFINITY, delay_samples: 0 })
    }

    /// Returns an error if the gain of the loop is not positive.
    pub fn check_positive_gain(&self) -> Result<(), Error> {
        let (slope, gain) = (self.slope.1, self.linear().dc_gain());
        if slope > 0.0 && slope.is_finite() && gain > 0.0 {
            return Ok(());
        }
        let (low, high) = self.limits;
        let because = format!(
            "slope {slope} of the hysteresis times gain {gain} of the linear block must be positive: change the sign \
            of y, or identify the model on records that cover {low} to {high} V"
        );
        Err(Error::Unsuited { what: "controller".into(), because })
    }

    /// The highest frequency of the identification data, if the model covers only a part of the frequencies [Hz].
    pub(crate) fn known_hz(&self) -> Option<f64> {
        let [_, high] = self.model.identified()?.hz?;
        Some(high).filter(|high| *high < FULL_BAND_RATE_SHARE / self.linear().ts())
    }

    /// Delay from a voltage to its measurement, without the linear block [s]: one sample of the loop, the sensor delay
    /// d, and the lag of a driver, which delays slow signals by its time constant.
    pub(super) fn delay_s(&self) -> f64 {
        let lag = self.model.driver().map_or(0.0, |driver| driver.lag_s);
        (1 + self.delay_samples) as f64 * self.linear().ts() + lag
    }

    /// The linear block, from z to y.
    pub fn linear(&self) -> &Arx {
        self.model.linear()
    }

    /// The margins with a controller, at this slope [z unit / V]; `None` if its law is not linear.
    pub(crate) fn margins(&self, controller: &dyn Controller, slope: f64) -> Option<Margins> {
        let law = controller.law()?;
        let grid = grid(&[self.linear(), &law], self.delay_samples);
        let l: Vec<_> = self.opened(&grid, &law, slope).collect();
        let stable = self.closed(&law, slope).is_ok_and(|t| t.is_stable());
        Some(Margins {
            gain_db: 20.0 * log10(growths(&l).filter(|&k| k > 1.0).fold(f64::INFINITY, f64::min)),
            phase_deg: phase(&l),
            peak: peak(&l),
            bandwidth_hz: bandwidth(&grid, &l),
            stable,
        })
    }

    /// |S| with a controller at this slope and these frequencies [Hz]; `None` if its law is not linear.
    pub(crate) fn sensitivity(&self, controller: &dyn Controller, slope: f64, hz: &[f64]) -> Option<Vec<f64>> {
        let law = controller.law()?;
        Some(self.opened(hz, &law, slope).map(|l| 1.0 / modulus(1.0 + l)).collect())
    }

    /// L with a linear law.
    fn opened<'a>(&'a self, grid: &'a [f64], law: &'a Arx, slope: f64) -> impl Iterator<Item = Complex<f64>> + 'a {
        open(grid, self.linear(), slope, self.delay_s()).zip(at(grid, law)).map(|(g, c)| g * c)
    }

    /// The closed loop from r to y with a linear law.
    ///
    /// # Errors
    /// Returns an error if it is too long for an [`Arx`].
    pub fn closed(&self, law: &Arx, slope: f64) -> Result<Arx, Error> {
        let forward = std::iter::repeat_n(0.0, 1 + self.delay_samples).chain(times(law.b(), self.linear().b()));
        let forward: Vec<f64> = forward.map(|c| slope * c).collect();
        let round = plus(&times(&law.denominator(), &self.linear().denominator()), 1.0, &forward);
        ratio(self.linear().ts(), &forward, &round)
    }
}

/// Returns an error for a sensor delay that is too long for tuning.
pub(super) fn check_delay(delay_samples: usize) -> Result<(), Error> {
    if delay_samples <= ControlLoop::MAX_DELAY_SAMPLES {
        return Ok(());
    }
    let rule = format!("must be at most {} samples", ControlLoop::MAX_DELAY_SAMPLES);
    Err(Error::parameter("delay_samples", delay_samples, rule))
}

/// Smallest and largest slope of the hysteresis on a major loop and on minor loops. The step after a reversal is
/// omitted, because a two-branch operator jumps there.
fn slopes(model: &Model, (low, high): (f64, f64)) -> (f64, f64) {
    let at = |share: f64| low + share * (high - low);
    let turns = [0.0, 1.0, 0.0, 0.75, 0.25, 0.5, 0.4, 1.0, 0.6, 0.9, 0.0].map(at);
    let operator = model.hysteresis();
    let mut x = operator.settled(low);
    ends(turns.windows(2).flat_map(|way| {
        let h = (way[1] - way[0]) / LEG as f64;
        let u: Vec<f64> = (1..=LEG).map(|t| way[0] + h * t as f64).collect();
        let z = operator.resume(&mut x, &u);
        z.windows(2).skip(1).map(|w| (w[1] - w[0]) / h).collect::<Vec<_>>()
    }))
}

/// Frequencies [Hz] up to half the sampling rate, finer around the modes of the blocks and for a sensor delay of
/// `delay_samples` samples.
pub(super) fn grid(blocks: &[&Arx], delay_samples: usize) -> Vec<f64> {
    let Some(first) = blocks.first() else { return Vec::new() };
    let nyquist = 0.5 / first.ts();
    let mut grid: Vec<f64> =
        (0..=POINTS).map(|i| nyquist * pow(10.0, 6.0 * (i as f64 / POINTS as f64 - 1.0))).collect();
    for pole in blocks.iter().flat_map(|b| b.poles()).filter(|p| p.z.im > 0.0) {
        let width = pole.damping.abs().max(1e-4);
        grid.extend((-AROUND..=AROUND).map(|i| pole.hz * (1.0 + width * sinh(0.075 * f64::from(i)) / 4.0)));
    }
    grid.extend((1..TURN * delay_samples).map(|i| nyquist * i as f64 / (TURN * delay_samples) as f64));
    grid.retain(|hz| *hz > 0.0 && *hz <= nyquist);
    grid.sort_by(f64::total_cmp);
    grid
}

/// k G(q), delayed by `after` [s].
pub(super) fn open<'a>(
    grid: &'a [f64],
    linear: &'a Arx,
    slope: f64,
    after: f64,
) -> impl Iterator<Item = Complex<f64>> + 'a {
    at(grid, linear).zip(grid).map(move |(g, hz)| g * polar(slope, -std::f64::consts::TAU * hz * after))
}

/// The response of a block.
pub(super) fn at<'a>(grid: &'a [f64], block: &'a Arx) -> impl Iterator<Item = Complex<f64>> + 'a {
    grid.iter().map(|&hz| {
        let response = block.response(hz);
        polar(response.gain, response.phase)
    })
}

/// The factors on L for which it passes through -1.
pub(super) fn growths(l: &[Complex<f64>]) -> impl Iterator<Item = f64> + '_ {
    let crossings = l.windows(2).filter(|w| (w[0].im < 0.0) != (w[1].im < 0.0)).map(|w| {
        let share = w[0].im / (w[0].im - w[1].im);
        w[0].re + share * (w[1].re - w[0].re)
    });
    crossings.chain(l.last().map(|l| l.re)).filter(|re| *re < 0.0).map(|re| -1.0 / re)
}

/// The smallest angle between L and -1 where |L| = 1 [degrees].
pub(super) fn phase(l: &[Complex<f64>]) -> f64 {
    let crossings = l.windows(2).filter(|w| (modulus(w[0]) < 1.0) != (modulus(w[1]) < 1.0));
    let angles = crossings.map(|w| {
        let (from, to) = (log(modulus(w[0])), log(modulus(w[1])));
        let turned = argument(w[1] / w[0]);
        let angle = argument(-w[0]) + turned * from / (from - to);
        argument(polar(1.0, angle)).abs().to_degrees()
    });
    angles.fold(f64::INFINITY, f64::min)
}

/// The largest |S|.
fn peak(l: &[Complex<f64>]) -> f64 {
    l.iter().map(|l| 1.0 / modulus(1.0 + l)).fold(0.0, f64::max)
}

/// The lowest frequency with |S| = -3 dB [Hz].
fn bandwidth(grid: &[f64], l: &[Complex<f64>]) -> f64 {
    let s = |i: usize| -log(modulus(1.0 + l[i]));
    let edge = -0.5 * std::f64::consts::LN_2;
    match (0..l.len()).find(|&i| s(i) >= edge) {
        None => grid.last().copied().unwrap_or(0.0),
        Some(0) => 0.0,
        Some(i) => {
            let share = (edge - s(i - 1)) / (s(i) - s(i - 1));
            exp(log(grid[i - 1]) + share * log(grid[i] / grid[i - 1]))
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::{filters, pi::Pi};
    use super::*;
    use piezoid_models::creep::Lag;
    use piezoid_models::driver::DriverModel;
    use piezoid_models::hammerstein::Domain;
    use piezoid_models::hysteresis::Proportional;
    use piezoid_testing::assert_close;
    use std::f64::consts::TAU;

    const TS: f64 = 5e-4;

    /// A loop of +-30 V with these slopes; the slope of its model is their mean.
    pub(in super::super) fn path_of(linear: Arx, slope: (f64, f64)) -> ControlLoop {
        let rises = Proportional::new(linear.ts(), 0.5 * (slope.0 + slope.1)).unwrap();
        let model = Model::new(std::sync::Arc::new(rises), linear, 0.0).unwrap();
        ControlLoop { model, slope, limits: (-30.0, 30.0), slew: f64::INFINITY, delay_samples: 0 }
    }

    fn path(linear: Arx) -> ControlLoop {
        path_of(linear, (1.0, 1.0))
    }

    #[test]
    fn the_margins_of_an_integral_on_a_gain_match_their_formulas() {
        // L = K / (exp(j w) - 1), S = (exp(j w) - 1) / (exp(j w) - 1 + K).
        let path = path(Arx::gain(TS, 1.0).unwrap());
        for k in [0.1, 0.5, 1.0] {
            let m = path.margins(&Pi::new(TS, 0.0, k / TS, (-1.0, 1.0)).unwrap(), 1.0).unwrap();
            let gain = 20.0 * (2.0 / k).log10();
            let phase = 90.0 - (0.5 * k).asin().to_degrees();
            assert_close(&[m.gain_db, m.phase_deg, m.peak], &[gain, phase, 2.0 / (2.0 - k)], 1e-3, 0.0);
            assert!(m.stable);
        }
        let m = path.margins(&Pi::new(TS, 0.0, 1.0 / TS, (-1.0, 1.0)).unwrap(), 1.0).unwrap();
        assert_close(&[m.bandwidth_hz], &[2.0 * (0.5 * 0.5f64.sqrt()).asin() / (TAU * TS)], 1e-3, 0.0);
        assert!(!path.margins(&Pi::new(TS, 0.0, 2.1 / TS, (-1.0, 1.0)).unwrap(), 1.0).unwrap().stable);
    }

    #[test]
    fn the_margins_of_a_pi_on_a_resonance_match_numpy() {
        // From five million frequencies; gain and phase at the crossings.
        let path = path(filters::lag(TS, 160.0, 0.03).unwrap());
        let m = path.margins(&Pi::new(TS, 0.01, 25.0, (-1.0, 1.0)).unwrap(), 1.0).unwrap();
        assert_close(&[m.gain_db, m.phase_deg, m.peak, m.bandwidth_hz], &[7.9968, 90.844, 1.771, 4.042], 2e-3, 0.0);
    }

    #[test]
    fn a_sensor_delay_changes_the_margins_as_a_delay_of_the_plant() {
        let block = filters::lag(TS, 160.0, 0.03).unwrap();
        let pi = Pi::new(TS, 0.01, 12.0, (-1.0, 1.0)).unwrap();
        let in_time = path(block.clone()).margins(&pi, 1.0).unwrap();
        for delay_samples in [1, 4, 20] {
            let delayed =
                Arx::new(TS, block.a().to_vec(), [vec![0.0; delay_samples], block.b().to_vec()].concat()).unwrap();
            let (sensor, plant) = (ControlLoop { delay_samples, ..path(block.clone()) }, path(delayed));
            let figures = |path: &ControlLoop| {
                let m = path.margins(&pi, 1.0).unwrap();
                ([m.gain_db, m.phase_deg, m.peak, m.bandwidth_hz], m.stable)
            };
            let (of_sensor, of_plant) = (figures(&sensor), figures(&plant));
            assert_close(&of_sensor.0, &of_plant.0, 2e-3, 0.0);
            assert!(
                of_sensor.1 == of_plant.1 && of_sensor.0[1] < in_time.phase_deg - 0.3 * sensor.delay_samples as f64,
                "{of_sensor:?}"
            );
            let hz = [1.0, 30.0, 160.0, 700.0];
            let s = |path: &ControlLoop| path.sensitivity(&pi, 1.0, &hz).unwrap();
            assert_close(&s(&sensor), &s(&plant), 1e-9, 0.0);
            let law = pi.law().unwrap();
            let closed = sensor.closed(&law, 1.0).unwrap();
            assert_eq!(closed, plant.closed(&law, 1.0).unwrap());
            // S = 1 - T.
            let from_closed: Vec<f64> = at(&hz, &closed).map(|t| modulus(1.0 - t)).collect();
            assert_close(&s(&sensor), &from_closed, 1e-9, 0.0);
        }
    }

    #[test]
    fn a_gain_above_the_margin_is_unstable() {
        let path = path(filters::lag(TS, 160.0, 0.03).unwrap());
        let pi = Pi::new(TS, 0.01, 25.0, (-1.0, 1.0)).unwrap();
        let margin = 10f64.powf(path.margins(&pi, 1.0).unwrap().gain_db / 20.0);
        let stable = |k: f64| path.margins(&pi, k).unwrap().stable;
        assert!(stable(0.998 * margin) && !stable(1.002 * margin));
    }

    #[test]
    fn slopes_are_those_of_the_operator_with_creep_in_the_largest() {
        let plays = piezoid_models::hysteresis::Operator::find("prandtl-ishlinskii").unwrap();
        let operator = (plays.example)(TS).unwrap();
        let (low, high) =
            slopes(&Model::new(operator.clone(), Arx::gain(TS, 1.0).unwrap(), 0.0).unwrap(), (-30.0, 30.0));
        // For plays the slope after a reversal is the first weight, and the slope at the end of the loop is the sum of
        // all.
        assert!(low > 0.0 && high > low, "{low} {high}");
        let creep = piezoid_models::creep::Creep::new(TS, vec![Lag { tau_s: 1.0, gain: 0.1 }]).unwrap();
        let model = Model::new(operator, Arx::gain(TS, 1.0).unwrap(), 0.0).unwrap().with_creep(creep).unwrap();
        let path = ControlLoop::of(&model, (-30.0, 30.0)).unwrap();
        assert_close(&[path.slope.0, path.slope.1], &[low, 1.1 * high], 1e-12, 0.0);
        let inverted = Model::new((plays.example)(TS).unwrap(), Arx::gain(TS, -1.0).unwrap(), 0.0).unwrap();
        let message = ControlLoop::of(&inverted, (-30.0, 30.0)).unwrap().check_positive_gain().unwrap_err().to_string();
        assert!(message.contains("change the sign"), "{message}");
        assert!(ControlLoop::of(&inverted, (30.0, -30.0)).is_err());
    }

    #[test]
    fn a_loop_without_a_positive_gain_is_refused() {
        let checked = |b: Vec<f64>, slope: f64| {
            let path = path_of(Arx::new(TS, vec![0.5], b).unwrap(), (0.0, slope));
            path.check_positive_gain().map_err(|error| error.to_string())
        };
        assert_eq!(checked(vec![1.0, 1.0], 2.0), Ok(()));
        for refused in [checked(vec![1.0, 1.0], 0.0), checked(vec![1.0, -1.0], 2.0)] {
            let message = refused.unwrap_err();
            assert!(message.contains("must be positive") && message.contains("cover -30 to 30 V"), "{message}");
        }
    }

    #[test]
    fn a_model_is_known_at_all_frequencies_from_a_share_of_the_sampling_rate_on() {
        let slow = path(Arx::gain(TS, 1.0).unwrap());
        let known = |hz: f64| {
            let domain = Domain { u: [-30.0, 30.0], hz: Some([1.0, hz]), slew: 1e3, mean: [0.0, 0.0] };
            ControlLoop { model: slow.model.clone().with_identified(domain), ..slow.clone() }.known_hz()
        };
        let share = FULL_BAND_RATE_SHARE / TS;
        assert_eq!([known(0.99 * share), known(share)], [Some(0.99 * share), None]);
    }

    #[test]
    fn the_delay_of_a_loop_is_that_of_its_sample_the_sensor_and_the_driver() {
        let rises = Proportional::new(TS / DriverModel::SUBSTEPS as f64, 1.0).unwrap();
        let driver = DriverModel::new(1e-4, None).unwrap();
        let linear = Arx::gain(TS, 1.0).unwrap();
        let model = Model::from_blocks(Some(driver), std::sync::Arc::new(rises), linear.clone(), 0.0).unwrap();
        let path = ControlLoop { model, delay_samples: 2, ..path(linear) };
        assert_close(&[path.delay_s()], &[3.0 * TS + 1e-4], 1e-12, 0.0);
    }

    #[test]
    fn the_grid_is_finer_around_a_mode_and_for_a_delay_and_ends_at_half_the_sampling_rate() {
        let of = |block: &Arx, delay_samples| grid(&[block], delay_samples);
        let (plain, mode) = (Arx::new(TS, vec![0.5], vec![0.5]).unwrap(), filters::lag(TS, 160.0, 0.03).unwrap());
        let (alone, around, delayed) = (of(&plain, 0), of(&mode, 0), of(&plain, 2));
        assert_eq!([alone.len(), around.len(), delayed.len()], [501, 501 + 121, 501 + 63]);
        assert_close(&[around[0], around[621]], &[1e-3, 1e3], 1e-12, 0.0);
        // 160 (1 +- 0.03 sinh(4.5) / 4), and the mode itself.
        for hz in [105.99639, 160.0, 214.00361] {
            assert!(around.iter().any(|found| (found - hz).abs() < 1e-4), "{hz}");
        }
        let widest = |grid: &[f64]| grid.windows(2).fold(0.0, |most: f64, w| most.max(w[1] - w[0]));
        assert!(widest(&alone) > 25.0 && widest(&delayed) < 1000.0 / 64.0 + 1e-9);
        // A wide mode at high frequencies.
        let wide = of(&filters::lag(TS, 900.0, 0.9).unwrap(), 1);
        assert!(wide.windows(2).all(|w| 0.0 < w[0] && w[0] <= w[1] && w[1] <= 1000.0));
    }

    #[test]
    fn crossings_are_found_on_lines_between_points_and_in_points() {
        let l = [(-2.0, -1.0), (-4.0, 3.0), (-1.0, 0.0), (-0.5, -2.0), (0.5, 0.0)].map(|(re, im)| Complex::new(re, im));
        // At -2.5, a quarter of the way, and in the third point; the curve ends to the right.
        assert_eq!(growths(&l).collect::<Vec<_>>(), [0.4, 1.0]);
        assert_eq!(growths(&[Complex::new(-0.25, -1.0)]).collect::<Vec<_>>(), [4.0]);
        assert_eq!(growths(&[Complex::new(0.0, -1.0)]).count(), 0);

        let down = [2.0, 1.0, 0.5].map(|modulus| Complex::new(0.0, -modulus));
        let up = [0.5, 1.0, 2.0].map(|modulus| Complex::new(0.0, -modulus));
        let at = |modulus: f64, degrees: f64| polar(modulus, degrees.to_radians());
        let (turned, across) = ([at(4.0, -90.0), at(0.5, -150.0)], [at(2.0, 170.0), at(0.5, -170.0)]);
        // |L| falls from 4 to 1 in two thirds of the way, by 40 degrees.
        let found = [phase(&down), phase(&up), phase(&turned), phase(&across)];
        assert_close(&found, &[90.0, 90.0, 50.0, 0.0], 0.0, 1e-9);
        assert_eq!([phase(&down[..2]), phase(&up[..1])], [f64::INFINITY; 2]);
    }

    #[test]
    fn the_bandwidth_is_where_s_reaches_minus_3_db_between_the_points() {
        // |S| rises from a quarter to 1, 12 dB on logarithmic scales, by 9 dB.
        let of = |l: [f64; 2]| bandwidth(&[1.0, 10.0], &l.map(Complex::from));
        assert_close(&[of([3.0, 0.0])], &[10f64.powf(0.75)], 1e-12, 0.0);
        assert_eq!([of([0.1, 3.0]), of([3.0, 3.0])], [0.0, 10.0]);
    }
}
