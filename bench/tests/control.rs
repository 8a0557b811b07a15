//! Control of a twin by a model identified from its records. Here the operator is named and the schemes are few, for time;
//! `examples/tracking.rs` leaves the choice to `auto` and tries all, and docs/control.md has what came out.

#![allow(clippy::expect_used)] // a test may stop at what must not happen

#[allow(dead_code)] // what writes and draws
#[path = "../examples/tracking.rs"]
mod tracking;

use piezoid::compensation::Fir;
use piezoid::control::{CONTROLLERS, Comparison, NamedReference, Tolerance};
use piezoid::plant::Preset;
use piezoid::progress::silent;
use piezoid::{Error, Model, System};
use std::sync::OnceLock;
use tracking::accuracy::TS;
use tracking::{PATHS, TRIED, accuracy, compared, drive, errors};

const TWIN: &str = "pl140";

/// The model, of records and nothing else.
fn model() -> &'static Model {
    static MODEL: OnceLock<Model> = OnceLock::new();
    let identified =
        || accuracy::Twin::new(TWIN).and_then(|twin| twin.joint("preisach", false)).expect("a model").model;
    MODEL.get_or_init(identified)
}

/// The rms error of each scheme along each reference, this many samples known ahead [% of stroke].
fn tracked(names: &[&str], paths: &[(&str, f64)], ahead: usize) -> Vec<Vec<f64>> {
    let drives = names.iter().map(|name| drive(model(), name, ahead)).collect::<Result<Vec<_>, Error>>();
    let compared = compared(TWIN, drives.expect("drives"), paths, None).expect("a comparison");
    compared.driven.iter().map(errors).collect()
}

/// Sines and triangles with their frequency [Hz].
fn periodic() -> &'static [(&'static str, f64)] {
    &PATHS[..8]
}

#[test]
fn feed_forward_alone_is_ten_times_nearer_than_the_best_straight_line() {
    let errors = tracked(&["gain", "feed-forward"], &PATHS, usize::MAX);
    for (path, (line, inverse)) in PATHS.iter().zip(errors[0].iter().zip(&errors[1])) {
        assert!(10.0 * inverse <= *line, "{path:?}: {inverse} after {line} %");
    }
}

/// How far the twin rings about the levels of steps of 200 um, as a share of a step, under a straight line: in what follows
/// the first 32 ms of each level, in which a shaped and smoothed step arrives.
fn rings(shaped: impl Fn(&[f64]) -> Vec<f64>) -> f64 {
    let level = |t: usize| 200.0 * (((t / 200) % 4) as f64 - 1.5);
    let steps: Vec<f64> = (0..4000).map(level).collect();
    let line = drive(model(), "gain", 0).expect("a drive");
    let plant = Preset::find(TWIN).expect("a twin");
    let wanted = vec![NamedReference { name: "steps".into(), r: shaped(&steps), from: 0 }];
    let done = Comparison::run((plant.name, &(plant.spec)()), vec![line], wanted, 1, None, &mut silent).expect("a run");
    let y = &done.driven[0].attempts[0].as_ref().expect("a run").run.y;
    let swing = |part: &[f64]| {
        let (low, high) = part.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), y| (a.min(*y), b.max(*y)));
        high - low
    };
    y.chunks(200).skip(4).map(|part| swing(&part[64..120])).fold(0.0, f64::max) / 600.0
}

#[test]
fn a_shaped_staircase_does_not_ring_the_resonance() {
    let mode = model().linear().resonance().expect("a mode");
    let zvd = Fir::zvd(TS, mode.hz, mode.damping).expect("a shaper");
    let smooth = Fir::smooth(TS, 0.02).expect("a bell");
    let (raw, shaped) = (rings(<[f64]>::to_vec), rings(|r| zvd.simulate(r)));
    let moved = rings(|r| zvd.simulate(&smooth.simulate(r)));
    assert!(raw > 0.2 && shaped < 0.1 * raw && moved < 0.05 * raw, "{raw} {shaped} {moved}");
}

/// 0.3 % up to 20 Hz, 1 % at 40 Hz.
#[track_caller]
fn stays_within_bounds(name: &str, ahead: usize) {
    for (path, error) in PATHS.iter().zip(&tracked(&[name], &PATHS, ahead)[0]) {
        let bound = if path.1 > 20.0 { 1.0 } else { 0.3 };
        assert!(*error <= bound, "{path:?}: {error} %");
    }
}

#[test]
fn feed_forward_with_feedback_that_knows_a_millisecond_ahead_is_near_enough() {
    stays_within_bounds("feed-forward+integral-notch", 2);
}

#[test]
fn predictive_control_that_knows_its_horizon_is_near_enough() {
    stays_within_bounds("predictive", 20);
}

#[test]
fn ten_trials_leave_a_thousandth_of_the_stroke() {
    let errors = tracked(&["learning"], periodic(), usize::MAX);
    for (path, error) in periodic().iter().zip(&errors[0]) {
        assert!(*error <= 0.1, "{path:?}: {error} %");
    }
}

#[test]
fn no_feedback_swings_on_any_of_two_hundred_plants_of_other_tolerance() {
    let feedbacks: Vec<&str> = CONTROLLERS.iter().map(|c| c.name).collect();
    let drives = feedbacks.iter().map(|name| drive(model(), name, 20)).collect::<Result<Vec<_>, Error>>();
    let drawn = compared(TWIN, drives.expect("drives"), &[TRIED], Some(&Tolerance::default())).expect("a comparison");
    for d in &drawn.driven {
        let spread = d.spread.as_ref().expect("draws");
        assert_eq!((spread.trials.len(), spread.unstable()), (200, 0), "{}", d.name());
    }
}
