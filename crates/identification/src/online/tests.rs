//! Tracking, noise, poor excitation, splits, and the program. The data come from twins, which share no code with the
//! models, or from a generator here.

use super::*;
use crate::{JointOptions, identify_joint};
use piezoid_models::creep::{Creep, Lag};
use piezoid_models::driver::DriverModel;
use piezoid_models::hammerstein::Domain;
use piezoid_models::hysteresis::{BasisDesign, OPERATORS, Operator};
use piezoid_models::linear::Arx;
use piezoid_models::program::Machine;
use piezoid_numerics::progress::Stage;
use piezoid_records::excitation::Prbs;
use piezoid_records::record::Record;
use piezoid_testing::assert_close;
use piezoid_twins::Plant;

const TS: f64 = 5e-4;

/// A model of this operator with a resonance at 147 Hz and creep.
fn model(operator: &str) -> Model {
    let law = (Operator::find(operator).unwrap().example)(TS).unwrap();
    let block = Arx::new(TS, vec![1.7424, -0.9453], vec![0.0, 3.0, 2.8]).unwrap();
    let creep = Creep::new(TS, vec![Lag { tau_s: 0.1, gain: 0.01 }, Lag { tau_s: 1.0, gain: 0.01 }]).unwrap();
    Model::new(law, block, 2.0)
        .unwrap()
        .with_creep(creep)
        .unwrap()
        .with_identified(Domain::of_input(&[-30.0, 30.0], TS))
}

/// Noise of variance 1, independent of the library's generators.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        let mut uniform = || {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            (self.0 >> 11) as f64 / (1u64 << 53) as f64
        };
        (0..12).map(|_| uniform()).sum::<f64>() - 6.0
    }
}

/// Sines of 23, 61 and 140 Hz, at most 28.
fn drive(t: usize) -> f64 {
    let at = |hz: f64| (std::f64::consts::TAU * hz * TS * t as f64).sin();
    14.0 * at(23.0) + 10.0 * at(61.0) + 4.0 * at(140.0)
}

fn check_program(model: &Model, settings: &OnlineSettings) {
    let online = Online::new(model, settings).unwrap();
    let mut program = model.program().unwrap();
    online.extend(&mut program).unwrap();
    let mut machine = Machine::new(&program, "online_state", false);
    let mut x = online.initial();
    assert_eq!(machine.state(), x);
    let y: Vec<f64> = model.simulate(&(0..400).map(drive).collect::<Vec<_>>());
    let mut noise = Noise(7);
    for (t, y) in y.into_iter().enumerate() {
        let (mut u, mut y) = (drive(t), 1.2 * y + 0.1 * noise.next());
        match t {
            100 => u = f64::NAN,
            120 => y = f64::INFINITY,
            140 => (u, y) = (1e30, -1e30),
            _ => {}
        }
        let expected = online.step(&mut x, u, y);
        let answer = machine.call("online_step", &[u, y]).unwrap()[0];
        let name = model.hysteresis().operator().name;
        assert_eq!(answer.to_bits(), expected.to_bits(), "{name} at {t}");
        assert_eq!(machine.state(), x, "{name} at {t}");
    }
}

#[test]
fn the_program_of_every_operator_and_setting_is_bit_identical() {
    for operator in OPERATORS {
        check_program(&model(operator.name), &OnlineSettings::default());
    }
    let plays = || (Operator::find("stop").unwrap().example)(TS).unwrap();
    let range = Domain::of_input(&[-30.0, 30.0], TS);
    for moves in 0..16u8 {
        let is = |bit: u8| moves & bit != 0;
        let moves = Moves { gain: is(1), offset: is(2), weights: is(4), linear: is(8) };
        let settings = OnlineSettings { moves: Some(moves), groups: 3, ..OnlineSettings::default() };
        check_program(&model("prandtl-ishlinskii"), &settings);
        for (a, b) in
            [(vec![], vec![0.5, 0.3]), (vec![0.6], vec![0.4]), (vec![1.2, -0.5, 0.1], vec![0.0, 0.0, 1.0, 0.3])]
        {
            let model = Model::new(plays(), Arx::new(TS, a, b).unwrap(), -1.0).unwrap().with_identified(range);
            check_program(&model, &settings);
        }
    }
    let driver = DriverModel::new(1e-4, Some(2e4)).unwrap();
    let law = (Operator::find("preisach").unwrap().example)(TS / DriverModel::SUBSTEPS as f64).unwrap();
    let model = Model::from_blocks(Some(driver), law, Arx::gain(TS, 3.0).unwrap(), 0.0).unwrap();
    check_program(&model.with_identified(range), &OnlineSettings::default());
}

