//! Tests of the whole controller on its own model and on other plants.

use super::super::margins::tests::path_of;
use super::super::tune::detuned;
use super::super::{ClosedLoop, ControlLoop, MarginTarget};
use super::realisation::tests::blocks;
use super::*;
use nalgebra::DMatrix;
use piezoid_models::creep::Creep;
use piezoid_models::driver::DriverModel;
use piezoid_models::feedback::{FeedbackDynamics, FeedbackMode, FeedbackModel};
use piezoid_models::hammerstein::Domain;
use piezoid_models::hysteresis::{Hysteresis, Operator, Proportional, load};
use piezoid_testing::assert_close;
use serde_json::json;

const TS: f64 = 5e-4;

fn plays(ts: f64) -> Arc<dyn Hysteresis> {
    (Operator::find("prandtl-ishlinskii").unwrap().example)(ts).unwrap()
}

/// Plays, creep and this linear block.
fn model_of(linear: Arx, offset: f64) -> Model {
    Model::new(plays(TS), linear, offset).unwrap().with_creep(blocks(1).0).unwrap()
}

/// Plays, creep and a resonance, with `gain` times the nominal gain and offset.
fn scaled(gain: f64, offset: f64) -> Model {
    let (_, linear) = blocks(1);
    model_of(Arx::new(TS, linear.a().to_vec(), linear.b().iter().map(|b| b * gain).collect()).unwrap(), offset)
}

fn model(gain: f64) -> Model {
    scaled(gain, 1.5)
}

/// The controller for the nominal model.
fn controller(settings: PredictiveSettings) -> Predictive {
    Predictive::new(&model(1.0), settings).unwrap()
}

/// `height` for `half` samples and `-height` for as many.
fn square(height: f64, half: usize, n: usize) -> Vec<f64> {
    (0..n).map(|t| if (t / half).is_multiple_of(2) { height } else { -height }).collect()
}

fn sine(amplitude: f64, n: usize) -> Vec<f64> {
    (0..n).map(|t| amplitude * (t as f64 * 0.06).sin()).collect()
}

/// The same with a driver that has a lag and this slew limit [V/s].
fn result(off: f64, slew: f64) -> Model {
    let driver = DriverModel::new(1e-4, Some(slew)).unwrap();
    let plain = model(off);
    let faster = plays(TS / DriverModel::SUBSTEPS as f64);
    let result = Model::from_blocks(Some(driver), faster, plain.linear().clone(), plain.offset()).unwrap();
    result.with_creep(plain.creep().clone()).unwrap()
}

/// A linear block with a proportional operator.
fn before(linear: Arx) -> Model {
    Model::new(Arc::new(Proportional::new(TS, 1.0).unwrap()), linear, 1.5).unwrap()
}

/// Runs the controller along `r`, with a constant error of the measurement and the sensor delay of its settings.
fn follow(mpc: &Predictive, plant: &Model, r: &[f64], disturbance: f64) -> (Vec<f64>, Vec<Plan>) {
    let (mut x, mut truth) = (mpc.settled(0.0), plant.settled(0.0));
    // The measurements, the oldest first: it is used now.
    let mut y = vec![plant.step(&mut truth.clone(), 0.0); 1 + mpc.settings.delay_samples];
    let step = |t: usize| {
        let plan = mpc.plan(&mut x, &r[t..], y[0]);
        y.rotate_left(1);
        *y.last_mut().unwrap() = plant.step(&mut truth, plan.u) + disturbance;
        (y[y.len() - 1], plan)
    };
    (0..r.len()).map(step).unzip()
}

fn rms(a: &[f64], b: &[f64]) -> f64 {
    (a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / a.len() as f64).sqrt()
}

