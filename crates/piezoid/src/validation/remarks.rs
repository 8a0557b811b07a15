//! Remarks on the figures: where the model extrapolates, and what the record does not test.

use super::drift::Drift;
use super::floor::rough;
use super::{LoopComparison, Metrics};
use crate::hammerstein::{Domain, Model};
use crate::number::short;
use crate::quality::{Defect, Finding, Need, around, excites, inspect, likely_cause};
use crate::record::Record;
use crate::series::{ends, mean, scatter};
use crate::waveform::cycle_rate;

/// Share of the identified range by which an input must return to count as a reversal, and stay off the ends to count
/// as an inner reversal.
const INSIDE: f64 = 0.05;

/// Relative excess of a rate or frequency without a remark.
const BEYOND: f64 = 0.1;

/// The same for the band of an input: a rising amplitude widens its line.
const BESIDE: f64 = 0.25;

/// How far the mean of an input may be from those of the identified records without a remark, over the identified
/// range. Inputs with another waveform over the same range differ by less; farther away, creep and inner loops occur at
/// levels that the identified records only passed.
const ASIDE: f64 = 0.2;

/// Share of the identified range below which an input does not test the hysteresis.
const SMALL: f64 = 0.2;

/// Width of the model's loop below which it does not test the hysteresis [% of its height].
const CLOSED: f64 = 1.0;

/// Correlation from which the output has the shape of the model's, and factor from which it is another scale.
const SHAPE: f64 = 0.95;
const SCALED: f64 = 2.5;

/// Range of the input, over the identified range, from which a unit or a scale is wrong.
const FAR: f64 = 100.0;

/// Drift of the error, over the peak-to-peak of y, up to which a drift of y is the model's own.
const DRIFTS: f64 = 0.01;

/// Remarks where the record exceeds the range of the model or of the figures.
pub(super) fn remarks(
    model: &Model,
    record: &Record,
    simulated: &[f64],
    metrics: &Metrics,
    drift: &Drift,
) -> Vec<String> {
    let mut remarks: Vec<String> = match (metrics.mse.is_finite(), metrics.nrmse_percent.is_finite()) {
        (false, _) => vec!["the error overflows: undefined figures are - in tables and null in JSON".into()],
        (true, false) => {
            vec!["the output is constant, so relative errors are undefined (- in tables, null in JSON)".into()]
        }
        (true, true) => Vec::new(),
    };
    let beyond_range = range(model, record);
    // The output of a model far outside its range says nothing.
    remarks.extend(beyond_range.is_none().then(|| scaled(record, simulated)).flatten());
    remarks.extend(beyond_range);
    let frequency = at_frequency(model, record);
    let reported = frequency.is_some();
    remarks.extend(frequency);
    remarks.extend(inner_reversals_of(model, record));
    remarks.extend(model.identified().map_or_else(Vec::new, |domain| beyond(model, domain, record, reported)));
    remarks.extend(drifts(record, metrics, drift));
    let rise = drift.slope.abs() * record.len() as f64;
    let is_told = |f: &Finding| match f.defect {
        // The error tells a drift better than the input alone.
        Defect::Drift => rise > DRIFTS * metrics.peak_to_peak,
        // What the figures themselves show is not repeated; swapped columns they do not show.
        defect => defect == Defect::Swapped || !defect.is_fatal(),
    };
    remarks.extend(inspect(record, &Need::default()).findings.into_iter().filter(is_told).map(|f| f.text));
    remarks
}

/// A remark if a drift makes much of the error.
fn drifts(record: &Record, metrics: &Metrics, drift: &Drift) -> Option<String> {
    let percent = |rms: f64| rough(100.0 * rms / metrics.std);
    drift.is_named.then(|| {
        format!(
            "a drift of {} {}/s makes {} of the {} % NRMSE: of the sensor or the temperature, or creep that the model \
             lacks. Set the offset to drift to see the rest",
            rough(drift.slope / record.ts()),
            record.units().y,
            percent(drift.rms),
            percent(metrics.rmse)
        )
    })
}

/// A remark if the output is a multiple of that of the model.
fn scaled(record: &Record, simulated: &[f64]) -> Option<String> {
    let (y, unit) = (record.y(), &record.units().y);
    let [mean_y, mean_model] = [y, simulated].map(mean);
    let product: f64 = y.iter().zip(simulated).map(|(y, s)| (y - mean_y) * (s - mean_model)).sum();
    let [power_y, power_model] = [y, simulated].map(scatter);
    let (factor, correlation) = (product / power_model, product / (power_y * power_model).sqrt());
    (correlation.abs() > SHAPE && !(1.0 / SCALED..=SCALED).contains(&factor)).then(|| {
        format!(
            "the output is {} times that of the model, and has its shape (correlation {}): {}",
            short(factor),
            short(correlation),
            match factor < 0.0 {
                true => "a sign is inverted".into(),
                false => likely_cause(factor, unit),
            }
        )
    })
}

