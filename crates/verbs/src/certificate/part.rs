//! The budgets of records and of bands.

use super::budget::{Budget, Contribution};
use super::evidence::Evidence;
use super::options::{CertificateOptions, Coefficient, MeanError, NoiseOrigin, Stated};
use crate::{Compared, Origin, merge};
use piezoid_models::hammerstein::Model;
use piezoid_numerics::error::Error;
use piezoid_numerics::number::{round, short};
use piezoid_numerics::series::mean;
use piezoid_numerics::system::System;
use piezoid_records::record::Units;
use piezoid_validation::{Bin, Offset, Source, output_factor};
use serde::Serialize;
use serde_json::{Value, json};

/// Smallest number of cycles of a band with a budget of its own.
const MIN_CYCLES: usize = 3;

/// Relative change of a voltage by which its influence is computed, if none is stated.
const SMALL: f64 = 1e-3;

/// The source that is noise.
const NOISE: &str = "noise";

/// A record of a certificate.
#[derive(Debug, Clone, PartialEq)]
pub struct CertifiedRecord {
    /// The record, and the free run on it.
    pub compared: Compared,
    /// Where it comes from.
    pub origin: Origin,
    /// Number of samples that count.
    pub n: usize,
    /// Its budget.
    pub budget: Budget,
    /// Mean of the measured displacement less the predicted one, and its standard uncertainty [output unit].
    pub mean_error: f64,
    /// See `mean_error`.
    pub mean_uncertainty: f64,
    /// Noise of the record [output unit].
    pub noise: Option<f64>,
    /// Number of independent errors.
    pub independent: f64,
    /// Share of its samples within the expanded uncertainty of the certificate [%].
    pub within_percent: f64,
    /// Share of its samples within its own expanded uncertainty [%].
    pub own_within_percent: f64,
}

/// A band of frequencies, over all records.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CertifiedBand {
    /// Lowest and highest frequency [Hz].
    pub hz: [f64; 2],
    /// Number of cycles.
    pub cycles: usize,
    /// Rms of the measured error [output unit].
    pub rmse: f64,
    /// Its budget.
    pub budget: Budget,
}

impl CertifiedBand {
    /// Its name.
    pub fn name(&self) -> String {
        let [low, high] = self.hz.map(short);
        format!("{low} to {high} Hz")
    }
}

impl CertifiedRecord {
    /// The errors that count: measured less predicted.
    pub fn errors(&self) -> Vec<f64> {
        errors(&self.compared)
    }

    /// Counts the samples within the expanded uncertainty of the certificate, and within its own. Measured errors have
    /// noise; if that does not count, it is added to the uncertainty here.
    pub(super) fn count_within(&mut self, correction: f64, expanded: f64) {
        let errors = self.errors();
        let counts = |row: &&Contribution| row.source == NOISE && row.sensitivity == 0.0;
        let noise = self.budget.rows.iter().find(counts).map_or(0.0, |row| self.budget.student_k * row.standard);
        let within = |uncertainty: f64| {
            let limit = libm::hypot(uncertainty, noise);
            let count = errors.iter().filter(|e| (*e - correction).abs() <= limit).count();
            100.0 * count as f64 / errors.len() as f64
        };
        (self.within_percent, self.own_within_percent) = (within(expanded), within(self.budget.expanded));
    }

    pub(super) fn to_json(&self) -> Value {
        let Compared { name, record, validation, domain } = &self.compared;
        let mut object = json!({
            "file": name, "sha256": self.origin.sha256, "ts": record.ts(), "duration_s": record.duration(),
            "n": self.n, "initial_condition": validation.initial_condition, "u": domain.u, "hz": domain.hz,
            "rmse": validation.metrics.rmse, "max_abs": validation.metrics.max_abs, "mean_error": self.mean_error,
            "mean_uncertainty": self.mean_uncertainty, "noise": self.noise, "drift_per_s": validation.drift_per_s,
            "independent": self.independent, "within_percent": self.within_percent,
            "own_within_percent": self.own_within_percent,
        });
        merge(&mut object, json!(self.budget));
        object
    }
}

