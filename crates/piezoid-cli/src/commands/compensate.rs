//! `piezoid compensate`: the voltage for a wanted displacement, by feed-forward.

use super::driver::Amplifier;
use crate::console::Console;
use crate::files::{self, Columns};
use crate::layout::table;
use crate::values::{apart, argument, period};
use anyhow::{Context, Result};
use clap::Args;
use piezoid::compensation::shaping::Shaping;
use piezoid::compensation::{Compensated, FeedForward, How};
use piezoid::number::{round, short as number};
use piezoid::validation::Metrics;
use piezoid::{Model, System};
use serde_json::json;
use std::path::{Path, PathBuf};

const EXAMPLES: &str = "\
Examples:
  The voltage for a displacement, within the limits of a driver:
    piezoid compensate --model model.json --reference r.csv --driver pl140 -o u.csv
  Steps as smooth moves of 20 ms that do not make the actuator ring:
    piezoid compensate --model model.json --reference steps.csv --smooth 0.02 --zvd \\
        -o u.csv
  What the plant makes of it:
    piezoid simulate --plant pl140 --input u.csv -o y.csv

The reference is the column r_*, or else y_*, in a unit of length that the model's output has too. It is taken to have \
stood at its first value for long. Errors are those of the model's free run: what the model does not know comes on top.";

#[derive(Args)]
#[command(after_help = EXAMPLES)]
#[command(override_usage = "piezoid compensate --model <FILE> --reference <FILE>\n           [OPTIONS] -o <FILE>")]
pub(crate) struct Compensate {
    /// The model file.
    #[arg(long, value_name = "FILE")]
    model: PathBuf,
    /// The wanted displacement.
    #[arg(long, value_name = "FILE")]
    reference: PathBuf,
    #[command(flatten)]
    amplifier: Amplifier,
    /// Come as close as the limits allow instead of refusing.
    #[arg(long)]
    clip: bool,
    /// Make minimum-jerk moves of this length from steps and corners.
    #[arg(long, value_name = "SECONDS", value_parser = period, allow_negative_numbers = true)]
    smooth: Option<f64>,
    /// Take the model's resonance out of the reference with a notch.
    #[arg(long)]
    notch: bool,
    /// Shaping the reference so that the model's resonance does not ring.
    #[arg(long)]
    zvd: bool,
    /// Correct, this many times at most, what the model's free run leaves.
    #[arg(long, value_name = "N", default_value_t = 0)]
    sweeps: usize,
    /// The file to write; - is stdout.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
    /// Write the figures as JSON; - is stdout.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    columns: Columns,
}

impl Compensate {
    pub(crate) fn run(self, console: &Console) -> Result<()> {
        apart(&[Some(&self.output), self.json.as_deref()], &[&self.model, &self.reference])?;
        files::ready(&[Some(&self.output), self.json.as_deref()])?;
        let limits = self.amplifier.limits()?.unwrap_or_default();
        let model = files::model(&self.model)?;
        let how = How { limits, clip: self.clip, sweeps: self.sweeps, ..How::default() };
        let advised = |e| self.amplifier.advised(e);
        let inverse =
            FeedForward::new(&model, how).map_err(advised).with_context(|| self.model.display().to_string())?;
        let asked = self.columns.reference(&self.reference, &model)?;
        let shape = Shaping { smooth: self.smooth, zvd: self.zvd, notch: self.notch };
        let r = argument(shape.of(&model, asked.clone()))?;
        let made = inverse.whole(&r).map_err(advised).with_context(|| self.reference.display().to_string())?;
        let (metrics, of_asked) = (Metrics::of(&r, &made.reached), Metrics::of(&asked, &made.reached));
        let of_asked = (r != asked).then_some(&of_asked);
        let stdout = Some(Path::new("-"));
        if self.json.as_deref() != stdout && Some(&*self.output) != stdout {
            console.print(&tables(&model, &metrics, of_asked, &made, console))?;
        }
        for note in &made.notes {
            console.remark(note);
        }
        let result = json!({
            "unit": model.units().y, "n": metrics.n, "rmse": metrics.rmse, "max_abs": metrics.max_abs,
            "rms_pp_percent": metrics.rms_pp_percent, "clipped": made.clipped, "reach": inverse.reach(),
            "usage": made.usage, "notes": made.notes, "asked": of_asked,
        });
        let (u_name, r_name) = (format!("u_{}", model.units().u), format!("r_{}", model.units().y));
        let text = piezoid::formats::Table::write(model.ts(), &[(&u_name, &made.u), (&r_name, &r)])?;
        files::write(&self.output, &text, console)?;
        files::write_json(self.json.as_deref(), &result, console)
    }
}

/// How near the model says the displacement comes, and what that takes.
fn tables(
    model: &Model,
    metrics: &Metrics,
    of_asked: Option<&Metrics>,
    made: &Compensated,
    console: &Console,
) -> String {
    let unit = &model.units().y;
    let (rms, max) = (format!("rms error [{unit}]"), format!("max [{unit}]"));
    let figures = |name: &str, m: &Metrics| {
        [vec![name.to_string()], [m.rmse, m.max_abs, m.rms_pp_percent].map(number).to_vec()].concat()
    };
    let name = if of_asked.is_some() { "of the shaped" } else { "foretold" };
    let foretold = std::iter::once(figures(name, metrics)).chain(of_asked.map(|m| figures("of the asked", m)));
    let input = &model.units().u;
    let row = |peak: &piezoid::excitation::Peak| {
        let (quantity, unit) = (peak.quantity.trim_end_matches(" voltage"), peak.unit.replace('V', input));
        let limit = peak.limit.map_or("-".into(), round);
        let share = peak.share.map_or("-".into(), |share| format!("{:.0}", 100.0 * share));
        vec![format!("{quantity} [{unit}]"), number(peak.value), limit, share]
    };
    let rows: Vec<Vec<String>> = made.usage.peaks().map(row).collect();
    let error = table(&["free run", &rms, &max, "% of stroke"], &foretold.collect::<Vec<_>>(), console.room());
    error + "\n" + &table(&["input", "value", "limit", "% of limit"], &rows, console.room())
}
