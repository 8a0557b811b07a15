//! `piezoid control`: the closed loop on a simulated actuator, several schemes side by side.

use super::driver::Amplifier;
use super::lists;
use super::tuning::Tuning;
use crate::console::Console;
use crate::files::{self, Columns};
use crate::layout::table;
use crate::values::{Misused, apart, argument, count, not_negative, percent, positive};
use anyhow::{Context, Result, bail};
use clap::Args;
use piezoid::compensation::How;
use piezoid::control::{
    Attempt, ClosedLoopRun, Comparison, ControllerInput, Drive, NamedReference, Reference, Scheme, Tolerance,
};
use piezoid::number::{round, short as number};
use piezoid::{Model, System, Units};
use std::hint::black_box;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

const EXAMPLES: &str = "\
Examples:
  The usual schemes along sines, triangles, a staircase and a random path:
    piezoid control --plant pl140 --model model.json
  One scheme along your own reference, the run as a file:
    piezoid control --plant pl140 --model model.json \\
        --controller feed-forward+integral-notch --reference r.csv -o run.csv
  200 actuators within +-20 % of the catalogue, as a page with figures:
    piezoid control --plant pl140 --model model.json --controller pi predictive \\
        --reference triangle:20 --tolerance 20 --report control.html

A controller is a feed-forward (gain, feed-forward, learning), a feedback (see `piezoid controllers`), or both with a + \
between; a feedback alone works on top of gain, the best straight line. A reference is a file with a column r_* or y_*, or sine, \
triangle, staircase or random with a frequency in Hz, such as sine:5. Errors are those of the reading, in % of the height of the \
reference, after a quarter of a second of those that repeat.";

/// What is compared where nothing is named.
const SCHEMES: [&str; 6] =
    ["gain", "feed-forward", "integral-notch", "feed-forward+integral-notch", "learning", "predictive"];
const REFERENCES: [&str; 10] = [
    "sine:1",
    "sine:5",
    "sine:20",
    "sine:40",
    "triangle:1",
    "triangle:5",
    "triangle:20",
    "triangle:40",
    "staircase:1",
    "random:20",
];

/// Frequency where none is given [Hz].
const FREQUENCY: f64 = 5.0;

/// The height of a named reference, as a share of what the model can hold.
const SHARE: f64 = 0.8;

/// Its length: at least this long, and this many periods.
const SECONDS: f64 = 1.0;
const PERIODS: f64 = 4.0;

/// Its length at most [samples].
const LONGEST: f64 = 1e6;

#[derive(Args)]
#[command(after_help = EXAMPLES)]
#[command(override_usage = "piezoid control --plant <NAME|FILE> --model <FILE>\n           [OPTIONS]")]
pub(crate) struct Control {
    /// The actuator by name (see `piezoid plants`), or a JSON file of its parameters.
    #[arg(long, value_name = "NAME|FILE")]
    plant: String,
    /// The model that controllers are made from.
    #[arg(long, value_name = "FILE")]
    model: PathBuf,
    /// What to compare, such as feed-forward+pi [default: six schemes].
    #[arg(long, value_name = "NAME", num_args = 1..)]
    controller: Vec<String>,
    /// What to follow: files, or names such as sine:5 [default: ten].
    #[arg(long, value_name = "FILE|NAME[:HZ]", num_args = 1..)]
    reference: Vec<String>,
    /// Peak of named references, in the model's output unit [default: 0.8 of what it can hold].
    #[arg(long, value_name = "PEAK", value_parser = positive, allow_negative_numbers = true)]
    amplitude: Option<f64>,
    /// Samples of the reference that are known ahead [default: all].
    #[arg(long, value_name = "N")]
    preview: Option<usize>,
    /// Noise of the sensor, rms in the model's output unit [default: the plant's own].
    #[arg(long, value_name = "RMS", value_parser = not_negative, allow_negative_numbers = true)]
    noise: Option<f64>,
    #[command(flatten)]
    amplifier: Amplifier,
    /// Let feed-forward come as close as the limits allow instead of refusing.
    #[arg(long)]
    clip: bool,
    #[command(flatten)]
    tuning: Tuning,
    /// Also try plants whose values lie within this many percent of these, along the first reference.
    #[arg(long, value_name = "PERCENT", value_parser = percent, allow_negative_numbers = true)]
    tolerance: Option<f64>,
    /// How many.
    #[arg(long, value_name = "N", default_value_t = 200, requires = "tolerance", value_parser = count)]
    draws: usize,
    /// Seed of the noise and of the draws.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// The run as a record; of one controller and one reference. - is stdout.
    #[arg(short, long, value_name = "FILE")]
    output: Option<PathBuf>,
    /// Write a page with figures; - is stdout.
    #[arg(long, value_name = "FILE")]
    report: Option<PathBuf>,
    /// Write all figures as JSON; - is stdout.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    #[command(flatten)]
    columns: Columns,
}

