//! Remarks on the figures: what is undefined, wrong with the record, or outside the data of the model. Each is a row of
//! [`REMARKS`] or of [`UNTESTED`]; the defects of the record ([`piezoid_records::quality`]) follow.

use super::drift::Drift;
use super::facts::{Facts, Shape};
use super::floor::rough;
use super::{LoopComparison, Metrics, extrapolation, untested};
use piezoid_models::hammerstein::{Domain, Model};
use piezoid_numerics::number::short;
use piezoid_records::quality::{Consequence, DRIFT, Finding, likely_cause};

/// Correlation from which the output has the shape of the model's, and factor from which it is another scale.
const MIN_SHAPE_CORRELATION: f64 = 0.95;
const MIN_SCALE_FACTOR: f64 = 2.5;

/// Drift of the error, over the peak-to-peak of y, up to which a drift of y is the model's own.
const MAX_MODEL_DRIFT_SHARE: f64 = 0.01;

/// A comparison of a model with a record, on which remarks are made.
pub(super) struct Comparison<'a> {
    pub(super) model: &'a Model,
    /// Sampling period of the record [s], and the unit of its output.
    pub(super) ts: f64,
    pub(super) unit: &'a str,
    pub(super) metrics: &'a Metrics,
    pub(super) drift: &'a Drift,
    pub(super) loops: &'a [LoopComparison],
    pub(super) facts: &'a Facts,
    /// Reversals of the input inside the range of the hysteresis.
    pub(super) inner_reversals: usize,
    pub(super) shape: &'a Shape,
}

impl Comparison<'_> {
    /// The data that the model was identified from, and those of this record; `None` if the former are not known.
    pub(super) fn domains(&self) -> Option<(&Domain, &Domain)> {
        Some((self.model.identified()?, &self.facts.domain))
    }
}

/// A remark: a row of [`REMARKS`] or of [`UNTESTED`].
pub(super) struct Remark {
    /// Name in the documentation.
    #[cfg_attr(not(test), allow(dead_code))] // The tables of docs/reference.md are compared with it.
    pub(super) name: &'static str,
    /// When it is made.
    #[cfg_attr(not(test), allow(dead_code))] // As the name.
    pub(super) when: &'static str,
    /// The remark; `None` if there is no reason for it.
    pub text: fn(&Comparison) -> Option<String>,
}

/// The remarks on figures that are undefined, on the record, and on the range of the model, in this order.
static REMARKS: &[&Remark] = &[
    &OVERFLOW,
    &CONSTANT_OUTPUT,
    &SCALE,
    &extrapolation::RANGE,
    &extrapolation::FREQUENCY,
    &extrapolation::INNER_REVERSALS,
    &extrapolation::BAND,
    &extrapolation::RATE,
    &extrapolation::BIAS,
    &ERROR_DRIFT,
];

/// Properties of the model that a record does not test.
static UNTESTED: &[&Remark] = &[&untested::RESONANCE, &untested::HYSTERESIS];

static OVERFLOW: Remark = Remark {
    name: "overflow",
    when: "the error is too large for a number",
    text: |c| {
        let text = "the error overflows: undefined figures are - in tables and null in JSON";
        (!c.metrics.mse.is_finite()).then(|| text.into())
    },
};

static CONSTANT_OUTPUT: Remark = Remark {
    name: "constant output",
    when: "y is constant",
    text: |c| {
        let text = "the output is constant, so relative errors are undefined (- in tables, null in JSON)";
        (c.metrics.mse.is_finite() && !c.metrics.nrmse_percent.is_finite()).then(|| text.into())
    },
};

static SCALE: Remark = Remark {
    name: "scale",
    when: "y has the shape of the model's output, and is more than 2.5 times as large or as small",
    // The output of a model far outside its range says nothing.
    text: |c| if extrapolation::range(c).is_none() { scaled(c.shape, c.unit) } else { None },
};

