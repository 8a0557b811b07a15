//! Reads any bytes as a model, and uses it.
//!
//! `cargo xtask fuzz` begins with `fuzz/models`. Its files are named for what is hostile in them, and are tests of the
//! library and of the command line too. What fails is a panic, and a run of more than 10 s.

#![no_main]

mod uses;

use libfuzzer_sys::fuzz_target;
use piezoid::Model;

fuzz_target!(|bytes: &[u8]| {
    if let Some(model) = std::str::from_utf8(bytes).ok().and_then(|text| Model::from_json(text).ok()) {
        uses::use_it(&model);
    }
});
