//! Modes from free decays: where the input stands still, the output is a sum of the decaying responses of the poles.
//!
//! ```text
//! y_t = y_end + sum_k c_k z_k^t,    H_0 = [d_{i+j}],  H_1 = [d_{i+j+1}],  d_t = y_{t+1} - y_t
//! H_0 = U S V',    z_k = eigenvalues of S^-1 U' H_1 V     (rank r)
//! ```
//! The rows of all decays stand in one matrix, because they have the same poles.
//!
//! Matrix pencil: Hua & Sarkar 1990, DOI 10.1109/29.56027; with several decays: Juang & Pappa 1985, DOI
//! 10.2514/3.20031.

use super::Pole;
use super::analysis::Root;
use nalgebra::{Complex, DMatrix, DVector};
use piezoid_numerics::complex::modulus;
use piezoid_numerics::series::ends;
use piezoid_records::record::Record;
use std::f64::consts::TAU;

/// Shortest and longest decay that is used [samples].
const SHORTEST: usize = 64;
const LONGEST: usize = 800;

/// Rank of the pencil: twice the number of modes, and some real poles.
const RANK: usize = 8;

/// Change of the input, as a share of its range, up to which it stands still.
const MAX_REST_CHANGE: f64 = 1e-4;

/// Share of the energy of the decays from which a mode counts, and the most damping that rings.
const MIN_MODE_ENERGY_SHARE: f64 = 0.03;
const MAX_MODE_DAMPING: f64 = 0.3;

/// Share of the energy of the decays from which the poles explain them: otherwise the output only holds noise.
const EXPLAINED: f64 = 0.5;

/// Ratio of singular values that is zero.
const SINGULAR: f64 = 1e-9;

/// Decay of ln(amplitude) over the longest decay from which it is not hum.
const MIN_LOG_DECAY: f64 = 0.5;

/// The highest frequency of a mode, over the sampling rate.
const HIGHEST: f64 = 0.45;

/// The modes that ring in the decays of `records`, the one with the most energy first.
pub fn free_decay_modes(records: &[Record]) -> Vec<Pole> {
    let Some(first) = records.first() else { return Vec::new() };
    let decays: Vec<Vec<f64>> = records.iter().flat_map(decays).collect();
    let Some(longest) = decays.iter().map(Vec::len).max() else { return Vec::new() };
    let rows = (longest / 3).clamp(RANK + 1, 160);
    let columns: usize = decays.iter().map(|d| d.len().saturating_sub(rows)).sum();
    if columns < 2 * RANK {
        return Vec::new();
    }
    let mut hankel = [DMatrix::zeros(rows, columns), DMatrix::zeros(rows, columns)];
    let mut column = 0;
    for d in &decays {
        for j in 0..d.len().saturating_sub(rows) {
            for i in 0..rows {
                hankel[0][(i, column)] = d[i + j];
                hankel[1][(i, column)] = d[i + j + 1];
            }
            column += 1;
        }
    }
    // U and S from the small matrix H_0 H_0'.
    let [h0, h1] = hankel;
    let eigen = (&h0 * h0.transpose()).symmetric_eigen();
    let mut order: Vec<usize> = (0..rows).collect();
    order.sort_by(|&i, &j| eigen.eigenvalues[j].total_cmp(&eigen.eigenvalues[i]));
    let u = DMatrix::from_fn(rows, RANK, |i, k| eigen.eigenvectors[(i, order[k])]);
    let squares = DVector::from_fn(RANK, |k, _| eigen.eigenvalues[order[k]].max(f64::MIN_POSITIVE));
    // S^-1 U' H_1 V = S^-2 U' H_1 H_0' U in other words.
    let crossed = u.transpose() * &h1 * h0.transpose() * &u;
    let pencil = DMatrix::from_fn(RANK, RANK, |i, j| crossed[(i, j)] / squares[j]);
    // A growing exponential is noise.
    let decays_away = |z: &Complex<f64>| modulus(*z) < 1.0;
    let poles: Vec<Complex<f64>> = pencil.complex_eigenvalues().iter().copied().filter(decays_away).collect();
    let (energy, left) = energies(&decays, &poles);
    let total: f64 = decays.iter().flatten().map(|d| d * d).sum();
    if left > (1.0 - EXPLAINED) * total {
        return Vec::new();
    }
    let ts = first.ts();
    let fades = |pole: &Pole| TAU * pole.hz * pole.damping * longest as f64 * ts > MIN_LOG_DECAY;
    let mut modes: Vec<(f64, Pole)> = poles
        .iter()
        .zip(energy)
        .filter(|(z, energy)| z.im > 0.0 && *energy > MIN_MODE_ENERGY_SHARE * total)
        .map(|(z, energy)| (energy, Pole::of(Root { re: z.re, im: z.im }, ts)))
        .filter(|(_, pole)| pole.damping < MAX_MODE_DAMPING && pole.hz < HIGHEST / ts && fades(pole))
        .collect();
    modes.sort_by(|p, q| q.0.total_cmp(&p.0));
    modes.into_iter().map(|(_, pole)| pole).collect()
}

