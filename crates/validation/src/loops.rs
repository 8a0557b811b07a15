//! Loops of record and model: width, area, closure and slopes of y over u.
//!
//! A cycle runs from one lower reversal of the input to the upper one and back to the next lower one. Its width is the
//! distance of its branches at mid input over its height. Its area is positive if the ascending branch is below. Its
//! closure is the difference of y between end and start over its height: creep, drift and rising amplitudes keep loops
//! open. Cycles of similar frequency and amplitude are averaged.

use super::bins::{alike, band};
use piezoid_numerics::series::{mean, range};
use piezoid_records::record::Record;
use piezoid_records::waveform::{Cycle, reversals};
use serde::Serialize;
use std::ops::RangeInclusive;

/// Part of the input's height after a reversal from which its slope is computed.
const SLOPE_RANGE_SHARE: f64 = 0.15;

/// Share of its range by which an output must return to count as a reversal.
const MIN_REVERSAL_SHARE: f64 = 0.02;

/// The shape of a loop of y over u.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LoopShape {
    /// 100 distance of the branches at mid input / height; negative if the ascending branch is above.
    pub width_percent: f64,
    /// Area [input unit x output unit]; negative if the loop is inverted.
    pub area: f64,
    /// 100 (y at its end - y at its start) / height.
    pub closure_percent: f64,
    /// Least-squares slope of all points [output unit / input unit].
    pub slope: f64,
    /// Mean slope just after both reversals; `None` if steps have no points there [output unit / input unit].
    pub slope_after_reversal: Option<f64>,
    /// Reversals of the output per cycle: 2, more if it rings.
    pub reversals: f64,
}

/// The mean loops of similar cycles, measured and modelled.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct LoopComparison {
    /// Mean frequency [Hz].
    pub hz: f64,
    /// Mean of half the input's height [input unit].
    pub amplitude: f64,
    /// Number of cycles averaged.
    pub cycles: usize,
    /// Measured loop.
    pub measured: LoopShape,
    /// Loop of the model.
    pub model: LoopShape,
}

/// The loops of these cycles of a record and of a free run.
pub(super) fn loops(record: &Record, simulated: &[f64], cycles: &[Cycle]) -> Vec<LoopComparison> {
    let mut sums = LoopSums::default();
    cycles.iter().for_each(|cycle| sums.add(record.u(), record.y(), simulated, cycle));
    sums.loops()
}

/// The loops of the cycles of a record, one after the other: sums of similar cycles.
#[derive(Debug, Default)]
pub(super) struct LoopSums(Vec<Group>);

/// The sums of similar cycles.
#[derive(Debug)]
struct Group {
    first: Cycle,
    cycles: usize,
    hz: f64,
    amplitude: f64,
    measured: ShapeSums,
    model: ShapeSums,
}

/// Sums of the figures of loops, in the order of [`LoopShape`]; the number of those with a slope after reversals.
#[derive(Debug, Default)]
struct ShapeSums([f64; 6], usize);

impl LoopSums {
    /// Adds a cycle of input, output and free run.
    pub(super) fn add(&mut self, u: &[f64], y: &[f64], simulated: &[f64], cycle: &Cycle) {
        let at = self.0.iter().position(|group| alike(&group.first, cycle)).unwrap_or(self.0.len());
        if at == self.0.len() {
            let [measured, model] = [ShapeSums::default(), ShapeSums::default()];
            self.0.push(Group { first: cycle.clone(), cycles: 0, hz: 0.0, amplitude: 0.0, measured, model });
        }
        let group = &mut self.0[at];
        group.cycles += 1;
        (group.hz, group.amplitude) = (group.hz + cycle.hz, group.amplitude + cycle.amplitude);
        group.measured.add(&of(u, y, cycle));
        group.model.add(&of(u, simulated, cycle));
    }

    /// The loops, by rising frequency, then amplitude.
    pub(super) fn loops(&self) -> Vec<LoopComparison> {
        let one = |group: &Group| LoopComparison {
            hz: group.hz / group.cycles as f64,
            amplitude: group.amplitude / group.cycles as f64,
            cycles: group.cycles,
            measured: group.measured.mean(group.cycles),
            model: group.model.mean(group.cycles),
        };
        let mut loops: Vec<LoopComparison> = self.0.iter().map(one).collect();
        loops.sort_by(|a, b| band(a.hz).total_cmp(&band(b.hz)).then(a.amplitude.total_cmp(&b.amplitude)));
        loops
    }
}

