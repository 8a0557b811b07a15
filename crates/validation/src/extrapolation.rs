//! Remarks on an input that leaves the data of which the model was identified: there the model extrapolates.

use super::remarks::{Comparison, Remark};
use piezoid_models::hammerstein::{Domain, Model};
use piezoid_numerics::number::short;
use piezoid_records::quality::likely_cause;

/// Share of the identified range by which an input must return to count as a reversal, and stay off the ends to count
/// as an inner reversal.
const MIN_REVERSAL_SHARE: f64 = 0.05;

/// Relative excess of a frequency without a remark.
const FREQUENCY_MARGIN: f64 = 0.1;

/// The same for the band of an input: a rising amplitude widens its line.
const BAND_MARGIN: f64 = 0.25;

/// How far the mean of an input may be from those of the identified records without a remark, over the identified
/// range. Inputs with another waveform over the same range differ by less; farther away, creep and inner loops occur at
/// levels that the identified records only passed.
const MEAN_MARGIN: f64 = 0.2;

/// Range of the input, over the identified range, from which a unit or a scale is wrong.
const MAX_RANGE_RATIO: f64 = 100.0;

pub(super) static RANGE: Remark =
    Remark { name: "range", when: "u exceeds the identified range by more than 1 %", text: range };

pub(super) static FREQUENCY: Remark = Remark {
    name: "frequency",
    when: "u oscillates more than 10 % outside the frequencies of a hysteresis block that depends on frequency",
    text: frequency,
};

pub(super) static INNER_REVERSALS: Remark = Remark {
    name: "inner reversals",
    when: "u reverses inside the identified range, and the hysteresis block has no minor loops",
    text: |c| {
        let operator = c.model.hysteresis().operator();
        let reversals = c.inner_reversals;
        (reversals > 0 && !operator.minor_loops).then(|| {
            format!(
                "the input has {reversals} reversals inside the identified range, but the {} block has no minor loops: \
                 at each of them it jumps to the other branch of the major loop",
                operator.name
            )
        })
    },
};

pub(super) static BAND: Remark = Remark {
    name: "band",
    when: "u has power more than 25 % outside the identified band",
    text: |c| {
        let (identified, domain) = c.domains()?;
        let ([low, high], [slowest, fastest]) = domain.hz.zip(identified.hz)?;
        // The frequency resolution of a record is one over its duration.
        let resolution = 1.0 / c.facts.duration;
        let is_above = high > (1.0 + BAND_MARGIN) * fastest + resolution;
        let is_below = low < (1.0 - BAND_MARGIN) * slowest - resolution;
        let [low, high, slowest, fastest] = [low, high, slowest, fastest].map(short);
        ((is_above || is_below) && frequency(c).is_none()).then(|| {
            format!(
                "the input has power from {low} to {high} Hz, but the model was identified from {slowest} to {fastest} \
                 Hz: outside this range it extrapolates"
            )
        })
    },
};

pub(super) static RATE: Remark = Remark {
    name: "rate",
    when: "u changes more than 10 % faster than in the training data",
    text: |c| {
        let ((identified, domain), unit) = (c.domains()?, &c.model.units().u);
        let [here, known] = [domain.slew, identified.slew].map(short);
        identified.is_slower_than(domain.slew).then(|| {
            format!(
                "the input changes by up to {here} {unit}/s, but the model was identified up to {known} {unit}/s: \
                 above this rate it extrapolates"
            )
        })
    },
};

pub(super) static BIAS: Remark = Remark {
    name: "bias",
    when: "the mean of u is outside those of the training data by more than 20 % of the identified range",
    text: |c| {
        let ((identified, domain), unit) = (c.domains()?, &c.model.units().u);
        let slack = MEAN_MARGIN * (identified.u[1] - identified.u[0]);
        let means = match (short(identified.mean[0]), short(identified.mean[1])) {
            (low, high) if low == high => low,
            (low, high) => format!("from {low} to {high}"),
        };
        let mean = short(domain.mean[0]);
        (domain.mean[0] < identified.mean[0] - slack || domain.mean[1] > identified.mean[1] + slack).then(|| {
            format!(
                "the input has a mean of {mean} {unit}, but the model was identified at {means} {unit}: at another \
                 bias the model extrapolates"
            )
        })
    },
};