/// A twin with its response [um] to the drive, and a model of it with plays.
fn twin(n: usize) -> (Model, Vec<f64>, Vec<f64>) {
    let plant = Plant::named("pl140", TS).unwrap();
    let measure = |u: Vec<f64>| Record::new(TS, u.clone(), plant.run(&u).y).unwrap();
    let small = Prbs { amplitude: 1.0, ..Default::default() }.samples(TS, 4094).unwrap();
    let large = (0..4000).map(|t| drive(t) * t as f64 / 4000.0).collect();
    let options = JointOptions {
        operator: "prandtl-ishlinskii".into(),
        elements: Some(12),
        order: Some(2),
        ..Default::default()
    };
    let found = identify_joint(&[measure(small)], &[measure(large)], &options, &mut Stage::ignore);
    let model = found.unwrap().model;
    let u: Vec<f64> = (0..n).map(drive).collect();
    let y = plant.run(&u).y;
    (model, u, y)
}

#[test]
fn a_step_of_the_gain_of_a_twin_by_10_percent_is_followed_within_200_samples_to_1_percent() {
    let (model, u, y) = twin(6000);
    for (noise_share, moves) in [(0.0, "auto"), (0.005, "auto"), (0.0, "gain,offset"), (0.005, "gain,offset")] {
        for ratio in [1.1, 0.9] {
            let settings = OnlineSettings { moves: Moves::of(moves).unwrap(), ..OnlineSettings::default() };
            let online = Online::new(&model, &settings).unwrap();
            let (mut x, mut noise) = (online.initial(), Noise(11));
            let level = noise_share * online.scales.stroke;
            // The gain before the step is what the estimator holds then: that of the model at these frequencies.
            let (mut before, mut after, mut from, mut to) = (0.0, 0.0, f64::INFINITY, 0.0f64);
            for t in 0..6000 {
                let g = if t < 4000 { 1.0 } else { ratio };
                online.step(&mut x, u[t], g * y[t] + level * noise.next());
                let gain = online.parameters(&x).gain;
                if (3000..4000).contains(&t) {
                    before += gain / 1000.0;
                }
                // The slowest sine has a period of 87 samples, longer than the memory: the gain follows what the model
                // leaves within a period. Its mean over four periods is the level.
                if (4200..4548).contains(&t) {
                    after += gain / 348.0;
                    (from, to) = (from.min(gain), to.max(gain));
                }
            }
            println!("{moves}, noise {noise_share}, to {ratio}: {before:.4}, then {after:.4}, {from:.4} to {to:.4}");
            let off = |gain: f64| (gain / (ratio * before) - 1.0).abs();
            assert!(off(after) < 0.01 && off(from) < 0.03 && off(to) < 0.03, "{before} {after} {from} {to}");
        }
    }
}

/// Runs a model of plays with noise, and returns the parameters at the end and the largest number of the state.
fn poorly_excited(input: fn(usize) -> f64, settings: OnlineSettings, samples: usize) -> (OnlineParameters, f64) {
    let model = model("prandtl-ishlinskii");
    let online = Online::new(&model, &settings).unwrap();
    let (mut x, mut actuator, mut noise) = (online.initial(), model.initial(), Noise(5));
    let mut most = 0.0f64;
    for t in 0..samples {
        let u = input(t);
        let y = model.step(&mut actuator, u) + noise.next();
        online.step(&mut x, u, y);
        if t % 64 == 0 {
            most = x.iter().fold(most, |most, v| most.max(v.abs()));
        }
    }
    assert!(x.iter().all(|v| v.is_finite()));
    (online.parameters(&x), most)
}

