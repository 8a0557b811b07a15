//! The noise floor: the scatter of y between repetitions of the same input.
//!
//! ```text
//! sigma^2 = sum over periods k and phases j of (y_kj - drift_kj - mean over k)^2 / (p (K - 1))
//! ```
//! with p samples in each of K periods, and the drift a line between the means of consecutive periods. No model can
//! have an rms error below sigma. Effects that repeat with the input (hum locked to it, a systematic sensor error) are
//! not noise here.
//!
//! Reference: Pintelon & Schoukens 2012, System Identification: A Frequency Domain Approach, doi:10.1002/9781118287422.

use crate::record::Record;
use crate::series::{ends, mean};
use crate::waveform::period;
use serde::Serialize;

/// Minimum number of samples per period.
const SHORTEST: usize = 8;

/// The noise floor of a record with periodic input.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Floor {
    /// Period of the input [samples].
    pub period: usize,
    /// Number of periods compared.
    pub periods: usize,
    /// Standard deviation of y between periods [output unit].
    pub rms: f64,
    /// 100 rms / peak-to-peak of y.
    pub rms_pp_percent: f64,
    /// Rms error of the model / rms.
    pub error_over_floor: f64,
}

impl Floor {
    /// The noise floor of a record, and the rms error of a model over it; `None` if the input is not periodic.
    pub(super) fn of(record: &Record, rmse: f64) -> Option<Self> {
        let Repeated { period, periods, noise, .. } = Repeated::of(record)?;
        let (low, high) = ends(record.y().iter().copied());
        let rms_pp_percent = 100.0 * noise / (high - low);
        Some(Floor { period, periods, rms: noise, rms_pp_percent, error_over_floor: rmse / noise })
    }
}

/// The mean period of a record with periodic input.
#[derive(Debug)]
pub(super) struct Repeated {
    /// Samples in a period.
    pub(super) period: usize,
    /// Number of periods compared.
    pub(super) periods: usize,
    /// The last period of the input.
    pub(super) u: Vec<f64>,
    /// The mean period of the output without drift.
    pub(super) y: Vec<f64>,
    /// Standard deviation about the mean period [output unit].
    pub(super) noise: f64,
}

impl Repeated {
    /// From the last complete periods; with three or more, without the first, which may contain a transient.
    pub(super) fn of(record: &Record) -> Option<Self> {
        let p = period(record.u()).filter(|p| *p >= SHORTEST)?;
        let all = record.len() / p;
        let periods = if all >= 3 { all - 1 } else { all };
        let start = record.len() - periods * p;
        let part = &record.y()[start..];
        let means: Vec<f64> = part.chunks_exact(p).map(mean).collect();
        let drift = |t: usize| {
            let at = (t as f64 + 0.5) / p as f64 - 0.5;
            let k = (at.max(0.0) as usize).min(periods - 2);
            means[k] + (means[k + 1] - means[k]) * (at - k as f64)
        };
        let level: Vec<f64> = part.iter().enumerate().map(|(t, y)| y - drift(t)).collect();
        let phase = |j: usize| level[j..].iter().step_by(p);
        let y: Vec<f64> = (0..p).map(|j| phase(j).sum::<f64>() / periods as f64).collect();
        let squares: f64 = (0..p).map(|j| phase(j).map(|v| (v - y[j]).powi(2)).sum::<f64>()).sum();
        let noise = (squares / (p * (periods - 1)) as f64).sqrt();
        Some(Repeated { period: p, periods, u: record.u()[record.len() - p..].to_vec(), y, noise })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::excitation::{Prbs, Sine};
    use crate::plant::{Plant, Preset};
    use crate::testing::assert_close;

    #[test]
    fn the_noise_floor_of_a_twin_is_its_sensor_noise_with_or_without_drift() {
        let spec = (Preset::find("pl140").unwrap().spec)();
        let sine = Sine { amplitude: 28.0, frequency: 5.0, ..Sine::default() }.samples(5e-4, 8000).unwrap();
        let prbs = Prbs { order: 9, ..Prbs::default() }.samples(5e-4, 511 * 5).unwrap();
        for u in [sine, prbs] {
            let plant = Plant::new(&spec, 5e-4).unwrap();
            let y = plant.run(&u).y;
            let drifting: Vec<f64> = y.iter().enumerate().map(|(t, y)| y + 3e-9 * t as f64).collect();
            for y in [y, drifting] {
                let floor = Floor::of(&Record::new(5e-4, u.clone(), y).unwrap(), 1e-6).unwrap();
                assert_close(&[floor.rms], &[spec.sensor.noise_rms_m], 0.1, 0.0);
                assert_close(&[floor.error_over_floor], &[1e-6 / floor.rms], 1e-12, 0.0);
            }
        }
    }

    #[test]
    fn a_record_without_periodic_input_has_no_floor() {
        let u = Prbs::default().samples(5e-4, 2047).unwrap();
        assert_eq!(Floor::of(&Record::new(5e-4, u.clone(), u).unwrap(), 1.0), None);
    }
}
