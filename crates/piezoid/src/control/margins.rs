//! How far a loop is from ringing: gain and phase margin, sensitivity peak, bandwidth, poles.
//!
//! ```text
//! L = C(q) k G(q) q^-(1+d),    S = 1 / (1 + L),    Ms = max |S|
//! ```
//! q^-1 is the sample between a measurement and the voltage that answers it, d how many samples later readings come. k is the
//! slope dz/du of the hysteresis block, which differs from place to place of a loop and within minor ones; margins hold where
//! they hold for the largest. Creep adds to a slow slope at most the sum of its gains, and the largest slope here includes it.
//! Frequency responses are taken on a logarithmic grid that is finer around every mode, and where late readings turn the
//! phase; between its points L is a chord. Whether the loop is stable is asked of its poles, which have no grid.
//!
//! Reference: K. J. Astrom, R. M. Murray, Feedback Systems, 2008, ISBN 978-0-691-13576-2, chapter 9. It does not do: limit
//! cycles, the time-varying slope as such (see the circle criterion), delays of part of a sample.

use super::Controller;
use super::filters::{plus, ratio, times};
use crate::error::Error;
use crate::hammerstein::Model;
use crate::linear::Arx;
use crate::series::ends;
use crate::system::System;
use nalgebra::Complex;
use serde::Serialize;

/// Points of the grid in all, and around each mode to either side.
const POINTS: usize = 500;
const AROUND: i32 = 60;

/// Points for each sample by which readings come late: 6 degrees of its phase.
const TURN: usize = 32;

/// Share of the sampling rate up to which all must be known for nothing to lie beyond.
const KNOWN: f64 = 0.4;

/// Samples of each way on which the slope is taken.
const LEG: usize = 200;

/// What a controller sees of a model: slope, linear block, and the voltages there are.
#[derive(Debug, Clone)]
pub struct ControlLoop {
    /// The model it is of.
    pub model: Model,
    /// Smallest and largest slope dz/du, the latter with all its creep [z unit / V].
    pub slope: (f64, f64),
    /// Lowest and highest voltage [V].
    pub limits: (f64, f64),
    /// The fastest change of voltage, infinite where there is no limit [V/s]. Margins know nothing of it.
    pub slew: f64,
    /// Samples d by which readings come late, [`ControlLoop::LATEST`] at most.
    pub late: usize,
}

/// How far a loop is from ringing.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Margins {
    /// By how much the gain may grow [dB]; infinite if without end.
    pub gain_db: f64,
    /// By how much the phase may lag or lead [degrees]; infinite if |L| never is 1.
    pub phase_deg: f64,
    /// Ms, the largest |S| [-].
    pub peak: f64,
    /// Where |S| first rises above -3 dB [Hz]; 0 if it begins there.
    pub bandwidth_hz: f64,
    /// Whether every pole of the closed loop lies inside the unit circle.
    pub stable: bool,
}

impl ControlLoop {
    /// Samples by which readings may come late, at most, for a controller to be tuned.
    pub const LATEST: usize = 20;

    /// The loop of a model between the lowest and the highest voltage [V], with readings in time. The slew limit of a driver in the
    /// model is left out.
    ///
    /// # Errors
    /// Refuses limits the wrong way round.
    pub fn of(model: &Model, limits: (f64, f64)) -> Result<Self, Error> {
        super::check(&[], limits)?;
        let crept: f64 = model.creep().lags().iter().map(|lag| lag.gain.max(0.0)).sum();
        let (least, largest) = slopes(model, limits);
        let slope = (least.max(0.0), largest * (1.0 + crept));
        Ok(ControlLoop { model: model.clone(), slope, limits, slew: f64::INFINITY, late: 0 })
    }

    /// Refuses a loop that no law with a positive gain closes.
    pub(super) fn check_positive_gain(&self) -> Result<(), Error> {
        let (slope, gain) = (self.slope.1, self.linear().dc_gain());
        if slope > 0.0 && slope.is_finite() && gain > 0.0 {
            return Ok(());
        }
        let (low, high) = self.limits;
        let because = format!(
            "slope {slope} of the hysteresis times gain {gain} of the linear block is not a positive number: turn the sign of y, or \
             identify the model on records that cover {low} to {high} V"
        );
        Err(Error::Unsuited { what: "controller".into(), because })
    }

