//! The cycles of an input in groups of like frequency and amplitude, and its minor loops.

use super::cycles::{Cycle, MIN_REVERSAL_SHARE, are_regular, reversals};
use super::nested::Nested;
use libm::sqrt;
use piezoid_numerics::series::{mean, quantile, range};
use serde::Serialize;
use std::f64::consts::PI;

/// Cycles are like ones up to this relative difference of frequency, and of amplitude.
const LIKE: f64 = 0.05;

/// Standard deviations of the noise that no reversal exceeds, and the largest share of the range for them.
const NOISE_DEVIATIONS: f64 = 7.0;
const MAX_REVERSAL_SHARE: f64 = 0.1;

/// The noise is estimated in so many places.
const PLACES: usize = 20_000;

/// The sixth difference of a smooth input is small even with ten samples a cycle; that of noise is not.
const SIXTH: [f64; 7] = [1.0, -6.0, 15.0, -20.0, 15.0, -6.0, 1.0];

/// A movement is a step if its middle four fifths take up less than this share of the time between its reversals.
const STEP: f64 = 0.1;

/// Largest share of minor loops that contain others, unless the cycles around them are regular: in random inputs it is
/// about a third.
const MAX_CONTAINING_SHARE: f64 = 0.15;

/// Upper limit for the median second difference of the logarithm of amplitude: it may change every other cycle.
const MAX_BEND: f64 = 0.7;

/// Largest number of cycles that are listed for a group, and of minor loops.
const LISTED: usize = 1000;

/// The cycles of an input by frequency and amplitude, and its minor loops. Samples are the first and the last one.
#[derive(Debug, Clone, Default, PartialEq, Serialize)]
pub struct CycleGroups {
    /// The groups, by frequency, then by amplitude.
    pub groups: Vec<CycleGroup>,
    /// The minor loops: from a reversal within a branch until the input is back at its value; the first thousand.
    pub minor: Vec<[usize; 2]>,
}

/// Cycles of like frequency and amplitude.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CycleGroup {
    /// Mean frequency [Hz], without the time in minor loops; equal in groups that differ in amplitude alone.
    pub frequency: f64,
    /// Mean of half of the movements up and down [input unit].
    pub amplitude: f64,
    /// Number of cycles.
    pub count: usize,
    /// The cycles, from minimum to minimum, in the order of time; the first thousand.
    pub cycles: Vec<[usize; 2]>,
}

impl CycleGroups {
    /// Of `u`, with sampling period `ts` [s]. Empty for inputs without regular cycles, such as PRBS, random steps and
    /// multisines, and for steps with long holds, which show creep.
    ///
    /// ```
    /// use piezoid::excitation::Triangle;
    /// use piezoid_records::waveform::CycleGroups;
    /// let u = Triangle { amplitude: 10.0, frequency: 5.0, ..Triangle::default() }.samples(1e-3, 1000)?;
    /// let found = CycleGroups::of(&u, 1e-3);
    /// assert_eq!((found.groups.len(), found.groups[0].count, found.minor.len()), (1, 4, 0));
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    pub fn of(u: &[f64], ts: f64) -> Self {
        let share = (NOISE_DEVIATIONS * noise(u) / range(u)).clamp(MIN_REVERSAL_SHARE, MAX_REVERSAL_SHARE);
        let all = reversals(u, share);
        let Nested { reversals, loops, containing } = Nested::of(u, &all);
        let (every, found) = (timed(u, &all, &[], ts), timed(u, &reversals, &loops, ts));
        let regular = match found.len() {
            3.. => [every, found.clone()].iter().any(|cycles| are_regular(cycles, MAX_BEND)),
            _ => containing as f64 <= MAX_CONTAINING_SHARE * loops.len() as f64,
        };
        if !regular {
            return CycleGroups::default();
        }
        let minor = loops.into_iter().filter(|[start, turn, _]| !is_step(&u[*start..=*turn])).take(LISTED);
        let minor = minor.map(|[start, _, back]| [start, back]).collect();
        CycleGroups { groups: grouped(u, found, ts), minor }
    }
}

