//! docs/stand-in.md: the tracking error on a stand-in beside the error on the actuator itself, for six twins and five
//! paths each.

use crate::page::{self, cell, head, row};
use piezoid::compensation::shaping::Shaping;
use piezoid::control::{Reference, SimulatedActuator};
use piezoid::excitation::Prbs;
use piezoid::plant::{Plant, Preset, Spec};
use piezoid::progress::Stage;
use piezoid::{Error, IdentifyOptions, Model, Record, Records, System, identify};
use piezoid_verbs::{CompensateOptions, Compensation, DataFile, File, stand_in};
use std::f64::consts::{PI, TAU};
use std::path::Path;

/// A twin, as it is measured: sampling period [s], range of the voltage [V], and highest frequency of the records [Hz].
struct Measured {
    twin: &'static str,
    ts: f64,
    range: (f64, f64),
    hz: f64,
}

const MEASURED: [Measured; 6] = [
    Measured { twin: "pl140", ts: 5e-4, range: (-28.0, 28.0), hz: 60.0 },
    Measured { twin: "pl140-bouc-wen", ts: 5e-4, range: (-28.0, 28.0), hz: 60.0 },
    Measured { twin: "pl140-nonlinear", ts: 5e-4, range: (-28.0, 28.0), hz: 60.0 },
    Measured { twin: "p885", ts: 1e-4, range: (5.0, 105.0), hz: 200.0 },
    Measured { twin: "p611", ts: 2e-4, range: (-15.0, 105.0), hz: 80.0 },
    Measured { twin: "tb3507", ts: 5e-5, range: (-230.0, 230.0), hz: 500.0 },
];

/// Samples of a record, and of a path.
const SAMPLES: usize = 12_000;
const PATH_SAMPLES: usize = 8_000;

/// A path: its name, its kind, its frequency over the highest one of the records, and its height over the stroke.
const PATHS: [(&str, &str, f64, f64); 5] = [
    ("slow triangle", "triangle", 0.05, 0.6),
    ("triangle", "triangle", 0.2, 0.6),
    ("small sine", "sine", 0.2, 0.15),
    ("fast sine", "sine", 1.0, 0.3),
    ("random", "random", 0.5, 0.5),
];

/// Smoothing of the paths, in periods of the highest frequency of the records.
const SMOOTH: f64 = 0.25;

/// Share of the records in which they begin and end.
const FADE: f64 = 0.02;

/// Share of a path in which its amplitude rises, and falls.
const RAMP: f64 = 0.2;

/// From 0 to 1 without a corner.
fn smoothstep(s: f64) -> f64 {
    s * s * (3.0 - 2.0 * s)
}

impl Measured {
    /// Rising sines at a low and at a middle frequency, a multisine up to the highest, and a small PRBS.
    fn records(&self) -> Result<(Vec<Record>, Vec<Record>), Error> {
        let (low, high) = self.range;
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        let time = |k: usize| k as f64 * self.ts;
        let along = |of: &dyn Fn(usize) -> f64| -> Vec<f64> {
            let fade = |k: usize| (k as f64 / (FADE * SAMPLES as f64)).min(1.0);
            (0..SAMPLES).map(|k| (middle + half * of(k)) * fade(k)).collect()
        };
        let rise = |k: usize| (k as f64 / (0.9 * SAMPLES as f64)).min(1.0);
        let slow = (0.05 * self.hz).max(2.0 / time(SAMPLES));
        let lines: Vec<f64> = (0..12).map(|k| slow * (self.hz / slow).powf(f64::from(k) / 11.0)).collect();
        // Phases of Schroeder, for a small peak.
        let phase = |j: usize| -PI * (j * j) as f64 / lines.len() as f64;
        let line = |(j, hz): (usize, &f64), k: usize| (TAU * hz * time(k) + phase(j)).sin();
        let sum = |k: usize| lines.iter().enumerate().map(|of| line(of, k)).sum::<f64>();
        let peak = (0..SAMPLES).map(|k| sum(k).abs()).fold(0.0, f64::max);
        let large = [
            along(&|k| rise(k) * (TAU * slow * time(k)).sin()),
            along(&|k| 0.9 * rise(k) * (TAU * self.hz / 3.0 * time(k)).sin()),
            along(&|k| 0.9 * sum(k) / peak),
        ];
        let steps = Prbs { amplitude: 0.03, ..Prbs::default() }.samples(self.ts, SAMPLES)?;
        let small = along(&|k| steps[k]);
        let spec = Preset::find(self.twin)?.spec();
        let record = |(seed, u): (u64, Vec<f64>)| -> Result<Record, Error> {
            let y = Plant::new(&spec, self.ts)?.with_seed(seed).run(&u).y;
            Record::new(self.ts, u, y)
        };
        let large = (1..).zip(large).map(record).collect::<Result<_, _>>()?;
        Ok((vec![record((9, small))?], large))
    }
}