static ERROR_DRIFT: Remark = Remark {
    name: "drift",
    when: "a slow linear trend makes more than half of the error about its mean",
    text: |c| {
        let [drift, all] = [c.drift.rms, c.metrics.rmse].map(|rms| rough(100.0 * rms / c.metrics.std));
        let (slope, unit) = (rough(c.drift.slope / c.ts), c.unit);
        c.drift.is_named.then(|| {
            format!(
                "a drift of {slope} {unit}/s makes {drift} of the {all} % NRMSE: the sensor or the temperature drifts, \
                 or the model lacks creep. Set the offset to drift to see the rest of the error"
            )
        })
    },
};

/// The remarks on a comparison, and the defects of its record.
pub(super) fn remarks(comparison: &Comparison) -> Vec<String> {
    let Comparison { facts, metrics, drift, .. } = comparison;
    let mut remarks = texts(REMARKS, comparison);
    let rise = drift.slope.abs() * metrics.n as f64;
    let is_new = |finding: &Finding| match finding.detector.consequence {
        // The figures show it themselves.
        Consequence::Unusable => false,
        // The error shows a drift better than the input alone.
        _ => finding.detector != &DRIFT || rise > MAX_MODEL_DRIFT_SHARE * metrics.peak_to_peak,
    };
    remarks.extend(facts.findings.iter().filter(|finding| is_new(finding)).map(|finding| finding.text.clone()));
    remarks
}

/// Properties of the model that the record does not test.
pub(super) fn not_covered(comparison: &Comparison) -> Vec<String> {
    texts(UNTESTED, comparison)
}

fn texts(rows: &[&Remark], comparison: &Comparison) -> Vec<String> {
    rows.iter().filter_map(|row| (row.text)(comparison)).collect()
}

/// A sentence if the output is a multiple of that of the model.
fn scaled(shape: &Shape, unit: &str) -> Option<String> {
    let (factor, correlation) = shape.factor_and_correlation();
    let is_scale = !(1.0 / MIN_SCALE_FACTOR..=MIN_SCALE_FACTOR).contains(&factor);
    (correlation.abs() > MIN_SHAPE_CORRELATION && is_scale).then(|| {
        let cause = if factor < 0.0 { "a sign is inverted".into() } else { likely_cause(factor, unit) };
        let [factor, correlation] = [factor, correlation].map(short);
        format!(
            "the output is {factor} times that of the model, and has its shape (correlation {correlation}): {cause}"
        )
    })
}

#[cfg(test)]
mod tests {
    use super::super::loops::loops;
    use super::super::{errors, facts};
    use super::*;
    use crate::Validate;
    use piezoid_models::hysteresis::{OPERATORS, Proportional};
    use piezoid_models::linear::Arx;
    use piezoid_numerics::system::System;
    use piezoid_records::record::Record;
    use piezoid_records::waveform::cycles;
    use std::f64::consts::TAU;
    use std::sync::Arc;

    const TS: f64 = 5e-4;

    fn sine(bias: f64, height: f64, hz: f64) -> Vec<f64> {
        (0..4000).map(|t| bias + height * (TAU * hz * f64::from(t) * TS).sin()).collect()
    }

    fn remarks_of(model: &Model, u: Vec<f64>) -> (Vec<String>, Vec<String>) {
        let y = model.simulate(&u);
        let validation = model.validate(&Record::new(TS, u, y).unwrap()).unwrap();
        (validation.remarks, validation.not_covered)
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
        let remarks = model.validate(&Record::new(TS, u, y).unwrap()).unwrap().remarks;
        assert!(remarks.iter().any(|r| r.contains("outliers: 1 sample (at 0.35 s)")), "{remarks:?}");
    }