/// The differences of the output from where the input stops on.
fn decays(record: &Record) -> Vec<Vec<f64>> {
    let (low, high) = ends(record.u().iter().copied());
    let slack = MAX_REST_CHANGE * (high - low);
    let (u, y) = (record.u(), record.y());
    let mut found = Vec::new();
    let mut start = 0;
    for t in 1..=u.len() {
        if t == u.len() || (u[t] - u[start]).abs() > slack {
            if t - start >= SHORTEST {
                let part = &y[start..t.min(start + LONGEST)];
                found.push(part.windows(2).map(|w| w[1] - w[0]).collect());
            }
            start = t;
        }
    }
    found
}

/// The energy of each pole and its conjugate in the decays, by least squares on all, and the energy that is left.
fn energies(decays: &[Vec<f64>], poles: &[Complex<f64>]) -> (Vec<f64>, f64) {
    let (mut energy, mut left) = (vec![0.0; poles.len()], 0.0);
    for d in decays {
        let n = d.len();
        let basis = DMatrix::from_fn(n, poles.len(), |t, k| poles[k].powu(t as u32));
        let target = DVector::from_iterator(n, d.iter().map(|d| Complex::new(*d, 0.0)));
        // Poles may be nearly equal.
        let Ok(c) = basis.clone().svd(true, true).solve(&target, SINGULAR) else { continue };
        for k in 0..poles.len() {
            energy[k] += 2.0 * (0..n).map(|t| (c[k] * basis[(t, k)]).norm_sqr()).sum::<f64>();
        }
        left += (target - basis * c).norm_squared();
    }
    (energy, left)
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::noise;

    const TS: f64 = 1e-3;

    /// Rest, a step and rest again, with `y` of the time since the step and of the time.
    fn stepped(y: impl Fn(f64, f64) -> f64) -> Record {
        let u = (0..600).map(|t| if t < 300 { 0.0 } else { 10.0 }).collect();
        let y = (0..600).map(|t| y(f64::from(t - 300) * TS, f64::from(t) * TS)).collect();
        Record::new(TS, u, y).unwrap()
    }

    #[test]
    fn a_ring_down_shows_its_mode() {
        let (w, zeta) = (TAU * 80.0, 0.02);
        let ring = |since: f64| match since < 0.0 {
            true => 0.0,
            false => 1.0 - (-zeta * w * since).exp() * (w * (1.0 - zeta * zeta).sqrt() * since).cos(),
        };
        let modes = free_decay_modes(&[stepped(|since, _| ring(since))]);
        assert_eq!(modes.len(), 1, "{modes:?}");
        assert!((modes[0].hz - 80.0).abs() < 0.01 && (modes[0].damping - 0.02).abs() < 1e-4, "{modes:?}");
    }

    #[test]
    fn energies_are_sums_over_the_decays_and_what_is_not_explained_is_left() {
        // A pole at the origin explains the first sample of each.
        let decays = [vec![1.0, 0.0, 0.0, 2.0], vec![3.0, 0.0, 1.0]];
        assert_eq!(energies(&decays, &[Complex::new(0.0, 0.0)]), (vec![2.0 * (1.0 + 9.0)], 4.0 + 1.0));
    }

    #[test]
    fn noise_and_hum_show_no_mode() {
        let noise = noise(1, 600);
        let noise = |t: f64| noise[(t / TS).round() as usize];
        assert!(free_decay_modes(&[stepped(|_, t| noise(t))]).is_empty());
        assert!(free_decay_modes(&[stepped(|_, t| noise(t) + 3.0 * (TAU * 50.0 * t).sin())]).is_empty());
        assert!(free_decay_modes(&[stepped(|_, t| (TAU * 50.0 * t).sin())]).is_empty());
    }

    #[test]
    fn long_noise_after_a_ring_does_not_hide_it() {
        let (w, zeta) = (TAU * 95.0, 0.05);
        let noise = noise(2, 30_000);
        let ring = |since: f64| (-zeta * w * since).exp() * (w * since).cos();
        // 30 steps a second apart, of which one rings.
        let u: Vec<f64> = (0..30_000).map(|t| f64::from(t / 1000 % 2)).collect();
        let y = (0..30_000).map(|t| {
            let since = f64::from(t - 9000) * TS;
            0.004 * noise[t as usize] + if (0.0..1.0).contains(&since) { ring(since) } else { 0.0 }
        });
        let modes = free_decay_modes(&[Record::new(TS, u, y.collect()).unwrap()]);
        assert_eq!(modes.len(), 1, "{modes:?}");
        assert!((modes[0].hz - 95.0).abs() < 1.0 && (modes[0].damping - 0.05).abs() < 0.01, "{modes:?}");
    }
}
