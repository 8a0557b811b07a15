//! One sample of the estimator. The operations and their order are those of its program.

use super::factor::FactorState;
use super::layout::{Layout, State};
use super::{
    GAIN_RANGE, MAX_COEFFICIENTS, MAX_FACTOR, MAX_GROUPS, MAX_RATIO, MAX_REFLECTION, MAX_ROW, Online, PHASES, parts_of,
};
use piezoid_models::hysteresis::Real;
use piezoid_models::linear::decays_within;
use piezoid_numerics::number::is_measurable;
use piezoid_numerics::series::shift_in;

impl Online {
    /// One sample: the input and the reading. Advances the state and returns the response that was expected with the
    /// parameters before this sample [output unit]. A reading that is no number is skipped, an input that is none held.
    pub fn step(&self, x: &mut [f64], u: f64, y: f64) -> f64 {
        let (mut s, mut fits) = self.split(x);
        if is_measurable(u) {
            *s.input = Real::clamp(u, self.scales.inputs.0, self.scales.inputs.1);
        }
        let mut parts = [0.0; MAX_GROUPS];
        let parts = &mut parts[..self.groups.len()];
        parts_of(&self.model, &self.groups, s.hidden, *s.input, parts);
        let (crept, response) = self.respond(&mut s, parts, fits.weights.as_mut());
        if let Some(q) = &mut fits.linear {
            self.filter(&mut s, q, crept, response);
        }
        let expected = *s.offset + *s.gain * response;
        *s.mean += self.scales.fresh * (response - *s.mean);
        let off = response - *s.mean;
        *s.power += self.scales.fresh * (off * off - *s.power);
        if is_measurable(y) {
            *s.error = y - expected;
            if *s.error > self.dead_zone || *s.error < -self.dead_zone {
                let e = Real::clamp(*s.error, -self.scales.stroke, self.scales.stroke);
                if *s.power >= self.scales.least_power {
                    self.move_all(&mut s, &mut fits, response, e);
                } else if self.moves.offset {
                    *s.offset += self.scales.drift * e;
                }
                *s.gain = Real::clamp(*s.gain, GAIN_RANGE.0, GAIN_RANGE.1);
                *s.offset = Real::clamp(*s.offset, self.scales.offsets.0, self.scales.offsets.1);
            }
        }
        expected
    }