    /// The highest frequency that its model was identified at, if it is known and some lie beyond [Hz].
    pub fn known_hz(&self) -> Option<f64> {
        let [_, high] = self.model.identified()?.hz?;
        Some(high).filter(|high| *high < KNOWN / self.linear().ts())
    }

    /// What passes between a voltage and the reading that shows it, beside the linear block [s]: the sample of the loop, d more, and
    /// the lag of a driver, which delays slow signals by as much.
    pub(super) fn delay_s(&self) -> f64 {
        let lag = self.model.driver().map_or(0.0, |driver| driver.lag_s);
        (1 + self.late) as f64 * self.linear().ts() + lag
    }

    /// Its linear block, from z to y.
    pub fn linear(&self) -> &Arx {
        self.model.linear()
    }

    /// The margins under a controller, at this slope [z unit / V]; `None` if its law is not linear.
    pub fn margins(&self, controller: &dyn Controller, slope: f64) -> Option<Margins> {
        let law = controller.law()?;
        let grid = grid(&[self.linear(), &law], self.late);
        let l = open(&grid, self.linear(), slope, self.delay_s())
            .zip(at(&grid, &law))
            .map(|(g, c)| g * c)
            .collect::<Vec<_>>();
        let stable = self.closed(&law, slope).is_ok_and(|t| t.is_stable());
        Some(Margins {
            gain_db: 20.0 * growths(&l).filter(|&k| k > 1.0).fold(f64::INFINITY, f64::min).log10(),
            phase_deg: phase(&l),
            peak: peak(&l),
            bandwidth_hz: bandwidth(&grid, &l),
            stable,
        })
    }

    /// |S| under a controller at this slope and these frequencies [Hz]; `None` if its law is not linear.
    pub fn sensitivity(&self, controller: &dyn Controller, slope: f64, hz: &[f64]) -> Option<Vec<f64>> {
        let law = controller.law()?;
        let l = open(hz, self.linear(), slope, self.delay_s()).zip(at(hz, &law)).map(|(g, c)| g * c);
        Some(l.map(|l| 1.0 / (1.0 + l).norm()).collect())
    }

    /// The closed loop from r to y under a linear law.
    ///
    /// # Errors
    /// Refuses what is too long for an [`Arx`].
    pub fn closed(&self, law: &Arx, slope: f64) -> Result<Arx, Error> {
        let forward = std::iter::repeat_n(0.0, 1 + self.late).chain(times(law.b(), self.linear().b()));
        let forward: Vec<f64> = forward.map(|c| slope * c).collect();
        let round = plus(&times(&law.denominator(), &self.linear().denominator()), 1.0, &forward);
        ratio(self.linear().ts(), &forward, &round)
    }
}

/// Refuses readings that come later than controllers are tuned for.
pub(super) fn check_late(late: usize) -> Result<(), Error> {
    match late <= ControlLoop::LATEST {
        true => Ok(()),
        false => Err(Error::parameter("late", late, format!("must be at most {} samples", ControlLoop::LATEST))),
    }
}

/// Smallest and largest slope of the hysteresis on a major loop and on minor ones within it. The step after a turn is left
/// out: there a two-branch operator jumps.
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

/// Frequencies [Hz] up to half the sampling rate, finer around the modes of these blocks and where readings come `late`.
pub(super) fn grid(blocks: &[&Arx], late: usize) -> Vec<f64> {
    let Some(first) = blocks.first() else { return Vec::new() };
    let nyquist = 0.5 / first.ts();
    let mut grid: Vec<f64> =
        (0..=POINTS).map(|i| nyquist * 10f64.powf(6.0 * (i as f64 / POINTS as f64 - 1.0))).collect();
    for pole in blocks.iter().flat_map(|b| b.poles()).filter(|p| p.z.im > 0.0) {
        let width = pole.damping.abs().max(1e-4);
        grid.extend((-AROUND..=AROUND).map(|i| pole.hz * (1.0 + width * (0.075 * f64::from(i)).sinh() / 4.0)));
    }
    grid.extend((1..TURN * late).map(|i| nyquist * i as f64 / (TURN * late) as f64));
    grid.retain(|hz| *hz > 0.0 && *hz <= nyquist);
    grid.sort_by(f64::total_cmp);
    grid
}

