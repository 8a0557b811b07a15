//! Linear blocks on many signals in parallel.

use multiversion::multiversion;

/// Signals that are filtered together: several vectors of a vector unit, as far as it has registers, or one.
const WIDE: usize = if cfg!(target_arch = "wasm32") { NARROW } else { 32 };
const NARROW: usize = 8;

/// What has decayed to this is zero: processors are slow with numbers next to the smallest ones.
pub(crate) const DECAYED_SIGNAL: f64 = 1e-100;

/// Creep, then G = B/A, on many signals.
pub(crate) struct Filters {
    /// 1 - exp(-Ts / tau), and gain, of the lags that have one.
    lags: Vec<(f64, f64)>,
    /// b_j and a_j of each delay.
    coefficients: Vec<(f64, f64)>,
    wide: Vec<States<WIDE>>,
    narrow: Vec<States<NARROW>>,
}

impl Filters {
    /// Filters at rest for at least this number of signals; `lags` are (1 - exp(-Ts / tau), gain).
    pub(super) fn new(signals: usize, lags: &[(f64, f64)], a: &[f64], b: &[f64]) -> Self {
        let lags: Vec<_> = lags.iter().copied().filter(|lag| lag.1 != 0.0).collect();
        let at = |c: &[f64], k: usize| c.get(k).copied().unwrap_or_default();
        let delays = b.len().max(a.len() + 1);
        let coefficients: Vec<_> = (0..delays).map(|k| (at(b, k), if k > 0 { at(a, k - 1) } else { 0.0 })).collect();
        Filters {
            wide: (0..signals / WIDE).map(|_| States::at_rest(lags.len(), delays)).collect(),
            narrow: (0..(signals % WIDE).div_ceil(NARROW)).map(|_| States::at_rest(lags.len(), delays)).collect(),
            lags,
            coefficients,
        }
    }

    /// The number of signals.
    pub(crate) fn len(&self) -> usize {
        WIDE * self.wide.len() + NARROW * self.narrow.len()
    }

    /// Filters the signals of `rows` from column `from` on, which have `width` columns each.
    pub(crate) fn pass(&mut self, rows: &mut [f64], width: usize, mut from: usize) {
        for states in &mut self.wide {
            pass(rows, width, from, &self.lags, &self.coefficients, &mut states.lagging, &mut states.carried);
            states.end_decayed();
            from += WIDE;
        }
        for states in &mut self.narrow {
            pass(rows, width, from, &self.lags, &self.coefficients, &mut states.lagging, &mut states.carried);
            states.end_decayed();
            from += NARROW;
        }
    }
}

/// The states of filters of `LANES` signals.
struct States<const LANES: usize> {
    lagging: Vec<[f64; LANES]>,
    /// What past samples add to the outputs of the next ones (the transposed direct form).
    carried: Vec<[f64; LANES]>,
}

impl<const LANES: usize> States<LANES> {
    fn at_rest(lags: usize, delays: usize) -> Self {
        States { lagging: vec![[0.0; LANES]; lags], carried: vec![[0.0; LANES]; delays] }
    }

    fn end_decayed(&mut self) {
        self.lagging.iter_mut().chain(&mut self.carried).flatten().for_each(end_decayed);
    }
}

fn end_decayed(x: &mut f64) {
    *x = if x.abs() < DECAYED_SIGNAL { 0.0 } else { *x };
}