    /// The parts of a state, and the states of the estimators.
    pub(super) fn split<'x>(&self, x: &'x mut [f64]) -> (State<'x>, Fits<'x>) {
        let mut s = self.layout.state(x);
        let mut rest = std::mem::take(&mut s.fits);
        let [weights, linear] = [&self.weights, &self.linear].map(|f| f.as_ref().map(|f| f.state(&mut rest)));
        let gain = self.gain.state(&mut rest);
        (s, Fits { weights, linear, gain })
    }

    /// Creep and linear block for each group: their input and output, weighted by the factors.
    fn respond(&self, s: &mut State, parts: &[f64], mut q: Option<&mut FactorState>) -> (f64, f64) {
        let Layout { lags, taps, past, .. } = self.layout;
        let (mut crept, mut response) = (0.0, 0.0);
        for (m, &part) in parts.iter().enumerate() {
            let mut z = part;
            for (k, lag) in s.lag[m * lags..(m + 1) * lags].iter_mut().enumerate() {
                *lag += self.rates[k] * (part - *lag);
                z += self.shares[k] * *lag;
            }
            let inputs = &mut s.inputs[m * taps..(m + 1) * taps];
            let outputs = &mut s.outputs[m * past..(m + 1) * past];
            let sum = inputs.iter().zip(&s.b[1..]).fold(s.b[0] * z, |sum, (z, b)| sum + b * z);
            let sum = outputs.iter().zip(&*s.a).fold(sum, |sum, (y, a)| sum + a * y);
            shift_in(inputs, z);
            shift_in(outputs, sum);
            if let Some(q) = &mut q {
                q.row[m] = sum;
            }
            crept += s.factor[m] * z;
            response += s.factor[m] * sum;
        }
        (crept, response)
    }

    /// Input and output of the linear block behind 1 / A, which are the derivatives by its coefficients.
    fn filter(&self, s: &mut State, q: &mut FactorState, crept: f64, response: f64) {
        let (by_a, by_b) = (*s.gain * self.scales.of_a, *s.gain * self.scales.of_b);
        let mut v = response;
        for (i, (a, before)) in s.a.iter().zip(&*s.filtered_out).enumerate() {
            v += a * before;
            q.row[i] = Real::clamp(before * by_a, -MAX_ROW, MAX_ROW);
        }
        shift_in(s.filtered_out, v);
        let v = s.a.iter().zip(&*s.filtered_in).fold(crept, |v, (a, before)| v + a * before);
        shift_in(s.filtered_in, v);
        let na = s.a.len();
        for (k, past) in s.filtered_in[self.delay..s.b.len()].iter().enumerate() {
            q.row[na + k] = Real::clamp(past * by_b, -MAX_ROW, MAX_ROW);
        }
    }

    /// The steps for the error `e`: of gain and offset in every sample, of the slow estimators in turn.
    fn move_all(&self, s: &mut State, fits: &mut Fits, response: f64, e: f64) {
        let phase = *s.phase;
        if let (Some(factor), Some(q), true) = (&self.weights, &mut fits.weights, phase == 0.0) {
            let scale = *s.gain * self.scales.of_gain;
            q.row.iter_mut().for_each(|row| *row = Real::clamp(*row * scale, -MAX_ROW, MAX_ROW));
            factor.update(q, e);
            factor.recall(q);
            self.move_factors(s, q);
        }
        if let (Some(factor), Some(q)) = (&self.linear, &mut fits.linear) {
            if phase == 1.0 {
                factor.update(q, e);
                self.move_coefficients(s, q);
            } else if phase == 2.0 {
                factor.recall(q);
            }
        }
        if self.moves.weights || self.moves.linear {
            *s.phase = if phase < PHASES - 1.0 { phase + 1.0 } else { 0.0 };
        }
        if self.moves.gain || self.moves.offset {
            let q = &mut fits.gain;
            q.row[0] =
                if self.moves.gain { Real::clamp(response * self.scales.of_gain, -MAX_ROW, MAX_ROW) } else { 0.0 };
            q.row[1] = if self.moves.offset { 1.0 } else { 0.0 };
            self.gain.update(q, e);
            self.gain.recall(q);
            *s.gain += q.step[0] * self.scales.of_gain;
            *s.offset += q.step[1];
        }
    }

    /// Takes a step of the factors; the change of their mean goes to the gain.
    fn move_factors(&self, s: &mut State, q: &mut FactorState) {
        let (mut moved, mut mean) = ([0.0; MAX_GROUPS], 0.0);
        for (m, factor) in s.factor.iter().enumerate() {
            moved[m] = Real::clamp(factor + q.step[m] * self.scales.of_gain, 0.0, MAX_FACTOR);
            mean += self.scales.share[m] * moved[m];
        }
        if mean * MAX_RATIO > 1.0 && mean < MAX_RATIO {
            let ratio = if self.moves.gain { mean } else { 1.0 };
            for (m, factor) in s.factor.iter_mut().enumerate() {
                *factor = Real::clamp(moved[m] / ratio, 0.0, MAX_FACTOR);
                q.away[m] = (*factor - 1.0) / self.scales.of_gain;
            }
            *s.gain *= ratio;
        }
    }

    /// Takes a step of the linear block if it leaves that stable; the change of its static gain goes to the gain.
    fn move_coefficients(&self, s: &mut State, q: &mut FactorState) {
        let (na, scales, start) = (s.a.len(), &self.scales, self.model.linear());
        let (mut rest, mut sum) = (1.0, 0.0);
        let moving = &mut s.b[self.delay..];
        // The rows are free until the next sample: they hold the new coefficients.
        for (i, old) in s.a.iter().enumerate() {
            q.row[i] = old + q.step[i] * scales.of_a;
            rest -= q.row[i];
        }
        for (k, old) in moving.iter().enumerate() {
            q.row[na + k] = Real::clamp(old + q.step[na + k] * scales.of_b, -scales.most_b, scales.most_b);
            sum += q.row[na + k];
        }
        let mean = sum / (rest * scales.still);
        let mut c = [0.0; MAX_COEFFICIENTS];
        c[..na].copy_from_slice(&q.row[..na]);
        if mean * MAX_RATIO > 1.0 && mean < MAX_RATIO && decays_within(&mut c[..na], MAX_REFLECTION) {
            let ratio = if self.moves.gain { mean } else { 1.0 };
            for (i, a) in s.a.iter_mut().enumerate() {
                *a = q.row[i];
                q.away[i] = (*a - start.a()[i]) / scales.of_a;
            }
            for (k, b) in moving.iter_mut().enumerate() {
                *b = q.row[na + k] / ratio;
                q.away[na + k] = (*b - start.b()[self.delay + k]) / scales.of_b;
            }
            *s.gain *= ratio;
        }
    }
}

/// The states of the estimators.
pub(super) struct Fits<'x> {
    weights: Option<FactorState<'x>>,
    linear: Option<FactorState<'x>>,
    gain: FactorState<'x>,
}
