//! Tuning: the controller with the largest integral gain among those of a kind that meet the margins.
//!
//! ```text
//! max  k_i = lim |C(exp(j w Ts))| w  for w to 0,    over the shapes of a kind and the factor on each,
//! such that  gain margin >= gain_db  for every detuning of the modes,  and  phase margin >= phase_deg,
//! and        |C| k |G(0)| 20 <= 10^(-gain_db / 20)  above the frequencies of the identification data
//! ```
//! at the largest slope. The integral gain divides slow disturbances (hysteresis, creep, drift). L is proportional to
//! the factor and the plant is stable. Therefore the loop is stable from factor 0 up to the first factor for which L
//! passes through -1. The gain margin refers to that factor, and no further encirclements have to be counted. There may
//! be a mode at frequencies without data: a model from a 5 Hz sine alone gives a slow loop that does not excite an
//! unknown resonance.
//!
//! Reference: K. J. Astrom, H. Panagopoulos, T. Hagglund, Automatica 34, 585 (1998), DOI 10.1016/S0005-1098(98)00011-9.
//! It does not do: continuous optimisation of the shapes; they come from lists.
//!
//! Why: docs/decisions/control.md, "Margins hold at the largest slope and with detuned modes".
//! Why: docs/decisions/control.md, "Frequencies outside the training data may resonate".

use super::margins::{ControlLoop, at, check_delay, grid, growths, open, phase};
use super::{Controller, filters};
use libm::pow;
use nalgebra::Complex;
use piezoid_models::linear::Arx;
use piezoid_numerics::complex::modulus;
use piezoid_numerics::error::{Error, positive};
use piezoid_numerics::number::power;
use piezoid_numerics::system::System;
use std::f64::consts::TAU;

/// Factor between two trials of the phase margin (0.25 dB), and the number of trials.
const STEP: f64 = 0.971_627_951_577_106;
const STEPS: i32 = 200;

/// Largest gain of an unknown mode over the static gain: a damping ratio of 0.025.
const MAX_UNKNOWN_MODE_GAIN: f64 = 20.0;

/// Modes with a damping ratio below this are detuned.
const MAX_DETUNED_DAMPING: f64 = 0.3;

/// The margins that a tuned loop must have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MarginTarget {
    /// Gain margin [dB].
    pub gain_db: f64,
    /// Phase margin [degrees].
    pub phase_deg: f64,
    /// Relative deviation of the modes' frequencies from the model, in both directions [-].
    pub detuning: f64,
}

impl Default for MarginTarget {
    /// 6 dB, 45 degrees, 22 %. The tolerance of a bender is +-20 % by its data sheet. Displacement per volt takes 1.6
    /// dB and damping 1.9 dB of gain, which leaves 2.5 dB of 6. Stiffness over mass gives 22 % of frequency. 45 degrees
    /// at the crossover give |S| = 1.3.
    fn default() -> Self {
        MarginTarget { gain_db: 6.0, phase_deg: 45.0, detuning: 0.22 }
    }
}

/// The controller with the largest integral gain that meets the target. `build` makes a controller from a shape and a
/// factor; its law is proportional to the factor.
pub(super) fn strongest<S: Copy, C: Controller>(
    path: &ControlLoop,
    target: &MarginTarget,
    shapes: impl IntoIterator<Item = S>,
    build: impl Fn(S, f64) -> Result<C, Error>,
) -> Result<C, Error> {
    positive("gain_db", target.gain_db, "dB")?;
    positive("phase_deg", target.phase_deg, "degrees")?;
    if !(0.0..0.9).contains(&target.detuning) {
        return Err(Error::parameter("detuning", target.detuning, "must be from 0 to below 0.9"));
    }
    check_delay(path.delay_samples)?;
    let none = |because: &str| Error::Unsuited { what: "controller".into(), because: because.into() };
    if !path.linear().is_stable() {
        return Err(none("the linear block of the model is not stable: identify it again with another order"));
    }
    path.check_positive_gain()?;
    let plants = PlantSet::new(path, target)?;
    let mut best: Option<(f64, S, f64)> = None;
    for shape in shapes {
        let Some(law) = build(shape, 1.0)?.law() else { continue };
        let Some(factor) = plants.factor(&law, target) else { continue };
        let merit = factor * integral_gain(&law);
        if best.is_none_or(|(most, ..)| merit > most) {
            best = Some((merit, shape, factor));
        }
    }
    let (_, shape, factor) = best.ok_or_else(|| none("no gain meets the margins: choose smaller margins"))?;
    build(shape, factor)
}

