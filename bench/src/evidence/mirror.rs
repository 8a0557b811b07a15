//! The mirror: three inputs, three outputs, many lightly damped modes. A model here has one input: each output is
//! predicted by the sum of three models.
//!
//! The records are periodic, in steady state, and the three inputs are orthogonal at each line over three realisations.
//! The linear response of an output to each input is thus the correlation of the training spectra. It only separates
//! the inputs: what an input adds to an output is the output less the linear responses to the two others.

use crate::page::{self, head, row};
use nalgebra::Complex;
use piezoid::{IdentifyOptions, Model, Record, System, Units, identify};
use piezoid_numerics::fourier::{Transform, windowed};
use piezoid_report::plot::{Axes, Axis, Figure, Role, Series};
use std::path::Path;

type Failure = Box<dyn std::error::Error>;
type Spectrum = Vec<Complex<f64>>;

/// Samples of a period, and their rate [Hz].
const N: usize = 8192;
const HZ: f64 = 6400.0;

/// Number of inputs and of outputs.
const AXES: usize = 3;
const REALISATIONS: usize = 6;
const PERIODS: usize = 2;

/// The rms levels of the voltages [mV].
const LEVELS: [usize; 3] = [100, 200, 300];

/// Training: the first realisations of each level. The inputs are orthogonal over three of them.
const TRAINING: std::ops::Range<usize> = 0..3;
const HELD_OUT: std::ops::Range<usize> = 3..6;

/// Lines are excited if their power is at least this share of the largest.
const EXCITED: f64 = 1e-6;

/// Metres in micrometres.
const UM: f64 = 1e6;

/// The steady state of one realisation at one level.
struct Experiment {
    level: usize,
    /// Voltages [V] and displacements [um]: means of the two periods.
    u: [Vec<f64>; AXES],
    y: [Vec<f64>; AXES],
    /// Half the difference of the displacements in the two periods: the noise of their mean [um].
    noise: [Vec<f64>; AXES],
}

/// The numbers of an array of shape (N, AXES, REALISATIONS, PERIODS).
fn array(path: &Path) -> Result<Vec<f64>, Failure> {
    let bytes = std::fs::read(path)?;
    let shape = format!("'shape': ({N}, {AXES}, {REALISATIONS}, {PERIODS})");
    let wrong = || format!("{}: not an array of doubles with {shape}", path.display());
    let start = bytes.iter().position(|byte| *byte == b'\n').ok_or_else(wrong)? + 1;
    let header = String::from_utf8_lossy(&bytes[..start]).into_owned();
    let (numbers, []) = bytes[start..].as_chunks() else { return Err(wrong().into()) };
    let known = ["'descr': '<f8'", "'fortran_order': False", &shape].iter().all(|part| header.contains(part));
    if !known || numbers.len() != N * AXES * REALISATIONS * PERIODS {
        return Err(wrong().into());
    }
    Ok(numbers.iter().map(|number| f64::from_le_bytes(*number)).collect())
}

/// All experiments of some realisations.
fn experiments(folder: &Path, realisations: std::ops::Range<usize>) -> Result<Vec<Experiment>, Failure> {
    let mut found = Vec::new();
    for level in LEVELS {
        let [u, y] = ["u", "y"].map(|name| array(&folder.join(format!("{name}_{level}mV_train.npy"))));
        let (u, y) = (u?, y?);
        let at =
            |t: usize, axis: usize, r: usize, period: usize| ((t * AXES + axis) * REALISATIONS + r) * PERIODS + period;
        for r in realisations.clone() {
            let of = |x: &[f64], sign: f64, scale: f64| {
                [0, 1, 2].map(|axis| {
                    let both = |t: usize| [x[at(t, axis, r, 0)], x[at(t, axis, r, 1)]];
                    (0..N).map(|t| 0.5 * scale * (both(t)[0] + sign * both(t)[1])).collect::<Vec<f64>>()
                })
            };
            found.push(Experiment { level, u: of(&u, 1.0, 1.0), y: of(&y, 1.0, UM), noise: of(&y, -1.0, UM) });
        }
    }
    Ok(found)
}

fn spectrum(x: &[f64]) -> Spectrum {
    windowed(x, |_| 1.0).0
}

/// The periodic signal of a one-sided spectrum without its mean.
fn signal(spectrum: &[Complex<f64>]) -> Vec<f64> {
    let mut bins = vec![Complex::new(0.0, 0.0); N];
    for (k, c) in spectrum.iter().enumerate().skip(1) {
        // The transform of the conjugate is the conjugate of the inverse one.
        (bins[k], bins[N - k]) = (c.conj(), *c);
    }
    Transform::new(N).process(&mut bins);
    bins.iter().map(|c| c.re / N as f64).collect()
}

/// The linear responses of the outputs to the inputs, by frequency.
struct Linear([[Spectrum; AXES]; AXES]);

