//! Control of a twin with a model identified from its records, as docs/control.md says. To save time, the operator is
//! given that `auto` selects, and there are few schemes; `src/control.rs` runs all and writes the page.

#![allow(clippy::expect_used, clippy::panic)] // a failing test panics

use piezoid::control::{CONTROLLERS, Comparison, NamedReference, Tolerance};
use piezoid::plant::Preset;
use piezoid::progress::Stage;
use piezoid::{Error, Model, System};
use piezoid_bench::control::{TRIED, compared, drive, errors};
use piezoid_bench::page::{printed, same};
use piezoid_bench::twin::{TS, Twin};
use piezoid_control::compensation::Fir;
use piezoid_verbs::PATHS;
use std::sync::OnceLock;

const TWIN: &str = "pl140";

const PAGE: &str = include_str!("../../docs/control.md");

/// The model, identified from records alone.
fn model() -> &'static Model {
    static MODEL: OnceLock<Model> = OnceLock::new();
    let identified = || Twin::new(TWIN).and_then(|twin| twin.joint("preisach", false)).expect("a model").model;
    MODEL.get_or_init(identified)
}

/// The rms error of each scheme along each reference, with this preview [% of stroke].
fn tracked(names: &[&str], paths: &[(&str, f64)], ahead: usize) -> Vec<Vec<f64>> {
    let drives = names.iter().map(|name| drive(model(), name, ahead)).collect::<Result<Vec<_>, Error>>();
    let compared = compared(TWIN, drives.expect("drives"), paths, None).expect("a comparison");
    compared.results.iter().map(errors).collect()
}

/// Sines and triangles with their frequency [Hz].
fn periodic() -> &'static [(&'static str, f64)] {
    &PATHS[..8]
}

/// Asserts that the errors along these references [% of stroke] are those of the row that begins with `first` and
/// `name`.
#[track_caller]
fn is_printed(first: &str, name: &str, paths: &[(&str, f64)], errors: &[f64]) {
    let row = printed(PAGE, &[first, &format!("`{name}`")]).expect("one row");
    for ((kind, hz), error) in paths.iter().zip(errors) {
        let path = format!("{kind} {hz}");
        same(*error, &row[&path]).unwrap_or_else(|e| panic!("{name}, {path}: {e}"));
    }
}

#[test]
fn feed_forward_alone_is_ten_times_better_than_the_best_straight_line() {
    let schemes = ["gain", "feed-forward"];
    let errors = tracked(&schemes, &PATHS, usize::MAX);
    for (path, (line, inverse)) in PATHS.iter().zip(errors[0].iter().zip(&errors[1])) {
        assert!(10.0 * inverse <= *line, "{path:?}: {inverse} after {line} %");
    }
    for (name, errors) in schemes.iter().zip(&errors) {
        is_printed(&format!("`{TWIN}`"), name, &PATHS, errors);
    }
}

/// Oscillation of the twin after steps of 200 um under the scheme `gain`, as a share of the largest step. The first
/// 32 ms after each step do not count, because a shaped and smoothed step takes this long.
fn rings(shaped: impl Fn(&[f64]) -> Vec<f64>) -> f64 {
    let level = |t: usize| 200.0 * (((t / 200) % 4) as f64 - 1.5);
    let steps: Vec<f64> = (0..4000).map(level).collect();
    let line = drive(model(), "gain", 0).expect("a drive");
    let plant = Preset::find(TWIN).expect("a twin");
    let reference = vec![NamedReference { name: "steps".into(), r: shaped(&steps), from: 0 }];
    let done = Comparison::run((plant.name, &plant.spec().into()), vec![line], reference, 1, None, &mut Stage::ignore)
        .expect("a run");
    let y = &done.results[0].attempts[0].as_ref().expect("a run").run.y;
    let oscillation = |part: &[f64]| {
        let (low, high) = part.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), y| (a.min(*y), b.max(*y)));
        high - low
    };
    y.chunks(200).skip(4).map(|part| oscillation(&part[64..120])).fold(0.0, f64::max) / 600.0
}

#[test]
fn a_shaped_staircase_does_not_excite_the_resonance() {
    let mode = model().linear().resonance().expect("a mode");
    let zvd = Fir::zvd(TS, mode.hz, mode.damping).expect("a shaper");
    let smooth = Fir::smooth(TS, 0.02).expect("a bell");
    let (raw, shaped) = (rings(<[f64]>::to_vec), rings(|r| zvd.simulate(r)));
    let moved = rings(|r| zvd.simulate(&smooth.simulate(r)));
    assert!(raw > 0.2 && shaped < 0.1 * raw && moved < 0.05 * raw, "{raw} {shaped} {moved}");
}

#[test]
fn feed_forward_with_feedback_and_a_preview_of_a_millisecond_tracks_as_the_page_says() {
    let name = "feed-forward+integral-notch";
    is_printed("2", name, &PATHS, &tracked(&[name], &PATHS, 2)[0]);
}

#[test]
fn predictive_control_with_its_preview_tracks_as_the_page_says() {
    is_printed("20", "predictive", &PATHS, &tracked(&["predictive"], &PATHS, 20)[0]);
}

#[test]
fn ten_learning_trials_reduce_the_error_as_the_page_says() {
    is_printed(&format!("`{TWIN}`"), "learning", periodic(), &tracked(&["learning"], periodic(), usize::MAX)[0]);
}

#[test]
fn every_feedback_is_stable_on_two_hundred_plants_within_the_tolerance() {
    let feedbacks: Vec<&str> = CONTROLLERS.iter().map(|c| c.name).collect();
    let drives = feedbacks.iter().map(|name| drive(model(), name, 20)).collect::<Result<Vec<_>, Error>>();
    let drawn = compared(TWIN, drives.expect("drives"), &[TRIED], Some(&Tolerance::default())).expect("a comparison");
    for d in &drawn.results {
        let spread = d.spread.as_ref().expect("draws");
        assert_eq!((spread.trials.len(), spread.unstable()), (200, 0), "{}", d.name());
    }
}
