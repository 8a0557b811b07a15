//! What the pictures of a record need beside its samples: its cycles, its straight line and its spectra.

use piezoid::Record;
use piezoid_numerics::series::line;
use piezoid_records::waveform::{CycleGroups, spectrum, thinned};
use serde_json::{Value, json};

/// Largest number of points of a spectrum.
const POINTS: usize = 2000;

/// The groups of cycles and the minor loops of the input, as `cycles`; and the straight line of the output over the
/// input, as `line`, null if the input is constant.
pub(super) fn shape(record: &Record) -> Value {
    let line = line(record.u(), record.y()).map(|(slope, offset)| json!({"slope": slope, "offset": offset}));
    json!({"cycles": CycleGroups::of(record.u(), record.ts()), "line": line})
}

/// The amplitude spectra of input, output and, if there is a model, its error, at few enough frequencies to be drawn.
pub(super) fn spectra(record: &Record, simulated: Option<&[f64]>) -> Vec<(&'static str, Vec<f64>)> {
    let error = simulated.map(|simulated| record.y().iter().zip(simulated).map(|(y, s)| y - s).collect::<Vec<f64>>());
    let (hz, u) = spectrum(record.u(), record.ts());
    let of = |x: &[f64]| spectrum(x, record.ts()).1;
    let others: Vec<Vec<f64>> = std::iter::once(of(record.y())).chain(error.as_deref().map(of)).collect();
    let others: Vec<&[f64]> = others.iter().map(Vec::as_slice).collect();
    if hz.is_empty() {
        return Vec::new();
    }
    let (hz, amplitudes) = thinned(&hz, &u, &others, POINTS);
    let names = ["u/amplitude", "y/amplitude", "error/amplitude"];
    std::iter::once(("hz", hz)).chain(names.into_iter().zip(amplitudes)).collect()
}