#[test]
fn without_limits_the_moves_minimise_their_cost() {
    let model = model(1.0);
    let settings = PredictiveSettings { voltage: (-60.0, 60.0), move_cost: 1e-2, ..Default::default() };
    let mpc = Predictive::new(&model, settings).unwrap();
    let r: Vec<f64> = sine(3.0, 21).iter().map(|r| 1.5 + r).collect();
    let plan = mpc.plan(&mut mpc.settled(0.0), &r, model.offset());
    // One column per move: its response through the blocks, then its steps.
    let n = 20;
    let scale = 1.0 / model.linear().dc_gain();
    let mut columns = DMatrix::zeros(2 * n, n);
    for k in 0..n {
        let z: Vec<f64> = (0..n + 1).map(|t| f64::from(u8::from(t == k))).collect();
        let y = model.linear().simulate(&model.creep().simulate(&z));
        (0..n).for_each(|t| columns[(t, k)] = y[t + 1] * scale);
        columns[(n + k, k)] = 0.1;
        if k + 1 < n {
            columns[(n + k + 1, k)] = -0.1;
        }
    }
    let target = nalgebra::DVector::from_fn(2 * n, |t, _| if t < n { (r[t + 1] - 1.5) * scale } else { 0.0 });
    let known = columns.svd(true, true).solve(&target, 1e-14).unwrap();
    assert!(plan.solved && plan.changes == 0);
    assert_close(&plan.z, known.as_slice(), 0.0, 1e-9);
    assert_close(&[plan.y[0]], &[1.5 + known[0] * mpc.horizon.phi[(0, 0)] / scale], 1e-9, 0.0);
}

#[test]
fn it_tracks_on_its_own_model_and_feedback_helps_on_another() {
    let r: Vec<f64> = sine(15.0, 800);
    let mpc = controller(PredictiveSettings::default());
    let error = |off: f64| rms(&follow(&mpc, &model(off), &r, 0.0).0[200..], &r[200..]);
    assert!(error(1.0) < 0.05, "{}", error(1.0));
    // Without feedback a gain error of a tenth gives an rms error of a tenth.
    assert!(error(1.1) < 0.075 * rms(&r[200..], &[0.0; 600]), "{}", error(1.1));
}

#[test]
fn a_constant_disturbance_leaves_no_offset() {
    for delay_samples in [0, 3, 20] {
        let mpc = controller(PredictiveSettings { delay_samples, ..Default::default() });
        for (off, disturbance) in [(1.0, 0.7), (0.85, -0.4)] {
            let (y, _) = follow(&mpc, &model(off), &[6.0; 3000], disturbance);
            assert_close(&y[2900..], &[6.0; 100], 0.0, 1e-3);
        }
    }
}

#[test]
fn on_its_own_model_a_sensor_delay_does_not_matter() {
    let r = sine(15.0, 800);
    for truth in [model(1.0), result(1.0, 6e4), before(Arx::gain(TS, 2.0).unwrap())] {
        let followed = |delay_samples| {
            let mpc = Predictive::new(&truth, PredictiveSettings { delay_samples, ..Default::default() }).unwrap();
            follow(&mpc, &truth, &r, 0.0).0
        };
        for delay_samples in [1, 3, 20] {
            assert_close(&followed(delay_samples), &followed(0), 0.0, 1e-6);
        }
    }
}

#[test]
fn on_other_plants_a_known_sensor_delay_is_better_than_an_unknown_one() {
    let r = sine(15.0, 800);
    let error = |plant: &Model, known: usize, delay_samples: usize| {
        let mpc = controller(PredictiveSettings { delay_samples: known, ..Default::default() });
        let closed_loop = ClosedLoop { delay_samples, ..ClosedLoop::new(&r, &[0.0; 800], (-30.0, 30.0)) };
        rms(&closed_loop.run(plant, &mpc).unwrap().y[200..], &r[200..])
    };
    let shifted = |share: f64| model_of(detuned(model(1.0).linear(), share).unwrap(), 1.5);
    for plant in [model(1.1), shifted(0.8), shifted(1.2)] {
        let (none, known, unknown) = (error(&plant, 0, 0), error(&plant, 3, 3), error(&plant, 0, 3));
        assert!(none < known && known < 1.5 * none && unknown > 1.5 * known, "{none} {known} {unknown}");
    }
}