impl Linear {
    /// That of the training data.
    fn of(training: &[Experiment]) -> Self {
        let spectra = |x: fn(&Experiment) -> &[Vec<f64>; AXES]| -> Vec<[Spectrum; AXES]> {
            training.iter().map(|e| [0, 1, 2].map(|axis| spectrum(&x(e)[axis]))).collect()
        };
        let (u, y) = (spectra(|e| &e.u), spectra(|e| &e.y));
        let response = |i: usize, j: usize| -> Spectrum {
            let power = |k: usize| u.iter().map(|u| u[j][k].norm_sqr()).sum::<f64>();
            let largest = (1..=N / 2).map(power).fold(0.0, f64::max);
            let gain = |k: usize| {
                let common: Complex<f64> = y.iter().zip(&u).map(|(y, u)| y[i][k] * u[j][k].conj()).sum();
                if k > 0 && power(k) > EXCITED * largest { common / power(k) } else { Complex::new(0.0, 0.0) }
            };
            (0..=N / 2).map(gain).collect()
        };
        Linear([0, 1, 2].map(|i| [0, 1, 2].map(|j| response(i, j))))
    }

    /// What the voltage of one input adds to an output [um].
    fn part(&self, i: usize, j: usize, u: &[f64]) -> Vec<f64> {
        signal(&spectrum(u).iter().zip(&self.0[i][j]).map(|(u, g)| u * g).collect::<Vec<_>>())
    }
}

/// The sum of what several inputs add.
fn sum(parts: impl Iterator<Item = Vec<f64>>) -> Vec<f64> {
    parts
        .reduce(|mut sum, part| {
            sum.iter_mut().zip(part).for_each(|(sum, x)| *sum += x);
            sum
        })
        .unwrap_or_default()
}

/// A period, from its largest voltage on: a record that starts there is taken to have been in motion before.
fn turned(u: &[f64], y: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let peak = (0..u.len()).max_by(|a, b| u[*a].abs().total_cmp(&u[*b].abs())).unwrap_or_default();
    let turn = |x: &[f64]| [&x[peak..], &x[..peak]].concat();
    (turn(u), turn(y))
}

/// The model of what an input adds to an output, from the first realisation of each level, with default options.
fn identified(training: &[Experiment], linear: &Linear, i: usize, j: usize) -> Result<Model, Failure> {
    let first = training.iter().step_by(TRAINING.len());
    let record = |e: &Experiment| {
        let others = sum((0..AXES).filter(|other| *other != j).map(|other| linear.part(i, other, &e.u[other])));
        let own: Vec<f64> = e.y[i].iter().zip(&others).map(|(y, others)| y - others).collect();
        let (u, y) = turned(&e.u[j], &own);
        Ok::<_, piezoid::Error>(Record::new(1.0 / HZ, u, y)?.with_units(Units { u: "V".into(), y: "um".into() }))
    };
    let records = first.map(record).collect::<Result<Vec<_>, _>>()?;
    let start = std::time::Instant::now();
    let model = identify(&records, &IdentifyOptions::default())?.model;
    eprintln!("output {i}, input {j}: {model}, {:.0} s", start.elapsed().as_secs_f64());
    Ok(model)
}

/// The steady state of a model along a period.
fn settled(model: &Model, u: &[f64]) -> Vec<f64> {
    model.simulate(&[u, u].concat()).split_off(u.len())
}

/// A way to predict the outputs of an experiment.
struct Way<'a> {
    name: &'static str,
    role: Role,
    predict: &'a dyn Fn(&Experiment, usize) -> Vec<f64>,
}

/// Errors of all outputs of an experiment without their means [um].
fn errors(way: &Way, e: &Experiment) -> [Vec<f64>; AXES] {
    [0, 1, 2].map(|i| {
        let predicted = (way.predict)(e, i);
        let error: Vec<f64> = e.y[i].iter().zip(&predicted).map(|(y, p)| y - p).collect();
        let mean = error.iter().sum::<f64>() / N as f64;
        error.iter().map(|x| x - mean).collect()
    })
}

fn rms<'a>(x: impl Iterator<Item = &'a Vec<f64>>) -> f64 {
    let (squares, n) = x.flatten().fold((0.0, 0.0), |(squares, n), x| (squares + x * x, n + 1.0));
    f64::sqrt(squares / n)
}