/// x_i += rate_i (v - x_i),  w = v + sum_i gain_i x_i;  y = b_0 w + s_0,  s_k = b_{k+1} w + a_{k+1} y + s_{k+1}.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2", "aarch64+neon"))]
fn pass<const LANES: usize>(
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

/// The states of creep behind z, and what its initial states have become.
pub(crate) struct CreepStates {
    /// Number of lags; the last of each eight may be none.
    lags: usize,
    rates: Vec<[f64; NARROW]>,
    gains: Vec<[f64; NARROW]>,
    initial: Vec<[f64; NARROW]>,
    lagging: Vec<[f64; NARROW]>,
    decaying: Vec<[f64; NARROW]>,
}

impl CreepStates {
    /// At rest; `lags` are (1 - exp(-Ts / tau), gain), and `initial` what their initial states add to the output.
    pub(super) fn new(lags: &[(f64, f64)], initial: &[f64]) -> Self {
        let by_eight = |values: &mut dyn Iterator<Item = f64>| {
            let values: Vec<f64> = values.collect();
            let eight = |values: &[f64]| std::array::from_fn(|l| values.get(l).copied().unwrap_or_default());
            values.chunks(NARROW).map(eight).collect::<Vec<_>>()
        };
        let rest = vec![[0.0; NARROW]; lags.len().div_ceil(NARROW)];
        CreepStates {
            lags: lags.len(),
            rates: by_eight(&mut lags.iter().map(|lag| lag.0)),
            gains: by_eight(&mut lags.iter().map(|lag| lag.1)),
            initial: by_eight(&mut initial.iter().copied()),
            lagging: rest.clone(),
            decaying: rest,
        }
    }

    /// The record begins: its initial states decay from here on.
    pub(crate) fn begin(&mut self) {
        self.decaying.iter_mut().for_each(|decaying| *decaying = [1.0; NARROW]);
    }

    /// Creep of a block of z; writes the lags, then the decaying ones, into `rows` from column `from` on.
    pub(super) fn pass(&mut self, z: &[f64], rows: &mut [f64], width: usize, from: usize) -> Vec<f64> {
        let mut crept = z.to_vec();
        for k in 0..self.rates.len() {
            creep(self, k, z, &mut crept, rows, width, from);
        }
        self.lagging.iter_mut().chain(&mut self.decaying).flatten().for_each(end_decayed);
        crept
    }
}

/// Eight lags from lag 8 `k` on:
/// x_i += rate_i (z - x_i),  d_i *= 1 - rate_i;  crept += sum_i gain_i x_i + initial_i d_i.
#[multiversion(targets("x86_64+avx512f+avx512vl", "x86_64+avx2", "aarch64+neon"))]
fn creep(
    states: &mut CreepStates,
    k: usize,
    z: &[f64],
    crept: &mut [f64],
    rows: &mut [f64],
    width: usize,
    from: usize,
) {
    let (n, first) = (NARROW.min(states.lags - NARROW * k), from + NARROW * k);
    let (rate, gain, initial) = (states.rates[k], states.gains[k], states.initial[k]);
    let (mut x, mut d) = (states.lagging[k], states.decaying[k]);
    for ((row, z), crept) in rows.chunks_exact_mut(width).zip(z).zip(crept) {
        let mut parts = [0.0; NARROW];
        for l in 0..NARROW {
            x[l] += rate[l] * (z - x[l]);
            d[l] *= 1.0 - rate[l];
            parts[l] = gain[l] * x[l] + initial[l] * d[l];
        }
        let [p, q, r, s, t, u, v, w] = parts;
        *crept += ((p + q) + (r + s)) + ((t + u) + (v + w));
        row[first..first + n].copy_from_slice(&x[..n]);
        row[first + states.lags..first + states.lags + n].copy_from_slice(&d[..n]);
    }
    (states.lagging[k], states.decaying[k]) = (x, d);
}

/// 1/A on one signal, block by block.
pub(crate) struct AllPole<'a> {
    a: &'a [f64],
    /// Number of outputs before the block.
    past: usize,
    /// Those, then the outputs of the block.
    outputs: Vec<f64>,
}

impl<'a> AllPole<'a> {
    /// At rest; stores the outputs of `past` samples before a block.
    pub(super) fn new(a: &'a [f64], past: usize) -> Self {
        let past = past.max(a.len());
        AllPole { a, past, outputs: vec![0.0; past] }
    }

    /// Filters the next block.
    pub(crate) fn pass(&mut self, inputs: &[f64]) {
        let start = self.outputs.len() - self.past;
        self.outputs.copy_within(start.., 0);
        self.outputs.truncate(self.past);
        self.outputs.iter_mut().for_each(end_decayed);
        self.outputs.extend(inputs);
        // Of a known order, the last outputs stay in registers.
        let pass = match self.a.len() {
            0 => return,
            1 => all_pole::<1>,
            2 => all_pole::<2>,
            3 => all_pole::<3>,
            4 => all_pole::<4>,
            5 => all_pole::<5>,
            6 => all_pole::<6>,
            7 => all_pole::<7>,
            8 => all_pole::<8>,
            _ => all_pole_of_any_order,
        };
        pass(self.a, &mut self.outputs, self.past);
    }