/// The cycles between these reversals; their frequencies are from the times of reversals between samples, without the
/// time in minor loops. Cycles of steps are not among them, and those whose two movements differ in size by more than
/// twice, where the amplitude changes.
fn timed(u: &[f64], reversals: &[usize], loops: &[[usize; 3]], ts: f64) -> Vec<Cycle> {
    // Where loops end that are in no others, and their duration until then.
    let mut inside = vec![(0, 0)];
    for [start, _, back] in loops {
        let (end, total) = inside[inside.len() - 1];
        if *start >= end {
            inside.push((*back, total + back - start));
        }
    }
    let until = |at: usize| inside[inside.partition_point(|(end, _)| *end <= at).max(1) - 1].1;
    // The first reversal is skipped if it is a maximum.
    let first = usize::from(reversals.len() > 1 && u[reversals[0]] > u[reversals[1]]);
    let starts = (first..reversals.len().saturating_sub(2)).step_by(2);
    let cycle = |k: usize| {
        let [start, peak, end] = [0, 1, 2].map(|turn| reversals[k + turn]);
        let (up, down) = (u[peak] - u[start], u[peak] - u[end]);
        let is_of_steps = is_step(&u[start..=peak]) && is_step(&u[peak..=end]);
        let is_change = up.max(down) > 2.0 * up.min(down);
        let duration = between(u, reversals, k + 2) - between(u, reversals, k) - (until(end) - until(start)) as f64;
        let samples = start..end + 1;
        let cycle = Cycle { samples, peak, amplitude: 0.25 * (up + down), hz: 1.0 / (duration * ts) };
        (!is_of_steps && !is_change && duration > 0.0).then_some(cycle)
    };
    starts.filter_map(cycle).collect()
}

/// The time of a reversal [samples]: the middle between the times at which the input passes a level a quarter of the
/// movement away. Noise hardly shifts it, unlike the extreme.
fn between(u: &[f64], reversals: &[usize], k: usize) -> f64 {
    let at = reversals[k];
    let (Some(before), Some(after)) = (k.checked_sub(1).map(|k| reversals[k]), reversals.get(k + 1)) else {
        return at as f64;
    };
    let away = 0.25 * (u[at] - u[before]).abs().min((u[at] - u[*after]).abs());
    let sign = (u[at] - u[before]).signum();
    let depth = |t: usize| sign * (u[at] - u[t]) - away;
    let passes =
        |near: usize, far: usize| near as f64 + (far as f64 - near as f64) * depth(near) / (depth(near) - depth(far));
    let left = (before..at).rev().find(|t| depth(*t) >= 0.0).map(|t| passes(t + 1, t));
    let right = (at + 1..=*after).find(|t| depth(*t) >= 0.0).map(|t| passes(t - 1, t));
    left.zip(right).map_or(at as f64, |(left, right)| 0.5 * (left + right))
}

/// True if a movement of an input is a step with a long hold.
fn is_step(u: &[f64]) -> bool {
    let (from, to) = (u[0], u[u.len() - 1]);
    let part = |t: &usize| (u[*t] - from) / (to - from);
    let (Some(start), Some(end)) = ((0..u.len()).find(|t| part(t) > 0.1), (0..u.len()).find(|t| part(t) >= 0.9)) else {
        return false;
    };
    // A step between two samples takes no longer than one period.
    (end - start + 1) as f64 <= STEP * u.len() as f64
}

