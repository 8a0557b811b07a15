use super::super::sample::Law;
use super::super::{Causal, FeedForward, FeedForwardSettings};
use piezoid_models::creep::Lag;
use piezoid_models::feedback::{FeedbackDynamics, FeedbackMode, FeedbackModel};
use piezoid_models::hammerstein::Model;
use piezoid_models::hysteresis::Proportional;
use piezoid_models::program::Machine;
use piezoid_numerics::error::Error;
use piezoid_numerics::system::System;
use piezoid_records::excitation::Limits;
use piezoid_testing::in_feedback;
use std::f64::consts::TAU;
use std::sync::Arc;

const TS: f64 = 5e-4;

/// One of each kind. The hysteresis of one of them senses less than the whole input.
fn models() -> impl Iterator<Item = (&'static str, Model)> {
    in_feedback().into_iter().map(|(name, document)| {
        let share = if name == "loaded" { 0.8 } else { 1.0 };
        let model = Model::from_json(&document.to_string()).unwrap();
        (name, changed(&model, |dynamics| dynamics.sensed *= share))
    })
}

fn dynamics(model: &Model) -> FeedbackDynamics {
    model.feedback().unwrap().dynamics().clone()
}

/// The same model with other dynamics.
fn changed(model: &Model, change: impl Fn(&mut FeedbackDynamics)) -> Model {
    let mut dynamics = dynamics(model);
    change(&mut dynamics);
    let feedback = model.feedback().unwrap().clone().with_dynamics(dynamics).unwrap();
    model.clone().with_feedback(feedback).unwrap()
}

/// 18 um at `hz` that rise smoothly, about a slow movement.
fn path(offset: f64, hz: f64, n: usize) -> Vec<f64> {
    let at = |t: usize| {
        let (time, rise) = (t as f64 * TS, (t as f64 / 500.0).min(1.0));
        let rise = rise * rise * rise * (10.0 - 15.0 * rise + 6.0 * rise * rise);
        offset + rise * (18.0 * (TAU * hz * time).sin() + 5.0 * (TAU * 8.0 * time).sin())
    };
    (0..n).map(at).collect()
}

fn least(model: &Model) -> usize {
    *Causal::delays(model).start()
}

fn causal(model: &Model, settings: FeedForwardSettings, more: usize) -> Causal {
    Causal::new(model, settings, least(model) + more).unwrap()
}

fn within(volts: f64) -> FeedForwardSettings {
    let limits = Limits { low: Some(-volts), high: Some(volts), ..Limits::default() };
    FeedForwardSettings { limits, ..FeedForwardSettings::default() }
}

/// The largest difference, without the end of a record, beyond which the motion is a guess.
fn most(y: &[f64], r: &[f64]) -> f64 {
    y.iter().zip(&r[..r.len() - 10]).fold(0.0f64, |most, (y, r)| most.max((y - r).abs()))
}

/// The largest error of the model along `r`, with the voltage sample by sample.
fn missed(model: &Model, causal: &Causal, r: &[f64]) -> f64 {
    let mut x = causal.settled_with_preview(r[0], &r[..causal.delay_samples()]);
    let last = r[r.len() - 1];
    let known = r[causal.delay_samples()..].iter().copied().chain(std::iter::repeat_n(last, causal.delay_samples()));
    let u: Vec<f64> = known.map(|r| causal.step(&mut x, r)).collect();
    most(&model.follow(&mut model.settled(u[0]), &u), r)
}

#[test]
fn a_reference_near_the_resonance_is_followed_sample_by_sample() {
    for (name, model) in models() {
        let offset = dynamics(&model).offset;
        for (hz, share) in [(20.0, 2e-3), (80.0, 5e-3), (120.0, 1e-2), (150.0, 1e-2)] {
            let r = path(offset, hz, 2000);
            let still = most(&vec![offset; r.len()], &r);
            let error = missed(&model, &causal(&model, FeedForwardSettings::default(), 0), &r);
            println!("{name} {hz} Hz: {:.4} %", 100.0 * error / still);
            assert!(still > 20.0 && error < share * still, "{name}, {hz} Hz: {error} of {still} um");
            // A longer preview changes nothing.
            let longer = missed(&model, &causal(&model, FeedForwardSettings::default(), 7), &r);
            assert!((longer - error).abs() < 1e-9 * still, "{name}: {longer} for {error}");
        }
    }
}

#[test]
fn a_whole_reference_is_corrected_by_iterations() {
    for (name, model) in models() {
        let r = path(dynamics(&model).offset, 150.0, 2000);
        let alone = missed(&model, &causal(&model, FeedForwardSettings::default(), 0), &r);
        let found = FeedForward::new(&model, within(100.0)).unwrap().whole(&r).unwrap();
        let error = most(&found.reached, &r);
        assert!(error < 0.7 * alone && error < 0.1, "{name}: {error} for {alone} um, {:?}", found.notes);
        // The voltage of the blocks in series, a line, is far off.
        let line: Vec<f64> = r.iter().map(|y| y - r[0]).collect();
        assert!(most(&model.follow(&mut model.settled(0.0), &line), &r) > 10.0);
    }
}