/// k G(q), `after` [s] later.
pub(super) fn open<'a>(
    grid: &'a [f64],
    linear: &'a Arx,
    slope: f64,
    after: f64,
) -> impl Iterator<Item = Complex<f64>> + 'a {
    at(grid, linear).zip(grid).map(move |(g, hz)| g * Complex::from_polar(slope, -std::f64::consts::TAU * hz * after))
}

/// The response of a block.
pub(super) fn at<'a>(grid: &'a [f64], block: &'a Arx) -> impl Iterator<Item = Complex<f64>> + 'a {
    grid.iter().map(|&hz| {
        let response = block.response(hz);
        Complex::from_polar(response.gain, response.phase)
    })
}

/// The factors on L that would lead it through -1.
pub(super) fn growths(l: &[Complex<f64>]) -> impl Iterator<Item = f64> + '_ {
    let crossings = l.windows(2).filter(|w| (w[0].im < 0.0) != (w[1].im < 0.0)).map(|w| {
        let share = w[0].im / (w[0].im - w[1].im);
        w[0].re + share * (w[1].re - w[0].re)
    });
    crossings.chain(l.last().map(|l| l.re)).filter(|re| *re < 0.0).map(|re| -1.0 / re)
}

/// The smallest angle between L and -1 where |L| = 1 [degrees].
pub(super) fn phase(l: &[Complex<f64>]) -> f64 {
    let crossings = l.windows(2).filter(|w| (w[0].norm() < 1.0) != (w[1].norm() < 1.0));
    let angles = crossings.map(|w| {
        let (from, to) = (w[0].norm().ln(), w[1].norm().ln());
        let turned = (w[1] / w[0]).arg();
        let angle = (-w[0]).arg() + turned * from / (from - to);
        Complex::from_polar(1.0, angle).arg().abs().to_degrees()
    });
    angles.fold(f64::INFINITY, f64::min)
}

/// The largest |S|.
fn peak(l: &[Complex<f64>]) -> f64 {
    l.iter().map(|l| 1.0 / (1.0 + l).norm()).fold(0.0, f64::max)
}