#[test]
fn limits_of_voltage_slew_and_displacement_are_kept() {
    let (top, fastest) = (12.0, 1500.0);
    let limits = PredictiveSettings { voltage: (-top, top), slew: Some(fastest), ..Default::default() };
    let square = square(30.0, 100, 600);
    let mpc = controller(limits);
    let (_, plans) = follow(&mpc, &model(1.0), &square, 0.0);
    assert!(plans.iter().all(|p| p.solved && p.u.abs() <= top));
    assert!(plans.windows(2).all(|w| (w[1].u - w[0].u).abs() <= fastest * TS * (1.0 + 1e-9)));
    assert!(plans.iter().any(|p| p.u.abs() == top) && plans.iter().any(|p| p.changes > 5));

    let limits = PredictiveSettings { displacement: Some((-5.0, 6.0)), ..Default::default() };
    let (y, plans) = follow(&controller(limits), &model(1.0), &square, 0.0);
    let (low, high) = piezoid_numerics::series::ends(y);
    let kept = (-5.1..-4.5).contains(&low) && (5.5..6.1).contains(&high);
    assert!(plans.iter().all(|p| p.solved) && kept, "{low} {high}");
}

#[test]
fn a_slew_limit_that_is_hardly_active_hardly_matters() {
    let r = sine(15.0, 800);
    for truth in [model(1.0), result(1.0, 6e4)] {
        let run = |slew| {
            let mpc = Predictive::new(&truth, PredictiveSettings { slew, ..Default::default() }).unwrap();
            follow(&mpc, &truth, &r, 0.0)
        };
        let (free, plans) = run(None);
        let fastest = plans[200..].windows(2).fold(0.0, |m: f64, w| m.max((w[1].u - w[0].u).abs())) / TS;
        let limited = run(Some(1.02 * fastest)).0;
        let [free, limited] = [free, limited].map(|y| rms(&y[200..], &r[200..]));
        assert!(limited < 1.2 * free, "{limited} {free}");
    }
}

#[test]
fn the_interior_point_method_gives_the_same_voltages() {
    let (voltage, slew, displacement) = ((-12.0, 12.0), Some(1500.0), Some((-9.0, 9.0)));
    let limits = PredictiveSettings { voltage, slew, displacement, ..Default::default() };
    let other = PredictiveSettings { solver: Solver::InteriorPoint, ..limits.clone() };
    let square = square(10.0, 30, 150);
    let voltages = |settings| {
        let mpc = controller(settings);
        let (y, plans) = follow(&mpc, &model(0.9), &square, 0.0);
        (y, plans.iter().map(|p| p.u).collect::<Vec<f64>>(), plans)
    };
    let (active, interior) = (voltages(limits), voltages(other));
    assert_close(&active.1, &interior.1, 0.0, 1e-6);
    assert!(active.2.iter().any(|p| p.changes > 0) && interior.2.iter().all(|p| p.solved));
}

#[test]
fn lost_measurements_are_bridged_and_runs_are_bit_identical() {
    let mpc = controller(PredictiveSettings::default());
    let r = sine(10.0, 300);
    let run = |lost: bool| {
        let (mut x, plant) = (mpc.settled(0.0), model(1.0));
        let (mut truth, mut y) = (plant.settled(0.0), 1.5);
        let mut ys = Vec::new();
        for t in 0..r.len() {
            let y_read = if lost && t % 7 == 3 { f64::NAN } else { y };
            let u = mpc.step(&mut x, &ControllerInput { y: y_read, ahead: &r[t..], ..Default::default() });
            y = plant.step(&mut truth, u);
            ys.push(y);
        }
        ys
    };
    assert_eq!(run(false), run(false));
    assert!(rms(&run(true)[100..], &r[100..]) < 0.05);
}

