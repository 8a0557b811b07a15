//! Reads any bytes as a document, the kind that the target is named after, and uses it: the profile of a rig, or a
//! plant.
//!
//! What fails is a panic, a run of more than 10 s, and a profile that changes when it is written and read.

#![no_main]

use libfuzzer_sys::fuzz_target;
use piezoid::control::SimulatedActuator;
use piezoid::formats::ColumnSelection;

fn profile(text: &str) {
    if let Ok(profile) = ColumnSelection::from_toml(text) {
        let written = profile.to_toml();
        assert_eq!(ColumnSelection::from_toml(&written).map(|again| again.to_toml()), Ok(written));
    }
}

fn plant(text: &str) {
    let Ok(plant) = SimulatedActuator::from_json(text) else { return };
    if let Ok((system, _)) = plant.played(plant.period().unwrap_or(5e-4), 1) {
        let (low, high) = plant.voltages().unwrap_or((-30.0, 30.0));
        let at = |t: i32| low + (high - low) * (0.5 + 0.5 * (0.3 * f64::from(t)).sin());
        let u: Vec<f64> = (0..48).map(at).collect();
        assert_eq!(system.simulate(&u).len(), u.len());
    }
}

fuzz_target!(|bytes: &[u8]| {
    if let Ok(text) = std::str::from_utf8(bytes) {
        if env!("CARGO_BIN_NAME") == "plant" { plant(text) } else { profile(text) }
    }
});
