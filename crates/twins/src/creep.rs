//! Creep: the slow growth of the displacement with the logarithm of time.
//!
//! ```text
//! dL(t) = dL(tau_0) [1 + g log10(t / tau_0)]
//! ```
//! as four lags one decade apart, each with gain g, and a direct path that makes the law exact at tau_0:
//! ```text
//! L = (1 - g S) w + g sum_k x_k,   x_k' = (w - x_k) / tau_k,   tau_k = tau_0, 10 tau_0, 100 tau_0, 1000 tau_0
//! S = sum_k (1 - exp(-tau_0 / tau_k))
//! ```
//! With tau_0 = 0.1 s: from 0.03 to 10 s after a step the error is at most 0.08 g; the slope per decade varies from
//! 0.87 g to 1.11 g (from 0.06 s), and is 0.99 g on average. Before and after that the displacement is constant, while
//! the law has no limits.
//!
//! Reference: H. Jung, D.-G. Gweon, "Creep characteristics of piezoelectric actuators", Rev. Sci. Instrum. 71, 1896
//! (2000), DOI 10.1063/1.1150559; PI's tutorial gives the law and g = 0.01 to 0.02.
//!
//! State: the four x_k [m].
//!
//! Why: docs/decisions/study-of-the-paper.md, "Creep of the simulated bender is four lags".

use super::spec::require;
use libm::expm1;
use piezoid_numerics::error::{Error, positive};

/// Time constants over the fastest.
const LAGS: [f64; 4] = [1.0, 10.0, 100.0, 1000.0];

/// The creep, for a fixed time step.
#[derive(Debug, Clone)]
pub(super) struct CreepStage {
    g: f64,
    /// Gain of the direct path, 1 - g S.
    direct: f64,
    /// 1 - exp(-h / tau), of each lag.
    gain: [f64; 4],
}

impl CreepStage {
    pub(super) const ORDER: usize = LAGS.len();

    /// Creep of `g` per decade from the time constant `from` on [s], advanced in steps of `h` [s].
    pub(crate) fn new(g: f64, from: f64, h: f64) -> Result<Self, Error> {
        positive("creep_from_s", from, "seconds")?;
        require((0.0..=0.2).contains(&g), "creep_per_decade", g, "must be from 0 to 0.2; ceramics have 0.01 to 0.02")?;
        let risen = |t: f64| LAGS.map(|ratio| -expm1(-t / (ratio * from)));
        Ok(CreepStage { g, direct: 1.0 - g * risen(from).iter().sum::<f64>(), gain: risen(h) })
    }

    /// Current displacement [m] for the static displacement `w` [m].
    pub(super) fn output(&self, x: &[f64], w: f64) -> f64 {
        self.direct * w + self.g * x.iter().sum::<f64>()
    }

    /// Advances one step under the held `w` and returns the mean displacement over it [m].
    #[inline]
    pub(crate) fn advance(&self, x: &mut [f64], w: f64) -> f64 {
        let mut twice = 0.0;
        for (x, gain) in x.iter_mut().zip(self.gain) {
            let rise = (w - *x) * gain;
            twice += 2.0 * *x + rise;
            *x += rise;
        }
        self.direct * w + 0.5 * self.g * twice
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;

    /// Displacement under a unit step at t = k h, k = 1...n.
    fn step_response(creep: &CreepStage, n: usize) -> Vec<f64> {
        let mut x = vec![0.0; CreepStage::ORDER];
        let step = |_| {
            creep.advance(&mut x, 1.0);
            creep.output(&x, 1.0)
        };
        (0..n).map(step).collect()
    }

    #[test]
    fn a_step_follows_the_creep_law_from_30_ms_to_10_s() {
        let (g, h) = (0.015, 0.01);
        let l = step_response(&CreepStage::new(g, 0.1, h).unwrap(), 1000);
        let decades = |i: usize| ((i + 1) as f64 * h / 0.1).log10();
        // Computed with numpy: within 0.077 g.
        let crept: Vec<f64> = l.iter().map(|l| (l - 1.0) / g).collect();
        let law: Vec<f64> = (0..1000).map(decades).collect();
        assert_close(&crept[2..], &law[2..], 0.0, 0.09);
        assert_close(&[l[9]], &[1.0], 1e-14, 0.0);
        assert_close(&[(l[999] - l[9]) / g / 2.0], &[1.0], 0.02, 0.0);
        for i in 6..900 {
            let slope = (l[i + 1] - l[i - 1]) / g / (decades(i + 1) - decades(i - 1));
            assert!((0.87..1.12).contains(&slope), "slope {slope} g per decade");
        }
    }

    #[test]
    fn one_long_step_equals_many_short_ones() {
        let long = step_response(&CreepStage::new(0.015, 0.1, 3.0).unwrap(), 1);
        let short = step_response(&CreepStage::new(0.015, 0.1, 0.003).unwrap(), 1000);
        assert_close(&long, &short[999..], 1e-13, 0.0);
    }

    #[test]
    fn without_creep_the_displacement_passes_unchanged() {
        let creep = CreepStage::new(0.0, 0.1, 1e-3).unwrap();
        assert_eq!(creep.advance(&mut [0.0; 4], 0.7), 0.7);
        assert!(CreepStage::new(f64::NAN, 0.1, 1e-3).is_err());
    }
}
