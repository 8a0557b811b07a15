//! docs/operators.md: every law identified as every law, followed by a resonance. How well does one hysteresis law
//! describe another? Learned operators are not among them: their fits would take most of the time.

use crate::page::{self, cell, head, row};
use piezoid::excitation::{Prbs, RisingSine, Staircase};
use piezoid::hammerstein::Model;
use piezoid::hysteresis::{OPERATORS, Operator};
use piezoid::linear::Arx;
use piezoid::validation::Metrics;
use piezoid::{Error, IdentifyOptions, Record, Records, System, identify};
use piezoid_report::plot::Figure;
use std::f64::consts::{SQRT_2, TAU};
use std::fmt::Write;
use std::path::Path;

/// Sampling period [s].
const TS: f64 = 5e-4;

/// Frequency [Hz] and damping ratio of the resonance behind the hysteresis.
const RESONANCE: (f64, f64) = (147.0, 0.06);

/// Frequencies [Hz] and amplitudes [V] of the rising sines, and their duration [s]. The largest amplitudes use the
/// whole range of the examples.
const RISING: [(f64, f64); 6] = [(5.0, 30.0), (20.0, 30.0), (80.0, 30.0), (5.0, 20.0), (20.0, 20.0), (80.0, 20.0)];
const DURATION: f64 = 0.8;

/// Amplitude of the validation data [V].
const VALIDATION: f64 = 29.0;

/// The example of an operator, followed by a resonance, without noise.
fn plant(truth: &Operator) -> Result<Model, Error> {
    let (hz, damping) = RESONANCE;
    let radius = (-damping * TAU * hz * TS).exp();
    let turn = TAU * hz * TS * (1.0f64 - damping * damping).sqrt();
    let a = [2.0 * radius * turn.cos(), -radius * radius];
    let half = 0.5 * (1.0 - a[0] - a[1]);
    let linear = Arx::new(TS, a.into(), vec![0.0, 1.1 * half, 0.9 * half])?;
    Model::new((truth.example)(TS)?, linear, 0.3)
}

/// Rms error [% of peak-to-peak] of the operator `model`, identified jointly from records of `truth`. The validation
/// data are a modulated sine and a staircase.
pub fn error(truth: &Operator, model: &Operator) -> Result<f64, Error> {
    let plant = plant(truth)?;
    let record = |u: Vec<f64>| Record::new(TS, u.clone(), plant.simulate(&u));
    let n = (DURATION / TS) as usize;
    let small = record(Prbs { order: 10, amplitude: 1.0, ..Prbs::default() }.samples(TS, 1023)?)?;
    let rising =
        |(frequency, amplitude)| record(RisingSine { amplitude, frequency, ..RisingSine::default() }.samples(TS, n)?);
    let large = RISING.into_iter().map(rising).collect::<Result<Vec<_>, _>>()?;
    let options = IdentifyOptions { operator: model.name.into(), seed: 0, ..IdentifyOptions::default() };
    let found = identify(Records { small_signal: &[small], large_signal: &large }, &options)?.model;

    let modulated = |t: usize| {
        let t = TS * t as f64;
        VALIDATION * (0.5 + 0.5 * (TAU * 3.7 * SQRT_2 * t).sin()) * (TAU * 17.3 * t).sin()
    };
    let staircase = Staircase { amplitude: VALIDATION, frequency: 3.0, levels: 15, offset: 0.0 }.samples(TS, 4000)?;
    let errors = [(0..4000).map(modulated).collect(), staircase]
        .map(|u| Metrics::of(&plant.simulate(&u), &found.simulate(&u)).rms_pp_percent);
    Ok((0.5 * (errors[0] * errors[0] + errors[1] * errors[1])).sqrt())
}

/// The operators that are not learned.
pub fn laws() -> impl Iterator<Item = &'static Operator> + Clone {
    OPERATORS.iter().copied().filter(|operator| !operator.is_learned())
}

/// The errors as the table of docs/operators.md.
fn table(errors: &[Vec<f64>]) -> String {
    let numbers = (1..=errors.len()).map(|k| k.to_string());
    let body = errors.iter().zip(laws()).enumerate().map(|(k, (errors, truth))| {
        row([format!("{} `{}`", k + 1, truth.name)].into_iter().chain(errors.iter().map(|e| cell(*e))))
    });
    head(["true operator".into()].into_iter().chain(numbers), 1) + &body.collect::<String>()
}

/// Width of the names, height of the numbers above, and size of a cell [units of the drawing].
const NAMES: usize = 250;
const HEAD: usize = 60;
const CELL: usize = 48;

/// Map of the errors: larger errors are darker, on a logarithmic scale from 0.01 to 10 %.
fn map(errors: &[Vec<f64>]) -> String {
    let n = errors.len();
    let (width, height) = (NAMES + n * CELL + 14, HEAD + n * CELL + 14);
    let text = |x: usize, y: usize, anchor: &str, class: &str, words: &str| {
        format!("<text x=\"{x}\" y=\"{y}\" text-anchor=\"{anchor}\" class=\"{class}\">{words}</text>\n")
    };
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" role=\"img\">\n\
         <title>Each operator identified as each operator</title>\n<style>\n{}text{{font:13px system-ui,sans-serif;fill:var(--pz-ink)}}\
         .small{{font-size:11px}}.soft{{fill:var(--pz-soft)}}.bold{{font-weight:600;fill:var(--pz-model)}}</style>\n\
         <rect width=\"{width}\" height=\"{height}\" fill=\"var(--pz-paper)\"/>\n",
        Figure::style()
    );
    svg += &text(14, 22, "start", "", "rms error on validation data [% of peak-to-peak]");
    svg += &text(14, HEAD - 10, "start", "soft", "true operator");
    svg += &text(NAMES - 14, HEAD - 10, "end", "soft", "identified as");
    for (i, (row, truth)) in errors.iter().zip(laws()).enumerate() {
        let (middle, y) = (HEAD + i * CELL + CELL / 2 + 5, HEAD + i * CELL);
        svg += &text(14, middle, "start", "", &format!("{} {}", i + 1, truth.name));
        svg += &text(NAMES + i * CELL + CELL / 2, HEAD - 10, "middle", "soft", &(i + 1).to_string());
        for (j, &error) in row.iter().enumerate() {
            let (x, shade) = (NAMES + j * CELL, ((error.max(1e-2).log10() + 2.0) / 3.0).clamp(0.0, 1.0));
            let _ = writeln!(
                svg,
                "<rect x=\"{x}\" y=\"{y}\" width=\"{CELL}\" height=\"{CELL}\" fill=\"var(--pz-descending)\" fill-opacity=\"{:.2}\" \
                 stroke=\"var(--pz-paper)\"/>",
                0.03 + 0.6 * shade
            );
            let words = cell(error);
            let class = match words.len() {
                _ if i == j => "bold",
                7.. => "small",
                _ => "",
            };
            svg += &text(x + CELL / 2, middle, "middle", class, &words);
        }
    }
    svg + "</svg>\n"
}

/// Writes the table into operators.md of this folder, and draws operators.svg.
pub fn write(docs: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let mut errors = Vec::new();
    for truth in laws() {
        errors.push(laws().map(|model| error(truth, model).unwrap_or(f64::NAN)).collect());
        eprintln!("{}: {:.4?}", truth.name, errors.last());
    }
    page::write(&docs.join("operators.md"), "matrix", &table(&errors))?;
    std::fs::write(docs.join("operators.svg"), map(&errors))?;
    Ok(())
}