/// The cycles in groups.
fn grouped(u: &[f64], found: Vec<Cycle>, ts: f64) -> Vec<CycleGroup> {
    // With few samples a cycle, these miss its peak.
    let missed = |cycle: &Cycle| 0.5 * (PI * cycle.hz * ts).powi(2);
    let noise = noise(u);
    let of_like_frequency = clustered(found, |cycle| cycle.hz, |cycle| LIKE + missed(cycle));
    let mut groups = Vec::new();
    for cycles in of_like_frequency {
        let frequency = 1.0 / mean(&cycles.iter().map(|cycle| 1.0 / cycle.hz).collect::<Vec<_>>());
        let differs = |cycle: &Cycle| LIKE + missed(cycle) + 2.0 * noise / cycle.amplitude;
        for mut cycles in clustered(cycles, |cycle| cycle.amplitude, differs) {
            cycles.sort_unstable_by_key(|cycle| cycle.samples.start);
            let amplitude = mean(&cycles.iter().map(|cycle| cycle.amplitude).collect::<Vec<_>>());
            let samples = |cycle: &Cycle| [cycle.samples.start, cycle.samples.end - 1];
            let cycles: Vec<_> = cycles.iter().map(samples).collect();
            groups.push(CycleGroup { frequency, amplitude, count: cycles.len(), cycles });
        }
    }
    let mut groups = without_changes(groups);
    groups.iter_mut().for_each(|group| group.cycles.truncate(LISTED));
    groups
}

/// The cycles with `of` in clusters: none differs by more than twice `differs` from the lowest.
fn clustered(mut cycles: Vec<Cycle>, of: impl Fn(&Cycle) -> f64, differs: impl Fn(&Cycle) -> f64) -> Vec<Vec<Cycle>> {
    cycles.sort_by(|p, q| of(p).total_cmp(&of(q)));
    let mut clusters: Vec<Vec<Cycle>> = Vec::new();
    for cycle in cycles {
        match clusters.last_mut() {
            Some(last) if of(&cycle) <= of(&last[0]) * (1.0 + 2.0 * differs(&last[0])) => last.push(cycle),
            _ => clusters.push(vec![cycle]),
        }
    }
    clusters
}

/// The groups without single cycles where the record changes from one group of several to another.
fn without_changes(groups: Vec<CycleGroup>) -> Vec<CycleGroup> {
    let ends = |at: usize, one: fn(&[usize; 2]) -> usize| {
        let touches = |group: &&CycleGroup| group.cycles.binary_search_by_key(&at, one).is_ok();
        groups.iter().filter(|group| group.count > 1).find(touches).map(|group| (group.frequency, group.amplitude))
    };
    let is_change = |group: &CycleGroup| {
        let [start, end] = group.cycles[0];
        let (before, after) = (ends(start, |cycle| cycle[1]), ends(end, |cycle| cycle[0]));
        group.count == 1 && before.zip(after).is_some_and(|(before, after)| before != after)
    };
    let changes: Vec<bool> = groups.iter().map(is_change).collect();
    groups.into_iter().zip(changes).filter_map(|(group, is_change)| (!is_change).then_some(group)).collect()
}

