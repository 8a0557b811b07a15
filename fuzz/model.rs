//! Reads any bytes as a model, and uses it: free run, prediction, validation, inverse, program.
//!
//! `cargo xtask fuzz` begins with `fuzz/models`. Its files are named for what is hostile in them, and are tests of the
//! library and of the command line too. What fails is a panic, and a run of more than 10 s.

#![no_main]

use libfuzzer_sys::fuzz_target;
use piezoid::compensation::{Causal, FeedForward, FeedForwardSettings};
use piezoid::{Model, Record, System};

fuzz_target!(|bytes: &[u8]| {
    let Some(model) = std::str::from_utf8(bytes).ok().and_then(|text| Model::from_json(text).ok()) else { return };
    let u: Vec<f64> = (0..64).map(|t| 25.0 * (0.2 * f64::from(t)).sin()).collect();
    let y = model.simulate(&u);
    let _ = (model.settled(1.0), model.predict(&u, &u), model.program());
    if let Ok(record) = Record::new(model.ts(), u.clone(), u.clone()) {
        let _ = model.validate(&record);
    }
    let settings = FeedForwardSettings { clip: true, iterations: 1, ..Default::default() };
    for r in [&y, &u] {
        let _ = FeedForward::new(&model, settings).map(|inverse| inverse.whole(r));
    }
    let delay_samples = *Causal::delays(&model).start();
    let _ = Causal::new(&model, settings, delay_samples).map(|causal| causal.simulate(&u));
});
