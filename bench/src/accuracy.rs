//! docs/accuracy.md: errors of joint identification on validation data, compared with the paper's method. One model
//! covers all frequencies. The joint method is also used on twins drawn at random.

use crate::page::{self, cell, head, row};
use crate::twin::{KINDS, OUTSIDE, RecordKind, TWINS, Twin, error};
use piezoid::hammerstein::{Identified, Model};
use piezoid::hysteresis::Split;
use piezoid::plant::{Preset, Spec};
use piezoid::{Error, IdentifyOptions, Record};
use piezoid_report::plot::{Axes, Axis, Figure, Role, Series};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::path::Path;

/// Number of twins drawn at random.
const DRAWS: u64 = 20;

/// Frequencies of the validation data [Hz].
pub const VALIDATION: [f64; 10] = [1.0, 5.0, 20.0, 40.0, 80.0, 120.0, 160.0, 200.0, 300.0, 400.0];

/// The smallest error, the median and the largest.
pub fn range(errors: &[f64]) -> [f64; 3] {
    let mut sorted = errors.to_vec();
    sorted.sort_by(f64::total_cmp);
    let (low, high) = (sorted[(sorted.len() - 1) / 2], sorted[sorted.len() / 2]);
    [sorted[0], 0.5 * (low + high), sorted[sorted.len() - 1]]
}

struct IdentificationMethod {
    name: &'static str,
    role: Role,
    identify: fn(&Twin) -> Result<Identified, Error>,
}

/// The paper's method, then the joint one.
static WAYS: [IdentificationMethod; 4] = [
    IdentificationMethod {
        name: "paper",
        role: Role::Descending,
        identify: |twin| twin.paper(IdentifyOptions::default()),
    },
    IdentificationMethod {
        name: "paper, best settings",
        role: Role::Muted,
        identify: |twin| {
            let (order, estimator, split) = (Some(4), Some("output-error".into()), Some(Split::Direction));
            twin.paper(IdentifyOptions { order, estimator, split, ..IdentifyOptions::default() })
        },
    },
    IdentificationMethod {
        name: "joint, driver unknown",
        role: Role::Accent5,
        identify: |twin| twin.joint("auto", false),
    },
    IdentificationMethod { name: "joint, driver given", role: Role::Model, identify: |twin| twin.joint("auto", true) },
];
const PAPER: std::ops::Range<usize> = 0..2;

/// The errors of one method on one twin.
struct Outcome {
    twin: &'static str,
    way: &'static IdentificationMethod,
    operator: &'static str,
    /// Rms errors by kind, then by frequency [% of peak-to-peak]; infinite if the free run diverged.
    errors: Vec<Vec<f64>>,
}

/// A larger error counts as a diverged run [% of peak-to-peak].
const DIVERGED: f64 = 1000.0;

/// Target for the ratio of the paper's error to the joint error.
const TIMES: f64 = 10.0;

/// The errors of a method on the records of a twin.
fn errors(way: &IdentificationMethod, twin: &Twin, records: &[Vec<Record>]) -> Result<(Model, Vec<Vec<f64>>), Error> {
    let model = (way.identify)(twin)?.model;
    let left = |record: &Record| Some(error(&model, record)).filter(|e| *e < DIVERGED).unwrap_or(f64::INFINITY);
    let errors = records.iter().map(|of_kind| of_kind.iter().map(left).collect()).collect();
    Ok((model, errors))
}

/// The validation records of a twin, by kind and frequency.
fn validation(twin: &Twin) -> Result<Vec<Vec<Record>>, Error> {
    let of_kind = |kind| VALIDATION.into_iter().map(|hz| twin.validation(kind, hz)).collect();
    KINDS.iter().map(of_kind).collect()
}

/// The errors of every method on a twin.
fn outcomes(name: &'static str) -> Result<Vec<Outcome>, Error> {
    let twin = Twin::new(name)?;
    let records = validation(&twin)?;
    let outcome = |way: &'static IdentificationMethod| {
        let (model, errors) = errors(way, &twin, &records)?;
        eprintln!("{name}, {}: {errors:.3?}", way.name);
        Ok(Outcome { twin: name, way, operator: model.hysteresis().operator().name, errors })
    };
    WAYS.iter().map(outcome).collect()
}

/// A `pl140` whose creep, hysteresis and driver are drawn at random.
fn drawn(seed: u64) -> Result<Spec, Box<dyn std::error::Error>> {
    let mut random = ChaCha8Rng::seed_from_u64(seed);
    let mut between = |low: f64, high: f64| random.random_range(low..high);
    let mut spec: serde_json::Value = serde_json::from_str(&Preset::find("pl140")?.spec().to_json()?)?;
    spec["creep_per_decade"] = between(0.01, 0.02).into();
    spec["creep_from_s"] = between(0.03f64.ln(), 0.3f64.ln()).exp().into();
    spec["driver"]["lag_s"] = between(3e-5f64.ln(), 3e-4f64.ln()).exp().into();
    let density = &mut spec["hysteresis"]["preisach"];
    density["width"] = between(0.08, 0.18).into();
    density["half_width_v"] = between(10.0, 30.0).into();
    density["asymmetry"] = between(0.0, 0.6).into();
    Ok(Spec::from_json(&spec.to_string())?)
}