/// `PIEZOID_SAMPLES=100000000 cargo test --release -p piezoid-identification --lib online::tests::poor -- --nocapture`
/// runs as long as the documentation states.
#[test]
fn poor_excitation_leads_nowhere() {
    let samples = std::env::var("PIEZOID_SAMPLES").map_or(400_000, |n| n.parse().unwrap());
    type Input = fn(usize) -> f64;
    let inputs: [(&str, Input); 4] = [
        ("constant", |_| 12.0),
        ("tiny sine", |t| 1e-3 * (0.0628 * (t % 100_000) as f64).sin()),
        ("one sine", |t| 20.0 * (0.062_831_853_071_795_86 * (t % 100) as f64).sin()),
        ("steps", |t| if t / 2000 % 2 == 0 { 0.0 } else { 10.0 }),
    ];
    for (name, input) in inputs {
        // Without the threshold of excitation the prior alone has to bound the estimators.
        for excitation in [0.01, 0.0] {
            let settings = OnlineSettings { excitation, ..OnlineSettings::default() };
            let (p, most) = poorly_excited(input, settings, samples);
            let pole = Arx::new(TS, p.a.clone(), p.b.clone()).unwrap().poles()[0];
            println!(
                "{name}, excitation {excitation}, {samples} samples: gain {:.4}, offset {:.3}, factors {:.3?}, {:.2} Hz, \
                 damping {:.4}, largest number {most:.2e}",
                p.gain, p.offset, p.factors, pole.hz, pole.damping
            );
            assert!((p.gain - 1.0).abs() < 0.1 && most < 1e7, "{name}: {p:?} {most}");
            assert!(p.factors.iter().all(|f| (f - 1.0).abs() < 0.5) && (pole.hz - 146.7).abs() < 15.0, "{name}: {p:?}");
        }
    }
}

#[test]
fn a_run_in_parts_that_is_saved_between_them_equals_one_run() {
    let online = Online::new(&model("stop"), &OnlineSettings::default()).unwrap();
    let run = |x: &mut Vec<f64>, from: usize, to: usize| {
        (from..to).for_each(|t| {
            online.step(x, drive(t), 30.0 * drive(t));
        });
    };
    let (mut whole, mut parts) = (online.initial(), online.initial());
    run(&mut whole, 0, 700);
    run(&mut parts, 0, 333);
    let saved = serde_json::to_string(&parts).unwrap();
    let mut restored: Vec<f64> = serde_json::from_str(&saved).unwrap();
    run(&mut restored, 333, 700);
    assert_eq!(restored, whole);
}

#[test]
fn what_is_excited_is_found_and_the_model_of_the_end_has_it() {
    let start = model("prandtl-ishlinskii");
    // Another resonance, other weights, another offset, and noise of 1 % of the stroke.
    let mut document = piezoid_models::hysteresis::save(start.hysteresis());
    let weights: Vec<f64> = document["weights"].as_array().unwrap().iter().map(|w| w.as_f64().unwrap()).collect();
    document["weights"] = weights.iter().enumerate().map(|(k, w)| if k == 0 { 0.9 * w } else { 1.3 * w }).collect();
    let truth = piezoid_models::hysteresis::load(&document, TS).unwrap();
    let block = Arx::new(TS, vec![1.72, -0.9453], vec![0.0, 3.0, 2.8]).unwrap();
    let truth = Model::new(truth, block, 7.0).unwrap().with_creep(start.creep().clone()).unwrap();
    let u: Vec<f64> = (0..60_000).map(drive).collect();
    let (y, mut noise) = (truth.simulate(&u), Noise(2));
    let online = Online::new(&start, &OnlineSettings::default()).unwrap();
    let mut x = online.initial();
    u.iter().zip(&y).for_each(|(u, y)| {
        online.step(&mut x, *u, y + 8.0 * noise.next());
    });
    let found = online.model(&x).unwrap();
    let rms = |model: &Model| {
        let run = model.simulate(&u);
        let squares = run.iter().zip(&y).skip(50_000).map(|(run, y)| (run - y) * (run - y));
        (squares.sum::<f64>() / 10_000.0).sqrt() / online.scales.stroke
    };
    println!("{:?}: {:.5} from {:.5} strokes", online.parameters(&x), rms(&found), rms(&start));
    assert!(rms(&found) < 0.02 && rms(&start) > 5.0 * rms(&found), "{} {}", rms(&start), rms(&found));
}

