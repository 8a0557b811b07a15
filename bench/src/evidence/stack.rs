//! The stack: one frequency, other amplitudes held out.

use crate::page::{self, cell, head, row};
use piezoid::formats::{ColumnSelection, Table};
use piezoid::validation::{Metrics, Offset, ValidateOptions, Validation};
use piezoid::{Error, IdentifyOptions, Model, Record, Validate, identify};
use piezoid_report::plot::{Axes, Figure, Role, Series};
use std::path::Path;

/// The transient at the start of each file [s].
const START: f64 = 1.5;

/// The displacement has an arbitrary offset, which drifts from record to record.
const FREE: ValidateOptions = ValidateOptions { skip: 0.0, offset: Offset::Free };

/// What one prediction of the held-out record gives.
pub struct Held {
    /// Its name.
    pub title: String,
    /// Its errors.
    pub metrics: Metrics,
}

/// A split of the records: what all are fitted to, what is held out, and from when on its errors count [s].
pub struct Split {
    /// Name of its table.
    pub name: &'static str,
    training: Vec<Record>,
    held_out: Record,
    skip: f64,
}

impl Split {
    /// The best straight line of the training data, on the held-out record.
    pub fn line(&self) -> (Held, Vec<f64>) {
        let of = |which: fn(&Record) -> &[f64]| -> Vec<f64> {
            // Each record has an offset of its own.
            let centred = |record| {
                let x = which(record);
                let mean = x.iter().sum::<f64>() / x.len() as f64;
                x.iter().map(move |x| x - mean).collect::<Vec<_>>()
            };
            self.training.iter().flat_map(centred).collect()
        };
        let (u, y) = (of(Record::u), of(Record::y));
        let gain = u.iter().zip(&y).map(|(u, y)| u * y).sum::<f64>() / u.iter().map(|u| u * u).sum::<f64>();
        let from = (self.skip / self.held_out.ts()).round() as usize;
        let (u, y) = (self.held_out.u(), &self.held_out.y()[from..]);
        let offset = y.iter().zip(&u[from..]).map(|(y, u)| y - gain * u).sum::<f64>() / y.len() as f64;
        let simulated: Vec<f64> = u.iter().map(|u| gain * u + offset).collect();
        (Held { title: "best straight line".into(), metrics: Metrics::of(y, &simulated[from..]) }, simulated)
    }

    /// The model of the training data with this operator, and its free run along the held-out record.
    ///
    /// # Errors
    /// The errors of [`identify`] and of the validation.
    pub fn model(&self, title: &str, operator: &str) -> Result<(Held, Validation), Error> {
        let options = IdentifyOptions { operator: operator.into(), ..IdentifyOptions::default() };
        let model: Model = identify(&self.training, &options)?.model;
        let found = model.validate_with(&self.held_out, &ValidateOptions { skip: self.skip, ..FREE })?;
        let name = model.hysteresis().operator().name;
        let title = if name == operator { title.into() } else { format!("{title}, `{name}`") };
        eprintln!("{title}: {:?}", found.metrics);
        Ok((Held { title, metrics: found.metrics }, found))
    }
}

fn record(folder: &Path, name: &str) -> Result<Record, Box<dyn std::error::Error>> {
    let bytes = std::fs::read(folder.join(name))?;
    Ok(Table::read(name, &bytes)?.record(&ColumnSelection::default())?.part(START, f64::INFINITY)?)
}

/// The splits of the records in this folder.
///
/// # Errors
/// Returns an error if a file is missing, or is no record.
pub fn splits(folder: &Path) -> Result<[Split; 2], Box<dyn std::error::Error>> {
    let (sine, other) = (record(folder, "model_1Hz.csv")?, record(folder, "test_am_1Hz.csv")?);
    let half = 0.5 * other.duration();
    let (first, second) = (other.part(0.0, half)?, other.part(half, f64::INFINITY)?);
    Ok([
        Split { name: "stack", training: vec![sine.clone()], held_out: other, skip: 0.0 },
        // Cut in motion: its first seconds depend on voltages that the second half does not have.
        Split { name: "stack with other amplitudes", training: vec![sine, first], held_out: second, skip: START },
    ])
}

/// Writes the tables of the stack, and its figure.
pub(super) fn write(folder: &Path, docs: &Path) -> Result<(), Box<dyn std::error::Error>> {
    for split in splits(folder)? {
        let (line, straight) = split.line();
        let (linear, _) = split.model("linear model", "proportional")?;
        let (model, run) = split.model("model with hysteresis", "auto")?;
        let mut table =
            head(["prediction", "rms error [% of peak-to-peak]", "rms error [um]", "largest error [um]"], 1);
        for Held { title, metrics } in [&line, &linear, &model] {
            let largest = format!("{:.2}", metrics.max_abs);
            table += &row([title.clone(), cell(metrics.rms_pp_percent), format!("{:.3}", metrics.rmse), largest]);
        }
        if let Some(floor) = &run.floor {
            let noise = [cell(floor.rms_pp_percent), format!("{:.3}", floor.rms), String::new()];
            table += &row(["noise of the record".to_string()].into_iter().chain(noise));
        }
        page::write(&docs.join("evidence.md"), split.name, &table)?;
        if split.skip == 0.0 {
            std::fs::write(docs.join("evidence-stack.svg"), figure(&split.held_out, &straight, &run).svg())?;
        }
    }
    Ok(())
}

/// The part that is drawn as loops [s]: the amplitude rises after a rest.
const LOOPS: std::ops::Range<f64> = 22.0..32.0;

/// Loops of the held-out record, measured and simulated, and the errors over time.
fn figure(held_out: &Record, straight: &[f64], run: &Validation) -> Figure {
    let caption = "Held out: sines of 1 Hz whose amplitude rises and falls. Left: voltage and displacement of ten \
                   seconds in which it rises, measured and simulated. Right: the errors over time, of the best straight \
                   line and of the model of another record.";
    let ts = held_out.ts();
    let at = |t: f64| ((t / ts) as usize).min(held_out.len());
    let drawn = at(LOOPS.start)..at(LOOPS.end);
    let mean = held_out.y().iter().sum::<f64>() / held_out.len() as f64;
    let centred = |y: &[f64]| y.iter().map(|y| y - mean).collect::<Vec<f64>>();
    let u = &held_out.u()[drawn.clone()];
    let loops = Axes::new("u [V]", "y [um], without its mean")
        .with(Series::line(u, &centred(&held_out.y()[drawn.clone()])).role(Role::Measured).named("measured"))
        .with(Series::line(u, &centred(&run.simulated[drawn])).role(Role::Model).dashes(1).named("model"));
    let t: Vec<f64> = (0..held_out.len()).map(|k| k as f64 * ts).collect();
    let error = |simulated: &[f64]| held_out.y().iter().zip(simulated).map(|(y, s)| y - s).collect::<Vec<f64>>();
    let errors = Axes::new("t [s]", "error [um]")
        .with(Series::line(&t, &error(straight)).role(Role::Muted).named("best straight line"))
        .with(Series::line(&t, &error(&run.simulated)).role(Role::Residual).named("model"));
    Figure::new("A stack, amplitudes held out", caption).medium().columns(2).panel(loops).panel(errors)
}