impl ShapeSums {
    fn add(&mut self, shape: &LoopShape) {
        let LoopShape { width_percent, area, closure_percent, slope, slope_after_reversal, reversals } = *shape;
        let figures = [width_percent, area, closure_percent, slope, slope_after_reversal.unwrap_or(0.0), reversals];
        self.0.iter_mut().zip(figures).for_each(|(sum, figure)| *sum += figure);
        self.1 += usize::from(slope_after_reversal.is_some());
    }

    fn mean(&self, cycles: usize) -> LoopShape {
        let [width_percent, area, closure_percent, slope, _, reversals] = self.0.map(|sum| sum / cycles as f64);
        let slope_after_reversal = (self.1 > 0).then(|| self.0[4] / self.1 as f64);
        LoopShape { width_percent, area, closure_percent, slope, slope_after_reversal, reversals }
    }
}

/// The shape of one cycle.
fn of(u: &[f64], y: &[f64], cycle: &Cycle) -> LoopShape {
    let (start, peak, end) = (cycle.samples.start, cycle.peak, cycle.samples.end - 1);
    let (x, part) = (&u[start..=end], &y[start..=end]);
    let height = range(part);
    let middle = 0.5 * (u[peak] + u[start].max(u[end]));
    let gap = at(u, y, peak..=end, middle) - at(u, y, start..=peak, middle);
    // Closed by a line from its end to its start, because an open path has no area.
    let closing = 0.5 * (y[start] + y[end]) * (u[start] - u[end]);
    let area: f64 =
        closing + x.windows(2).zip(part.windows(2)).map(|(u, y)| 0.5 * (y[0] + y[1]) * (u[1] - u[0])).sum::<f64>();
    let after = SLOPE_RANGE_SHARE * 2.0 * cycle.amplitude;
    let rising: Vec<usize> = (start..=peak).take_while(|&t| u[t] <= u[start] + after).collect();
    let falling: Vec<usize> = (peak..=end).take_while(|&t| u[t] >= u[peak] - after).collect();
    let slope_at = |points: &[usize]| {
        let (u, y): (Vec<f64>, Vec<f64>) = points.iter().map(|&t| (u[t], y[t])).unzip();
        (points.len() >= 3).then(|| slope(&u, &y)).filter(|s| s.is_finite())
    };
    // The output is delayed: with a quarter more on either side there are three reversals, one of them of a
    // neighbouring cycle.
    let quarter = (end - start) / 4;
    let around = &y[start.saturating_sub(quarter)..(end + quarter + 1).min(y.len())];
    LoopShape {
        width_percent: 100.0 * gap / height,
        // The integral of y du is the area below the ascending branch less the one below the descending branch.
        area: -area,
        closure_percent: 100.0 * (y[end] - y[start]) / height,
        slope: slope(x, part),
        slope_after_reversal: slope_at(&rising).zip(slope_at(&falling)).map(|(a, b)| 0.5 * (a + b)),
        reversals: reversals(around, MIN_REVERSAL_SHARE).len().saturating_sub(1) as f64,
    }
}

/// The value of `y`, interpolated, where `u` first passes `level` in a part of the record.
fn at(u: &[f64], y: &[f64], part: RangeInclusive<usize>, level: f64) -> f64 {
    let (start, end) = part.into_inner();
    let passes = |t: &usize| (u[*t] - level) * (u[*t + 1] - level) <= 0.0 && u[*t] != u[*t + 1];
    let crossing = (start..end).find(passes);
    crossing.map_or(f64::NAN, |t| y[t] + (y[t + 1] - y[t]) * (level - u[t]) / (u[t + 1] - u[t]))
}