fn errors(compared: &Compared) -> Vec<f64> {
    let (y, simulated) = (compared.record.y(), &compared.validation.simulated);
    y.iter().zip(simulated).skip(compared.validation.start).map(|(y, s)| y - s).collect()
}

/// How much a stated uncertainty changes the displacement of a record, at most.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Reach {
    /// Largest displacement from zero, or from the mean if that is removed [output unit].
    displacement: f64,
    /// Change of the displacement per percent of the voltage [output unit / %].
    gain: f64,
    /// Change of the displacement with an offset of the voltage [output unit / input unit].
    offset: f64,
}

impl Reach {
    pub(super) fn of(compared: &Compared, model: &Model, options: &CertificateOptions) -> Result<Self, Error> {
        let (record, start) = (&compared.record, compared.validation.start);
        let is_free = options.validation.offset != Offset::Kept;
        let farthest = |x: &[f64]| {
            let zero = if is_free { mean(x) } else { 0.0 };
            x.iter().map(|x| (x - zero).abs()).fold(0.0, f64::max)
        };
        let displacement = farthest(&compared.validation.simulated[start..]);
        if options.voltage_gain.is_none() && options.voltage_offset.is_none() {
            return Ok(Reach { displacement, ..Reach::default() });
        }
        let whole = record.at("the model", model.ts())?;
        let every = whole.every() / record.every();
        let k = output_factor(model.units(), record.units())?;
        let run = model.simulate(whole.u());
        let change = |of: &dyn Fn(f64) -> f64| {
            let u: Vec<f64> = whole.u().iter().map(|u| of(*u)).collect();
            let changed = model.simulate(&u);
            let change: Vec<f64> = changed.iter().zip(&run).skip(start * every).map(|(a, b)| k * (a - b)).collect();
            farthest(&change)
        };
        // By as much as is stated (5.1.3 of the GUM, second note): the hysteresis has no derivative at reversals.
        let share =
            options.voltage_gain.filter(|gain| *gain > 0.0).map_or(SMALL, |gain| 0.01 * gain / options.voltage_k);
        let span = whole.u().iter().fold(0.0, |most: f64, u| most.max(u.abs()));
        let volts = options.voltage_offset.filter(|offset| *offset > 0.0).unwrap_or(SMALL * span);
        let offset = if volts > 0.0 { change(&|u| u + volts) / volts } else { 0.0 };
        Ok(Reach { displacement, gain: change(&|u| u * (1.0 + share)) / (100.0 * share), offset })
    }

    /// The largest of each.
    pub(super) fn largest(all: &[Reach]) -> Self {
        all.iter().fold(Reach::default(), |a, b| Reach {
            displacement: a.displacement.max(b.displacement),
            gain: a.gain.max(b.gain),
            offset: a.offset.max(b.offset),
        })
    }
}

/// How budgets are made.
pub(super) struct Rules<'a> {
    pub(super) options: &'a CertificateOptions,
    pub(super) stated: &'a Stated,
    pub(super) units: &'a Units,
}