impl Control {
    pub(crate) fn run(self, console: &Console) -> Result<()> {
        let results = [self.output.as_deref(), self.report.as_deref(), self.json.as_deref()];
        let files: Vec<PathBuf> = self.reference.iter().filter(|r| named(r).is_none()).map(PathBuf::from).collect();
        apart(&results, &files.iter().chain([&self.model]).collect::<Vec<_>>())?;
        let schemes = self.schemes()?;
        if self.output.is_some() && (schemes.len() != 1 || self.reference.len() != 1) {
            bail!(Misused("-o holds one run: name one --controller and one --reference with it".into()));
        }
        files::ready(&results)?;
        let compared = self.compared(schemes, console)?;
        if !results.contains(&Some(Path::new("-"))) {
            console.print(&tables(&compared, console))?;
        }
        self.remarks(&compared, console);
        if let (Some(path), Some(Ok(attempt))) = (&self.output, compared.driven[0].attempts.first()) {
            files::write(path, &record(&compared, &attempt.run)?, console)?;
        }
        if let Some(path) = &self.report {
            files::write(path, &piezoid_report::report::tracking(&compared).html(), console)?;
        }
        files::write_json(self.json.as_deref(), &compared.to_json(), console)
    }

    fn schemes(&self) -> Result<Vec<Scheme>> {
        let names: Vec<&str> = match self.controller.is_empty() {
            true => SCHEMES.to_vec(),
            false => self.controller.iter().map(String::as_str).collect(),
        };
        names.into_iter().map(|name| argument(Scheme::named(name))).collect()
    }

    fn compared(&self, schemes: Vec<Scheme>, console: &Console) -> Result<Comparison> {
        let limits = self.amplifier.limits()?.unwrap_or_default();
        let mut spec = lists::plant(&self.plant)?;
        let model = files::model(&self.model)?;
        if let Some(noise) = self.noise {
            let unit = &model.units().y;
            let Some(factor) = Units::factor(unit, "m") else {
                bail!("{}: its output is in {unit}, which is no length: leave --noise out", self.model.display());
            };
            spec = spec.with_sensor_noise(noise * factor);
        }
        let how = How { limits, clip: self.clip, ..How::default() };
        let target = self.tuning.target();
        let drive = |scheme: Scheme| -> Result<Drive> {
            let made =
                Drive::new(scheme, &model, how, self.tuning.late, &target).map_err(|e| self.amplifier.advised(e));
            let mut drive = made.with_context(|| format!("{}: {}", self.model.display(), scheme.name()))?;
            drive.ahead = self.preview.unwrap_or(usize::MAX);
            Ok(drive)
        };
        let mut drives = Vec::with_capacity(schemes.len());
        for scheme in schemes {
            match drive(scheme) {
                // Of the usual ones, those that the model gives.
                Err(e) if self.controller.is_empty() && scheme.law.is_some() => {
                    console.remark(&format!("{} is left out: {}", scheme.name(), e.root_cause()));
                }
                made => drives.push(made?),
            }
        }
        let wanted = self.wanted(&model, how)?;
        for NamedReference { name, r, .. } in &wanted {
            drives[0].check(r).map_err(|e| self.amplifier.advised(e)).with_context(|| name.clone())?;
        }
        let share =
            self.tolerance.map(|percent| Tolerance { share: percent / 100.0, draws: self.draws, seed: self.seed });
        let plant = Path::new(&self.plant).file_name().and_then(|name| name.to_str()).unwrap_or(&self.plant);
        console.done(Comparison::run(
            (plant, &spec),
            drives,
            wanted,
            self.seed,
            share.as_ref(),
            &mut console.progress(),
        ))
    }