#[test]
fn what_cannot_move_is_an_error_and_states_why() {
    let refused = |model: &Model, settings: OnlineSettings| Online::new(model, &settings).unwrap_err().to_string();
    let named = |names: &str| OnlineSettings { moves: Moves::of(names).unwrap(), ..OnlineSettings::default() };
    let message = refused(&model("preisach"), named("weights"));
    assert!(message.contains("no response of its own for each weight of preisach"), "{message}");
    let law = (Operator::find("stop").unwrap().example)(TS).unwrap();
    let of = |a: Vec<f64>, b: Vec<f64>| Model::new(law.clone(), Arx::new(TS, a, b).unwrap(), 0.0).unwrap();
    let bounded = |model: Model| model.with_identified(Domain::of_input(&[-30.0, 30.0], TS));
    assert!(refused(&bounded(of(vec![], vec![2.0])), named("linear")).contains("it is a gain"));
    let high = bounded(of(vec![0.1; 8], vec![1.0, 1.0]));
    assert!(refused(&high, named("linear")).contains("10 of them, and at most 7 move"));
    assert!(refused(&bounded(of(vec![1.1], vec![1.0])), named("gain")).contains("unstable"));
    assert!(refused(&bounded(of(vec![0.5], vec![1.0, -1.0])), named("gain")).contains("static response"));
    for (settings, why) in [
        (OnlineSettings { memory: 2.0, ..OnlineSettings::default() }, "memory = 2: must be at least 10 samples"),
        (OnlineSettings { gain_memory: f64::NAN, ..OnlineSettings::default() }, "gain_memory"),
        (OnlineSettings { groups: 7, ..OnlineSettings::default() }, "groups = 7: must be from 2 to 4"),
        (OnlineSettings { dead_zone: -1.0, ..OnlineSettings::default() }, "dead_zone = -1"),
    ] {
        let message = refused(&high, settings);
        assert!(message.starts_with(why), "{message}");
    }
}

#[test]
fn errors_up_to_the_dead_zone_move_nothing() {
    let online = Online::new(&model("stop"), &OnlineSettings { dead_zone: 0.5, ..OnlineSettings::default() }).unwrap();
    // At rest, 2 is expected, and only the offset moves: by a 500th of the error.
    for (y, offset) in [(2.5, 2.0), (1.5, 2.0), (2.75, 2.0015), (1.25, 1.9985)] {
        let mut x = online.initial();
        assert_eq!(online.step(&mut x, 0.0, y), 2.0);
        assert_close(&[online.parameters(&x).offset], &[offset], 1e-12, 0.0);
    }
}

#[test]
fn without_a_moving_gain_no_scale_doubles_or_halves() {
    let model = model("prandtl-ishlinskii");
    let u: Vec<f64> = (0..3000).map(drive).collect();
    let y = model.simulate(&u);
    for (names, ratio) in [("weights", 4.0), ("weights", 0.1), ("linear", 4.0), ("linear", 0.1)] {
        let settings = OnlineSettings { moves: Moves::of(names).unwrap(), memory: 30.0, ..OnlineSettings::default() };
        let online = Online::new(&model, &settings).unwrap();
        let (mut x, mut least, mut most) = (online.initial(), 1.0f64, 1.0f64);
        for (u, y) in u.iter().zip(&y) {
            online.step(&mut x, *u, 2.0 + ratio * (y - 2.0));
            let OnlineParameters { factors, a, b, .. } = online.parameters(&x);
            let of_weights: f64 = factors.iter().zip(&online.scales.share).map(|(factor, share)| factor * share).sum();
            let of_linear = b.iter().sum::<f64>() / (1.0 - a.iter().sum::<f64>()) / model.linear().dc_gain();
            let scale = if names == "weights" { of_weights } else { of_linear };
            (least, most) = (least.min(scale), most.max(scale));
        }
        assert!(least > 0.4999 && most < 2.0001, "{names} {ratio}: {least} {most}");
        assert!(most / least > 1.2, "{names} {ratio}: {least} {most}");
    }
}

#[test]
fn a_settled_state_stands_still_with_the_response_of_the_settled_model() {
    for operator in ["prandtl-ishlinskii", "preisach"] {
        let model = model(operator);
        let online = Online::new(&model, &OnlineSettings::default()).unwrap();
        let start = online.settled(12.0);
        assert_eq!((online.ts(), online.order()), (TS, start.len()));
        let mut x = start.clone();
        let response = model.step(&mut model.settled(12.0), 12.0);
        for _ in 0..5 {
            // A reading that is no number moves no parameter.
            assert_close(&[online.step(&mut x, 12.0, f64::NAN)], &[response], 1e-9, 0.0);
        }
        let signals = start.len() - online.layout.fits.iter().sum::<usize>();
        assert_close(&x[..signals], &start[..signals], 1e-9, 1e-9);
        assert_eq!(online.settled(1e9), online.settled(online.scales.inputs.1));
    }
}