/// Writes the table of the mirror, and its figure.
pub(super) fn write(folder: &Path, docs: &Path) -> Result<(), Failure> {
    let (training, held_out) = (experiments(folder, TRAINING)?, experiments(folder, HELD_OUT)?);
    let linear = Linear::of(&training);
    let gains = |i: usize, j: usize| {
        let products = |x: fn(&Experiment, usize) -> &Vec<f64>, axis: usize| -> f64 {
            training.iter().map(|e| x(e, axis).iter().zip(&e.u[j]).map(|(x, u)| x * u).sum::<f64>()).sum()
        };
        products(|e, i| &e.y[i], i) / products(|e, j| &e.u[j], j)
    };
    let gains = [0, 1, 2].map(|i| [0, 1, 2].map(|j| gains(i, j)));
    let mut models = Vec::new();
    for i in 0..AXES {
        models.push((0..AXES).map(|j| identified(&training, &linear, i, j)).collect::<Result<Vec<_>, _>>()?);
    }
    let scaled = |e: &Experiment, i: usize| sum((0..AXES).map(|j| e.u[j].iter().map(|u| gains[i][j] * u).collect()));
    let modelled = |e: &Experiment, i: usize| sum((0..AXES).map(|j| settled(&models[i][j], &e.u[j])));
    let lines = |e: &Experiment, i: usize| sum((0..AXES).map(|j| linear.part(i, j, &e.u[j])));
    let ways = [
        Way { name: "best constant gains", role: Role::Muted, predict: &scaled },
        Way { name: "sums of three models", role: Role::Model, predict: &modelled },
        Way { name: "linear response, each line by itself", role: Role::Reference, predict: &lines },
    ];
    let titles = LEVELS.iter().flat_map(|level| [format!("{level} mV [um]"), "[%]".into()]);
    let mut table = head(["prediction".to_string()].into_iter().chain(titles), 1);
    let at = |level: usize| held_out.iter().filter(move |e| e.level == level);
    // Largest less smallest displacement, as a root mean square over outputs and realisations.
    let heights = |level: usize| {
        let height =
            |y: &Vec<f64>| y.iter().copied().fold(f64::MIN, f64::max) - y.iter().copied().fold(f64::MAX, f64::min);
        rms([at(level).flat_map(|e| e.y.iter().map(height)).collect::<Vec<f64>>()].iter())
    };
    let mut line = |name: &str, of: &dyn Fn(usize) -> f64| {
        let cells = LEVELS.iter().flat_map(|level| {
            let error = of(*level);
            [format!("{error:.3}"), page::cell(100.0 * error / heights(*level))]
        });
        table += &row([name.to_string()].into_iter().chain(cells));
    };
    for way in &ways {
        line(way.name, &|level| {
            let all: Vec<_> = at(level).flat_map(|e| errors(way, e)).collect();
            rms(all.iter())
        });
    }
    line("repeatability", &|level| {
        let all: Vec<_> = at(level).flat_map(|e| e.noise.clone()).collect();
        rms(all.iter())
    });
    page::write(&docs.join("evidence.md"), "mirror", &table)?;
    Ok(std::fs::write(docs.join("evidence-mirror.svg"), figure(&held_out, &ways).svg())?)
}

/// Bands of a third of an octave from this frequency on [Hz].
const FIRST_BAND: f64 = 12.5;
const BANDS: i32 = 24;

/// Rms in bands [um] of all outputs of some experiments.
fn bands(all: &[Vec<f64>]) -> (Vec<f64>, Vec<f64>) {
    let spectra: Vec<Spectrum> = all.iter().map(|x| spectrum(x)).collect();
    let edge = |k: i32| FIRST_BAND * libm::exp2((f64::from(k) - 0.5) / 3.0);
    let power = |k: i32| {
        let bin = |hz: f64| ((hz * N as f64 / HZ).round() as usize).min(N / 2);
        let within = |x: &Spectrum| x[bin(edge(k))..bin(edge(k + 1))].iter().map(|c| 2.0 * c.norm_sqr()).sum::<f64>();
        spectra.iter().map(within).sum::<f64>() / (spectra.len() as f64 * (N * N) as f64)
    };
    (0..BANDS).map(|k| (FIRST_BAND * libm::exp2(f64::from(k) / 3.0), power(k).sqrt())).unzip()
}

/// Displacement and errors by frequency, at the highest level.
fn figure(held_out: &[Experiment], ways: &[Way]) -> Figure {
    let caption = "Rms displacement and errors of the held-out realisations at 300 mV in bands of a third of an octave, \
                   all three outputs: measured, repeatability, and the errors of the ways to predict it.";
    let level = LEVELS[LEVELS.len() - 1];
    let at = || held_out.iter().filter(move |e| e.level == level);
    let series = |all: Vec<Vec<f64>>, role: Role, k: usize, name: &str| {
        let (hz, rms) = bands(&all);
        Series::marked(&hz, &rms).role(role).dashes(k).named(name)
    };
    let axes = Axes::new(Axis::log("f [Hz]"), Axis::log("rms [um]")).with(series(
        at().flat_map(|e| e.y.clone()).collect(),
        Role::Measured,
        0,
        "measured displacement",
    ));
    let of = |axes: Axes, (k, way): (usize, &Way)| {
        axes.with(series(at().flat_map(|e| errors(way, e)).collect(), way.role, k + 1, way.name))
    };
    // The errors of constant gains are as large as the displacement.
    let axes = ways.iter().enumerate().skip(1).fold(axes, of);
    let noise = series(at().flat_map(|e| e.noise.clone()).collect(), Role::Accent5, 4, "repeatability");
    Figure::new("A mirror, realisations held out", caption).panel(axes.with(noise))
}