fn limits() -> Limits {
    Limits { low: Some(-28.0), high: Some(29.0), ..Limits::default() }
}

#[track_caller]
fn assert_program_is_bit_identical(name: &str, model: &Model, limits: Limits, more: usize) {
    let causal = causal(model, FeedForwardSettings { limits, ..FeedForwardSettings::default() }, more);
    let mut program = model.program().unwrap();
    causal.extend(&mut program).unwrap();
    let (mut machine, mut x) = (Machine::new(&program, "ff_state", false), causal.initial());
    assert_eq!(machine.state(), x, "{name}");
    for t in 0..300 {
        let r = match t {
            50 => f64::NAN,
            250 => 1e200,
            _ => 12.0 * (0.05 * f64::from(t)).sin() + 6.0 * (0.4 * f64::from(t)).sin() + f64::from(t % 90) / 9.0,
        };
        let (u, found) = (causal.step(&mut x, r), machine.call("ff_step", &[r]).unwrap()[0]);
        assert_eq!(found.to_bits(), u.to_bits(), "{name}, {more}, {limits:?}, at {t}: {found} for {u}");
    }
    assert_eq!(machine.state(), x, "{name}");
}

#[test]
fn the_program_is_bit_identical_to_the_steps() {
    let limits = limits();
    for (name, model) in models() {
        for (limits, more) in [(limits, 0), (limits, 3), (Limits { slew: Some(2e4), ..limits }, 0)] {
            assert_program_is_bit_identical(name, &model, limits, more);
        }
    }
}

#[test]
fn a_constant_reference_is_held_from_the_settled_state_and_rest_needs_no_voltage() {
    for (name, model) in models() {
        let causal = causal(&model, FeedForwardSettings::default(), 2);
        let r = dynamics(&model).offset + 7.0;
        let mut x = causal.settled(r);
        let before = x[0];
        let u = causal.resume(&mut x, &[r; 40]);
        assert!(u.iter().all(|u| (u - before).abs() < 1e-9), "{name}: {u:?} for {before}");
        let y = model.resume(&mut model.settled(before), &vec![before; 2000]);
        // The model moves there from rest in a jump, which the way of the displacement follows and turns.
        assert!((y[1999] - r).abs() < 0.03, "{name}: {} for {r}", y[1999]);
        let rest = model.simulate(&[0.0; 200])[199];
        assert!(causal.simulate(&[rest; 50]).iter().all(|u| u.abs() < 1e-9), "{name}");
    }
}

#[test]
fn references_that_are_not_finite_are_replaced_and_others_keep_the_limits() {
    for (name, model) in models() {
        let limits = Limits { low: Some(-30.0), high: Some(25.0), slew: Some(3e4), ..Limits::default() };
        let causal = causal(&model, FeedForwardSettings { limits, ..FeedForwardSettings::default() }, 1);
        let r = path(dynamics(&model).offset, 60.0, 700);
        let with = |at: &[(usize, f64)]| {
            let mut r = r.clone();
            at.iter().for_each(|(t, value)| r[*t] = *value);
            causal.resume(&mut causal.settled(r[0]), &r)
        };
        let invalid = with(&[(600, f64::NAN), (601, f64::INFINITY)]);
        assert_eq!(invalid, with(&[(600, r[599]), (601, r[599])]), "{name}");
        for far in [1e3, -1e9, 1e100, f64::MAX, -1e200] {
            let u = with(&[(600, far)]);
            assert!(u.iter().all(|u| (-30.0..=25.0).contains(u)), "{name}: {far:e}");
            assert!(u.windows(2).all(|u| (u[1] - u[0]).abs() <= 3e4 * TS + 1e-9), "{name}: {far:e}");
            // The hysteresis remembers it, but the voltages move again.
            let moves = u[690..].windows(2).all(|u| u[0] != u[1]);
            assert!(moves, "{name}, {far:e}: {:?} for {:?}", &u[690..], &invalid[690..]);
        }
        for sign in [1.0, -1.0] {
            let farthest = with(&[(600, sign * 1e12)]);
            for far in [1e100, 1e200, f64::MAX] {
                assert_eq!(with(&[(600, sign * far)]), farthest, "{name}: {sign} {far:e}");
            }
        }
    }
}