    /// A model identified from sines of 20 V at 5 Hz, and its record of such a sine, that no row but `RESONANCE`
    /// comments on.
    fn stock(operator: &str) -> (Model, Vec<f64>) {
        let operator = OPERATORS.iter().find(|o| o.name == operator).unwrap();
        let beam = Arx::new(TS, vec![1.7424, -0.9453], vec![3.4, 3.3]).unwrap();
        let model = Model::new((operator.example)(TS).unwrap(), beam, 0.0).unwrap();
        let u = sine(0.0, 20.0, 5.0);
        let record = Record::new(TS, u.clone(), u.clone()).unwrap();
        let model = model.with_identified(Domain::of(&[record]).unwrap());
        (model, u)
    }

    type Change = fn(usize, f64) -> f64;

    /// The names of the rows that remark on a record: of `u`, and of the output of the model for it, changed by `y`.
    fn remarked(rows: &[&Remark], model: &Model, u: Vec<f64>, y: Change) -> Vec<&'static str> {
        remarks_with(rows, model, u, y, &|_| {}).into_iter().map(|(name, _)| name).collect()
    }

    /// The same with the remarks, if facts are changed too.
    fn remarks_with(
        rows: &[&Remark],
        model: &Model,
        u: Vec<f64>,
        y: Change,
        change: &dyn Fn(&mut Facts),
    ) -> Vec<(&'static str, String)> {
        let simulated = model.simulate(&u);
        let y = simulated.iter().enumerate().map(|(t, s)| y(t, *s)).collect();
        let record = Record::new(TS, u, y).unwrap();
        let mut facts = Facts::of(model, &record);
        change(&mut facts);
        let metrics = Metrics::of(record.y(), &simulated);
        let drift = Drift::of(&errors(record.y(), &simulated), &simulated, TS);
        let loops = loops(&record, &simulated, &cycles(record.u(), TS));
        let comparison = Comparison {
            model,
            ts: TS,
            unit: "um",
            metrics: &metrics,
            drift: &drift,
            loops: &loops,
            facts: &facts,
            inner_reversals: facts::inner_reversals_of(model, record.u()),
            shape: &Shape::of(record.y(), &simulated),
        };
        rows.iter().filter_map(|row| Some((row.name, (row.text)(&comparison)?))).collect()
    }

    #[test]
    fn each_row_makes_its_remark_and_none_on_a_record_like_those_identified() {
        let (model, u) = stock("prandtl-ishlinskii");
        let same: Change = |_, y| y;
        assert_eq!(remarked(REMARKS, &model, u.clone(), same), [""; 0]);
        assert_eq!(remarked(UNTESTED, &model, u.clone(), same), ["resonance"]);
        let both: Vec<f64> = u.iter().zip(sine(0.0, 3.0, 140.0)).map(|(u, v)| u + v).collect();
        assert_eq!(remarked(UNTESTED, &model, both, same), [""; 0]);
        assert_eq!(remarked(UNTESTED, &model, sine(0.0, 2.0, 5.0), same), ["resonance", "hysteresis"]);
        let examples: [(&str, &str, Vec<f64>, Change); 10] = [
            ("overflow", "prandtl-ishlinskii", u.clone(), |_, y| y + 1e300),
            ("constant output", "prandtl-ishlinskii", u.clone(), |_, _| 7.0),
            ("scale", "prandtl-ishlinskii", u.clone(), |_, y| 3.0 * y),
            // The range of the operator counts, 30 V, not that of the identification data.
            ("range", "prandtl-ishlinskii", sine(0.0, 31.0, 5.0), same),
            ("frequency", "rate-scheduled", sine(0.0, 1.0, 200.0), same),
            ("inner reversals", "two-branch", sine(0.0, 10.0, 5.0), same),
            ("band", "prandtl-ishlinskii", sine(0.0, 0.5, 300.0), same),
            ("rate", "prandtl-ishlinskii", sine(0.0, 20.0, 6.0), same),
            ("bias", "prandtl-ishlinskii", sine(9.0, 10.0, 5.0), same),
            ("drift", "prandtl-ishlinskii", u, |t, y| y + 2e-3 * (t as f64 - 2000.0)),
        ];
        assert_eq!(
            examples.each_ref().map(|example| example.0).as_slice(),
            names(REMARKS),
            "one example each, in order"
        );
        for (name, operator, u, change) in examples {
            let remarks = remarked(REMARKS, &stock(operator).0, u, change);
            assert!(remarks.contains(&name), "{name}: {remarks:?}");
        }
    }

    fn names(rows: &[&Remark]) -> Vec<&'static str> {
        rows.iter().map(|row| row.name).collect()
    }

    #[test]
    fn the_reference_lists_the_remarks() {
        let page = include_str!("../../../docs/reference.md");
        for (rows, title) in [(REMARKS, "remark"), (UNTESTED, "property")] {
            let table: String = rows.iter().map(|row| format!("| {} | {} |\n", row.name, row.when)).collect();
            assert!(page.contains(&format!("| {title} | if |\n|---|---|\n{table}\n")), "\n{table}");
        }
    }

    #[test]
    fn an_input_may_leave_the_identified_data_by_the_margins() {
        let (model, u) = stock("prandtl-ishlinskii");
        let known = Domain { u: [-20.0, 20.0], hz: Some([10.0, 100.0]), slew: 1e4, mean: [-1.0, 2.0] };
        let model = model.with_identified(known);
        let with = |domain: Domain| {
            let change = |facts: &mut Facts| (facts.domain, facts.duration) = (domain, 2.0);
            let found = remarks_with(REMARKS, &model, u.clone(), |_, y| y, &change);
            found.into_iter().map(|(name, _)| name).collect::<Vec<_>>()
        };
        let hz = |hz| Domain { hz: Some(hz), ..known };
        let mean = |mean| Domain { mean, ..known };
        // The frequencies have the resolution of 2 s, the range is that of the operator, and 1 % more counts as within.
        for within in [
            known,
            hz([10.0, 125.4]),
            hz([7.1, 100.0]),
            mean([9.9; 2]),
            mean([-8.9; 2]),
            Domain { slew: 1.09e4, ..known },
            Domain { u: [-30.5, 30.5], ..known },
        ] {
            assert_eq!(with(within), [""; 0], "{within:?}");
        }
        for (beyond, name) in [
            (hz([10.0, 125.6]), "band"),
            (hz([6.9, 100.0]), "band"),
            (mean([10.1; 2]), "bias"),
            (mean([-9.1; 2]), "bias"),
            (Domain { slew: 1.11e4, ..known }, "rate"),
            (Domain { u: [-30.7, 30.0], ..known }, "range"),
            (Domain { u: [-30.0, 30.7], ..known }, "range"),
        ] {
            assert_eq!(with(beyond), [name], "{beyond:?}");
        }
    }

    #[test]
    fn cycles_may_leave_the_frequencies_of_the_hysteresis_by_a_tenth() {
        let (model, u) = stock("rate-scheduled");
        let (slowest, fastest) = model.hysteresis().frequencies().unwrap();
        let remarked = |hz: f64| {
            let change = |facts: &mut Facts| facts.cycle_rates = vec![slowest, hz];
            remarks_with(&[&extrapolation::FREQUENCY], &model, u.clone(), |_, y| y, &change).len()
        };
        assert_eq!([0.91 * slowest, 1.09 * fastest].map(remarked), [0; 2]);
        assert_eq!([0.89 * slowest, 1.11 * fastest].map(remarked), [1; 2]);
    }

    #[test]
    fn a_range_of_more_than_a_hundred_identified_ones_has_a_likely_cause() {
        let (model, u) = stock("proportional");
        let remark = |most: f64| {
            let change = |facts: &mut Facts| facts.domain.u = [-20.0, most];
            remarks_with(&[&extrapolation::RANGE], &model, u.clone(), |_, y| y, &change).remove(0).1
        };
        let says = |most: f64| remark(most).contains("; at 101.0 times the range, ");
        assert!(says(4020.0) && !remark(3940.0).contains(" times the range"), "{}", remark(4020.0));
    }
}