/// A remark if the input exceeds the identified range.
fn range(model: &Model, record: &Record) -> Option<String> {
    let unit = &model.units().u;
    let (low, high) = identified_range(model)?;
    let (lowest, highest) = ends(record.u().iter().copied());
    let slack = 0.01 * (high - low);
    let times = (highest - lowest) / (high - low);
    (lowest < low - slack || highest > high + slack).then(|| {
        format!(
            "the input runs from {} to {} {unit}, but the model was identified from {} to {} {unit}: outside this \
             range it extrapolates{}",
            short(lowest),
            short(highest),
            short(low),
            short(high),
            match times > FAR {
                true => format!("; at {} times the range, {}", short(times), likely_cause(times, unit)),
                false => String::new(),
            }
        )
    })
}

fn identified_range(model: &Model) -> Option<(f64, f64)> {
    model.hysteresis().range().or_else(|| model.identified().map(|d| (d.u[0], d.u[1])))
}

/// A remark if the input oscillates at a frequency outside those of the hysteresis block.
fn at_frequency(model: &Model, record: &Record) -> Option<String> {
    let (slowest, fastest) = model.hysteresis().frequencies()?;
    let hz = cycle_rate(record.u(), record.ts())?;
    (!((1.0 - BEYOND) * slowest..=(1.0 + BEYOND) * fastest).contains(&hz)).then(|| {
        format!(
            "the input oscillates at {} Hz, but the model was identified from {} to {} Hz: outside this range it \
             extrapolates",
            short(hz),
            short(slowest),
            short(fastest)
        )
    })
}

/// A remark if the input has inner reversals and the block has no minor loops.
fn inner_reversals_of(model: &Model, record: &Record) -> Option<String> {
    let (low, high) = model.hysteresis().range()?;
    let operator = model.hysteresis().operator();
    let reversals = inner_reversals(record.u(), low, high);
    (reversals > 0 && !operator.minor_loops).then(|| {
        format!(
            "the input has {reversals} reversals inside the identified range, but the {} block has no minor loops: at \
             each of them it jumps to the other branch of the major loop",
            operator.name
        )
    })
}

/// Remarks on frequencies (unless `reported`), rates and means outside the identified data.
fn beyond(model: &Model, domain: &Domain, record: &Record, reported: bool) -> Vec<String> {
    let unit = &model.units().u;
    let seen = Domain::of_input(record.u(), record.ts());
    let mut beyond = Vec::new();
    // The frequency resolution of a record is one over its duration.
    let resolution = 1.0 / record.duration();
    if let Some(([low, high], [slowest, fastest])) = seen.hz.zip(domain.hz)
        && !reported
        && (high > (1.0 + BESIDE) * fastest + resolution || low < (1.0 - BESIDE) * slowest - resolution)
    {
        beyond.push(format!(
            "the input has power from {} to {} Hz, but the model was identified from {} to {} Hz: outside this range \
             it extrapolates",
            short(low),
            short(high),
            short(slowest),
            short(fastest)
        ));
    }
    if seen.slew > (1.0 + BEYOND) * domain.slew {
        beyond.push(format!(
            "the input changes by up to {} {unit}/s, but the model was identified up to {} {unit}/s: above this rate \
             it extrapolates",
            short(seen.slew),
            short(domain.slew)
        ));
    }
    let slack = ASIDE * (domain.u[1] - domain.u[0]);
    if seen.mean[0] < domain.mean[0] - slack || seen.mean[1] > domain.mean[1] + slack {
        let identified = match (short(domain.mean[0]), short(domain.mean[1])) {
            (low, high) if low == high => low,
            (low, high) => format!("from {low} to {high}"),
        };
        beyond.push(format!(
            "the input has a mean of {} {unit}, but the model was identified at {identified} {unit}: at another bias \
             the model extrapolates",
            short(seen.mean[0])
        ));
    }
    beyond
}

/// Properties of the model that this record does not test.
pub(super) fn not_covered(model: &Model, record: &Record, loops: &[LoopComparison]) -> Vec<String> {
    let mut not_covered = Vec::new();
    if let Some(pole) = model.linear().resonance()
        && !excites(record.u(), record.ts(), around(pole.hz))
    {
        not_covered.push(format!(
            "the resonance at {} Hz (damping {}): the input has no power near it",
            short(pole.hz),
            short(pole.damping)
        ));
    }
    let curved = model.hysteresis().operator().name != "proportional";
    let (lowest, highest) = ends(record.u().iter().copied());
    let share = identified_range(model).map(|(low, high)| (highest - lowest) / (high - low));
    let widest = loops.iter().map(|l| l.model.width_percent.abs()).reduce(f64::max);
    match (share, widest) {
        (Some(share), _) if curved && share < SMALL => not_covered
            .push(format!("the hysteresis: the input covers {} % of the identified range", short(100.0 * share))),
        (_, Some(width)) if curved && width < CLOSED => not_covered
            .push(format!("the hysteresis: at this amplitude the loop of the model is only {} % wide", short(width))),
        _ => {}
    }
    not_covered
}