    fn wanted(&self, model: &Model, how: How) -> Result<Vec<NamedReference>> {
        let names: Vec<&str> = match self.reference.is_empty() {
            true => REFERENCES.to_vec(),
            false => self.reference.iter().map(String::as_str).collect(),
        };
        let ts = model.ts();
        let one = |name: &str| match named(name) {
            None => {
                let path = Path::new(name);
                if let (false, Err(unknown)) = (path.exists(), Reference::find(name.split(':').next().unwrap_or(name)))
                {
                    bail!(Misused(format!("{name}: there is no such file, and {unknown}")));
                }
                let r = self.columns.reference(path, model)?;
                let short = path.file_name().and_then(|name| name.to_str()).unwrap_or(name);
                Ok(NamedReference::new(short, ts, r))
            }
            Some((kind, hz)) => {
                let hz = hz?;
                let peak = self.amplitude.map_or_else(|| held(model, how), Ok)?;
                let n = (SECONDS.max(PERIODS / hz) / ts).round();
                if n > LONGEST {
                    let least = number(PERIODS / (LONGEST * ts));
                    bail!(Misused(format!(
                        "--reference {name}: four periods are {n} samples: choose {least} Hz or more"
                    )));
                }
                let n = n as usize;
                let r = argument((kind.samples)(ts, n, peak, hz))?;
                Ok(NamedReference::new(format!("{} {} Hz", kind.name, round(hz)), ts, r))
            }
        };
        names.into_iter().map(one).collect()
    }

    fn remarks(&self, compared: &Comparison, console: &Console) {
        if let Some(hz) = compared.driven[0].drive.known_hz() {
            console.remark(&format!(
                "the model was identified up to {} Hz: feedback is kept slow enough for a resonance beyond; identify it on a PRBS too for \
                 a faster one",
                number(hz)
            ));
        }
        let mut told = Vec::new();
        for d in &compared.driven {
            for (wanted, attempt) in compared.wanted.iter().zip(&d.attempts) {
                let along = &wanted.name;
                match attempt {
                    Err(error) => console.remark(&format!("{}, {along}: {error}", d.name())),
                    Ok(Attempt { fed, run, .. }) => {
                        // A feed-forward says the same under every controller.
                        for note in
                            fed.notes.iter().map(|note| format!("{}, {along}: {note}", d.drive.scheme.feed.name))
                        {
                            if !told.contains(&note) {
                                console.remark(&note);
                                told.push(note);
                            }
                        }
                        if run.limited > 0 {
                            let (name, n) = (d.name(), run.u.len());
                            console.remark(&format!("{name}, {along}: {} of {n} voltages are at a limit", run.limited));
                        }
                    }
                }
            }
            if let (Some(_), Some(Ok(attempt))) = (d.drive.scheme.law, d.attempts.iter().find(|a| a.is_ok())) {
                let [middle, most] = timed(&d.drive, &attempt.run).map(|time| number(1e6 * time.as_secs_f64()));
                let (name, ts) = (d.name(), round(1e6 * d.drive.model().ts()));
                console.remark(&format!(
                    "{name}: a step takes {middle} us here, 99 of 100 at most {most}; a sample is {ts} us"
                ));
            }
        }
    }
}

/// A reference by name, and its frequency [Hz]; a name that is not in the list is a file's.
fn named(text: &str) -> Option<(&'static Reference, Result<f64>)> {
    let (name, hz) = text.split_once(':').map_or((text, None), |(name, hz)| (name, Some(hz)));
    let kind = Reference::find(name).ok()?;
    let hz = hz.map_or(Ok(FREQUENCY), |hz| {
        let hz = hz.parse().ok().filter(|hz: &f64| hz.is_finite() && *hz > 0.0);
        hz.ok_or_else(|| {
            Misused(format!("--reference {text}: the frequency must be a positive number of hertz")).into()
        })
    });
    Some((kind, hz))
}

/// The peak of named references: 0.8 of what can be held to both sides of 0.
fn held(model: &Model, how: How) -> Result<f64> {
    let (low, high) = piezoid::compensation::FeedForward::new(model, how)?.reach();
    let both = high.min(-low);
    if both > 0.0 {
        return Ok(SHARE * both);
    }
    let (low, high, unit) = (round(low), round(high), &model.units().y);
    bail!(
        "the model holds {low} to {high} {unit}, and named references go to both sides of 0: give a file, or --amplitude"
    )
}