impl Rules<'_> {
    /// The correction of all predictions, with its standard uncertainty; `None` if they are used as they are.
    pub(super) fn correction(&self, files: &[Compared]) -> Option<(f64, (f64, f64))> {
        if self.options.mean_error == MeanError::Included || self.options.validation.offset != Offset::Kept {
            return None;
        }
        let all: Vec<Evidence> = files.iter().map(|c| Evidence::of(&errors(c), &c.validation)).collect();
        let means: Vec<f64> = all.iter().map(|evidence| evidence.mean).collect();
        let value = mean(&means);
        let r = means.len() as f64;
        Some(match &all[..] {
            [one] => (value, (one.mean_uncertainty, one.nu)),
            // A further record has a mean of its own (4.2.3).
            _ => {
                let scatter = means.iter().map(|m| (m - value).powi(2)).sum::<f64>() / (r - 1.0);
                (value, ((scatter * (1.0 + 1.0 / r)).sqrt(), r - 1.0))
            }
        })
    }

    pub(super) fn record(
        &self,
        compared: Compared,
        origin: Origin,
        reach: &Reach,
        correction: Option<(f64, (f64, f64))>,
    ) -> CertifiedRecord {
        let evidence = Evidence::of(&errors(&compared), &compared.validation);
        let mut rows = self.model(&evidence);
        let y = &self.units.y;
        rows.extend(evidence.drift.map(|rms| {
            let because = "measured: rms of the straight line through the error of the record".into();
            let row = Contribution::measured("drift within the record", rms, y, f64::INFINITY, because);
            Contribution { distribution: "rectangular", ..row }
        }));
        rows.extend(match correction {
            _ if self.options.validation.offset != Offset::Kept => None,
            Some((value, (rms, nu))) => {
                let because = format!("measured: {} {y} are added to every prediction", short(value));
                Some(Contribution::measured("correction of the mean error", rms, y, nu, because))
            }
            None => {
                let because = "measured: predictions are not corrected by it".into();
                let row = Contribution::measured("mean error", evidence.mean.abs(), y, f64::INFINITY, because);
                Some(Contribution { distribution: "known", ..row })
            }
        });
        let Evidence { mean: mean_error, mean_uncertainty, nu: independent, .. } = evidence;
        rows.extend(self.stated(reach));
        let coverage = 0.01 * self.options.coverage;
        let mut budget = Budget::of(rows, coverage);
        if self.options.noise == NoiseOrigin::Unknown {
            let offset = correction.map_or(0.0, |(value, _)| value);
            let sizes = errors(&compared).iter().map(|e| (e - offset).abs()).collect();
            budget = budget.at_least(covering(sizes, coverage));
        }
        CertifiedRecord {
            origin,
            n: compared.record.len() - compared.validation.start,
            budget,
            mean_error,
            mean_uncertainty,
            noise: evidence.noise.map(|(rms, _)| rms),
            independent,
            within_percent: 0.0,
            own_within_percent: 0.0,
            compared,
        }
    }

    /// The bands, if there are several.
    pub(super) fn bands(&self, bins: &[Bin], records: &[CertifiedRecord], reach: &Reach) -> Vec<CertifiedBand> {
        let counts = |bin: &&Bin| bin.source == Source::Cycles && bin.cycles >= MIN_CYCLES && !bin.little_excited;
        let bins: Vec<&Bin> = bins.iter().filter(counts).collect();
        if bins.len() < 2 {
            return Vec::new();
        }
        let (n, independent) = records.iter().fold((0, 0.0), |(n, nu), record| (n + record.n, nu + record.independent));
        let band = |bin: &&Bin| {
            // The information is spread over the bands like the samples; a sine has two independent errors.
            let nu = (independent * bin.n as f64 / n as f64).max(2.0);
            let mut rows = self.model(&Evidence::of_band(bin, nu));
            rows.extend(self.stated(reach));
            let budget = Budget::of(rows, 0.01 * self.options.coverage);
            CertifiedBand { hz: [bin.low, bin.high], cycles: bin.cycles, rmse: bin.rmse, budget }
        };
        bins.iter().map(band).collect()
    }

    /// The error of the model and the noise.
    fn model(&self, evidence: &Evidence) -> Vec<Contribution> {
        let y = &self.units.y;
        let because = match evidence.noise {
            Some(_) => "measured: rms error of the free run, without the noise",
            None => "measured: rms error of the free run, with the noise, which is not known by itself",
        };
        let model = Contribution::measured("error of the model", evidence.model, y, evidence.model_nu, because.into());
        let noise = evidence.noise.map(|(rms, nu)| {
            let counts = self.options.noise == NoiseOrigin::Unknown;
            let because = match counts {
                true => "measured: noise floor of the record, which may be motion",
                false => "measured: noise floor of the record; stated to be of the sensor alone",
            };
            counted(Contribution::measured(NOISE, rms, y, nu, because.into()), counts)
        });
        let resolution = self.stated.resolution.map(|step| {
            let of = ("resolution", "stated: half of the step".to_string());
            let row = Contribution::rectangular(of, (0.5 * step, y), 1.0);
            match evidence.noise {
                None => row,
                Some(_) => {
                    let because = "stated: half of the step; the measured noise contains it".into();
                    counted(Contribution { because, ..row }, false)
                }
            }
        });
        [Some(model), noise, resolution].into_iter().flatten().collect()
    }

    /// What is stated.
    fn stated(&self, reach: &Reach) -> Vec<Contribution> {
        let (Rules { options, stated, units }, y) = (self, &self.units.y);
        let farthest = format!("at {} {y}", short(reach.displacement));
        let expanded = |k: f64| format!("stated: expanded, k = {}", round(k));
        let calibration = options.sensor_calibration.map(|percent| {
            let of = ("calibration of the sensor", format!("{}; {farthest}", expanded(options.sensor_k)));
            Contribution::new(of, (percent, "%"), options.sensor_k, 0.01 * reach.displacement)
        });
        let half_width = |source, value: Option<f64>| {
            value.map(|value| Contribution::rectangular((source, "stated: half-width".into()), (value, y), 1.0))
        };
        let temperature = stated.temperature.map(|(coefficient, half_width)| {
            let (sensitivity, because) = match coefficient {
                Coefficient::Length(length) => (length, format!("stated: half-width; {} {y}/K", short(length))),
                Coefficient::Percent(percent) => {
                    let because = format!("stated: half-width; {} %/K {farthest}", round(percent));
                    (0.01 * percent * reach.displacement, because)
                }
            };
            Contribution::rectangular(("temperature", because), (half_width, "K"), sensitivity)
        });
        let gain = options.voltage_gain.map(|percent| {
            let because = format!("{}; by free runs of the model", expanded(options.voltage_k));
            Contribution::new(("gain of the voltage", because), (percent, "%"), options.voltage_k, reach.gain)
        });
        let offset = options.voltage_offset.map(|volts| {
            let because = "stated: half-width; by free runs of the model".into();
            Contribution::rectangular(("offset of the voltage", because), (volts, &units.u), reach.offset)
        });
        let linearity = half_width("linearity of the sensor", stated.linearity);
        let drift = half_width("drift after the records", stated.drift);
        [calibration, linearity, drift, temperature, gain, offset].into_iter().flatten().collect()
    }

    /// The sources that no budget has.
    pub(super) fn not_stated(&self) -> Vec<&'static str> {
        let (options, stated) = (self.options, self.stated);
        let all = [
            ("calibration of the sensor", options.sensor_calibration.is_some()),
            ("linearity of the sensor", stated.linearity.is_some()),
            ("resolution", stated.resolution.is_some()),
            ("drift after the records", stated.drift.is_some()),
            ("temperature", stated.temperature.is_some()),
            ("gain of the voltage", options.voltage_gain.is_some()),
            ("offset of the voltage", options.voltage_offset.is_some()),
        ];
        all.into_iter().filter(|(_, is_stated)| !is_stated).map(|(source, _)| source).collect()
    }
}

/// The smallest of these sizes that has at least this share of them up to it.
fn covering(mut sizes: Vec<f64>, share: f64) -> f64 {
    sizes.sort_unstable_by(f64::total_cmp);
    let count = libm::ceil(share * sizes.len() as f64) as usize;
    sizes.get(count.clamp(1, sizes.len().max(1)) - 1).copied().unwrap_or(0.0)
}

/// A row that counts, or else is listed alone: with a sensitivity coefficient of 0.
fn counted(row: Contribution, counts: bool) -> Contribution {
    if counts { row } else { Contribution { sensitivity: 0.0, contribution: 0.0, ..row } }
}
