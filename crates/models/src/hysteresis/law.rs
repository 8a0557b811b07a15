//! Operators defined by one [`Law`], the responses phi_k to the input. From a law, [`Weighted`] makes the block that
//! runs, the basis that is fitted, and the document that is saved.
//!
//! Why: docs/decisions/hysteresis-laws.md, "A law is written twice, to run and to export".

use super::basis::{Basis, SensitiveOperator, ShapeParameter, counted, curvature};
use super::inverse::{Inverted, by_slopes, by_trials, with_scratch};
use super::real::{Dual, Real, Sensitive, Several, Slope};
use super::{Hysteresis, LinearWeights, Operator, document, parse, thresholds};
use crate::program::Block;
use piezoid_numerics::error::{Error, finite, positive};
use piezoid_numerics::system::System;
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};
use std::fmt::Debug;
use std::sync::Arc;

/// One input sample with its context.
#[derive(Debug, Clone, Copy)]
pub(super) struct Input<R = f64> {
    /// The input [input unit].
    pub(super) u: R,
    /// The previous input; 0 before the first [input unit].
    pub(super) before: R,
    /// Sampling period [s]; infinite for a quasi-static movement.
    pub(super) ts: f64,
    /// Input range of the identification data [input unit].
    pub(super) range: (f64, f64),
}

impl Input {
    /// The next sample.
    fn then<R: Real>(self, u: R) -> Input<R> {
        Input { u, before: self.u.into(), ts: self.ts, range: self.range }
    }
}

impl<R: Real> Input<R> {
    /// Movement of the input [input unit].
    pub(super) fn path(&self) -> R {
        self.u - self.before
    }

    /// Direction of the movement: 1, -1, or 0 while the input is held.
    pub(super) fn direction(&self) -> f64 {
        let path = self.path().value();
        if path == 0.0 { 0.0 } else { path.signum() }
    }

    /// Absolute movement of the input [input unit].
    pub(super) fn length(&self) -> R {
        self.path() * self.direction().into()
    }

    /// Absolute rate of the input [input unit/s].
    pub(super) fn rate(&self) -> R {
        self.length() / self.ts.into()
    }

    /// Half the range [input unit].
    pub(super) fn half(&self) -> f64 {
        0.5 * (self.range.1 - self.range.0)
    }

    /// The largest |u| of the range [input unit].
    pub(super) fn largest(&self) -> f64 {
        self.range.0.abs().max(self.range.1.abs())
    }

    /// The middle of the range [input unit].
    pub(super) fn middle(&self) -> f64 {
        0.5 * (self.range.0 + self.range.1)
    }
}

/// Returns an error with `rule` unless it `holds`.
pub(super) fn require(holds: bool, name: &str, value: f64, rule: &str) -> Result<(), Error> {
    if holds { Ok(()) } else { Err(Error::parameter(name, value, rule)) }
}