#[test]
fn invalid_settings_are_errors_with_numbers() {
    let refused = |settings| Predictive::new(&model(1.0), settings).unwrap_err().to_string();
    assert!(refused(PredictiveSettings { horizon: 0, ..Default::default() }).contains("from 1 to 200"));
    assert!(
        refused(PredictiveSettings { delay_samples: 21, ..Default::default() })
            .starts_with("delay_samples = 21: must be at most 20")
    );
    assert!(refused(PredictiveSettings { voltage: (30.0, -30.0), ..Default::default() }).contains("30 to -30"));
    assert!(refused(PredictiveSettings { move_cost: f64::NAN, ..Default::default() }).starts_with("move_cost = NaN"));
    let slow = refused(PredictiveSettings { multiplications_per_second: 1e7, ..Default::default() });
    assert!(slow.contains("horizon = 20") && slow.contains("the longest horizon that fits is "), "{slow}");
    let longest = slow.rsplit(' ').nth(1).unwrap().parse().unwrap();
    let at = |horizon| PredictiveSettings { horizon, multiplications_per_second: 1e7, ..Default::default() };
    assert!(Predictive::new(&model(1.0), at(longest)).is_ok());
    assert!(Predictive::new(&model(1.0), at(longest + 1)).is_err());
}

#[test]
fn it_tracks_with_a_driver_in_the_model_as_well_as_without() {
    let r = sine(15.0, 800);
    let error = |model: &Model, truth: &Model| {
        let mpc = Predictive::new(model, PredictiveSettings::default()).unwrap();
        rms(&follow(&mpc, truth, &r, 0.0).0[200..], &r[200..])
    };
    let plain = error(&model(1.0), &model(1.0));
    let behind = error(&result(1.0, 6e4), &result(1.0, 6e4));
    assert!(behind < 1.1 * plain, "{behind} {plain}");
    let (plain, behind) = (error(&model(1.0), &model(1.1)), error(&result(1.0, 6e4), &result(1.1, 6e4)));
    assert!(behind < 1.1 * plain, "{behind} {plain}");
    // A driver that is not in the model increases the error.
    let unknown = error(&model(1.0), &result(1.0, 6e4));
    assert!(unknown > 1.5 * error(&result(1.0, 6e4), &result(1.0, 6e4)), "{unknown}");
}

#[test]
fn limits_are_kept_with_a_driver_and_its_slew_limit_is_planned_for() {
    let square = square(15.0, 100, 600);
    let run = |slew: Option<f64>, model: &Model| {
        let settings = PredictiveSettings { voltage: (-14.0, 14.0), slew, ..Default::default() };
        follow(&Predictive::new(model, settings).unwrap(), &result(1.0, 1500.0), &square, 0.0)
    };
    let (y, plans) = run(None, &result(1.0, 1500.0));
    assert!(plans.iter().all(|p| p.solved && p.u.abs() <= 14.0));
    // Requests above the driver's slew rate do not accumulate.
    let (requested, plans) = run(Some(1e4), &result(1.0, 1500.0));
    assert!(plans.windows(2).all(|w| (w[1].u - w[0].u).abs() <= 1500.0 * TS * (1.0 + 1e-9)));
    let unknown = run(None, &model(1.0)).0;
    let [known, requested, unknown] = [&y, &requested, &unknown].map(|y| rms(&y[200..], &square[200..]));
    assert!(known < 0.98 * unknown && requested < 1.1 * known, "{known} {requested} {unknown}");
}

#[test]
fn measurements_and_references_that_are_not_finite_give_valid_voltages() {
    let mpc = controller(PredictiveSettings { slew: Some(2e4), ..Default::default() });
    let plant = model(1.0);
    for invalid in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, f64::MAX, -f64::MAX, 1e200] {
        for (of_y, of_r) in [(true, false), (false, true), (true, true)] {
            let (mut x, mut truth, mut y) = (mpc.settled(0.0), plant.settled(0.0), 1.5);
            for t in 0..600 {
                let now = t < 100 && t % 3 > 0;
                let r = [if now && of_r { invalid } else { 5.0 }; 3];
                let read = if now && of_y { invalid } else { y };
                let u = mpc.step(&mut x, &ControllerInput { y: read, ahead: &r, ..Default::default() });
                assert!(u.abs() <= 30.0, "{u} at {t} of {invalid}");
                y = plant.step(&mut truth, u);
            }
            assert_close(&[y], &[5.0], 0.0, 1e-2);
        }
    }
    // Without a reference z stays constant.
    let mut x = mpc.settled(3.0);
    let y = plant.step(&mut plant.settled(3.0), 3.0);
    assert_close(&[mpc.step(&mut x, &ControllerInput { y, ..Default::default() })], &[3.0], 1e-9, 0.0);
}