/// Standard deviation of the noise of `u`, robust against its reversals.
pub(crate) fn noise(u: &[f64]) -> f64 {
    let places = u.len().saturating_sub(SIXTH.len() - 1);
    let difference = |t: usize| SIXTH.iter().zip(&u[t..]).map(|(c, u)| c * u).sum::<f64>().abs();
    let differences = (0..places).step_by(places / PLACES + 1).map(difference).collect();
    quantile(differences, 0.5) / (0.6745 * sqrt(SIXTH.iter().map(|c| c * c).sum()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::{Chirp, DecayingSine, Multisine, Prbs, RisingSine, Staircase};
    use piezoid_testing::noise;
    use std::f64::consts::TAU;

    const TS: f64 = 1e-3;

    /// Frequency, amplitude and number of cycles of each group, rounded.
    fn groups(u: &[f64]) -> Vec<(f64, f64, usize)> {
        let rounded = |x: f64| (10.0 * x).round() / 10.0;
        let found = CycleGroups::of(u, TS).groups;
        found.iter().map(|group| (rounded(group.frequency), group.amplitude.round(), group.count)).collect()
    }

    /// Sines of these frequencies [Hz], amplitudes and numbers of cycles, one after the other.
    fn sines(parts: &[(f64, f64, usize)]) -> Vec<f64> {
        let part = |&(hz, amplitude, cycles): &(f64, f64, usize)| {
            (0..(cycles as f64 / (hz * TS)) as usize).map(move |t| amplitude * (TAU * hz * TS * t as f64).sin())
        };
        parts.iter().flat_map(part).collect()
    }

    /// Straight lines between these levels, of `slope` a sample.
    fn ramps(levels: &[f64], slope: f64) -> Vec<f64> {
        let between = |w: &[f64]| {
            let (from, to, n) = (w[0], w[1], ((w[1] - w[0]).abs() / slope) as usize);
            (0..n).map(move |t| from + (to - from) * t as f64 / n as f64)
        };
        levels.windows(2).flat_map(between).chain(levels.last().copied()).collect()
    }

    /// With noise of this standard deviation.
    fn noisy(u: &[f64], deviation: f64) -> Vec<f64> {
        u.iter().zip(noise(7, u.len())).map(|(u, e)| u + deviation * e).collect()
    }

    #[test]
    fn sines_one_after_the_other_are_a_group_each_without_the_changes_between_them() {
        let u = sines(&[(1.0, 10.0, 4), (5.0, 10.0, 10), (20.0, 10.0, 20)]);
        // A cycle from minimum to minimum: of each sine one is lost.
        let expected = [(1.0, 10.0, 3), (5.0, 10.0, 9), (20.0, 10.0, 19)];
        assert_eq!(groups(&u), expected);
        assert_eq!(groups(&noisy(&u, 0.03)), expected);
        let first = &CycleGroups::of(&u, TS).groups[0];
        assert_eq!(first.cycles, [[750, 1750], [1750, 2750], [2750, 3750]]);

        let u = sines(&[(5.0, 10.0, 6), (5.0, 2.0, 6), (5.0, 6.0, 6), (10.0, 6.0, 6)]);
        let found = CycleGroups::of(&u, TS);
        assert_eq!(groups(&u), [(5.0, 2.0, 5), (5.0, 6.0, 5), (5.0, 10.0, 5), (10.0, 6.0, 5)]);
        assert!(found.minor.is_empty() && found.groups[0].frequency == found.groups[1].frequency, "{found:?}");
        // Two cycles of each amplitude are no minor loops.
        assert_eq!(groups(&sines(&[(5.0, 2.0, 3), (5.0, 6.0, 3), (5.0, 10.0, 3)])).len(), 3);
    }

    #[test]
    fn cycles_of_rising_and_decaying_sines_are_in_groups_of_their_amplitudes() {
        let rising =
            RisingSine { amplitude: 30.0, frequency: 10.0, ..RisingSine::default() }.samples(TS, 6000).unwrap();
        let decaying =
            DecayingSine { amplitude: 30.0, frequency: 10.0, ..DecayingSine::default() }.samples(TS, 6000).unwrap();
        for u in [&rising, &decaying, &noisy(&rising, 0.03)] {
            let found = CycleGroups::of(u, TS);
            let count: usize = found.groups.iter().map(|group| group.count).sum();
            assert!(count > 50 && found.groups.len() > 10 && found.minor.is_empty(), "{count} {}", found.minor.len());
            for group in &found.groups {
                assert!((group.frequency / 10.0 - 1.0).abs() < 0.03, "{} {}", group.frequency, group.amplitude);
                for [from, to] in &group.cycles {
                    let amplitude = 0.5 * range(&u[*from..=*to]);
                    assert!((amplitude / group.amplitude - 1.0).abs() < 0.2, "{amplitude} {}", group.amplitude);
                }
            }
        }
    }

    #[test]
    fn minor_loops_of_a_triangle_are_apart_from_its_branches() {
        let branch = [-40.0, -10.0, -20.0, 20.0, 5.0, 15.0, 8.0, 40.0];
        let levels = [&branch[..], &[-40.0, 40.0], &branch, &[-40.0, 40.0], &[-40.0, 40.0, 0.0]].concat();
        for deviation in [0.0, 0.1] {
            let u = noisy(&ramps(&levels, 0.1), deviation);
            let found = CycleGroups::of(&u, TS);
            let count: usize = found.groups.iter().map(|group| group.count).sum();
            assert_eq!((count, found.minor.len()), (4, 6), "{found:?}");
            assert!(found.groups.iter().all(|group| (group.amplitude - 40.0).abs() < 0.5), "{found:?}");
            // From -10 down to -20 and back; from 20 to 5 and back, which contains the one from 15 to 8.
            for (minor, right) in found.minor.iter().zip([[300, 500], [800, 1240], [1050, 1190]]) {
                assert!((0..2).all(|k| minor[k].abs_diff(right[k]) <= 20), "{minor:?} {right:?}");
            }
        }
    }

    #[test]
    fn a_few_samples_a_cycle_do() {
        for samples in [6.3, 8.0, 10.7, 20.0] {
            let u: Vec<f64> = (0..400).map(|t| 10.0 * (TAU * f64::from(t) / samples).sin()).collect();
            let found = CycleGroups::of(&u, TS).groups;
            let all: usize = found.iter().map(|group| group.count).sum();
            let most = found.iter().max_by_key(|group| group.count).unwrap();
            assert!(most.count as f64 > 0.9 * 398.0 / samples && all <= 400 / 6, "{samples}: {found:?}");
            assert!((most.frequency * TS * samples - 1.0).abs() < 0.02, "{samples}: {}", most.frequency);
        }
    }

    #[test]
    fn sweeps_and_staircases_have_cycles() {
        let sweep = Chirp { frequency_start: 1.0, frequency_end: 50.0, ..Chirp::default() }.samples(TS, 8000).unwrap();
        let found = CycleGroups::of(&sweep, TS).groups;
        assert!(found.len() > 10 && found.is_sorted_by_key(|group| group.frequency) && found[0].frequency < 6.0);
        let steps = Staircase { amplitude: 3.0, frequency: 2.0, ..Staircase::default() }.samples(TS, 3000).unwrap();
        assert_eq!(groups(&steps).len(), 1);
    }

    #[test]
    fn broadband_inputs_and_long_steps_have_none() {
        let steps = |levels: &[f64]| levels.iter().flat_map(|level| vec![*level; 500]).collect::<Vec<f64>>();
        let wide = |seed| Multisine { frequency_high: 300.0, seed, ..Multisine::default() }.samples(TS, 4000).unwrap();
        for u in [
            Prbs::default().samples(TS, 2047).unwrap(),
            wide(3),
            wide(4),
            steps(&[0.0, 10.0, 0.0, 20.0, 0.0, 30.0]),
            steps(&[0.0, 50.0, 0.0, 50.0, 0.0]),
            noisy(&steps(&[0.0, 50.0, 10.0, 40.0, 20.0, 30.0]), 0.05),
            noise(1, 5000),
            vec![1.0; 50],
            vec![1.0, 2.0],
            vec![1.0],
        ] {
            assert_eq!(CycleGroups::of(&u, TS), CycleGroups::default());
        }
    }

    #[test]
    fn a_sine_on_a_slow_triangle_is_minor_loops_of_it() {
        let slow = ramps(&[-40.0, 40.0, -40.0, 40.0, -40.0, 40.0, -40.0], 0.02);
        let u: Vec<f64> = slow.iter().enumerate().map(|(t, u)| u + 3.0 * (TAU * t as f64 / 250.0).sin()).collect();
        let found = CycleGroups::of(&u, TS);
        assert_eq!(found.groups.iter().map(|group| group.count).sum::<usize>(), 3, "{:?}", found.groups);
        assert!(found.minor.len() > 50, "{}", found.minor.len());
    }
}