/// The law of an operator. Its fields (thresholds, shape parameters) are also those of its file.
pub(super) trait Law: Debug + Clone + PartialEq + Send + Sync + Serialize + DeserializeOwned + 'static {
    /// Its row of [`super::OPERATORS`].
    const ROW: &'static Operator;

    /// Returns an error if a field is out of its range; by default it checks the thresholds.
    fn check(&self) -> Result<(), Error> {
        thresholds::check(self.thresholds())
    }

    /// The response phi_k of threshold k after a step, as a program, of a law whose phi_0 is the input: an expression
    /// of the state `x`, the input `u` and `k`, which counts from 0. Empty if the responses are others.
    const RESPONSE: &'static str = "";

    /// Thresholds of a law of plays or stops; the defaults below are for such a law.
    fn thresholds(&self) -> &[f64] {
        &[]
    }

    /// Number of responses phi; by default that of the input, then one per threshold, or one of a law without them.
    fn responses(&self) -> usize {
        1 + self.thresholds().len().max(1)
    }

    /// Length of the state, which is 0 at rest; by default one number per threshold, or one of a law without them.
    fn order(&self) -> usize {
        self.thresholds().len().max(1)
    }

    /// One sample: advances `x` and passes every phi_k, in order, to `phi`.
    fn step<R: Real>(&self, shape: &[R], x: &mut [R], input: Input<R>, phi: impl FnMut(usize, R));

    /// Replaces the inputs in `signal`, which come after `last`, by z. Overridden where that is measurably faster. The
    /// result must be bit-identical for any division of `signal`.
    fn run(&self, weights: &[f64], shape: &[f64], x: &mut [f64], last: Input, signal: &mut [f64]) {
        let mut input = last;
        for v in signal {
            input = input.then(*v);
            // -0 leaves every sum unchanged, -0 included: programs begin with the first product.
            *v = -0.0;
            self.step(shape, x, input, |k, phi| *v += weights[k] * phi);
        }
    }

    /// z and its slope after the next `input`, from the state `x`. `trial` is scratch space for shape and state.
    /// Overridden where that is measurably faster.
    fn ahead(&self, weights: &[f64], shape: &[f64], x: &[f64], trial: &mut [Dual], input: Input<Dual>) -> Dual {
        trial.iter_mut().zip(shape.iter().chain(x)).for_each(|(copy, value)| *copy = Dual::from(*value));
        let (shape, x) = trial.split_at_mut(shape.len());
        let mut z = -Dual::from(0.0);
        self.step(shape, x, input, |k, phi| z = z + Dual::from(weights[k]) * phi);
        z
    }

    /// [`Hysteresis::invert`] in closed form, from the `last` input and the state `x`. `None` if there is no formula
    /// for this state.
    fn closed(&self, _weights: &[f64], _x: &[f64], _last: f64, _z: f64, _ends: (f64, f64)) -> Option<Inverted> {
        None
    }

    /// See [`Hysteresis::deviation`]; `last` is the last input.
    fn deviation(&self, _weights: &[f64], _x: &[f64], _last: Input) -> Option<f64> {
        None
    }

    /// [`Law::step`] as a program, as in [`Hysteresis::block`]. Completes a `block` that has the last input as `last`,
    /// the weights as `w`, and the shape parameters under their names. For [`Law::closed`] it may add
    /// `hysteresis_closed(x: hysteresis, z, low, high)`, which returns u and 1, or 0 as second value if there is no
    /// solution.
    fn block(&self, block: Block, input: Input) -> Block;

    /// True if weight `k` must not be negative.
    fn non_negative(&self, _k: usize) -> bool {
        true
    }

    /// See [`Basis::roughness`]; by default the second differences of the weights of thresholds.
    fn roughness(&self) -> Vec<Vec<(usize, f64)>> {
        curvature(1, 1 + self.thresholds().len())
    }

    /// See [`Basis::shape`]; the input range is 2 `half` [input unit], the sampling period `ts` [s].
    fn shape(&self, _half: f64, _ts: f64) -> Vec<ShapeParameter> {
        Vec::new()
    }

    /// The law with these responses alone, if records select them; see [`Basis::with_terms`].
    fn with_terms(&self, _terms: &[usize]) -> Option<Self> {
        None
    }

    /// The same law with other shape parameters, which are fields of its file.
    fn reshaped(&self, shape: &[f64]) -> Result<Self, Error> {
        let mut fields = document(self);
        fields.extend(self.shape(1.0, 1.0).iter().zip(shape).map(|(p, value)| (p.name.into(), (*value).into())));
        parse(Self::ROW.name, fields.into())
    }
}

/// A law with weights: z = sum_k w_k phi_k.
///
/// State: the last input, then the state of the law.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Weighted<L> {
    ts: f64,
    params: LawParams<L>,
    /// Shape parameters of the law.
    shape: Vec<f64>,
}

#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
struct LawParams<L> {
    /// Input range of the identification data [input unit].
    range: (f64, f64),
    #[serde(flatten)]
    law: L,
    weights: Vec<f64>,
}