#[test]
fn it_tracks_with_gains_delays_integrators_and_negative_signs() {
    let gain = |k: f64| before(Arx::gain(TS, k).unwrap());
    let delay_samples =
        |delay: usize| before(Arx::new(TS, vec![0.9], [vec![0.0; delay], vec![0.05, 0.05]].concat()).unwrap());
    let crept = |m: Model| m.with_creep(blocks(1).0).unwrap();
    let mut models = vec![gain(2.0), gain(-2.0), crept(gain(2.0)), crept(gain(-3.0))];
    models.extend((0..9).map(delay_samples));
    models.extend((0..9).map(|delay| crept(delay_samples(delay))));
    models.push(crept(before(Arx::new(TS, vec![1.6, -0.8], vec![0.0, -0.25, -0.1, -0.05]).unwrap())));
    // An integrator has no finite gain.
    models.push(before(Arx::new(TS, vec![1.0], vec![0.0, 0.02]).unwrap()));
    let r = sine(10.0, 800);
    for model in models {
        for horizon in [1, 20] {
            let settings =
                PredictiveSettings { horizon, move_cost: 1e-4, displacement: Some((-9.0, 9.0)), ..Default::default() };
            let mpc = Predictive::new(&model, settings).unwrap();
            let delay_samples = model.linear().delay();
            let (y, plans) = follow(&mpc, &model, &r, 0.2);
            let kept: Vec<f64> = r.iter().map(|r| r.clamp(-9.0, 9.0)).collect();
            let error = rms(&y[300..], &kept[300..]);
            let solved = plans.iter().all(|p| p.solved);
            assert!(error < 0.5 && solved, "{error} after {delay_samples}, {horizon}: {:?}", model.linear());
        }
    }
}

#[test]
fn the_unit_of_y_does_not_matter() {
    let r = sine(15.0, 300);
    let limits = PredictiveSettings { displacement: Some((-12.0, 13.0)), slew: Some(3e3), ..Default::default() };
    let voltages = |unit: f64| {
        let m = scaled(unit, 1.5 * unit);
        let displacement = limits.displacement.map(|(low, high)| (low * unit, high * unit));
        let mpc = Predictive::new(&m, PredictiveSettings { displacement, ..limits.clone() }).unwrap();
        let r: Vec<f64> = r.iter().map(|r| r * unit).collect();
        follow(&mpc, &m, &r, 0.3 * unit).1.iter().map(|p| p.u).collect::<Vec<f64>>()
    };
    for unit in [1e-3, 1e-6, 1e3] {
        assert_close(&voltages(unit), &voltages(1.0), 0.0, 1e-5);
    }
}

/// A play of this weight alone.
fn dead_zone(weight: i32) -> Arc<dyn Hysteresis> {
    let (name, weights) = ("prandtl-ishlinskii", [0, weight]);
    let file = json!({"operator": name, "range": [-20, 20], "thresholds": [3], "weights": weights});
    load(&file, TS).unwrap()
}

#[test]
fn a_dead_zone_is_crossed_at_any_slew_rate() {
    let model = Model::new(dead_zone(1), Arx::new(TS, vec![0.3], vec![0.0, 0.7]).unwrap(), 0.0).unwrap();
    // Crossing it takes 12 samples.
    for solver in [Solver::ActiveSet, Solver::InteriorPoint] {
        let limits = PredictiveSettings { voltage: (-20.0, 20.0), slew: Some(1000.0), solver, ..Default::default() };
        let mpc = Predictive::new(&model, limits).unwrap();
        let square = square(4.0, 400, 1200);
        let (y, plans) = follow(&mpc, &model, &square, 0.0);
        for end in [400, 800, 1200] {
            assert_close(&y[end - 50..end - 25], &square[end - 50..end - 25], 0.0, 0.01);
            // It rests there until the next edge is within the horizon.
            let rest: Vec<f64> = plans[end - 50..end - 25].iter().map(|p| p.u).collect();
            assert_close(&rest, &[rest[0]; 25], 0.0, 0.01);
        }
    }
}