/// Table of the errors on twins drawn at random: of each twin its median error, and its largest one.
fn draws() -> Result<String, Box<dyn std::error::Error>> {
    let titles = ["method", "median of a twin: smallest [%]", "median [%]", "largest [%]"];
    let worst = ["largest of a twin: smallest [%]", "median [%]", "largest [%]"];
    let mut text = head(titles.into_iter().chain(worst), 1);
    for way in &WAYS[PAPER.end..] {
        let (mut medians, mut largest) = (Vec::new(), Vec::new());
        for seed in 0..DRAWS {
            let twin = Twin::of(&drawn(seed)?)?;
            let (model, errors) = errors(way, &twin, &validation(&twin)?)?;
            let [_, median, most] = range(&errors.concat());
            eprintln!("draw {seed}, {}, {}: {median:.3} {most:.2}", way.name, model.hysteresis().operator().name);
            medians.push(median);
            largest.push(most);
        }
        let shown = [medians, largest].map(|errors| range(&errors).map(cell));
        text += &row([way.name.into()].into_iter().chain(shown.concat()));
    }
    Ok(text)
}

/// Ratios of the paper's errors to the joint errors, by kind and frequency.
fn times<'a>(paper: &'a Outcome, joint: &'a Outcome) -> impl Iterator<Item = (&'static str, f64, f64)> + 'a {
    let of_kind = |((kind, p), j): ((&'static RecordKind, &'a Vec<f64>), &'a Vec<f64>)| {
        VALIDATION.into_iter().zip(p.iter().zip(j)).map(|(hz, (p, j))| (kind.name, hz, p / j))
    };
    KINDS.iter().zip(&paper.errors).zip(&joint.errors).flat_map(of_kind)
}

/// Table of the errors by method, with the ratios of the paper's errors to them; then the records with a small ratio.
fn summary(twins: &[Vec<Outcome>]) -> String {
    let titles = [
        "twin",
        "method",
        "operator",
        "smallest error [%]",
        "median [%]",
        "largest [%]",
        "smallest ratio `paper` / row",
        "smallest ratio `paper, best settings` / row",
    ];
    let mut text = head(titles, 3);
    for (k, (outcomes, o)) in twins.iter().flat_map(|outcomes| outcomes.iter().map(move |o| (outcomes, o))).enumerate()
    {
        let [lowest, median, worst] = range(&o.errors.concat());
        let least = |paper| times(paper, o).map(|(.., times)| times).fold(f64::INFINITY, f64::min);
        let below = |paper| {
            if PAPER.contains(&(k % WAYS.len())) { String::new() } else { format!("{:.1}", least(paper)) }
        };
        let [name, operator] = [o.twin, o.operator].map(|name| format!("`{name}`"));
        let [paper, tuned] = [0, 1].map(|k| below(&outcomes[PAPER][k]));
        let [lowest, median, worst] = [format!("{lowest:.3}"), format!("{median:.3}"), format!("{worst:.2}")];
        text += &row([name, o.way.name.into(), operator, lowest, median, worst, paper, tuned]);
    }
    let inside = twins.iter().filter(|outcomes| outcomes[0].twin != OUTSIDE);
    text + &page::wrapped(&inside.map(|outcomes| near(outcomes)).collect::<String>())
}

/// Records of a twin on which the error of the best variant of the paper's method is less than [`TIMES`] times the
/// error of the best joint model.
fn near(outcomes: &[Outcome]) -> String {
    let [_, tuned, .., with_driver] = outcomes else { return String::new() };
    let near = times(tuned, with_driver).filter(|(.., times)| *times < TIMES);
    let near: Vec<String> = near.map(|(kind, hz, times)| format!("{kind} of {hz} Hz ({times:.1})")).collect();
    let (joint, paper, twin) = (with_driver.way.name, tuned.way.name, with_driver.twin);
    format!(
        "\nOn `{twin}` the error of `{paper}` is less than {TIMES} times the error of `{joint}` on these records (ratio \
         in brackets): {}.\n",
        near.join(", ")
    )
}

/// Table of all errors.
fn table(twins: &[Vec<Outcome>]) -> String {
    let titles = ["twin", "record", "method"].map(String::from).into_iter();
    let mut text = head(titles.chain(VALIDATION.map(|hz| hz.to_string())), 3);
    for outcomes in twins {
        for (k, kind) in KINDS.iter().enumerate() {
            for o in outcomes {
                let names = [format!("`{}`", o.twin), kind.name.into(), o.way.name.into()].into_iter();
                text += &row(names.chain(o.errors[k].iter().map(|e| cell(*e))));
            }
        }
    }
    text
}

/// The largest error over the kinds of record against frequency, one panel per twin.
fn figure(twins: &[Vec<Outcome>]) -> Figure {
    let caption = "Error of the free run on validation data, the largest of three kinds of record at each frequency: the \
                   paper's method, the same with its best settings, and the joint model without and with the driver \
                   given. Each method has one model for all frequencies.";
    let panel = |outcomes: &Vec<Outcome>| {
        let axes = Axes::new(Axis::log("f [Hz]").ticks(&VALIDATION), Axis::log("rms error [% of peak-to-peak]"));
        outcomes.iter().enumerate().fold(axes.titled(outcomes[0].twin), |axes, (way, o)| {
            let largest = |k: usize| o.errors.iter().map(|of_kind| of_kind[k]).fold(0.0, f64::max);
            let errors: Vec<f64> = (0..VALIDATION.len()).map(largest).collect();
            axes.with(Series::marked(&VALIDATION, &errors).role(o.way.role).dashes(way).named(o.way.name))
        })
    };
    twins.iter().map(panel).fold(Figure::new("Accuracy on validation data", caption), Figure::panel)
}

/// Writes the tables into accuracy.md of this folder, and draws accuracy.svg.
pub fn write(docs: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let page = docs.join("accuracy.md");
    page::write(&page, "draws", &draws()?)?;
    let twins = TWINS.into_iter().chain([OUTSIDE]).map(outcomes).collect::<Result<Vec<_>, _>>()?;
    page::write(&page, "summary", &summary(&twins))?;
    page::write(&page, "errors", &table(&twins))?;
    Ok(std::fs::write(docs.join("accuracy.svg"), figure(&twins).svg())?)
}