impl<L: Law> Weighted<L> {
    pub(super) fn new(ts: f64, range: (f64, f64), law: L, weights: Vec<f64>) -> Result<Self, Error> {
        positive("ts", ts, "seconds")?;
        finite("range", &[range.0, range.1])?;
        if range.0 >= range.1 {
            let rule = "must be the lowest input followed by a higher one";
            return Err(Error::parameter("range", format!("{range:?}"), rule));
        }
        finite("weights", &weights)?;
        law.check()?;
        counted(L::ROW.name, "weights", weights.len(), law.responses())?;
        let mut block = Weighted { ts, params: LawParams { range, law, weights }, shape: Vec::new() };
        block.shape = Basis::shape(&block).iter().map(|s| s.value).collect();
        Ok(block)
    }

    /// See [`Operator::load`].
    pub(super) fn load(params: Value, ts: f64) -> Result<Arc<dyn Hysteresis>, Error> {
        let name = L::ROW.name;
        let names: Vec<String> = params.as_object().map(|p| p.keys().cloned().collect()).unwrap_or_default();
        let LawParams::<L> { range, law, weights } = parse(name, params)?;
        let block = Self::new(ts, range, law, weights)?;
        // serde cannot reject unknown fields beside a flattened struct.
        let known = block.params();
        match names.iter().find(|key| !known.contains_key(*key)) {
            None => Ok(Arc::new(block)),
            Some(key) => Err(Error::Content(format!("hysteresis block `{name}`: unknown field `{key}`: remove it"))),
        }
    }

    /// See [`Operator::basis`]: the weights are 1 until they are fitted.
    pub(super) fn basis(ts: f64, range: (f64, f64), law: L) -> Result<Box<dyn Basis>, Error> {
        let weights = vec![1.0; law.responses()];
        Ok(Box::new(Self::new(ts, range, law, weights)?))
    }

    /// See [`Operator::example`]: for inputs of +-30.
    pub(super) fn example(ts: f64, law: L, weights: Vec<f64>) -> Result<Arc<dyn Hysteresis>, Error> {
        Ok(Arc::new(Self::new(ts, (-30.0, 30.0), law, weights)?))
    }

    /// The last input, from the state `x`.
    fn last(&self, x: &[f64]) -> Input {
        Input { u: x[0], before: x[0], ts: self.ts, range: self.params.range }
    }

    fn advance<R: Real>(&self, shape: &[R], x: &mut [R], u: R, phi: impl FnMut(usize, R)) {
        let input = Input { u, before: x[0], ts: self.ts, range: self.params.range };
        self.params.law.step(shape, &mut x[1..], input, phi);
        x[0] = u;
    }

    /// [`Basis::slopes`] by at most `N` shape parameters at once.
    fn slopes_by<const N: usize>(&self, weights: &[f64], u: &[f64]) -> Vec<Vec<f64>> {
        let of = |from: usize| {
            let by = |k: usize| Several(std::array::from_fn(|j| f64::from(u8::from(from + j == k))));
            let seeded = |(k, &value): (usize, &f64)| Dual { value, slope: by(k) };
            let shape: Vec<Dual<Several<N>>> = self.shape.iter().enumerate().map(seeded).collect();
            let mut x = vec![Dual::from(0.0); System::order(self)];
            let mut slopes = vec![vec![0.0; u.len()]; N.min(self.shape.len() - from)];
            for (t, &u) in u.iter().enumerate() {
                let mut slope = Several::<N>::ZERO;
                self.advance(&shape, &mut x, u.into(), |k, phi| slope = slope + phi.slope * weights[k]);
                slopes.iter_mut().zip(slope.0).for_each(|(slopes, slope)| slopes[t] = slope);
            }
            slopes
        };
        (0..self.shape.len()).step_by(N).flat_map(of).collect()
    }

    fn run(&self, x: &mut [f64], last: Input, signal: &mut [f64]) {
        let Some(&end) = signal.last() else { return };
        self.params.law.run(&self.params.weights, &self.shape, &mut x[1..], last, signal);
        x[0] = end;
    }
}