#[test]
fn a_reference_beyond_the_limits_is_refused_or_clipped() {
    for (name, model) in models() {
        let far: Vec<f64> = (0..2000).map(|t| 90.0 * (0.01 * f64::from(t)).sin()).collect();
        let refused = FeedForward::new(&model, within(20.0)).unwrap().whole(&far).unwrap_err();
        assert!(matches!(refused, Error::Unreachable { .. }), "{name}: {refused}");
        let settings = FeedForwardSettings { clip: true, ..within(20.0) };
        let clipped = FeedForward::new(&model, settings).unwrap().whole(&far).unwrap();
        assert!(clipped.clipped > 100 && clipped.u.iter().all(|u| u.abs() <= 20.0), "{name}");
    }
}

#[test]
fn delays_out_of_reach_name_the_option_and_models_without_an_inverse_say_why() {
    for (name, model) in models() {
        assert_eq!(least(&model), 5 + dynamics(&model).delay);
        let refused = |n| Causal::delayed(&model, within(20.0), ("preview", n)).unwrap_err().to_string();
        let (few, many) = (refused(3), refused(489));
        assert!(few.starts_with("preview = 3: must be at least") && many.starts_with("preview = 489: must be at most"));
        // An input that acts on hysteresis and modes, or nothing that moves a mode.
        let both = changed(&model, |dynamics| (dynamics.sensed, dynamics.direct[0]) = (1.0, 0.1));
        let none = changed(&model, |dynamics| {
            dynamics.modes.iter_mut().for_each(|mode| (mode.input, mode.hysteretic) = (0.0, 0.0))
        });
        for model in [both, none] {
            let refused = Causal::new(&model, within(20.0), 9).unwrap_err().to_string();
            assert!(
                refused.contains("no inverse sample by sample") || refused.contains("acts on modes"),
                "{name}: {refused}"
            );
        }
    }
}

/// Two modes that the input moves and z bends; z creeps, and adds to the displacement.
fn guided() -> Model {
    let (_, model) = models().find(|(name, _)| *name == "guided").unwrap();
    changed(&model, |dynamics| {
        let second = FeedbackMode { hz: 700.0, input: 0.1, hysteretic: -0.03, sensed: 0.8, ..dynamics.modes[0] };
        dynamics.modes.push(second);
        dynamics.direct[1] = 0.1;
        dynamics.creep.push(Lag { tau_s: 0.02, gain: 0.1 });
    })
}

/// The same model about an operator without a state.
fn without_memory(model: &Model) -> Model {
    let line = Arc::new(Proportional::new(TS, 0.9).unwrap());
    model.clone().with_feedback(FeedbackModel::new(TS, dynamics(model), line).unwrap()).unwrap()
}

#[test]
fn z_that_creeps_and_adds_to_the_displacement_is_inverted() {
    let (model, settings) = (guided(), FeedForwardSettings::default());
    let r = path(0.0, 20.0, 2000);
    let error = missed(&model, &causal(&model, settings, 0), &r);
    assert!(error < 0.01 * most(&vec![0.0; r.len()], &r), "{error}");
    let causal = causal(&model, settings, 2);
    let mut x = causal.settled(7.0);
    let before = x[0];
    let u = causal.resume(&mut x, &[7.0; 40]);
    assert!(u.iter().all(|u| (u - before).abs() < 1e-9), "{u:?} for {before}");
    assert_program_is_bit_identical("with z in the displacement", &model, limits(), 1);
}

#[test]
fn an_operator_without_a_state_has_a_bit_identical_program() {
    for (name, model) in models() {
        assert_program_is_bit_identical(name, &without_memory(&model), limits(), 0);
    }
}

#[test]
fn a_state_has_no_parts_for_what_is_not_there() {
    // The last input, 5 q, 6 p and 4 held; then what is known with p, the voltage behind a driver, and creep.
    let expected = [("guided", 3), ("bender", 4 + 1 + 2), ("loaded", 4 + 2), ("stiffened", 0), ("filtered", 0)];
    for ((name, model), (expected_name, parts)) in models().zip(expected) {
        let of_hysteresis = model.feedback().unwrap().hysteresis().order();
        let order = |more| causal(&model, FeedForwardSettings::default(), more).order();
        assert_eq!((name, order(0)), (expected_name, 16 + parts + of_hysteresis));
        assert_eq!(order(3), order(0) + 3, "{name}");
    }
}

#[test]
fn what_a_stiff_mode_moves_besides_itself_is_taken_into_account() {
    let (_, stiff) = models().find(|(name, _)| *name == "stiffened").unwrap();
    let stiff = changed(&stiff, |dynamics| (dynamics.modes[0].softening, dynamics.direct[1]) = (-0.02, 0.3));
    let whole = causal(&stiff, FeedForwardSettings::default(), 0);
    let mut without = whole.clone();
    if let Law::Feedback(flat) = &mut without.law {
        flat.bends = 0.0;
    }
    // Near the resonance.
    let r = path(dynamics(&stiff).offset, 120.0, 2000);
    let errors = [&whole, &without].map(|causal| missed(&stiff, causal, &r));
    assert!(errors[0] < 0.7 * errors[1], "{errors:?}");
}