/// |C| w, far below all its dynamics.
fn integral_gain(law: &Arx) -> f64 {
    let hz = 1e-6 / law.ts();
    law.response(hz).gain * TAU * hz
}

/// The plants that a law must stabilise, as responses on one grid; the nominal model is the first.
struct PlantSet {
    grid: Vec<f64>,
    /// Highest frequency of the data [Hz], and the largest possible k G above it.
    beyond: f64,
    unseen: f64,
    plants: Vec<Vec<Complex<f64>>>,
}

impl PlantSet {
    fn new(path: &ControlLoop, target: &MarginTarget) -> Result<Self, Error> {
        let d = target.detuning;
        let shifts: &[f64] = if d > 0.0 { &[0.0, -1.0, -0.67, -0.33, 0.33, 0.67, 1.0] } else { &[0.0] };
        let blocks = shifts.iter().map(|s| detuned(path.linear(), 1.0 + s * d)).collect::<Result<Vec<_>, _>>()?;
        let grid = grid(&blocks.iter().collect::<Vec<_>>(), path.delay_samples);
        let plants = blocks.iter().map(|b| open(&grid, b, path.slope.1, path.delay_s()).collect()).collect();
        let unseen = MAX_UNKNOWN_MODE_GAIN * path.slope.1 * path.linear().dc_gain();
        Ok(PlantSet { grid, beyond: path.known_hz().unwrap_or(f64::INFINITY), unseen, plants })
    }

    /// The largest factor on `law` that meets the target.
    fn factor(&self, law: &Arx, target: &MarginTarget) -> Option<f64> {
        let c: Vec<Complex<f64>> = at(&self.grid, law).collect();
        let l = |plant: &[Complex<f64>], k: f64| c.iter().zip(plant).map(|(c, g)| c * g * k).collect::<Vec<_>>();
        let first =
            self.plants.iter().flat_map(|p| growths(&l(p, 1.0)).collect::<Vec<_>>()).fold(f64::INFINITY, f64::min);
        let beyond = self.grid.iter().zip(&c).filter(|(hz, _)| **hz > self.beyond);
        let first = beyond.map(|(_, c)| 1.0 / (self.unseen * modulus(*c))).fold(first, f64::min);
        let most = first * pow(10.0, -target.gain_db / 20.0);
        let nominal = l(self.plants.first()?, most);
        // The margin is infinite if the loop is too weak for a crossover on the grid.
        let angle = |k: f64| phase(&nominal.iter().map(|l| l * k).collect::<Vec<_>>());
        let keeps = |k: f64| (target.phase_deg..f64::INFINITY).contains(&angle(k));
        let factors = (0..STEPS).map(|i| power(STEP, i));
        factors.into_iter().find(|&k| most.is_finite() && keeps(k)).map(|k| k * most)
    }
}