#[test]
fn slow_creep_and_a_disturbance_leave_no_offset() {
    let creep = Creep::logarithmic(TS, 0.02, 0.01, 1000.0).unwrap();
    let model = before(blocks(2).1).with_creep(creep).unwrap();
    let mpc = Predictive::new(&model, PredictiveSettings::default()).unwrap();
    let (y, _) = follow(&mpc, &model, &[6.0; 4000], 0.5);
    assert_close(&y[3900..], &[6.0; 100], 0.0, 1e-3);
}

#[test]
fn models_and_limits_without_a_solution_are_errors() {
    let refused = |model: &Model, settings| Predictive::new(model, settings).unwrap_err().to_string();
    let falling = Model::new(Arc::new(Proportional::new(TS, -1.0).unwrap()), Arx::gain(TS, 1.0).unwrap(), 0.0).unwrap();
    let message = refused(&falling, PredictiveSettings::default());
    assert!(
        message.starts_with("no predictive control is possible with this model: its operator is not monotonic"),
        "{message}"
    );
    let still = Model::new(dead_zone(0), Arx::gain(TS, 1.0).unwrap(), 0.0).unwrap();
    assert!(refused(&still, PredictiveSettings::default()).contains("gives a constant output between -30 and 30 V"));
    let beyond = PredictiveSettings { displacement: Some((1e6, 2e6)), ..Default::default() };
    let message = refused(&model(1.0), beyond);
    assert!(message.starts_with("displacement = 1000000 to 2000000: must overlap with -"), "{message}");
    let washed_out = before(Arx::new(TS, vec![0.5], vec![1.0, -1.0]).unwrap());
    assert!(refused(&washed_out, PredictiveSettings::default()).contains("cannot be identified"));
}

#[test]
fn voltage_limits_that_exclude_zero_are_reached_and_kept() {
    for slew in [None, Some(1e3)] {
        let limits = PredictiveSettings { voltage: (5.0, 25.0), slew, ..Default::default() };
        let mpc = controller(limits);
        let inside = model(1.0).simulate(&[15.0; 4000])[3999];
        for (r, near) in [(inside, inside), (-1e3, mpc.reachable().0)] {
            let (y, plans) = follow(&mpc, &model(1.0), &[r; 1000], 0.0);
            assert!(plans.iter().all(|p| (5.0..=25.0).contains(&p.u)), "{slew:?} {r}");
            // The first program, from rest to a jump of the reference, may take too many changes.
            assert!(plans[1..].iter().all(|p| p.solved), "{slew:?} {r}");
            assert_close(&y[900..], &[near; 100], 0.02, 0.05);
        }
    }
}

#[test]
fn mechanics_with_hysteresis_in_feedback_are_controlled_by_their_blocks_in_series() {
    let mode = FeedbackMode { hz: 100.0, damping: 0.1, input: 1.0, hysteretic: -0.2, sensed: 1.0, softening: 0.0 };
    let dynamics = FeedbackDynamics { modes: vec![mode], sensed: 0.0, ..FeedbackDynamics::default() };
    let blocks = model(1.0);
    let friction = (Operator::find("bouc-wen").unwrap().example)(blocks.ts()).unwrap();
    let feedback = FeedbackModel::new(blocks.ts(), dynamics, friction).unwrap();
    let run = |model: &Model| {
        let mpc = Predictive::new(model, PredictiveSettings::default()).unwrap();
        let mut x = mpc.settled(0.0);
        let input = |t: usize| ControllerInput { ahead: &[5.0; 20][t..], ..Default::default() };
        (0..20).map(|t| mpc.step(&mut x, &input(t))).collect::<Vec<_>>()
    };
    assert_eq!(run(&blocks.clone().with_feedback(feedback).unwrap()), run(&blocks));
}