    /// The outputs of the block `delay` samples later, and those of the `more` samples before them.
    fn delayed(&self, delay: usize, more: usize) -> &[f64] {
        &self.outputs[self.past - delay - more..self.outputs.len() - delay]
    }

    /// Adds sum_j b_j q^-j of the outputs to the block `y`.
    pub(crate) fn add_to(&self, y: &mut [f64], b: &[f64]) {
        b.iter().enumerate().for_each(|(delay, b)| add(y, *b, self.delayed(delay, 0)));
    }

    /// The differences of order 0, 1, ... `n` - 1 of the outputs over the block, `delay` samples later.
    pub(crate) fn differences(&self, delay: usize, n: usize, mut each: impl FnMut(usize, &[f64])) {
        let Some(highest) = n.checked_sub(1) else { return };
        let mut differences = self.delayed(delay, highest).to_vec();
        let samples = self.outputs.len() - self.past;
        for order in 0..=highest {
            if order > 0 {
                (1..differences.len()).for_each(|t| differences[t - 1] = differences[t] - differences[t - 1]);
                differences.pop();
            }
            each(order, &differences[differences.len() - samples..]);
        }
    }
}

/// y_t = v_t + sum_i a_i y_{t-i}, in place of v from sample `start` on, in the transposed direct form.
fn all_pole<const N: usize>(a: &[f64], signal: &mut [f64], start: usize) {
    let Some(&a) = a.first_chunk::<N>() else { return };
    let carried = |k: usize| (k..N).map(|i| a[i] * signal[start + k - i - 1]).sum();
    let mut carried: [f64; N] = std::array::from_fn(carried);
    for y in &mut signal[start..] {
        *y += carried[0];
        for k in 0..N - 1 {
            carried[k] = a[k] * *y + carried[k + 1];
        }
        carried[N - 1] = a[N - 1] * *y;
    }
}

