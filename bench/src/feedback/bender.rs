//! A bender whose vibration drives its hysteresis too, whose first mode softens, and whose sensor is curved: its errors
//! by both structures, and how compensated paths are followed near its resonance.

use crate::accuracy::{VALIDATION, range};
use crate::page::{self, cell, head, row};
use crate::twin::{KINDS, OUTSIDE, TS, Twin, error};
use piezoid::compensation::{Causal, FeedForward, FeedForwardSettings};
use piezoid::excitation::Limits;
use piezoid::feedback::Structure;
use piezoid::{Error, Model, System};
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

/// Samples by which an inverse sample by sample knows the path in advance.
const PREVIEW: usize = 8;

/// The voltage for a path by the inverse of `model`: for all of it, or sample by sample.
fn voltage(model: &Model, r: &[f64], is_whole: bool) -> Result<Vec<f64>, Error> {
    let limits = Limits { low: Some(-30.0), high: Some(30.0), ..Limits::default() };
    let settings = FeedForwardSettings { limits, clip: true, ..FeedForwardSettings::default() };
    if is_whole {
        return Ok(FeedForward::new(model, settings)?.whole(r)?.u);
    }
    let causal = Causal::new(model, settings, PREVIEW)?;
    let mut x = causal.settled_with_preview(r[0], &r[..PREVIEW]);
    let last = std::iter::repeat_n(r[r.len() - 1], PREVIEW);
    Ok(causal.resume(&mut x, &r[PREVIEW..].iter().copied().chain(last).collect::<Vec<_>>()))
}

/// The rms error of the twin along a path, about its mean, with this voltage [% of peak-to-peak].
fn followed(twin: &Twin, model: &Model, hz: f64, is_whole: bool) -> Result<f64, Error> {
    let r = path(hz);
    let y = twin.response(&voltage(model, &r, is_whole)?);
    // Beyond the end of a path its motion is a guess.
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
        for (is_whole, known) in [(true, "whole"), (false, "8 samples")] {
            let of = |hz: &f64| followed(&twin, &model, *hz, is_whole).map(cell);
            let followed = PATHS.iter().map(of).collect::<Result<Vec<_>, _>>()?;
            paths_of += &row([name.into(), known.into()].into_iter().chain(followed));
        }
    }
    let titles = ["model", "best [%]", "median [%]", "worst [%]"];
    page::write(page, "bender", &(head(titles, 1) + &errors_of))?;
    let titles = PATHS.map(|hz| format!("{hz} Hz [%]"));
    let titles = ["inverse of", "path known"].map(String::from).into_iter().chain(titles);
    page::write(page, "followed", &(head(titles, 2) + &paths_of))
}