/// True if the input leaves the data that the model was identified from.
pub(super) fn is_outside(c: &Comparison) -> bool {
    [&RANGE, &FREQUENCY, &BAND, &RATE, &BIAS].iter().any(|remark| (remark.text)(c).is_some())
}

pub(super) fn range(c: &Comparison) -> Option<String> {
    let unit = &c.model.units().u;
    let (low, high) = identified_range(c.model)?;
    let [lowest, highest] = c.facts.domain.u;
    let times = (highest - lowest) / (high - low);
    let cause = || format!("; at {} times the range, {}", short(times), likely_cause(times, unit));
    let cause = (times > MAX_RANGE_RATIO).then(cause).unwrap_or_default();
    let known = Domain { u: [low, high], ..c.facts.domain };
    (!known.spans([lowest, highest])).then(|| {
        let [lowest, highest, low, high] = [lowest, highest, low, high].map(short);
        format!(
            "the input runs from {lowest} to {highest} {unit}, but the model was identified from {low} to {high} \
             {unit}: outside this range it extrapolates{cause}"
        )
    })
}

pub(super) fn identified_range(model: &Model) -> Option<(f64, f64)> {
    model.hysteresis().range().or_else(|| model.identified().map(|d| (d.u[0], d.u[1])))
}

fn frequency(c: &Comparison) -> Option<String> {
    let (slowest, fastest) = c.model.hysteresis().frequencies()?;
    let known = (1.0 - FREQUENCY_MARGIN) * slowest..=(1.0 + FREQUENCY_MARGIN) * fastest;
    c.facts.cycle_rates.iter().find(|hz| !known.contains(*hz)).map(|hz| {
        let [hz, slowest, fastest] = [*hz, slowest, fastest].map(short);
        format!(
            "the input oscillates at {hz} Hz, but the model was identified from {slowest} to {fastest} Hz: outside \
             this range it extrapolates"
        )
    })
}

/// Number of reversals of `u` inside the range from `low` to `high`, away from its ends.
pub fn inner_reversals(u: &[f64], low: f64, high: f64) -> usize {
    let mut inner = InnerReversals::new(low, high);
    u.iter().for_each(|u| inner.add(*u));
    inner.count
}

/// The same, sample by sample.
#[derive(Debug)]
pub(super) struct InnerReversals {
    low: f64,
    high: f64,
    extreme: Option<f64>,
    trend: f64,
    /// Their number so far.
    pub(super) count: usize,
}

impl InnerReversals {
    pub(super) fn new(low: f64, high: f64) -> Self {
        InnerReversals { low, high, extreme: None, trend: 0.0, count: 0 }
    }

    pub(super) fn add(&mut self, u: f64) {
        let (extreme, margin) = (*self.extreme.get_or_insert(u), MIN_REVERSAL_SHARE * (self.high - self.low));
        if (u - extreme) * self.trend > 0.0 {
            self.extreme = Some(u);
        } else if (u - extreme).abs() > margin {
            let is_inner = extreme > self.low + margin && extreme < self.high - margin;
            self.count += usize::from(self.trend != 0.0 && is_inner);
            (self.trend, self.extreme) = ((u - extreme).signum(), Some(u));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_reversals_inside_the_range_are_counted() {
        let full: Vec<f64> = (0..400).map(|t| (f64::from(t) * 0.1).sin()).collect();
        assert_eq!(inner_reversals(&full, -1.0, 1.0), 0);
        let half: Vec<f64> = full.iter().map(|u| 0.5 * u).collect();
        assert_eq!(inner_reversals(&half, -1.0, 1.0), 12);
    }

    #[test]
    fn reversals_of_more_than_the_margin_count_if_they_are_off_the_ends_by_more() {
        // A twentieth of the range is 0.2.
        let count = |u: &[f64]| inner_reversals(u, -1.0, 3.0);
        assert_eq!([2.7, 2.9, -0.7, -0.9].map(|turn| count(&[1.0, turn, 1.0])), [1, 0, 1, 0]);
        assert_eq!([0.35, 0.25].map(|turn| count(&[0.0, 0.5, turn, 0.6])), [0, 2]);
        assert_eq!(count(&[0.0, 0.5, 0.6, 0.3, 0.2, 0.1, 0.4]), 2, "from the extreme on");
    }
}
