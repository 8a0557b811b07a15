//! The simulated experiment: measurements on the plant, and steps 3 to 6 of the paper.

use super::{
    AMPLITUDE, BINS, DURATION, Frequency, LoopSource, METHODS, MethodModel, RANGE_USED, RISING_DURATION, SETTLING,
    Study, StudyRow, TS, table_2,
};
use piezoid::excitation::{RisingSine, Sine, SteppedSine};
use piezoid::hysteresis::{Hysteresis, Proportional};
use piezoid::linear::Arx;
use piezoid::plant::{Plant, Saturation, Spec};
use piezoid::validation::Metrics;
use piezoid::{Error, Model, Record, System, Units};
use piezoid_identification::large_signal::proportional;
use piezoid_models::hammerstein::HiddenLoop;
use piezoid_models::hysteresis::{Branches, LoopOptions, MeasuredLoop, TwoBranch};
use std::sync::Arc;

/// A drive signal [V] by its amplitude [V].
type DriveSignal<'a> = dyn Fn(f64) -> Result<Vec<f64>, Error> + 'a;

/// A plant whose output is measured in millimetres.
pub(super) struct Bench {
    plant: Plant,
    /// Seed of the study; each measurement has its own noise.
    seed: u64,
    /// Range of the sensor [mm].
    range: Option<f64>,
    /// The records in which limits of the plant were reached.
    pub(super) limits: Vec<(String, Saturation)>,
}

impl Bench {
    /// The plant with these parameters and this seed of its noise.
    pub(super) fn new(spec: &Spec, seed: u64) -> Result<Self, Error> {
        let range = spec.sensor_range().map(|m| 1e3 * m);
        Ok(Bench { plant: Plant::new(spec, TS)?, seed, range, limits: Vec::new() })
    }

    /// Runs the plant from rest and records it, and notes the limits that were reached.
    pub(super) fn measure(&mut self, u: Vec<f64>, what: &str) -> Result<Record, Error> {
        let (y, saturation) = self.answer(&u);
        if saturation.any() {
            self.limits.push((what.into(), saturation));
        }
        Ok(Record::new(TS, u, y)?.with_units(Units { u: "V".into(), y: "mm".into() }))
    }

    /// Measured output from rest [mm], with its own noise, and the limits that were reached.
    pub(super) fn answer(&self, u: &[f64]) -> (Vec<f64>, Saturation) {
        let number = u.iter().fold(self.seed, |hash, u| hash.rotate_left(5) ^ u.to_bits());
        let run = self.plant.clone().with_seed(number).run(u);
        (run.y.iter().map(|y| 1e-3 * y).collect(), run.saturation)
    }

    /// The amplitude [V] at which the responses to all `drives` stay well within the sensor's range: reduced from the
    /// whole range of the driver, as an experimenter would.
    fn amplitude(&self, drives: &[&DriveSignal]) -> Result<f64, Error> {
        let Some(range) = self.range else { return Ok(AMPLITUDE) };
        let mut amplitude = AMPLITUDE;
        loop {
            let mut peak = 0.0f64;
            for drive in drives {
                peak = self.plant.run(&drive(amplitude)?).y.iter().fold(peak, |peak, y| peak.max(1e-3 * y.abs()));
            }
            if peak <= RANGE_USED * range || amplitude <= 1.0 {
                break;
            }
            amplitude = (amplitude * (RANGE_USED * range / peak).max(0.5)).floor().max(1.0);
        }
        Ok(amplitude)
    }

    /// A rising sine up to the largest amplitude within the sensor's range.
    pub(super) fn rising(&mut self, hz: f64) -> Result<Record, Error> {
        let n = (RISING_DURATION / TS) as usize;
        let rising = |amplitude| RisingSine { amplitude, frequency: hz, ..Default::default() }.samples(TS, n);
        let amplitude = self.amplitude(&[&rising])?;
        self.measure(rising(amplitude)?, &format!("rising sine of {hz} Hz"))
    }

