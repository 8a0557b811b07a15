//! Properties of an input: dominant frequency, rate of its cycles, period, cycles, frequency band, and spectrum.

pub mod band;
mod cycles;
mod groups;
mod motion;
mod nested;
mod rate;
mod repetition;
mod spectrum;

pub use band::band;
pub use cycles::{Cycle, CycleSearch, MIN_REVERSAL_SHARE, Turn, cycles, reversals};
pub(crate) use groups::noise;
pub use groups::{CycleGroup, CycleGroups};
pub use motion::{in_motion, inputs_before};
pub use rate::cycle_rate;
pub use repetition::period;
pub use spectrum::{spectrum, thinned};

use piezoid_numerics::series::ends;

/// The frequency at which `u` crosses its mid-value upwards [Hz], averaged over whole periods; `ts` is the sampling
/// period [s]. `None` if there is no whole period. It exists for broad inputs too, as a measure of their speed; the
/// frequency that a user sees is [`cycle_rate`].
pub fn dominant_frequency(u: &[f64], ts: f64) -> Option<f64> {
    let crossings = crossings(u);
    let (first, last) = (crossings.first()?, crossings.last()?);
    let periods = (crossings.len() - 1) as f64;
    (last > first).then(|| periods / ((last - first) * ts))
}

/// The times [samples] at which `u` crosses its mid-value upwards.
fn crossings(u: &[f64]) -> Vec<f64> {
    let (low, high) = ends(u.iter().copied());
    let (middle, guard) = (0.5 * (low + high), 0.1 * (high - low));
    // A crossing counts only after the input was clearly below; its time is interpolated.
    let mut armed = false;
    let mut crossings = Vec::new();
    for (t, w) in u.windows(2).enumerate() {
        armed |= w[0] < middle - guard;
        if armed && w[0] < middle && w[1] >= middle {
            crossings.push(t as f64 + (middle - w[0]) / (w[1] - w[0]));
            armed = false;
        }
    }
    crossings
}