/// The block with every lightly damped mode at `share` of its frequency, with the same damping ratios and static gain.
pub(super) fn detuned(block: &Arx, share: f64) -> Result<Arx, Error> {
    let ts = block.ts();
    let mut denominator = vec![1.0];
    for pole in block.poles() {
        let rings = pole.z.im > 0.0 && pole.damping < MAX_DETUNED_DAMPING;
        // A mode is kept below half the sampling rate.
        let hz = if rings { (share * pole.hz).min((0.49 / ts).max(pole.hz)) } else { pole.hz };
        let factor = match pole.z.im > 0.0 {
            true if rings => filters::pair(ts, hz, pole.damping).to_vec(),
            true => vec![1.0, -2.0 * pole.z.re, pole.z.modulus().powi(2)],
            false => vec![1.0, -pole.z.re],
        };
        denominator = filters::times(&denominator, &factor);
    }
    let gain = denominator.iter().sum::<f64>() / block.denominator().iter().sum::<f64>();
    let numerator: Vec<f64> = block.b().iter().map(|b| gain * b).collect();
    filters::ratio(ts, &numerator, &denominator)
}

/// `n` numbers from `low` to `high`, equally spaced in their logarithms.
pub(super) fn spread(low: f64, high: f64, n: usize) -> impl Iterator<Item = f64> + Clone {
    (0..n).map(move |i| low * pow(high / low, i as f64 / (n - 1).max(1) as f64))
}

/// Natural frequency [Hz] and damping ratio of the lightly damped modes, the least damped first.
pub(super) fn modes(block: &Arx) -> Vec<(f64, f64)> {
    let mut modes: Vec<(f64, f64)> = block
        .poles()
        .iter()
        .filter(|p| p.z.im > 0.0 && p.damping < MAX_DETUNED_DAMPING)
        .map(|p| (p.hz, p.damping))
        .collect();
    modes.sort_by(|a, b| a.1.total_cmp(&b.1));
    modes
}

#[cfg(test)]
mod tests {
    use super::super::margins::tests::path_of;
    use super::super::pi::Pi;
    use super::super::{CONTROLLERS, ClosedLoop, ControllerKind};
    use super::*;
    use piezoid_models::hammerstein::Domain;
    use piezoid_testing::assert_close;

    use std::sync::Arc;

    const TS: f64 = 5e-4;

    /// A bender with two modes and slopes from 30 to 40 um / V.
    fn bender() -> ControlLoop {
        let p = filters::times(&filters::pair(TS, 160.0, 0.03), &filters::pair(TS, 900.0, 0.03));
        let gain = p.iter().sum::<f64>();
        let linear = filters::ratio(TS, &[0.0, 0.6 * gain, 0.4 * gain], &p).unwrap();
        path_of(linear, (30.0, 40.0))
    }

    /// The tuned controllers with a linear law.
    fn lawful(path: &ControlLoop) -> impl Iterator<Item = (&'static ControllerKind, Arc<dyn Controller>, Arx)> {
        let tuned = CONTROLLERS.iter().map(|kind| (kind, (kind.tune)(path, &MarginTarget::default()).unwrap()));
        tuned.filter_map(|(kind, controller)| controller.law().map(|law| (kind, controller, law)))
    }

    #[test]
    fn every_controller_keeps_its_margins_with_every_mode_detuned() {
        for delay_samples in [0, 3] {
            let path = ControlLoop { delay_samples, ..bender() };
            for (kind, controller, law) in lawful(&path) {
                let (m, name) = (path.margins(&*controller, path.slope.1).unwrap(), kind.name);
                let keeps = m.stable && m.gain_db > 5.9 && m.phase_deg > 44.5 && m.bandwidth_hz > 1.0;
                assert!(keeps, "{name}, delay = {delay_samples}: {m:?}");
                for share in [0.78, 0.9, 1.1, 1.22] {
                    let other =
                        ControlLoop { delay_samples, ..path_of(detuned(path.linear(), share).unwrap(), path.slope) };
                    let loud = other.closed(&law, 1.95 * path.slope.1).unwrap();
                    assert!(loud.is_stable(), "{name} with modes at {share}, delay = {delay_samples}");
                }
            }
        }
    }