#[test]
fn a_plan_states_the_displacement_that_its_moves_give() {
    for delay in [0, 1, 3] {
        let (creep, linear) = blocks(delay);
        let model = before(linear).with_creep(creep).unwrap();
        let mpc = Predictive::new(&model, PredictiveSettings::default()).unwrap();
        let (mut x, mut truth, mut y, r) = (mpc.settled(0.0), model.settled(0.0), 1.5, sine(5.0, 80));
        for t in 0..40 {
            let mut ahead = truth.clone();
            let plan = mpc.plan(&mut x, &r[t..], y);
            y = model.step(&mut truth, plan.u);
            let held = std::iter::repeat_n(plan.z[19], delay);
            let known: Vec<f64> =
                plan.z.iter().copied().chain(held).map(|z| model.step(&mut ahead, z)).skip(delay).collect();
            assert_close(&plan.y, &known, 1e-9, 1e-9);
        }
    }
}

#[test]
fn the_reach_is_that_of_the_ends_with_all_creep() {
    let reach = |model: &Model| {
        let settings = PredictiveSettings { voltage: (-10.0, 30.0), ..Default::default() };
        let (low, high) = Predictive::new(model, settings).unwrap().reachable();
        [low, high]
    };
    let gain = |k: f64| before(Arx::gain(TS, k).unwrap());
    assert_close(&reach(&gain(2.0)), &[1.5 - 20.0, 1.5 + 60.0], 1e-12, 0.0);
    // Creep adds 6 %.
    let crept = gain(-2.0).with_creep(blocks(1).0).unwrap();
    assert_close(&reach(&crept), &[1.5 - 63.6, 1.5 + 21.2], 1e-12, 0.0);
}

#[test]
fn at_a_limit_of_z_the_voltage_goes_to_its_own_limit_if_the_optimum_lies_beyond() {
    let settings = PredictiveSettings { voltage: (5.0, 30.0), ..Default::default() };
    let mpc = Predictive::new(&before(Arx::gain(TS, 2.0).unwrap()), settings).unwrap();
    let mut x = mpc.settled(15.0);
    let parts = mpc.parts(&mut x);
    (parts.low[0], parts.high[0]) = (10.0, 20.0);
    // Within 25e-6, a millionth of the range of z.
    let low = [(10.00002, 9.0, 8.0), (10.00003, 9.0, 10.00003), (10.0, 9.99998, 10.0), (10.0, 9.99997, 8.0)];
    let high = [(19.99998, 21.0, 22.0), (19.99997, 21.0, 19.99997), (20.0, 20.00002, 20.0), (20.0, 20.00003, 22.0)];
    for (z, free, u) in low.into_iter().chain(high) {
        parts.z[0] = z;
        assert_close(&[mpc.voltage(&parts, free, (8.0, 22.0))], &[u], 0.0, 1e-6);
    }
}

#[test]
fn a_measurement_farther_off_than_ten_ranges_counts_as_ten() {
    let settings = PredictiveSettings { voltage: (-10.0, 30.0), ..Default::default() };
    let mpc = Predictive::new(&before(Arx::gain(TS, 2.0).unwrap()), settings).unwrap();
    let disturbance = |y: f64| {
        let mut x = mpc.settled(0.0);
        mpc.plan(&mut x, &[1.5], y);
        mpc.parts(&mut x).s.to_vec()
    };
    // y ranges over 80, and is 1.5 at 0 V.
    for side in [1.0, -1.0] {
        let most = disturbance(1.5 + side * 800.0);
        assert_close(&disturbance(side * 1e9), &most, 1e-9, 0.0);
        assert_close(&disturbance(1.5 + side * 780.0), &[0.975 * most[0]], 1e-9, 0.0);
    }
}

