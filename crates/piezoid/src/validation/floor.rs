//! What the sensor leaves by itself: the scatter of y between repetitions of the same input.
//!
//! ```text
//! sigma^2 = sum over periods k and phases j of (y_kj - drift_kj - mean over k)^2 / (p (K - 1))
//! ```
//! with p samples in each of K periods, and the drift a line from the mean of each period to that of the next. No model of the
//! same input, however good, leaves less than sigma. What repeats with the input (hum locked to it, a systematic error
//! of the sensor) is not noise here.
//!
//! Reference: Pintelon & Schoukens 2012, System Identification: A Frequency Domain Approach, doi:10.1002/9781118287422.

use crate::record::Record;
use crate::series::{ends, mean};
use crate::waveform::period;
use serde::Serialize;

/// The fewest samples in a period that tell a scatter.
const SHORTEST: usize = 8;

/// The noise floor of a record whose input repeats.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Floor {
    /// Period of the input [samples].
    pub period: usize,
    /// Periods compared.
    pub periods: usize,
    /// Standard deviation of y between periods [output unit].
    pub rms: f64,
    /// 100 rms / peak-to-peak of y.
    pub rms_pp_percent: f64,
    /// Rms error of the model / rms.
    pub error_over_floor: f64,
}

impl Floor {
    /// Of a record, beside the rms error of a model; none where the input does not repeat.
    pub(super) fn of(record: &Record, rmse: f64) -> Option<Self> {
        let Repeated { period, periods, noise, .. } = Repeated::of(record)?;
        let (low, high) = ends(record.y().iter().copied());
        let rms_pp_percent = 100.0 * noise / (high - low);
        Some(Floor { period, periods, rms: noise, rms_pp_percent, error_over_floor: rmse / noise })
    }
}

/// The output of an input that repeats.
#[derive(Debug)]
pub(super) struct Repeated {
    /// Samples in a period.
    pub(super) period: usize,
    /// Periods compared.
    pub(super) periods: usize,
    /// One period of the input, the last.
    pub(super) u: Vec<f64>,
    /// The mean period of the output, drift taken off.
    pub(super) y: Vec<f64>,
    /// Standard deviation about it [output unit].
    pub(super) noise: f64,
}

impl Repeated {
    /// Of the last whole periods; of three or more without the first, which may hold a transient.
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
    fn the_floor_of_a_twin_is_its_sensors_noise_creep_and_drift_or_not() {
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
    fn an_input_that_does_not_repeat_has_none() {
        let u = Prbs::default().samples(5e-4, 2047).unwrap();
        assert_eq!(Floor::of(&Record::new(5e-4, u.clone(), u).unwrap(), 1.0), None);
    }
}