    #[test]
    fn the_loop_is_stable_with_a_delay_of_the_phase_margin() {
        let path = bender();
        for (_, controller, law) in lawful(&path) {
            // The last crossover of |L| = 1 gives the smallest delay that a margin allows.
            let grid = grid(&[path.linear(), &law], 0);
            let plant = open(&grid, path.linear(), path.slope.1, path.delay_s());
            let l: Vec<_> = plant.zip(at(&grid, &law)).map(|(g, c)| g * c).collect();
            let last = grid[l.iter().rposition(|l| modulus(*l) >= 1.0).unwrap()];
            let samples = (45.0 / 360.0 / last / TS).floor() as usize;
            let b: Vec<f64> = path.linear().b().iter().map(|b| b * path.slope.1).collect();
            let plant = Arx::new(TS, path.linear().a().to_vec(), [vec![0.0; samples], b].concat()).unwrap();
            let y = ClosedLoop::new(&[100.0; 20_000], &[0.0; 20_000], path.limits).run(&plant, &*controller).unwrap().y;
            assert_close(&[y[19_000], y[19_999]], &[100.0; 2], 1e-3, 0.0);
        }
    }

    #[test]
    fn notches_and_damping_allow_larger_gains_than_a_pi() {
        let path = bender();
        let gain = |name| {
            let tune = super::super::ControllerKind::find(name).unwrap().tune;
            integral_gain(&tune(&path, &MarginTarget::default()).unwrap().law().unwrap())
        };
        let pi = gain("pi");
        assert!(gain("integral-notch") > 1.5 * pi && gain("positive-position") > 1.5 * pi, "{pi}");
    }

    #[test]
    fn a_model_of_slow_motion_gives_a_loop_that_is_stable_with_an_unknown_resonance() {
        // The model is a gain identified up to 5 Hz; the plant has a mode at 160 Hz.
        let slow = path_of(Arx::gain(TS, 0.9).unwrap(), (30.0, 40.0));
        let known = Domain { u: [-30.0, 30.0], hz: Some([5.0, 5.0]), slew: 1e3, mean: [0.0, 0.0] };
        let observed = ControlLoop { model: slow.model.clone().with_identified(known), ..slow.clone() };
        let truth = path_of(filters::lag(TS, 160.0, 0.03).unwrap(), (30.0, 40.0));
        let stable = |path: &ControlLoop| {
            let tuned = CONTROLLERS.iter().filter_map(|kind| (kind.tune)(path, &MarginTarget::default()).ok()?.law());
            tuned.map(|law| truth.closed(&law, 36.0).unwrap().is_stable()).collect::<Vec<bool>>()
        };
        assert!(observed.known_hz() == Some(5.0) && slow.known_hz().is_none());
        assert!(
            stable(&observed).len() >= 3 && stable(&observed).iter().all(|s| *s) && stable(&slow).iter().any(|s| !*s)
        );
        let predictive = super::super::ControllerKind::find("predictive").unwrap().tune;
        let refused = predictive(&observed, &MarginTarget::default()).unwrap_err().to_string();
        assert!(refused.contains("identified up to 5") && refused.contains("PRBS"), "{refused}");
    }

    #[test]
    fn a_detuned_block_has_its_modes_at_the_requested_frequencies() {
        let block = bender().linear().clone();
        let lower = detuned(&block, 0.8).unwrap();
        let hz: Vec<f64> = lower.poles().iter().map(|p| p.hz).collect();
        assert_close(&hz, &[128.0, 720.0], 1e-6, 0.0);
        assert_close(&[lower.dc_gain()], &[block.dc_gain()], 1e-9, 0.0);
        assert_close(detuned(&block, 1.0).unwrap().a(), block.a(), 1e-9, 1e-12);
    }