/// The rms errors along a path: constant gain and compensated on the stand-in, its range, and compensated on the twin.
struct Tracked {
    stand_in: [f64; 2],
    spread: [f64; 2],
    twin: f64,
}

/// The rms errors along a path that is smoothed over so many seconds [% of its height].
fn tracked(
    model: &Model,
    (own, twin): (&SimulatedActuator, &SimulatedActuator),
    (r, smooth): (Vec<f64>, f64),
) -> Result<Tracked, Error> {
    let (low, high) = r.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), r| (low.min(*r), high.max(*r)));
    let units = model.units();
    let table = piezoid::formats::Table::write("r.csv", model.ts(), &[(&format!("r_{}", units.y), &r)])?;
    let (file, reference) = (File::new("model.json", model.to_json()), DataFile::from(File::new("r.csv", table)));
    let on = |name: &str, actuator: &SimulatedActuator| -> Result<Compensation, Error> {
        CompensateOptions {
            shape: Shaping { smooth: Some(smooth), ..Shaping::default() },
            ..CompensateOptions::default()
        }
        .run(&file, &reference, &Default::default(), Some((name, actuator)))
    };
    let percent = |rms: f64| 100.0 * rms / (high - low);
    let errors = |found: Compensation| {
        let played = found.on_plant.ok_or_else(|| Error::Content("nothing was played".into()))?;
        Ok::<_, Error>((played.errors.map(|error| percent(error.rmse)), played.spread.map(|s| s.map(percent))))
    };
    let (stand_in, spread) = errors(on("stand-in", own)?)?;
    let ([_, twin], _) = errors(on("twin", twin)?)?;
    Ok(Tracked { stand_in, spread: spread.unwrap_or([f64::NAN; 2]), twin })
}

/// Writes the table into stand-in.md of this folder.
pub fn write(docs: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let titles = ["twin", "operators", "path", "constant gain", "stand-in", "its range", "twin", "ratio"];
    let (mut body, mut ratios) = (String::new(), Vec::new());
    for measured in &MEASURED {
        let (small, large) = measured.records()?;
        let records = Records { small_signal: &small, large_signal: &large };
        let model = identify(records, &IdentifyOptions::default())?.model;
        let own = stand_in(&model, records, &mut Stage::ignore)?;
        let name = |model: &Model| model.hysteresis().operator().name;
        let operators = format!("`{}`, `{}`", name(&model), name(own.other()));
        let spec: Spec = Preset::find(measured.twin)?.spec();
        let (own, twin) = (own.into(), spec.into());
        let (low, high) = measured.range;
        let still = |u: f64| model.step(&mut model.settled(u), u);
        let (bottom, top) = (still(low), still(high));
        for (title, kind, hz, height) in PATHS {
            let peak = 0.5 * height * (top - bottom);
            let hz = (hz * measured.hz).max(3.0 / (PATH_SAMPLES as f64 * measured.ts));
            let mut r = Reference::find(kind)?.samples(measured.ts, PATH_SAMPLES, peak, hz)?;
            // It begins and ends at rest: no voltage follows a sine that stops.
            let ramp = |k: usize| (k as f64 / (RAMP * PATH_SAMPLES as f64)).min(1.0);
            let at_rest = |k: usize| smoothstep(ramp(k)) * smoothstep(ramp(PATH_SAMPLES - 1 - k));
            r.iter_mut().enumerate().for_each(|(k, r)| *r = 0.5 * (bottom + top) + at_rest(k) * *r);
            let found = tracked(&model, (&own, &twin), (r, SMOOTH / measured.hz))?;
            let ratio = found.stand_in[1] / found.twin;
            ratios.push(ratio);
            let range = found.spread.map(cell).join(" to ");
            let cells =
                [cell(found.stand_in[0]), cell(found.stand_in[1]), range, cell(found.twin), format!("{ratio:.2}")];
            body += &row([format!("`{}`", measured.twin), operators.clone(), title.into()].into_iter().chain(cells));
        }
    }
    let within = ratios.iter().filter(|ratio| (0.5..=2.0).contains(*ratio)).count();
    let [least, most] = [f64::min, f64::max].map(|of| ratios.iter().copied().reduce(of).unwrap_or(f64::NAN));
    let sentence =
        format!("\nWithin a factor of two: {within} of {}; all ratios: {least:.2} to {most:.2}.\n", ratios.len());
    page::write(&docs.join("stand-in.md"), "stand-in", &(head(titles, 3) + &body + &sentence))
}