fn all_pole_of_any_order(a: &[f64], signal: &mut [f64], start: usize) {
    for t in start..signal.len() {
        let past = signal[t - a.len()..t].iter().rev();
        signal[t] += a.iter().zip(past).map(|(a, y)| a * y).sum::<f64>();
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
        let mut filters = Filters::new(WIDE + NARROW + 1, &lags, arx.a(), arx.b());
        // Rows of 3 other signals, then those to filter.
        let width = 3 + filters.len();
        let mut rows: Vec<f64> = (0..400).flat_map(|t| (0..width).map(move |k| signal(k, t))).collect();
        rows.chunks_mut(64 * width).for_each(|rows| filters.pass(rows, width, 3));
        for k in 0..width {
            let input: Vec<f64> = (0..400).map(|t| signal(k, t)).collect();
            let filtered = arx.simulate(&creep.simulate(&input));
            let out: Vec<f64> = rows.iter().skip(k).step_by(width).copied().collect();
            assert_close(&out, if k < 3 { &input } else { &filtered }, 1e-12, 1e-12);
        }
    }

    #[test]
    fn an_all_pole_block_gives_its_outputs_and_their_differences() {
        let mut block = AllPole::new(&[0.5], 3);
        block.pass(&[1.0]);
        block.pass(&[0.0, 0.0]);
        let mut y = [0.0; 2];
        block.add_to(&mut y, &[1.0, 0.0, 8.0]);
        assert_eq!(y, [0.5, 0.25 + 8.0]);
        let mut found = Vec::new();
        block.differences(1, 3, |order, values| found.push((order, values.to_vec())));
        assert_eq!(found, [(0, vec![1.0, 0.5]), (1, vec![1.0, -0.5]), (2, vec![1.0, -1.5])]);
    }

    #[test]
    fn filters_have_lanes_for_all_signals_and_few_more() {
        for (signals, lanes) in [(1, 8), (8, 8), (9, 16), (32, 32), (33, 40), (64, 64), (73, 80)] {
            assert_eq!(Filters::new(signals, &[], &[0.5], &[1.0]).len(), lanes);
        }
    }

    #[test]
    fn all_pole_blocks_of_every_order_are_those_of_the_difference_equation() {
        let u: Vec<f64> = (0..100).map(|t| (0.7 * f64::from(t)).sin()).collect();
        for order in 1..=10 {
            let a: Vec<f64> = (0..order).map(|k| 0.4 * (-0.6f64).powi(k)).collect();
            let b = [0.0, 1.0, 0.5];
            let mut block = AllPole::new(&a, b.len());
            let mut y = Vec::new();
            for inputs in u.chunks(7) {
                block.pass(inputs);
                let mut part = vec![0.0; inputs.len()];
                block.add_to(&mut part, &b);
                y.extend(part);
            }
            let expected = Arx::new(1e-3, a, b.to_vec()).unwrap().simulate(&u);
            assert_close(&y, &expected, 1e-12, 1e-12);
        }
    }

    #[test]
    fn lags_beyond_eight_creep_and_decay_each_on_its_own() {
        let lags: Vec<(f64, f64)> = (1..=11).map(|k| (0.3 / f64::from(k), 0.1 + 0.02 * f64::from(k))).collect();
        let initial: Vec<f64> = (1..=11).map(|k| 0.7 - 0.2 * f64::from(k)).collect();
        let mut creep = CreepStates::new(&lags, &initial);
        // Three other columns, the lags, the decaying ones, and another column.
        let (width, from) = (26, 3);
        let mut rows = vec![7.0; 40 * width];
        assert_eq!(creep.pass(&[0.0; 5], &mut rows[..5 * width], width, from), [0.0; 5]);
        assert_eq!(rows[from..from + 22], [0.0; 22], "nothing decays before the record begins");
        creep.begin();
        let mut crept = Vec::new();
        for rows in rows.chunks_mut(16 * width) {
            crept.extend(creep.pass(&vec![2.0; rows.len() / width], rows, width, from));
        }
        for (t, row) in (1..).zip(rows.chunks(width)) {
            let decaying: Vec<f64> = lags.iter().map(|lag| (1.0 - lag.0).powi(t)).collect();
            let lagging: Vec<f64> = decaying.iter().map(|d| 2.0 * (1.0 - d)).collect();
            let each = lags.iter().zip(&initial).zip(lagging.iter().zip(&decaying));
            let sum = 2.0 + each.map(|(((_, gain), initial), (x, d))| gain * x + initial * d).sum::<f64>();
            assert_close(&row[from..from + 22], &[lagging, decaying].concat(), 1e-12, 1e-14);
            assert_close(&[crept[t as usize - 1]], &[sum], 1e-12, 1e-12);
            assert_eq!([&row[..from], &row[from + 22..]].concat(), [7.0; 4]);
        }
        assert_eq!(crept.len(), 40);
    }

    #[test]
    fn what_has_decayed_is_zero() {
        // Each halves its signal in a sample: 2^-600 is 2e-181.
        let mut filters = Filters::new(1, &[(0.5, 1.0)], &[0.5], &[1.0]);
        let (mut creep, mut block) = (CreepStates::new(&[(0.5, 1.0)], &[1.0]), AllPole::new(&[0.5], 1));
        creep.begin();
        for k in 0..10 {
            let mut signal = [0.0; 64];
            signal[0] = if k == 0 { 1.0 } else { 0.0 };
            let mut rows = vec![0.0; 64 * NARROW];
            rows[0] = signal[0];
            filters.pass(&mut rows, NARROW, 0);
            let mut lags = vec![0.0; 64 * 2];
            let crept = creep.pass(&signal, &mut lags, 2, 0);
            block.pass(&signal);
            let mut y = [0.0; 64];
            block.add_to(&mut y, &[1.0]);
            let largest = [&rows[..], &lags, &crept, &y].map(|x| x.iter().fold(0.0f64, |most, x| most.max(x.abs())));
            // Each block takes up the last state of the one before.
            assert!(largest.iter().all(|largest| (*largest > 0.0) == (k < 6)), "{k}: {largest:?}");
        }
    }
}