    #[test]
    fn targets_and_blocks_without_a_controller_are_errors() {
        let pi = super::super::ControllerKind::find("pi").unwrap().tune;
        let wrong = MarginTarget { phase_deg: 0.0, ..Default::default() };
        assert!(pi(&bender(), &wrong).unwrap_err().to_string().starts_with("phase_deg = 0"));
        let unstable = path_of(Arx::new(TS, vec![1.01], vec![0.1]).unwrap(), (30.0, 40.0));
        assert!(pi(&unstable, &MarginTarget::default()).unwrap_err().to_string().contains("not stable"));
        let too_long = ControlLoop { delay_samples: 21, ..bender() };
        assert!(
            pi(&too_long, &MarginTarget::default())
                .unwrap_err()
                .to_string()
                .starts_with("delay_samples = 21: must be at most 20")
        );
        let steep = MarginTarget { phase_deg: 179.0, ..Default::default() };
        assert!(pi(&bender(), &steep).unwrap_err().to_string().contains("no gain meets the margins"));
    }

    #[test]
    fn the_integral_gain_is_that_of_the_integral() {
        let law = Pi::new(TS, 0.2, 30.0, (-1.0, 1.0)).unwrap().law().unwrap();
        assert_close(&[integral_gain(&law)], &[30.0], 1e-5, 0.0);
    }

    #[test]
    fn only_lightly_damped_modes_are_detuned_and_only_below_half_the_sampling_rate() {
        let modes_of = [(160.0, 0.05), (300.0, 0.5), (900.0, 0.02)].map(|(hz, damping)| filters::pair(TS, hz, damping));
        let p = modes_of.iter().fold(vec![1.0, -0.9], |p, pair| filters::times(&p, pair));
        let block = filters::ratio(TS, &[1.0], &p).unwrap();
        let found: Vec<f64> = modes(&block).into_iter().flat_map(|(hz, damping)| [hz, damping]).collect();
        assert_close(&found, &[900.0, 0.02, 160.0, 0.05], 1e-6, 0.0);
        let hz = |block: &Arx, share| detuned(block, share).unwrap().poles().iter().map(|p| p.hz).collect::<Vec<_>>();
        // The real pole stays; the last mode would come to 1098 Hz.
        let real = (1.0f64 / 0.9).ln() / (TAU * TS);
        assert_close(&hz(&block, 1.22), &[real, 195.2, 300.0, 980.0], 1e-6, 0.0);
        assert_close(&hz(&filters::lag(TS, 990.0, 0.02).unwrap(), 1.1), &[990.0], 1e-6, 0.0);
    }

    #[test]
    fn above_the_frequencies_of_the_data_the_gain_leaves_the_margin_to_an_unknown_mode() {
        let slow = path_of(Arx::gain(TS, 0.9).unwrap(), (30.0, 40.0));
        let known = Domain { u: [-30.0, 30.0], hz: Some([5.0, 5.0]), slew: 1e3, mean: [0.0, 0.0] };
        let observed = ControlLoop { model: slow.model.clone().with_identified(known), ..slow };
        let pi = super::super::ControllerKind::find("pi").unwrap().tune;
        let law = pi(&observed, &MarginTarget::default()).unwrap().law().unwrap();
        // 20 times the slope 40 and the gain 0.9, at -6 dB at the first frequency above 5 Hz, up to 3 % higher.
        assert_close(&[20.0 * 40.0 * 0.9 * law.response(5.0).gain], &[10f64.powf(-0.3)], 0.03, 0.0);
    }

    #[test]
    fn without_a_mode_the_resonator_lies_about_a_twentieth_of_the_sampling_rate() {
        let tune = super::super::ControllerKind::find("positive-position").unwrap().tune;
        let path = path_of(Arx::gain(TS, 0.9).unwrap(), (30.0, 40.0));
        let law = tune(&path, &MarginTarget::default()).unwrap().law().unwrap();
        // From 0.4 to 2 times 100 Hz, besides the integral.
        let poles: Vec<f64> = law.poles().iter().map(|pole| pole.hz).filter(|hz| *hz > 1e-3).collect();
        assert!(!poles.is_empty() && poles.iter().all(|hz| (39.9..200.1).contains(hz)), "{poles:?}");
    }
}
