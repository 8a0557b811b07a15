//! Strategies for random inputs, blocks and operators.

use crate::hysteresis::*;
use crate::linear::Arx;
pub(crate) use piezoid_testing::random::*;
use proptest::prelude::*;
use std::sync::Arc;

pub(crate) const TS: f64 = 5e-4;

/// Product of two polynomials, coefficients by rising power of q^-1.
pub(crate) fn times(p: &[f64], q: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; p.len() + q.len() - 1];
    for (i, p) in p.iter().enumerate() {
        for (j, q) in q.iter().enumerate() {
            product[i + j] += p * q;
        }
    }
    product
}

/// 1 + c1 q^-1 + ... with up to `pairs` pairs of roots of the given moduli, and up to one real root.
pub(crate) fn monic(modulus: impl Strategy<Value = f64> + Clone, pairs: usize) -> impl Strategy<Value = Vec<f64>> {
    let pair = (modulus.clone(), 0.05..3.1f64).prop_map(|(r, angle)| vec![1.0, -2.0 * r * angle.cos(), r * r]);
    let real = (modulus, any::<bool>()).prop_map(|(r, negative)| vec![1.0, if negative { r } else { -r }]);
    (prop::collection::vec(pair, 0..=pairs), prop::option::of(real))
        .prop_map(|(pairs, real)| pairs.iter().chain(&real).fold(vec![1.0], |product, factor| times(&product, factor)))
}

/// A block of the given poles and zeros with a gain of either sign, and a delay of up to `delay_samples` samples.
pub(crate) fn arx(
    poles: impl Strategy<Value = Vec<f64>>,
    zeros: impl Strategy<Value = Vec<f64>>,
    delay_samples: usize,
) -> impl Strategy<Value = Arx> {
    let gain = (0.1..10.0f64, any::<bool>()).prop_map(|(k, negative)| if negative { -k } else { k });
    (poles, zeros, gain, 0..=delay_samples).prop_map(|(poles, zeros, gain, delay_samples)| {
        let a = poles[1..].iter().map(|c| -c).collect();
        let b = std::iter::repeat_n(0.0, delay_samples).chain(zeros.iter().map(|c| gain * c)).collect();
        Arx::new(TS, a, b).expect("a block")
    })
}

pub(crate) fn stable() -> impl Strategy<Value = Arx> {
    arx(monic(0.05..0.97f64, 3), monic(0.05..2.0f64, 2), 3)
}

/// Knots from -30 to 30 V, because both branches need the same ends.
pub(crate) fn knots() -> impl Strategy<Value = (Vec<f64>, Vec<f64>)> {
    prop::collection::vec((0.01..10.0f64, -40.0..40.0f64), 2..9).prop_map(|steps| {
        let whole: f64 = steps[1..].iter().map(|(step, _)| step).sum();
        let mut passed = -steps[0].0;
        let last = steps.len() - 1;
        let rising = |(k, (step, z))| {
            passed += step;
            (if k == last { 30.0 } else { 60.0 * passed / whole - 30.0 }, z)
        };
        steps.into_iter().enumerate().map(rising).unzip()
    })
}

pub(crate) fn branches() -> impl Strategy<Value = Branches> {
    (knots(), knots()).prop_map(|(up, down)| Branches::new(up, down).expect("branches"))
}

/// One operator of every kind, random if possible.
pub(crate) fn operators() -> impl Strategy<Value = Vec<Arc<dyn Hysteresis>>> {
    (branches(), branches(), -5.0..5.0f64).prop_map(|(low, high, gain)| {
        let pair = |frequency_hz, branches: &Branches| Pair { frequency_hz, branches: branches.clone() };
        let scheduled = RateScheduled::new(TS, vec![pair(5.0, &low), pair(200.0, &high)], HeldInput::Held);
        let mut all: Vec<Arc<dyn Hysteresis>> = vec![
            Arc::new(Proportional::new(TS, gain).expect("a gain")),
            Arc::new(TwoBranch::new(TS, low, HeldInput::Held).expect("a block")),
            Arc::new(TwoBranch::new(TS, high, HeldInput::Printed).expect("a block")),
            Arc::new(scheduled.expect("two pairs")),
        ];
        all.extend(OPERATORS.iter().map(|o| (o.example)(TS).expect("an example")));
        all
    })
}