impl<L: Law> System for Weighted<L> {
    fn ts(&self) -> f64 {
        self.ts
    }

    fn order(&self) -> usize {
        1 + self.params.law.order()
    }

    fn settled(&self, u: f64) -> Vec<f64> {
        let mut x = System::initial(self);
        let slowly = Input { ts: f64::INFINITY, ..self.last(&x) };
        self.run(&mut x, slowly, &mut [u]);
        x
    }

    fn step(&self, x: &mut [f64], u: f64) -> f64 {
        let mut signal = [u];
        self.run(x, self.last(x), &mut signal);
        signal[0]
    }

    fn respond(&self, x: &mut [f64], signal: &mut [f64]) {
        self.run(x, self.last(x), signal);
    }
}

impl<L: Law> Hysteresis for Weighted<L> {
    fn operator(&self) -> &'static Operator {
        L::ROW
    }

    fn params(&self) -> Map<String, Value> {
        document(&self.params)
    }

    fn range(&self) -> Option<(f64, f64)> {
        Some(self.params.range)
    }

    fn deviation(&self, x: &[f64]) -> Option<f64> {
        self.params.law.deviation(&self.params.weights, &x[1..], self.last(x))
    }

    fn block(&self) -> Option<Block> {
        let block = Block::new("hysteresis", format!("{}: {}", L::ROW.name, L::ROW.summary));
        let block = block.number("last", 0.0).table("w", &self.params.weights);
        let block = Basis::shape(self).iter().fold(block, |block, shape| block.constant(shape.name, shape.value));
        Some(self.params.law.block(block, self.last(&[0.0])))
    }

    #[cfg(test)]
    fn ahead(&self, x: &[f64], u: f64) -> Option<(f64, f64)> {
        let (law, input) = (&self.params.law, self.last(x).then(Dual { value: u, slope: 1.0 }));
        let mut trial = vec![Dual::from(0.0); self.shape.len() + x.len() - 1];
        let z = law.ahead(&self.params.weights, &self.shape, &x[1..], &mut trial, input);
        Some((z.value, z.slope))
    }

    fn linear_weights(&self) -> Option<LinearWeights<'_>> {
        let linear = LinearWeights { weights: &self.params.weights, basis: self, response: L::RESPONSE };
        Some(linear).filter(|linear| !linear.response.is_empty())
    }

    fn invert(&self, x: &[f64], z: f64, ends: (f64, f64)) -> Inverted {
        let (last, LawParams { law, weights, .. }) = (self.last(x), &self.params);
        if let Some(found) = law.closed(weights, &x[1..], last.u, z, ends) {
            return found;
        }
        let found = with_scratch(self.shape.len() + x.len() - 1, |trial| {
            let ahead = |u| law.ahead(weights, &self.shape, &x[1..], trial, last.then(Dual { value: u, slope: 1.0 }));
            by_slopes(last.u, z, ends, ahead)
        });
        found.unwrap_or_else(|| by_trials(self, x, z, ends))
    }
}

impl<L: Law> Basis for Weighted<L> {
    fn len(&self) -> usize {
        self.params.law.responses()
    }

    fn order(&self) -> usize {
        System::order(self)
    }

    fn step(&self, x: &mut [f64], u: f64, phi: &mut [f64]) {
        self.advance(&self.shape, x, u, |k, value| phi[k] = value);
    }

    fn non_negative(&self) -> Vec<bool> {
        (0..Basis::len(self)).map(|k| self.params.law.non_negative(k)).collect()
    }

    fn roughness(&self) -> Vec<Vec<(usize, f64)>> {
        self.params.law.roughness()
    }

    fn shape(&self) -> Vec<ShapeParameter> {
        let (low, high) = self.params.range;
        self.params.law.shape(0.5 * (high - low), self.ts)
    }

    fn reshaped(&self, shape: &[f64]) -> Result<Box<dyn Basis>, Error> {
        finite("shape", shape)?;
        counted(L::ROW.name, "shape", shape.len(), self.shape.len())?;
        Self::basis(self.ts, self.params.range, self.params.law.reshaped(shape)?)
    }