    /// Steps 3 to 6 of the paper at one frequency, for every method.
    pub(super) fn frequency(&mut self, hz: f64, own: &(Arx, f64), joint: &Model) -> Result<Frequency, Error> {
        let n = (DURATION / TS) as usize;
        let frequency = hz;
        let sine = |amplitude| Sine { amplitude, frequency, ..Default::default() }.samples(TS, n);
        let stepped =
            |amplitude| SteppedSine { amplitude, frequency, steps: Study::STEPS_USED, offset: 0.0 }.samples(TS, n);
        let amplitude = self.amplitude(&[&sine, &stepped])?;
        let sine = self.measure(sine(amplitude)?, &format!("sine of {hz} Hz"))?;
        let whole = self.measure(stepped(amplitude)?, &format!("stepped sine of {hz} Hz"))?;
        let settled = (SETTLING / TS) as usize;

        let loop_of = |z: &[f64]| -> Result<HiddenLoop, Error> {
            let settled = settled.min(z.len());
            let (u, z) = (sine.u()[settled..z.len()].to_vec(), z[settled..].to_vec());
            let found = Branches::of_loop(&u, &z, &LoopOptions { bins: BINS, ..LoopOptions::default() })?;
            Ok(HiddenLoop { frequency_hz: Some(hz), u, z, found })
        };
        let loop_by = |arx: &Arx, offset: f64| loop_of(&arx.hidden(offset, sine.y())?.0);
        let table_2 = table_2(hz)?;
        let (by_own, by_table_2) = (loop_by(&own.0, own.1)?, loop_by(&table_2, 0.0)?);
        // The driver is omitted, because its lag is not hysteresis, but the sampling behind it is kept.
        let faster = (TS / joint.hysteresis().ts()).round() as usize;
        let between = |w: &[f64]| {
            let (from, rise) = (w[0], (w[1] - w[0]) / faster as f64);
            (1..=faster).map(move |k| from + k as f64 * rise)
        };
        let u: Vec<f64> = std::iter::once(sine.u()[0]).chain(sine.u().windows(2).flat_map(between)).collect();
        // Scaled to the z of the others, because a factor can be in z or in the gain of the linear block.
        let scale = joint.linear().dc_gain() / own.0.dc_gain();
        let z: Vec<f64> = joint.hysteresis().simulate(&u).iter().step_by(faster).map(|z| scale * z).collect();
        let of_joint = loop_of(&z)?;
        let test = whole.part(SETTLING, f64::INFINITY)?;
        let width = |found: &MeasuredLoop| 100.0 * found.branches.width();
        let rows = METHODS.iter().map(|method| {
            let series = |block: Arc<dyn Hysteresis>, arx: &Arx, offset| Model::new(block, arx.clone(), offset);
            let (model, loop_width_percent) = match method.way {
                MethodModel::Branches(observed, reading) => {
                    let (arx, offset, found) = match observed {
                        LoopSource::ByTable2 => (&table_2, 0.0, &by_table_2.found),
                        LoopSource::ByOwn => (&own.0, own.1, &by_own.found),
                    };
                    let block = TwoBranch::new(TS, found.branches.clone(), reading)?;
                    (series(Arc::new(block), arx, offset)?, width(found))
                }
                MethodModel::Gain => {
                    let (gain, offset) = proportional(&own.0, own.1, std::slice::from_ref(&sine))?;
                    (series(Arc::new(Proportional::new(TS, gain)?), &own.0, offset)?, 0.0)
                }
                MethodModel::Joint => (joint.clone(), width(&of_joint.found)),
            };
            let simulated = model.simulate(whole.u())[settled..].to_vec();
            let metrics = Metrics::of(test.y(), &simulated);
            Ok(StudyRow { method: method.name, model, metrics, loop_width_percent, simulated })
        });
        let rows = rows.collect::<Result<_, Error>>()?;
        Ok(Frequency { hz, amplitude, own: by_own, by_table_2, joint: of_joint, test, rows })
    }
}
