//! The state of the estimator as named parts of a vector, in the order of its program.

use super::factor::take;
use piezoid_models::hammerstein::Model;
use piezoid_numerics::system::System;

/// Lengths of the parts.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Layout {
    hidden: usize,
    pub(super) groups: usize,
    /// Lags of creep.
    pub(super) lags: usize,
    /// Past inputs of the linear block.
    pub(super) taps: usize,
    /// Past outputs of the linear block.
    pub(super) past: usize,
    /// Past values of the filtered signals, input then output; 0 if the linear block stands still.
    pub(super) filtered: [usize; 2],
    /// States of the estimators: weights, linear block, gain.
    pub(super) fits: [usize; 3],
}

/// The parts of a state.
pub(super) struct State<'x> {
    /// Hysteresis block and driver.
    pub(super) hidden: &'x mut [f64],
    /// The last input.
    pub(super) input: &'x mut f64,
    /// The last error.
    pub(super) error: &'x mut f64,
    /// The gain, relative to the start.
    pub(super) gain: &'x mut f64,
    pub(super) offset: &'x mut f64,
    /// The factor of each group of weights.
    pub(super) factor: &'x mut [f64],
    pub(super) a: &'x mut [f64],
    pub(super) b: &'x mut [f64],
    /// Lags, past inputs and past outputs of each group.
    pub(super) lag: &'x mut [f64],
    pub(super) inputs: &'x mut [f64],
    pub(super) outputs: &'x mut [f64],
    /// Input and output of the linear block behind 1 / A, newest first.
    pub(super) filtered_in: &'x mut [f64],
    pub(super) filtered_out: &'x mut [f64],
    /// Mean and mean square of the alternating part of the response.
    pub(super) mean: &'x mut f64,
    pub(super) power: &'x mut f64,
    /// Which of the slow estimators is next.
    pub(super) phase: &'x mut f64,
    pub(super) fits: &'x mut [f64],
}

impl Layout {
    pub(super) fn new(model: &Model, groups: usize, linear_moves: bool, fits: [usize; 3]) -> Self {
        let (past, b) = (model.linear().a().len(), model.linear().b().len());
        let filtered = if linear_moves { [past.max(b), past] } else { [0, 0] };
        let (hidden, lags) = (model.hidden_initial().len(), model.creep().order());
        Layout { hidden, groups, lags, taps: b - 1, past, filtered, fits }
    }

    pub(super) fn order(&self) -> usize {
        let Layout { hidden, groups, lags, taps, past, filtered, fits } = self;
        let of_a_group = 1 + lags + taps + past;
        hidden + 7 + groups * of_a_group + past + taps + 1 + filtered.iter().sum::<usize>() + fits.iter().sum::<usize>()
    }

    pub(super) fn state<'x>(&self, mut x: &'x mut [f64]) -> State<'x> {
        let Layout { hidden, groups, lags, taps, past, filtered, fits } = *self;
        let x = &mut x;
        let hidden = take(x, hidden);
        let [input, error, gain, offset] = [(); 4].map(|()| &mut take(x, 1)[0]);
        let [factor, a, b] = [groups, past, taps + 1].map(|n| take(x, n));
        let [lag, inputs, outputs] = [lags, taps, past].map(|n| take(x, groups * n));
        let [filtered_in, filtered_out] = filtered.map(|n| take(x, n));
        let [mean, power, phase] = [(); 3].map(|()| &mut take(x, 1)[0]);
        let fits = take(x, fits.iter().sum());
        State {
            hidden,
            input,
            error,
            gain,
            offset,
            factor,
            a,
            b,
            lag,
            inputs,
            outputs,
            filtered_in,
            filtered_out,
            mean,
            power,
            phase,
            fits,
        }
    }
}
