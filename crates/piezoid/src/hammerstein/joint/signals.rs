//! Linear blocks on many signals in parallel.

use multiversion::multiversion;

/// Creep on `width` signals.
pub(super) struct Ladder {
    /// 1 - exp(-Ts / tau), and gain, of the lags that have one.
    lags: Vec<(f64, f64)>,
    /// The states of all signals, one lag after the other.
    x: Vec<f64>,
}

impl Ladder {
    pub(super) fn new(rates: &[f64], gains: &[f64], width: usize) -> Self {
        let lags: Vec<_> = rates.iter().copied().zip(gains.iter().copied()).filter(|lag| lag.1 != 0.0).collect();
        Ladder { x: vec![0.0; width * lags.len()], lags }
    }

    /// Adds its creep to each signal of `v`.
    pub(super) fn step(&mut self, v: &mut [f64]) {
        for (x, &(rate, _)) in self.x.chunks_exact_mut(v.len()).zip(&self.lags) {
            follow(x, rate, v);
        }
        for (x, &(_, gain)) in self.x.chunks_exact(v.len()).zip(&self.lags) {
            add(v, gain, x);
        }
    }
}

/// G = B/A on `width` signals.
pub(super) struct LinearFilter<'a> {
    a: &'a [f64],
    b: &'a [f64],
    width: usize,
    /// Ring buffers of the last inputs and outputs, one vector per coefficient.
    inputs: Vec<f64>,
    outputs: Vec<f64>,
    out: Vec<f64>,
    t: usize,
}

impl<'a> LinearFilter<'a> {
    pub(super) fn new(a: &'a [f64], b: &'a [f64], width: usize) -> Self {
        let ring = |n: usize| vec![0.0; n * width];
        LinearFilter { a, b, width, inputs: ring(b.len()), outputs: ring(a.len()), out: vec![0.0; width], t: 0 }
    }

    pub(super) fn step(&mut self, v: &[f64]) -> &[f64] {
        let (width, na, nb, t) = (self.width, self.a.len(), self.b.len(), self.t);
        let slot = |k: usize| k * width..(k + 1) * width;
        self.inputs[slot(t % nb)].copy_from_slice(v);
        self.out.fill(0.0);
        for (j, &b) in self.b.iter().enumerate().filter(|(_, b)| **b != 0.0) {
            add(&mut self.out, b, &self.inputs[slot((t + nb - j) % nb)]);
        }
        for (i, &a) in self.a.iter().enumerate() {
            add(&mut self.out, a, &self.outputs[slot((t + na - 1 - i) % na)]);
        }
        if na > 0 {
            self.outputs[slot(t % na)].copy_from_slice(&self.out);
        }
        self.t += 1;
        &self.out
    }
}

/// 1/A on one signal, with its last outputs.
pub(super) struct AllPole<'a> {
    a: &'a [f64],
    past: Vec<f64>,
}

impl<'a> AllPole<'a> {
    /// Stores the last `length` outputs.
    pub(super) fn new(a: &'a [f64], length: usize) -> Self {
        AllPole { a, past: vec![0.0; length.max(a.len()).max(1)] }
    }

    pub(super) fn step(&mut self, v: f64) {
        let y = v + self.a.iter().zip(&self.past).map(|(a, y)| a * y).sum::<f64>();
        self.past.rotate_right(1);
        self.past[0] = y;
    }

    /// The last outputs, newest first.
    pub(super) fn past(&self) -> &[f64] {
        &self.past
    }
}

/// y += k x.
#[multiversion(targets("x86_64+avx512f+avx512vl+fma", "x86_64+avx2+fma", "aarch64+neon"))]
pub(super) fn add(y: &mut [f64], k: f64, x: &[f64]) {
    for t in 0..y.len().min(x.len()) {
        y[t] += k * x[t];
    }
}

/// x += rate (v - x).
#[multiversion(targets("x86_64+avx512f+avx512vl+fma", "x86_64+avx2+fma", "aarch64+neon"))]
fn follow(x: &mut [f64], rate: f64, v: &[f64]) {
    for t in 0..x.len().min(v.len()) {
        x[t] += rate * (v[t] - x[t]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::creep::{Creep, Lag};
    use crate::linear::Arx;
    use crate::system::System;
    use crate::testing::assert_close;

    #[test]
    fn parallel_signals_are_those_of_single_runs() {
        let arx = Arx::new(1e-3, vec![1.5, -0.7, 0.1], vec![0.0, 0.3, 0.2]).unwrap();
        let lags = vec![Lag { tau_s: 0.02, gain: 0.1 }, Lag { tau_s: 0.3, gain: 0.0 }, Lag { tau_s: 1.0, gain: 0.3 }];
        let creep = Creep::new(1e-3, lags.clone()).unwrap();
        let rates: Vec<f64> = lags.iter().map(|l| -(-1e-3 / l.tau_s).exp_m1()).collect();
        let gains: Vec<f64> = lags.iter().map(|l| l.gain).collect();
        let signal = |k: usize, t: usize| (t as f64 * (0.1 + 0.07 * k as f64)).sin() + k as f64;
        let (mut ladder, mut filter) = (Ladder::new(&rates, &gains, 3), LinearFilter::new(arx.a(), arx.b(), 3));
        let mut together = vec![Vec::new(); 3];
        for t in 0..400 {
            let mut v = [0, 1, 2].map(|k| signal(k, t));
            ladder.step(&mut v);
            filter.step(&v).iter().zip(&mut together).for_each(|(y, out)| out.push(*y));
        }
        for (k, out) in together.iter().enumerate() {
            let alone = arx.simulate(&creep.simulate(&(0..400).map(|t| signal(k, t)).collect::<Vec<_>>()));
            assert_close(out, &alone, 1e-12, 1e-12);
        }
    }

    #[test]
    fn an_all_pole_block_stores_its_outputs() {
        let mut block = AllPole::new(&[0.5], 3);
        [1.0, 0.0, 0.0].iter().for_each(|&v| block.step(v));
        assert_eq!(block.past(), [0.25, 0.5, 1.0]);
    }
}