#[test]
fn the_model_of_the_start_is_the_model() {
    for operator in ["prandtl-ishlinskii", "preisach"] {
        let model = model(operator);
        let online = Online::new(&model, &OnlineSettings::default()).unwrap();
        assert_eq!(online.model(&online.initial()).unwrap(), model);
    }
}

#[test]
fn settings_at_the_ends_of_their_ranges_are_taken_and_beyond_them_refused() {
    let (model, usual) = (model("stop"), OnlineSettings::default());
    let least = OnlineSettings { gain_memory: 10.0, memory: 10.0, groups: 2, excitation: 1.0, ..usual };
    assert!(Online::new(&model, &least).is_ok());
    for (settings, why) in [
        (OnlineSettings { gain_memory: 9.5, ..usual }, "gain_memory = 9.5: must be at least 10 samples"),
        (OnlineSettings { groups: 1, ..usual }, "groups = 1: must be from 2 to 4"),
        (OnlineSettings { excitation: 1.5, ..usual }, "excitation = 1.5: must be at most 1, half the stroke"),
        (OnlineSettings { excitation: -0.5, ..usual }, "excitation = -0.5: must be 0 or a positive number"),
        (OnlineSettings { dead_zone: f64::INFINITY, ..usual }, "dead_zone = inf: must be 0 or a positive number"),
    ] {
        let message = Online::new(&model, &settings).unwrap_err().to_string();
        assert!(message.starts_with(why), "{message}");
    }
}

/// A model of plays with this number of weights, and this linear block.
fn of_plays(weights: usize, a: Vec<f64>, b: Vec<f64>) -> Model {
    let elements = Some(weights - 1);
    let design = BasisDesign { ts: TS, range: (-30.0, 30.0), elements, frequencies: Vec::new() };
    let basis = (Operator::find("prandtl-ishlinskii").unwrap().basis)(&design).unwrap();
    let model = Model::new(basis.operator(&vec![1.0; weights]).unwrap(), Arx::new(TS, a, b).unwrap(), 0.0).unwrap();
    model.with_identified(Domain::of_input(&[-30.0, 30.0], TS))
}

#[test]
fn what_cannot_move_is_remarked_unless_names_leave_it_out() {
    let remarks = |model: &Model, names: &str| {
        let settings = OnlineSettings { moves: Moves::of(names).unwrap(), ..OnlineSettings::default() };
        let online = Online::new(model, &settings).unwrap();
        let Moves { weights, linear, .. } = online.moves();
        (weights, linear, online.remarks().join("; "))
    };
    let (still, at_rest) = ("the weights keep their proportions: ", "the linear block keeps its coefficients: ");
    assert_eq!(remarks(&of_plays(64, vec![0.5], vec![1.0]), "auto"), (true, true, String::new()));
    let many = of_plays(65, vec![], vec![0.0, 2.0]);
    let why = format!("{still}prandtl-ishlinskii has 65 of them, and at most 64 move; {at_rest}it is a gain");
    assert_eq!(remarks(&many, "auto"), (false, false, why));
    assert_eq!(remarks(&many, "gain"), (false, false, String::new()));
    let near = of_plays(3, vec![0.999_999_5], vec![1.0]);
    let why = format!("{at_rest}a pole is too near the unit circle at this sampling rate");
    assert_eq!(remarks(&near, "auto"), (true, false, why));
    let longest = of_plays(3, vec![0.1; 4], vec![0.0, 0.5, 0.2, 0.1]);
    assert_eq!(remarks(&longest, "auto"), (true, true, String::new()));
    let driver = DriverModel::new(1e-4, None).unwrap();
    let law = (Operator::find("prandtl-ishlinskii").unwrap().example)(TS / DriverModel::SUBSTEPS as f64).unwrap();
    let driven = Model::from_blocks(Some(driver), law, Arx::new(TS, vec![0.5], vec![1.0]).unwrap(), 0.0).unwrap();
    let driven = driven.with_identified(Domain::of_input(&[-30.0, 30.0], TS));
    assert_eq!(remarks(&driven, "auto"), (false, true, format!("{still}the driver moves the input within a sample")));
}

#[test]
fn groups_are_the_input_and_equal_parts_of_the_thresholds() {
    let groups = |weights: usize| {
        Online::new(&of_plays(weights, vec![0.5], vec![1.0]), &OnlineSettings::default()).unwrap().groups
    };
    assert_eq!(groups(9), [0..1, 1..3, 3..6, 6..9]);
    assert_eq!(groups(3), [0..1, 1..2, 2..3]);
}