/// The time of a step of the controller on the readings of a run: of the middle one, and of 99 of 100 at most.
fn timed(drive: &Drive, run: &ClosedLoopRun) -> [Duration; 2] {
    let controller = drive.controller();
    let mut x = controller.initial();
    let mut took = |t: usize| {
        let now = ControllerInput { y: run.y[t - 1], r: run.r[t - 1], feed: run.u[t], ahead: &run.r[t..] };
        let start = Instant::now();
        black_box(controller.step(&mut x, black_box(&now)));
        start.elapsed()
    };
    let mut times: Vec<Duration> = (1..run.u.len()).map(&mut took).collect();
    times.sort();
    [0.5, 0.99].map(|share| times.get((share * times.len() as f64) as usize).copied().unwrap_or_default())
}

/// The run as a record, with the reference.
fn record(compared: &Comparison, run: &ClosedLoopRun) -> Result<String> {
    let model = compared.driven[0].drive.model();
    let (u, y, r) =
        (format!("u_{}", model.units().u), format!("y_{}", model.units().y), format!("r_{}", model.units().y));
    Ok(piezoid::formats::Table::write(model.ts(), &[(&u, &run.u), (&y, &run.y), (&r, &run.r)])?)
}

fn tables(compared: &Comparison, console: &Console) -> String {
    let mut parts = vec![tracking(compared, console)];
    parts.extend(margins(compared, console));
    parts.extend(spreads(compared, console));
    parts.join("\n")
}

/// One reference: all figures of each scheme. Several: the rms errors.
fn tracking(compared: &Comparison, console: &Console) -> String {
    let unit = compared.unit();
    if let [only] = &compared.wanted[..] {
        let row = |d: &piezoid::control::SchemeResult| {
            let figures = match &d.attempts[0] {
                Err(_) => vec!["-".to_string(); 5],
                Ok(Attempt { run, tracking: t, .. }) => {
                    [t.percent_of_stroke, t.rms, t.max, t.effort, run.highest()].map(number).to_vec()
                }
            };
            [vec![d.name()], figures].concat()
        };
        let rows: Vec<_> = compared.driven.iter().map(row).collect();
        let (rms, max) = (format!("rms [{unit}]"), format!("max [{unit}]"));
        let header = [&*only.name, "rms [% of stroke]", &rms, &max, "effort [V]", "highest [V]"];
        return table(&header, &rows, console.room());
    }
    let row = |(k, wanted): (usize, &NamedReference)| {
        let figure = |a: &Result<Attempt, _>| a.as_ref().map_or("-".into(), |a| number(a.tracking.percent_of_stroke));
        let cells = compared.driven.iter().map(|d| figure(&d.attempts[k]));
        [wanted.name.clone()].into_iter().chain(cells).collect()
    };
    let names: Vec<String> = compared.driven.iter().map(|d| d.name()).collect();
    let header: Vec<&str> = ["rms error [% of stroke]"].into_iter().chain(names.iter().map(String::as_str)).collect();
    table(&header, &compared.wanted.iter().enumerate().map(row).collect::<Vec<_>>(), console.room())
}

fn margins(compared: &Comparison, console: &Console) -> Option<String> {
    let row = |d: &piezoid::control::SchemeResult| {
        let m = d.drive.margins()?;
        let figures = [m.gain_db, m.phase_deg, m.peak, m.bandwidth_hz].map(number);
        Some([d.name()].into_iter().chain(figures).collect())
    };
    let rows: Vec<Vec<String>> = compared.driven.iter().filter_map(row).collect();
    let header = ["loop", "gain margin [dB]", "phase margin [deg]", "peak of |S|", "bandwidth [Hz]"];
    (!rows.is_empty()).then(|| table(&header, &rows, console.room()))
}

fn spreads(compared: &Comparison, console: &Console) -> Option<String> {
    let row = |d: &piezoid::control::SchemeResult| {
        let spread = d.spread.as_ref()?;
        let shares = [0.5, 0.9, 1.0].map(|share| number(spread.percent_of_stroke(share)));
        let counted = |_| format!("{} of {}", spread.unstable(), spread.trials.len());
        let unstable = d.drive.scheme.law.map_or("-".into(), counted);
        Some([d.name()].into_iter().chain(shares).chain([unstable]).collect())
    };
    let rows: Vec<Vec<String>> = compared.driven.iter().filter_map(row).collect();
    let header = ["draws, rms [% of stroke]", "median", "9 of 10", "worst", "unstable"];
    (!rows.is_empty()).then(|| table(&header, &rows, console.room()))
}