    fn with_terms(&self, terms: &[usize]) -> Option<Box<dyn Basis>> {
        let law = self.params.law.with_terms(terms)?;
        Self::basis(self.ts, self.params.range, law).ok()
    }

    fn with_period(&self, ts: f64) -> Option<Box<dyn Basis>> {
        let all: Vec<usize> = (0..Basis::len(self)).collect();
        let law = self.params.law.with_terms(&all)?;
        Self::basis(ts, self.params.range, law).ok()
    }

    fn slopes(&self, weights: &[f64], u: &[f64]) -> Vec<Vec<f64>> {
        // The code of the page is small rather than fast; the numbers are the same.
        match self.shape.len() {
            0 => Vec::new(),
            _ if cfg!(target_arch = "wasm32") => self.slopes_by::<4>(weights, u),
            1..=2 => self.slopes_by::<2>(weights, u),
            3..=4 => self.slopes_by::<4>(weights, u),
            _ => self.slopes_by::<8>(weights, u),
        }
    }

    fn sensitive<'a>(&'a self, weights: &'a [Sensitive], shape: &'a [Sensitive]) -> Option<SensitiveOperator<'a>> {
        let mut x = vec![Sensitive::from(0.0); Basis::order(self)];
        Some(Box::new(move |u| {
            let mut z = Sensitive::from(0.0);
            self.advance(shape, &mut x, u, |k, phi| z = z + weights[k] * phi);
            z
        }))
    }

    fn operator(&self, weights: &[f64]) -> Result<Arc<dyn Hysteresis>, Error> {
        let (ts, LawParams { range, law, .. }) = (self.ts, self.params.clone());
        Ok(Arc::new(Self::new(ts, range, law, weights.to_vec())?))
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Operator, load};
    use serde_json::json;

    #[test]
    fn errors_about_fields_of_a_law_state_the_value() {
        let refused = |document: serde_json::Value| load(&document, 5e-4).unwrap_err().to_string();
        let play = |range: [f64; 2], thresholds: &[f64], weights: &[f64]| json!({"operator": "prandtl-ishlinskii", "range": range, "thresholds": thresholds, "weights": weights});
        assert!(load(&play([-1.0, 1.0], &[0.5], &[1.0, 1.0]), 5e-4).is_ok());
        let message = refused(play([-1.0, 1.0], &[0.5], &[1.0]));
        assert_eq!(message, "weights = 1 numbers: must be 2 numbers for this prandtl-ishlinskii");
        let mut more = play([-1.0, 1.0], &[0.5], &[1.0, 1.0]);
        more["treshold"] = json!(1);
        assert!(refused(more).contains("`prandtl-ishlinskii`: unknown field `treshold`"));
        assert!(
            refused(play([1.0, 1.0], &[0.5], &[1.0, 1.0])).starts_with("range = (1.0, 1.0): must be the lowest input")
        );
        let message = refused(play([-1.0, 1.0], &[0.5, 0.5], &[1.0; 3]));
        assert!(message.starts_with("thresholds[1] = 0.5: must be above 0.5"), "{message}");
    }

    #[test]
    fn rate_dependent_operators_settle_as_after_a_slow_movement() {
        for name in ["rate-dependent-prandtl-ishlinskii", "maxwell-slip"] {
            let block = (Operator::find(name).unwrap().example)(5e-4).unwrap();
            let slowly: Vec<f64> = (0..=200_000).map(|t| 20.0 * f64::from(t) / 200_000.0).collect();
            let z = block.simulate(&slowly)[200_000];
            let settled = block.step(&mut block.settled(20.0), 20.0);
            piezoid_testing::assert_close(&[settled], &[z], 5e-3, 0.0);
            let rushed = block.simulate(&[20.0])[0];
            assert!((rushed - z).abs() > 0.02 * z.abs(), "{name}: a step must give another z than {rushed}");
        }
    }
}