/// The least-squares slope of y over u.
fn slope(u: &[f64], y: &[f64]) -> f64 {
    let (mu, my) = (mean(u), mean(y));
    let (mut uu, mut uy) = (0.0, 0.0);
    for (u, y) in u.iter().zip(y) {
        uu += (u - mu) * (u - mu);
        uy += (u - mu) * (y - my);
    }
    uy / uu
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_records::record::Record;
    use piezoid_records::waveform::cycles;
    use piezoid_testing::assert_close;
    use std::f64::consts::{PI, TAU};

    const TS: f64 = 5e-4;

    fn loops_of(u: Vec<f64>, y: Vec<f64>, simulated: &[f64]) -> Vec<LoopComparison> {
        let record = Record::new(TS, u, y).unwrap();
        loops(&record, simulated, &cycles(record.u(), TS))
    }

    #[test]
    fn the_width_and_area_of_an_ellipse_are_exact() {
        let wave =
            |lag: f64| (0..4000).map(|t| 10.0 * (TAU * 5.0 * f64::from(t) * TS - lag).sin()).collect::<Vec<f64>>();
        let found = loops_of(wave(0.0), wave(0.2), &wave(0.0));
        assert_eq!((found.len(), found[0].cycles), (1, 9));
        let LoopComparison { hz, amplitude, measured, model, .. } = found[0];
        // y lags u by 0.2 rad: the branches are 2 x 10 sin 0.2 apart at mid input, and the area is pi 10 10 sin 0.2.
        let width = 100.0 * 0.2f64.sin();
        assert_close(&[hz, amplitude, measured.width_percent], &[5.0, 10.0, width], 1e-3, 0.0);
        assert_close(&[measured.area, measured.slope], &[PI * 100.0 * 0.2f64.sin(), 0.2f64.cos()], 1e-3, 0.0);
        assert_close(&[measured.closure_percent, model.width_percent, model.area], &[0.0; 3], 0.0, 1e-9);
        assert_eq!((measured.reversals, model.slope_after_reversal.map(|s| (s - 1.0).abs() < 1e-9)), (2.0, Some(true)));
        assert!(measured.slope_after_reversal.unwrap() < 0.8);
    }

    #[test]
    fn the_figures_of_an_open_polygon_are_those_of_its_corners() {
        let u = [0.0, 0.5, 1.0, 4.0, 8.0, 7.5, 7.0, 4.0, 1.0];
        let y = [0.0, 1.0, 1.5, 5.0, 10.0, 9.5, 9.0, 6.0, 3.0];
        let found = of(&u, &y, &Cycle::of(&u, [0, 4, 8], TS));
        // At 4.5, halfway between the maximum and the higher minimum: 5.625 and 6.5.
        assert_close(&[found.width_percent, found.closure_percent], &[8.75, 30.0], 1e-12, 0.0);
        assert_close(&[found.area, found.slope], &[6.375, 884.25 / 742.5], 1e-12, 0.0);
        assert_close(&[found.slope_after_reversal.unwrap()], &[0.5 * (1.5 + 1.0)], 1e-12, 0.0);
        let coarse = Cycle::of(&u, [2, 4, 7], TS);
        assert_eq!(of(&u, &y, &coarse).slope_after_reversal, None, "no three points after the minimum");
    }

    #[test]
    fn loops_of_like_cycles_are_averaged_and_listed_by_frequency_and_amplitude() {
        let u = [0.0, 1.0, 2.0, 1.0, 0.0];
        let mut sums = LoopSums::default();
        for (hz, amplitude, height) in [(10.0, 1.0, 1.0), (5.0, 2.0, 1.0), (5.0, 1.0, 2.0), (5.02, 1.02, 4.0)] {
            let y = u.map(|u| height * u);
            sums.add(&u, &y, &u, &Cycle { samples: 0..5, peak: 2, amplitude, hz });
        }
        let found = sums.loops();
        let listed: Vec<_> = found.iter().map(|l| (l.cycles, l.amplitude, l.measured.slope, l.model.slope)).collect();
        assert_eq!(listed, [(2, 1.01, 3.0, 1.0), (1, 2.0, 1.0, 1.0), (1, 1.0, 1.0, 1.0)]);
        assert_close(&[found[0].hz], &[5.01], 1e-12, 0.0);
    }

    #[test]
    fn drift_opens_loops_and_ringing_adds_reversals() {
        let u: Vec<f64> = (0..4000).map(|t| 10.0 * (TAU * 5.0 * f64::from(t) * TS).sin()).collect();
        let drifting: Vec<f64> = u.iter().enumerate().map(|(t, u)| u + 1e-3 * t as f64).collect();
        let ringing: Vec<f64> = u.iter().enumerate().map(|(t, u)| u + 3.0 * (0.2 * t as f64).sin()).collect();
        let found = loops_of(u, drifting, &ringing);
        assert_close(&[found[0].measured.closure_percent], &[100.0 * 0.4 / 20.2], 2e-2, 0.0);
        assert_eq!(found[0].measured.reversals, 2.0);
        assert!(found[0].model.reversals > 10.0);
    }
}