/// Where |S| first rises above -3 dB [Hz].
fn bandwidth(grid: &[f64], l: &[Complex<f64>]) -> f64 {
    let s = |i: usize| -(1.0 + l[i]).norm().ln();
    let edge = -0.5 * std::f64::consts::LN_2;
    match (0..l.len()).find(|&i| s(i) >= edge) {
        None => grid.last().copied().unwrap_or(0.0),
        Some(0) => 0.0,
        Some(i) => {
            let share = (edge - s(i - 1)) / (s(i) - s(i - 1));
            (grid[i - 1].ln() + share * (grid[i] / grid[i - 1]).ln()).exp()
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::{filters, pi::Pi};
    use super::*;
    use crate::creep::Lag;
    use crate::testing::assert_close;
    use std::f64::consts::TAU;

    const TS: f64 = 5e-4;

    /// A loop of +-30 V of a model that rises by the mean of these slopes.
    pub(in super::super) fn path_of(linear: Arx, slope: (f64, f64)) -> ControlLoop {
        let rises = crate::hysteresis::Proportional::new(linear.ts(), 0.5 * (slope.0 + slope.1)).unwrap();
        let model = Model::new(std::sync::Arc::new(rises), linear, 0.0).unwrap();
        ControlLoop { model, slope, limits: (-30.0, 30.0), slew: f64::INFINITY, late: 0 }
    }

    fn path(linear: Arx) -> ControlLoop {
        path_of(linear, (1.0, 1.0))
    }

    #[test]
    fn the_margins_of_an_integral_on_a_gain_are_their_formulas() {
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
    fn the_margins_of_a_pi_on_a_resonance_are_those_of_numpy() {
        // Of five million frequencies; gain and phase by the crossings among them.
        let path = path(filters::lag(TS, 160.0, 0.03).unwrap());
        let m = path.margins(&Pi::new(TS, 0.01, 25.0, (-1.0, 1.0)).unwrap(), 1.0).unwrap();
        assert_close(&[m.gain_db, m.phase_deg, m.peak, m.bandwidth_hz], &[7.9968, 90.844, 1.771, 4.042], 2e-3, 0.0);
    }

    #[test]
    fn late_readings_cost_the_margins_that_as_much_delay_of_the_plant_does() {
        let block = filters::lag(TS, 160.0, 0.03).unwrap();
        let pi = Pi::new(TS, 0.01, 12.0, (-1.0, 1.0)).unwrap();
        let in_time = path(block.clone()).margins(&pi, 1.0).unwrap();
        for late in [1, 4, 20] {
            let delayed = Arx::new(TS, block.a().to_vec(), [vec![0.0; late], block.b().to_vec()].concat()).unwrap();
            let (late, delayed) = (ControlLoop { late, ..path(block.clone()) }, path(delayed));
            let figures = |path: &ControlLoop| {
                let m = path.margins(&pi, 1.0).unwrap();
                ([m.gain_db, m.phase_deg, m.peak, m.bandwidth_hz], m.stable)
            };
            let (told, known) = (figures(&late), figures(&delayed));
            assert_close(&told.0, &known.0, 2e-3, 0.0);
            assert!(told.1 == known.1 && told.0[1] < in_time.phase_deg - 0.3 * late.late as f64, "{told:?}");
            let hz = [1.0, 30.0, 160.0, 700.0];
            let s = |path: &ControlLoop| path.sensitivity(&pi, 1.0, &hz).unwrap();
            assert_close(&s(&late), &s(&delayed), 1e-9, 0.0);
            let law = pi.law().unwrap();
            assert_eq!(late.closed(&law, 1.0).unwrap(), delayed.closed(&law, 1.0).unwrap());
        }
    }

    #[test]
    fn gain_beyond_the_margin_makes_the_poles_leave_the_circle() {
        let path = path(filters::lag(TS, 160.0, 0.03).unwrap());
        let pi = Pi::new(TS, 0.01, 25.0, (-1.0, 1.0)).unwrap();
        let room = 10f64.powf(path.margins(&pi, 1.0).unwrap().gain_db / 20.0);
        let stable = |k: f64| path.margins(&pi, k).unwrap().stable;
        assert!(stable(0.998 * room) && !stable(1.002 * room));
    }

    #[test]
    fn slopes_are_those_of_the_operator_with_creep_on_the_largest() {
        let plays = crate::hysteresis::Operator::find("prandtl-ishlinskii").unwrap();
        let operator = (plays.example)(TS).unwrap();
        let (low, high) =
            slopes(&Model::new(operator.clone(), Arx::gain(TS, 1.0).unwrap(), 0.0).unwrap(), (-30.0, 30.0));
        // Of plays, the slope after a turn is the first weight, and at the end of the loop the sum of all.
        assert!(low > 0.0 && high > low, "{low} {high}");
        let creep = crate::creep::Creep::new(TS, vec![Lag { tau_s: 1.0, gain: 0.1 }]).unwrap();
        let model = Model::new(operator, Arx::gain(TS, 1.0).unwrap(), 0.0).unwrap().with_creep(creep).unwrap();
        let path = ControlLoop::of(&model, (-30.0, 30.0)).unwrap();
        assert_close(&[path.slope.0, path.slope.1], &[low, 1.1 * high], 1e-12, 0.0);
        let turned = Model::new((plays.example)(TS).unwrap(), Arx::gain(TS, -1.0).unwrap(), 0.0).unwrap();
        assert!(
            ControlLoop::of(&turned, (-30.0, 30.0))
                .unwrap()
                .check_positive_gain()
                .unwrap_err()
                .to_string()
                .contains("turn the sign")
        );
        assert!(ControlLoop::of(&turned, (30.0, -30.0)).is_err());
    }
}