#[test]
fn the_rows_are_limited_by_the_major_loop_the_slowest_slew_and_the_displacement() {
    let model = Model::new(Arc::new(Proportional::new(TS, 2.0).unwrap()), Arx::gain(TS, 4.0).unwrap(), 1.5).unwrap();
    let settings = PredictiveSettings { slew: Some(1e3), displacement: Some((-9.0, 13.0)), ..Default::default() };
    let mpc = Predictive::new(&model, settings).unwrap();
    let mut x = mpc.settled(3.0);
    let mut parts = mpc.parts(&mut x);
    mpc.limit(&mut parts, (2.5, 3.25));
    // z is twice u, which moves by 0.5 V a sample; y is 4 z and the offset.
    let rows = |first: f64, major: f64, step: f64, displacement: f64| {
        [vec![first], vec![major; 19], vec![step; 19], vec![displacement; 20]].concat()
    };
    assert_close(parts.low, &rows(5.0, -60.0, -1.0, -2.625), 1e-9, 0.0);
    assert_close(parts.high, &rows(6.5, 60.0, 1.0, 2.875), 1e-9, 0.0);
}

#[test]
fn a_tuned_controller_keeps_the_limits_of_its_loop_and_needs_data_up_to_a_twentieth_of_the_sampling_rate() {
    let path = ControlLoop { limits: (-12.0, 13.0), slew: 1e3, ..path_of(blocks(1).1, (1.0, 1.0)) };
    let mpc = (ROW.tune)(&path, &MarginTarget::default()).unwrap();
    let (mut x, mut plant, mut y) = (mpc.settled(0.0), path.linear().initial(), 0.0);
    let mut step = || {
        let u = mpc.step(&mut x, &ControllerInput { y, ahead: &[40.0], ..Default::default() });
        y = path.linear().step(&mut plant, u);
        u
    };
    let u: Vec<f64> = std::iter::once(0.0).chain((0..40).map(|_| step())).collect();
    let fastest = u.windows(2).fold(0.0, |most: f64, w| most.max((w[1] - w[0]).abs()));
    // For the reference it would need 20 V.
    assert_close(&[fastest, u[40]], &[0.5, 13.0], 0.0, 1e-6);

    let known = |hz: f64| {
        let domain = Domain { u: [-12.0, 13.0], hz: Some([1.0, hz]), slew: 1e3, mean: [0.0, 0.0] };
        let known = ControlLoop { model: path.model.clone().with_identified(domain), ..path.clone() };
        (ROW.tune)(&known, &MarginTarget::default()).is_ok()
    };
    let share = MIN_BAND_RATE_SHARE / TS;
    assert_eq!([known(0.99 * share), known(share)], [false, true]);
}

#[test]
fn ends_that_are_no_range_are_refused_by_their_name() {
    for ends in [(5.0, 5.0), (5.0, 4.0), (f64::NEG_INFINITY, 1.0), (0.0, f64::INFINITY), (f64::NAN, 1.0)] {
        let voltage = PredictiveSettings { voltage: ends, ..Default::default() };
        let displacement = PredictiveSettings { displacement: Some(ends), ..Default::default() };
        for (name, settings) in [("voltage", voltage), ("displacement", displacement)] {
            let message = settings.check().unwrap_err().to_string();
            assert!(message.starts_with(&format!("{name} = ")) && message.contains("both finite"), "{message}");
        }
    }
}

#[test]
fn the_computing_time_of_a_horizon_is_that_of_all_its_multiplications() {
    // For two states and 3 samples: 10 for the observer, 9 for the free optimum, and the program.
    let soft = 10 + 9 + condensed::operations(3, 8, 6);
    let hard = 10 + 9 + condensed::operations(3, 5, 3);
    for (displacement, needed) in [(Some((-1.0, 1.0)), soft), (None, hard)] {
        let within = |multiplications: usize| {
            let multiplications_per_second = 2.0 * multiplications as f64;
            let settings =
                PredictiveSettings { horizon: 3, displacement, multiplications_per_second, ..Default::default() };
            settings.check_computing_time(2, 0.5).map_err(|error| error.to_string())
        };
        assert_eq!(within(needed), Ok(()));
        let message = within(needed - 1).unwrap_err();
        assert!(message.contains("the longest horizon that fits is 2 samples"), "{message}");
    }
}
