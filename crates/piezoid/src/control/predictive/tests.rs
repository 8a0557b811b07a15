//! The whole controller on models of its own and on others.

use super::realisation::tests::blocks;
use super::*;
use crate::hysteresis::operator;
use crate::testing::assert_close;
use nalgebra::DMatrix;

const TS: f64 = 5e-4;

/// Plays before a creeping resonance; with twice the gain and other loops where it is `off`.
fn model(off: f64) -> Model {
    let plays = (operator("prandtl-ishlinskii").unwrap().example)(TS).unwrap();
    let (creep, linear) = blocks(1);
    let linear = Arx::new(TS, linear.a().to_vec(), linear.b().iter().map(|b| b * off).collect());
    Model::new(plays, linear.unwrap(), 1.5).unwrap().with_creep(creep).unwrap()
}

fn sine(amplitude: f64, n: usize) -> Vec<f64> {
    (0..n).map(|t| amplitude * (t as f64 * 0.06).sin()).collect()
}

/// Plans on the way along `r`, with a disturbance of the reading.
fn follow(mpc: &Predictive, plant: &Model, r: &[f64], disturbance: f64) -> (Vec<f64>, Vec<Plan>) {
    let (mut x, mut truth) = (mpc.settled(0.0), plant.settled(0.0));
    let mut y = plant.step(&mut truth.clone(), 0.0);
    let step = |t: usize| {
        let plan = mpc.plan(&mut x, &r[t..], y);
        y = plant.step(&mut truth, plan.u) + disturbance;
        (y, plan)
    };
    (0..r.len()).map(step).unzip()
}

fn rms(a: &[f64], b: &[f64]) -> f64 {
    (a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / a.len() as f64).sqrt()
}

#[test]
fn without_limits_the_moves_are_the_least_squares_of_their_cost() {
    let model = model(1.0);
    let mpc = Predictive::new(&model, Settings { voltage: (-60.0, 60.0), ..Settings::default() }).unwrap();
    let r: Vec<f64> = sine(3.0, 21).iter().map(|r| 1.5 + r).collect();
    let plan = mpc.plan(&mut mpc.settled(0.0), &r, model.offset());
    // One column a move, each the answer of the blocks to it; below, the steps.
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
    let wanted = DVector::from_fn(2 * n, |t, _| if t < n { (r[t + 1] - 1.5) * scale } else { 0.0 });
    let known = columns.svd(true, true).solve(&wanted, 1e-14).unwrap();
    assert!(plan.solved && plan.changes == 0);
    assert_close(&plan.z, known.as_slice(), 0.0, 1e-9);
    assert_close(&[plan.y[0]], &[1.5 + known[0] * mpc.horizon.phi[(0, 0)] / scale], 1e-9, 0.0);
}

#[test]
fn a_model_of_itself_is_followed_and_a_wrong_one_nearer_than_without_readings() {
    let r: Vec<f64> = sine(15.0, 800);
    let mpc = Predictive::new(&model(1.0), Settings::default()).unwrap();
    let missed = |off: f64| rms(&follow(&mpc, &model(off), &r, 0.0).0[200..], &r[200..]);
    assert!(missed(1.0) < 0.05, "{}", missed(1.0));
    // Without readings a tenth more gain would miss by a tenth of the rms of r.
    assert!(missed(1.1) < 0.075 * rms(&r[200..], &[0.0; 600]), "{}", missed(1.1));
}

#[test]
fn a_disturbance_that_lasts_leaves_no_offset() {
    let mpc = Predictive::new(&model(1.0), Settings::default()).unwrap();
    for (off, disturbance) in [(1.0, 0.7), (0.85, -0.4)] {
        let (y, _) = follow(&mpc, &model(off), &[6.0; 3000], disturbance);
        assert_close(&y[2900..], &[6.0; 100], 0.0, 1e-3);
    }
}