/// Number of reversals of `u` inside the range from `low` to `high`, away from its ends.
pub(crate) fn inner_reversals(u: &[f64], low: f64, high: f64) -> usize {
    let margin = INSIDE * (high - low);
    let (mut extreme, mut trend, mut reversals) = (u[0], 0.0, 0);
    for &u in u {
        if (u - extreme) * trend > 0.0 {
            extreme = u;
        } else if (u - extreme).abs() > margin {
            reversals += usize::from(trend != 0.0 && extreme > low + margin && extreme < high - margin);
            (trend, extreme) = ((u - extreme).signum(), u);
        }
    }
    reversals
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hysteresis::{OPERATORS, Proportional};
    use crate::linear::Arx;
    use crate::system::System;
    use std::f64::consts::TAU;
    use std::sync::Arc;

    const TS: f64 = 5e-4;

    #[test]
    fn only_reversals_inside_the_range_are_counted() {
        let full: Vec<f64> = (0..400).map(|t| (f64::from(t) * 0.1).sin()).collect();
        assert_eq!(inner_reversals(&full, -1.0, 1.0), 0);
        let half: Vec<f64> = full.iter().map(|u| 0.5 * u).collect();
        assert_eq!(inner_reversals(&half, -1.0, 1.0), 12);
    }

    fn sine(bias: f64, height: f64, hz: f64) -> Vec<f64> {
        (0..4000).map(|t| bias + height * (TAU * hz * f64::from(t) * TS).sin()).collect()
    }

    fn remarks_of(model: &Model, u: Vec<f64>) -> (Vec<String>, Vec<String>) {
        let y = model.simulate(&u);
        let seen = model.validate(&Record::new(TS, u, y).unwrap()).unwrap();
        (seen.remarks, seen.not_covered)
    }

    #[test]
    fn amplitude_frequency_rate_and_bias_outside_the_identified_data_are_remarked() {
        let gain = Arc::new(Proportional::new(TS, 1.0).unwrap());
        let model = Model::new(gain, Arx::gain(TS, 33.0).unwrap(), 0.0).unwrap();
        let without_domain = remarks_of(&model, sine(0.0, 90.0, 300.0)).0;
        assert_eq!(without_domain, Vec::<String>::new(), "a model without domain has no limits");
        let record = |u: Vec<f64>| Record::new(TS, u.clone(), u).unwrap();
        let domain = Domain::of(&[record(sine(0.0, 20.0, 5.0)), record(sine(0.0, 1.0, 200.0))]).unwrap();
        let model = model.with_identified(domain);
        for within in [sine(0.0, 20.0, 5.0), sine(0.0, 1.0, 200.0), sine(0.5, 15.0, 10.0), sine(7.0, 10.0, 5.0)] {
            assert_eq!(remarks_of(&model, within).0, Vec::<String>::new());
        }
        for (u, says) in [
            (sine(0.0, 25.0, 5.0), "from -25.00 to 25.00 V, but the model was identified from -20.00 to 20.00 V"),
            (sine(0.0, 0.5, 300.0), "power from 300.0 to 300.0 Hz, but the model was identified from 5.0"),
            (sine(0.0, 20.0, 50.0), "the input changes by up to 6"),
            (sine(9.0, 10.0, 5.0), "the input has a mean of 9.000 V, but the model was identified at"),
        ] {
            let remarks = remarks_of(&model, u).0;
            assert!(remarks.len() == 1 && remarks[0].contains(says), "{says}: {remarks:?}");
        }
    }

    #[test]
    fn what_a_record_does_not_test_is_reported() {
        let beam = Arx::new(TS, vec![1.7424, -0.9453], vec![3.4, 3.3]).unwrap();
        for o in OPERATORS {
            let model = Model::new((o.example)(TS).unwrap(), beam.clone(), 0.0).unwrap();
            let large = remarks_of(&model, sine(0.0, 28.0, 5.0)).1;
            assert!(large.len() == 1 && large[0].contains("the resonance at 146.7 Hz"), "{}: {large:?}", o.name);
            let small = remarks_of(&model, sine(0.0, 2.0, 140.0)).1;
            assert_eq!(small.len(), usize::from(o.name != "proportional"), "{}: {small:?}", o.name);
            assert!(small.iter().all(|s| s.contains("the hysteresis: the input covers")), "{small:?}");
        }
    }

    #[test]
    fn defects_of_a_record_are_remarked() {
        let gain = Arc::new(Proportional::new(TS, 1.0).unwrap());
        let model = Model::new(gain, Arx::gain(TS, 33.0).unwrap(), 0.0).unwrap();
        let u = sine(0.0, 20.0, 5.0);
        let mut y = model.simulate(&u);
        y[700] += 200.0;
        let seen = model.validate(&Record::new(TS, u, y).unwrap()).unwrap();
        assert!(seen.remarks.iter().any(|r| r.contains("outliers: 1 sample (at 0.35 s)")), "{:?}", seen.remarks);
    }
}
