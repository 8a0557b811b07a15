//! A bender whose vibration drives its hysteresis too, whose first mode softens, and whose sensor is curved: its errors
//! by both structures, and how compensated paths are followed near its resonance.

use crate::accuracy::{VALIDATION, range};
use crate::page::{self, cell, head, row};
use crate::twin::{KINDS, OUTSIDE, TS, Twin, error};
use piezoid::compensation::{FeedForward, FeedForwardSettings};
use piezoid::excitation::Limits;
use piezoid::feedback::Structure;
use piezoid::{Error, Model};
use piezoid_numerics::series::scatter;
use std::f64::consts::TAU;
use std::path::Path;

/// Frequencies of the paths [Hz] and their amplitude [um]; the first mode is at 166 Hz.
const PATHS: [f64; 4] = [20.0, 80.0, 120.0, 150.0];
const AMPLITUDE: f64 = 300.0;

/// Samples of a path, and of its rise.
const SAMPLES: usize = 2000;
const RISE: f64 = 600.0;

/// A sine that rises smoothly.
fn path(hz: f64) -> Vec<f64> {
    let at = |t: usize| {
        let rise = (t as f64 / RISE).min(1.0);
        let rise = rise * rise * rise * (10.0 - 15.0 * rise + 6.0 * rise * rise);
        AMPLITUDE * rise * libm::sin(TAU * hz * TS * t as f64)
    };
    (0..SAMPLES).map(at).collect()
}

/// The rms error of the twin along a path, about its mean, with the voltage by the inverse of `model` [% of
/// peak-to-peak].
fn followed(twin: &Twin, model: &Model, hz: f64) -> Result<f64, Error> {
    let r = path(hz);
    let limits = Limits { low: Some(-30.0), high: Some(30.0), ..Limits::default() };
    let settings = FeedForwardSettings { limits, clip: true, ..FeedForwardSettings::default() };
    let found = FeedForward::new(model, settings)?.whole(&r)?;
    // Beyond the end of a path its motion is a guess.
    let y = twin.response(&found.u);
    let errors: Vec<f64> = y.iter().zip(&r).take(SAMPLES - 10).map(|(y, r)| y - r).collect();
    Ok(100.0 * (scatter(&errors) / errors.len() as f64).sqrt() / (2.0 * AMPLITUDE))
}

/// Measures, and writes the tables of the bender.
pub(super) fn write(page: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let twin = Twin::new(OUTSIDE)?;
    let started = std::time::Instant::now();
    let found = twin.joint_by("preisach", Structure::Auto)?;
    eprintln!("{OUTSIDE}: {:?}", started.elapsed());
    found.remarks().iter().for_each(|remark| eprintln!("{remark}"));
    let rows = [
        ("`--structure hammerstein`, the default", found.model.without_feedback()),
        ("`--structure auto`: vibration drives the hysteresis too", found.model),
    ];
    let mut errors_of = String::new();
    let mut paths_of = String::new();
    for (name, model) in rows {
        let mut errors = Vec::new();
        for kind in &KINDS {
            for hz in VALIDATION {
                errors.push(error(&model, &twin.validation(kind, hz)?));
            }
        }
        errors_of += &row([name.into()].into_iter().chain(range(&errors).map(cell)));
        let followed = PATHS.iter().map(|hz| followed(&twin, &model, *hz).map(cell)).collect::<Result<Vec<_>, _>>()?;
        paths_of += &row([name.into()].into_iter().chain(followed));
    }
    let titles = ["model", "best [%]", "median [%]", "worst [%]"];
    page::write(page, "bender", &(head(titles, 1) + &errors_of))?;
    let titles = PATHS.map(|hz| format!("{hz} Hz [%]"));
    let titles = ["inverse of".to_string()].into_iter().chain(titles);
    page::write(page, "followed", &(head(titles, 1) + &paths_of))
}