#[test]
fn voltage_slew_and_displacement_are_kept() {
    let (top, fastest) = (12.0, 1500.0);
    let limits = Settings { voltage: (-top, top), slew: Some(fastest), ..Settings::default() };
    let square: Vec<f64> = (0..600).map(|t| if t % 200 < 100 { 30.0 } else { -30.0 }).collect();
    let mpc = Predictive::new(&model(1.0), limits).unwrap();
    let (_, plans) = follow(&mpc, &model(1.0), &square, 0.0);
    assert!(plans.iter().all(|p| p.solved && p.u.abs() <= top));
    assert!(plans.windows(2).all(|w| (w[1].u - w[0].u).abs() <= fastest * TS * (1.0 + 1e-9)));
    assert!(plans.iter().any(|p| p.u.abs() == top) && plans.iter().any(|p| p.changes > 5));

    let limits = Settings { displacement: Some((-5.0, 6.0)), ..Settings::default() };
    let (y, plans) = follow(&Predictive::new(&model(1.0), limits).unwrap(), &model(1.0), &square, 0.0);
    let (low, high) = crate::series::ends(y);
    assert!(
        plans.iter().all(|p| p.solved) && (-5.1..-4.5).contains(&low) && (5.5..6.1).contains(&high),
        "{low} {high}"
    );
}

#[test]
fn the_interior_point_method_gives_the_same_voltages() {
    let limits =
        Settings { voltage: (-12.0, 12.0), slew: Some(1500.0), displacement: Some((-9.0, 9.0)), ..Settings::default() };
    let other = Settings { solver: Solver::InteriorPoint, ..limits.clone() };
    let square: Vec<f64> = (0..150).map(|t| if t % 60 < 30 { 10.0 } else { -10.0 }).collect();
    let voltages = |settings| {
        let mpc = Predictive::new(&model(1.0), settings).unwrap();
        let (y, plans) = follow(&mpc, &model(0.9), &square, 0.0);
        (y, plans.iter().map(|p| p.u).collect::<Vec<f64>>(), plans)
    };
    let (active, interior) = (voltages(limits), voltages(other));
    assert_close(&active.1, &interior.1, 0.0, 1e-6);
    assert!(active.2.iter().any(|p| p.changes > 0) && interior.2.iter().all(|p| p.solved));
}

#[test]
fn readings_that_are_lost_are_bridged_and_runs_repeat_to_the_bit() {
    let mpc = Predictive::new(&model(1.0), Settings::default()).unwrap();
    let r = sine(10.0, 300);
    let run = |lost: bool| {
        let (mut x, plant) = (mpc.settled(0.0), model(1.0));
        let (mut truth, mut y) = (plant.settled(0.0), 1.5);
        let mut ys = Vec::new();
        for t in 0..r.len() {
            let y_read = if lost && t % 7 == 3 { f64::NAN } else { y };
            let u = mpc.step(&mut x, &Now { y: y_read, ahead: &r[t..], ..Now::default() });
            y = plant.step(&mut truth, u);
            ys.push(y);
        }
        ys
    };
    assert_eq!(run(false), run(false));
    assert!(rms(&run(true)[100..], &r[100..]) < 0.05);
}

#[test]
fn what_cannot_be_followed_or_run_is_refused_with_numbers() {
    let limits = Settings { displacement: Some((-5.0, 6.0)), ..Settings::default() };
    let mpc = Predictive::new(&model(1.0), limits).unwrap();
    assert!(mpc.check(&[0.0, 5.9]).is_ok());
    assert!(mpc.check(&[0.0, f64::NAN]).unwrap_err().to_string().starts_with("reference[1] is NaN"));
    assert!(mpc.check(&[0.0, 6.5]).unwrap_err().to_string().contains("reference[1] = 6.5: must lie from -5 to 6"));
    let refused = |settings| Predictive::new(&model(1.0), settings).unwrap_err().to_string();
    assert!(refused(Settings { horizon: 0, ..Settings::default() }).contains("from 1 to 200"));
    assert!(refused(Settings { voltage: (30.0, -30.0), ..Settings::default() }).contains("30 to -30"));
    assert!(refused(Settings { move_cost: f64::NAN, ..Settings::default() }).starts_with("move_cost = NaN"));
    let slow = refused(Settings { multiplications_per_second: 1e7, ..Settings::default() });
    assert!(slow.contains("horizon = 20") && slow.contains("the longest that does not is "), "{slow}");
    let longest = slow.rsplit(' ').next().unwrap().parse().unwrap();
    let at = |horizon| Settings { horizon, multiplications_per_second: 1e7, ..Settings::default() };
    assert!(Predictive::new(&model(1.0), at(longest)).is_ok());
    assert!(Predictive::new(&model(1.0), at(longest + 1)).is_err());
}
