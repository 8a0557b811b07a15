//! Linear blocks on many signals in parallel.

use multiversion::multiversion;

/// Signals that are filtered together: several vectors of a vector unit. With fewer, the compiler unrolls the loops
/// over them, and makes vectors of the coefficients instead, which is slow.
pub(crate) const LANES: usize = 32;

/// What has decayed to this is zero: processors are slow with numbers next to the smallest ones.
pub(crate) const DECAYED_SIGNAL: f64 = 1e-100;

/// Creep, then G = B/A, on [`LANES`] signals.
pub(crate) struct Filter {
    /// 1 - exp(-Ts / tau), and gain, of the lags that have one.
    lags: Vec<(f64, f64)>,
    /// b_j and a_j of each delay.
    coefficients: Vec<(f64, f64)>,
    lagging: Vec<[f64; LANES]>,
    /// What past samples add to the outputs of the next ones (the transposed direct form).
    carried: Vec<[f64; LANES]>,
}

impl Filter {
    /// The filter at rest; `lags` are (1 - exp(-Ts / tau), gain).
    pub(super) fn new(lags: &[(f64, f64)], a: &[f64], b: &[f64]) -> Self {
        let lags: Vec<_> = lags.iter().copied().filter(|lag| lag.1 != 0.0).collect();
        let at = |c: &[f64], k: usize| c.get(k).copied().unwrap_or_default();
        let delays = b.len().max(a.len() + 1);
        let coefficients: Vec<_> = (0..delays).map(|k| (at(b, k), if k > 0 { at(a, k - 1) } else { 0.0 })).collect();
        let rest = |n: usize| vec![[0.0; LANES]; n];
        Filter { lagging: rest(lags.len()), carried: rest(delays), lags, coefficients }
    }

    /// Filters the signals `from..from + LANES` of `rows`, which have `width` signals each.
    pub(crate) fn pass(&mut self, rows: &mut [f64], width: usize, from: usize) {
        pass(rows, width, from, &self.lags, &self.coefficients, &mut self.lagging, &mut self.carried);
        for x in self.lagging.iter_mut().chain(&mut self.carried).flatten().filter(|x| x.abs() < DECAYED_SIGNAL) {
            *x = 0.0;
        }
    }
}

/// x_i += rate_i (v - x_i),  w = v + sum_i gain_i x_i;  y = b_0 w + s_0,  s_k = b_{k+1} w + a_{k+1} y + s_{k+1}.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2", "aarch64+neon"))]
fn pass(
    rows: &mut [f64],
    width: usize,
    from: usize,
    lags: &[(f64, f64)],
    coefficients: &[(f64, f64)],
    lagging: &mut [[f64; LANES]],
    carried: &mut [[f64; LANES]],
) {
    let Some((&(first, _), later)) = coefficients.split_first() else { return };
    for row in rows.chunks_exact_mut(width) {
        let Some(signals) = row[from..].first_chunk_mut::<LANES>() else { return };
        let (v, mut w, mut y) = (*signals, *signals, [0.0; LANES]);
        for (x, &(rate, gain)) in lagging.iter_mut().zip(lags) {
            for l in 0..LANES {
                x[l] += rate * (v[l] - x[l]);
                w[l] += gain * x[l];
            }
        }
        for l in 0..LANES {
            y[l] = first * w[l] + carried[0][l];
        }
        for (k, &(b, a)) in later.iter().enumerate() {
            let next = carried[k + 1];
            for l in 0..LANES {
                carried[k][l] = b * w[l] + a * y[l] + next[l];
            }
        }
        *signals = y;
    }
}

/// 1/A on one signal, with its last outputs.
pub(crate) struct AllPole<'a> {
    a: &'a [f64],
    past: Vec<f64>,
}

impl<'a> AllPole<'a> {
    /// Stores the last `length` outputs.
    pub(super) fn new(a: &'a [f64], length: usize) -> Self {
        AllPole { a, past: vec![0.0; length.max(a.len()).max(1)] }
    }

    pub(crate) fn step(&mut self, v: f64) {
        let y = v + self.a.iter().zip(&self.past).map(|(a, y)| a * y).sum::<f64>();
        let kept = self.past.len() - 1;
        self.past.copy_within(..kept, 1);
        self.past[0] = if y.abs() < DECAYED_SIGNAL { 0.0 } else { y };
    }

    /// The last outputs, newest first.
    pub(crate) fn past(&self) -> &[f64] {
        &self.past
    }
}

/// y += k x.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2", "aarch64+neon"))]
pub(crate) fn add(y: &mut [f64], k: f64, x: &[f64]) {
    for t in 0..y.len().min(x.len()) {
        y[t] += k * x[t];
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_models::creep::{Creep, Lag};
    use piezoid_models::linear::Arx;
    use piezoid_numerics::system::System;
    use piezoid_testing::assert_close;

    #[test]
    fn parallel_signals_are_those_of_single_runs() {
        let arx = Arx::new(1e-3, vec![1.5, -0.7, 0.1], vec![0.0, 0.3, 0.2]).unwrap();
        let lags = vec![Lag { tau_s: 0.02, gain: 0.1 }, Lag { tau_s: 0.3, gain: 0.0 }, Lag { tau_s: 1.0, gain: 0.3 }];
        let creep = Creep::new(1e-3, lags.clone()).unwrap();
        let rates = lags.iter().map(|l| -(-1e-3 / l.tau_s).exp_m1());
        let gains = lags.iter().map(|l| l.gain);
        let signal = |k: usize, t: usize| (t as f64 * (0.1 + 0.07 * k as f64)).sin() + k as f64;
        let lags: Vec<_> = rates.zip(gains).collect();
        let mut filter = Filter::new(&lags, arx.a(), arx.b());
        // Rows of 3 other signals, then those to filter.
        let width = 3 + LANES;
        let mut rows: Vec<f64> = (0..400).flat_map(|t| (0..width).map(move |k| signal(k, t))).collect();
        rows.chunks_mut(64 * width).for_each(|rows| filter.pass(rows, width, 3));
        for k in 0..width {
            let input: Vec<f64> = (0..400).map(|t| signal(k, t)).collect();
            let filtered = arx.simulate(&creep.simulate(&input));
            let out: Vec<f64> = rows.iter().skip(k).step_by(width).copied().collect();
            assert_close(&out, if k < 3 { &input } else { &filtered }, 1e-12, 1e-12);
        }
    }

    #[test]
    fn an_all_pole_block_stores_its_outputs() {
        let mut block = AllPole::new(&[0.5], 3);
        [1.0, 0.0, 0.0].iter().for_each(|&v| block.step(v));
        assert_eq!(block.past(), [0.25, 0.5, 1.0]);
    }
}
