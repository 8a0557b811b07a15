//! The numbers of the inverse, from those of the model.

use super::taps::{Differences, Hold, REACH, TAPS, combined};
use super::{Drive, Flat, MOST_BEND, Slow};
use piezoid_models::creep::Lag;
use piezoid_models::feedback::{FeedbackDynamics, FeedbackMode, FeedbackModel, Intersample};
use piezoid_numerics::system::System;
use std::f64::consts::TAU;

/// Inputs beyond the limits that a search of the hysteresis still tries, as a share of their range.
const BEYOND: f64 = 0.1;

/// What is held, of a smooth input at the end of its sample.
const AT_END: [f64; REACH] = [0.0, 1.0, 0.0, 0.0];

/// Farthest displacement that a reference may request, over that which the limits hold: a resonance of a damping ratio
/// of 0.01 has 50 times as much. Any other would only spoil creep and hysteresis.
const FARTHEST: f64 = 50.0;

impl Flat {
    /// The inverse with this delay, at least the least one; `ends` are the lowest and highest input. `None` if the
    /// model has none: without a mode that the input or the hysteresis moves, or if the input acts on hysteresis and
    /// modes.
    pub(in super::super) fn new(model: &FeedbackModel, ends: (f64, f64), delay_samples: usize) -> Option<Self> {
        let FeedbackDynamics { intersample, modes, sensed, senses_vibration, direct, creep, .. } = model.dynamics();
        let by_input = *sensed != 0.0;
        let acts = modes.iter().any(|mode| mode.input != 0.0) || direct[0] != 0.0;
        // What moves the modes: the input, or z alone.
        let (of, direct_of): (fn(&FeedbackMode) -> f64, f64) = match (by_input, acts, senses_vibration) {
            (true, false, _) => (|mode| mode.hysteretic, direct[1]),
            (false, true, false) => (|mode| mode.input, direct[0]),
            _ => return None,
        };
        let moved = modes.iter().enumerate().filter(|(_, mode)| of(mode) != 0.0);
        let (first, mode) = moved.min_by(|a, b| a.1.hz.total_cmp(&b.1.hz))?;
        let others = || modes.iter().enumerate().filter(|(k, _)| *k != first).map(|(_, other)| other);
        let share_of = |other: &FeedbackMode| of(other) / of(mode);
        let rho = direct_of / of(mode) + others().map(share_of).sum::<f64>();
        let share = 1.0 / (1.0 + rho);

        let (ts, w) = (model.ts(), TAU * mode.hz);
        let differences = Differences::new(ts, w);
        let at = [0.0, 0.0, 1.0, 0.0, 0.0];
        let by = [at, differences.first(), differences.second(), differences.third(), differences.fourth()];
        let [m1, m2] = [2.0 * mode.damping / w, 1.0 / (w * w)];
        let vibrates = combined([(m1, by[1]), (m2, by[2])]);
        // F of q, and what the lag of another mode takes from its share of it.
        let force = combined([(share, at), (share, vibrates)]);
        let lag = |other: &FeedbackMode| {
            let [d1, d2] = [2.0 * other.damping, 1.0 / (TAU * other.hz)].map(|v| v / (TAU * other.hz));
            let fourth = (d2 * m2, by[4]);
            combined([(d1, by[1]), (d2 + d1 * m1, by[2]), (d1 * m2 + d2 * m1, by[3]), fourth]).map(|tap| share * tap)
        };
        // The sum over the other modes of such a share of their lags.
        let lags = |of: &dyn Fn(&FeedbackMode) -> f64| {
            others().fold([0.0; TAPS], |sum, other| combined([(1.0, sum), (of(other), lag(other))]))
        };
        let hold = match intersample {
            Intersample::Held => Some(Hold::new(differences, 0.0)),
            Intersample::Driven(driver) => Some(Hold::new(differences, driver.lag_s)),
            Intersample::BandLimited => None,
        };
        // The direct path follows the staircase.
        let behind = hold.map_or(0.0, |hold| hold.behind() * direct_of / of(mode));
        let moves = combined([(1.0, by[1]), (m1, by[2]), (m2, by[3])]);
        let across = combined([(1.0, at), (-rho, force), (1.0, lags(&share_of)), (share * behind, moves)]);
        let sensed_share = |other: &FeedbackMode| other.sensed * share_of(other);
        let of_others: f64 = others().map(sensed_share).sum();
        let lags_of_others = lags(&sensed_share);
        let drive = if by_input {
            let beyond = BEYOND * (ends.1 - ends.0);
            let [a, b] = [ends.0 - beyond, ends.1 + beyond].map(|u| sensed * u);
            Drive::Input {
                displacement: mode.sensed,
                force: of_others,
                z: if *senses_vibration { -mode.hysteretic * (mode.sensed + of_others) } else { 0.0 },
                between: hold.map_or(AT_END, |hold| hold.between()),
                vibration: lags_of_others,
                ends: (a.min(b), a.max(b)),
                left: hold.map_or([0.0; 2], |hold| hold.left),
            }
        } else {
            let whole = modes.iter().map(|mode| mode.hysteretic).sum::<f64>() + direct[1];
            let sensed = combined([(of_others, force), (-1.0, lags_of_others)]);
            Drive::Displacement { sensed, direct: share * (whole - mode.hysteretic * (1.0 + rho)) }
        };
        let held = hold.map_or(AT_END, |hold| if by_input { hold.voltage() } else { hold.input() });
        let slow = |lag: &Lag| {
            let leaves = -libm::expm1(-ts / lag.tau_s);
            let settled = lag.gain * (1.0 - 0.5 * leaves);
            Slow { adds: settled * leaves, leaves, settled }
        };
        let creep: Vec<Slow> = creep.iter().map(slow).collect();
        let settles = model.dynamics().creep.iter().fold(1.0, |sum, lag| sum + lag.gain);
        let creeps = settles - creep.iter().map(|lag| lag.settled).sum::<f64>();
        let held_by = |u: f64| match by_input {
            true => mode.hysteretic * settles * model.hysteresis().step(&mut model.hysteresis().initial(), sensed * u),
            false => mode.input * u,
        };
        let curve = model.dynamics().curve.abs();
        let farthest = FARTHEST * held_by(ends.0).abs().max(held_by(ends.1).abs()) / share.abs();
        let farthest = if farthest > 0.0 && farthest.is_finite() { farthest } else { f64::MAX };
        let all_are_finite =
            [share, creeps, settles].iter().chain(&across).chain(&vibrates).chain(&held).all(|v| v.is_finite());
        (all_are_finite && delay_samples >= Flat::least_delay(model)).then(|| Flat {
            model: model.clone(),
            delay_samples,
            mode: *mode,
            farthest,
            farthest_reading: (farthest * (1.0 + curve * farthest)).min(MOST_BEND / curve).min(f64::MAX),
            share,
            across,
            vibrates,
            estimates: combined([(share, vibrates)]),
            bends: if mode.softening == 0.0 { 0.0 } else { rho },
            drive,
            held,
            creep,
            creeps,
            settles,
        })
    }
}
