use super::advice::{added, covariance, predicted, products, uncertain};
use super::{Plan, PlanOptions, PlannedDrive};
use piezoid_models::creep::{Creep, Lag};
use piezoid_models::hammerstein::{InitialCondition, Model};
use piezoid_models::hysteresis::Proportional;
use piezoid_models::linear::Arx;
use piezoid_numerics::error::Error;
use piezoid_numerics::options::Options;
use piezoid_numerics::system::System;
use piezoid_testing::assert_close;
use serde_json::{Value, json};
use std::f64::consts::TAU;
use std::sync::Arc;

fn planned(input: Value) -> Result<Plan, Error> {
    PlanOptions::from_json(input).and_then(|options| options.run(None))
}

fn refusal(input: Value) -> String {
    planned(input).unwrap_err().to_string()
}

/// Requests for the simulated actuators.
fn requests() -> [Value; 5] {
    [
        json!({"range": [-30, 30], "bandwidth": 80, "driver": "pl140", "actuator": "pl140"}),
        json!({"range": [0, 120], "bandwidth": 50, "driver": "e-610", "capacitance": 1.5e-6, "ts": 2e-4}),
        json!({"bandwidth": 30, "driver": "e-503", "actuator": "p-611.1s"}),
        json!({"range": [-250, 250], "bandwidth": 200, "driver": "trek-2220", "actuator": "tb3507"}),
        // Little current: all amplitudes but that of the slow sine are reduced.
        json!({"range": [0, 150], "bandwidth": 150, "driver": "kpz101", "capacitance": 1e-6}),
    ]
}

#[test]
fn every_drive_is_within_the_limits_and_starts_and_ends_at_the_middle() {
    for request in requests() {
        let plan = planned(request.clone()).unwrap();
        let (middle, fastest) = (plan.rig.middle(), plan.rig.limits.fastest());
        for PlannedDrive { name, u, usage, .. } in &plan.drives {
            assert!(usage.peaks().all(|peak| !peak.exceeds()), "{request} {name}: {usage:?}");
            assert!(usage.slew.value <= 0.9 * fastest * (1.0 + 1e-9), "{request} {name}: {usage:?}");
            assert!(usage.lowest.value >= plan.rig.low && usage.highest.value <= plan.rig.high, "{request} {name}");
            assert_close(&[u[0], u[u.len() - 1]], &[middle; 2], 0.0, 1e-3 * plan.rig.half());
            assert!(u.len() <= 200_000 && u.len() as f64 * plan.ts < 60.01, "{request} {name}: {}", u.len());
        }
        assert_eq!(plan, planned(request).unwrap());
    }
}

#[test]
fn amplitudes_are_those_of_the_request_unless_the_driver_is_too_slow() {
    let [ample, .., scarce] = requests().map(|request| planned(request).unwrap());
    let peak = |plan: &Plan, k: usize| plan.drives[k].usage.highest.value;
    assert_close(&[0, 1, 3, 4, 5].map(|k| peak(&ample, k)), &[0.6, 28.5, 28.5, 24.0, 27.0], 0.02, 0.0);
    assert!(ample.notes.iter().all(|note| !note.contains("reduced")), "{:?}", ample.notes);
    // 90 % of 7.5 mA into 1 uF: a sine of 150 Hz has 6750 / (2 pi 150) = 7.16 V.
    assert_close(&[peak(&scarce, 1), peak(&scarce, 3)], &[146.25, 82.16], 1e-3, 0.0);
    let message = scarce.notes.join("\n");
    assert!(message.contains("rise3_u.csv: amplitude reduced from 71.25 V to 7.176 V (10 %)"), "{message}");
    assert!(message.contains("creep_u.csv: shortened from 60 s to 40 s"), "{message}");
}

#[test]
fn drives_that_a_controller_cannot_hold_are_sampled_less_often() {
    for points in [32_768, 8192] {
        let request = json!({"bandwidth": 80, "driver": "pl140", "actuator": "pl140", "points": points, "cycle": 5e-5});
        let plan = planned(request).unwrap();
        assert_eq!(plan.ts, 5e-4);
        for PlannedDrive { name, ts, u, .. } in plan.drives.iter().chain([&plan.demagnetisation]) {
            assert!(u.len() <= points, "{name}: {}", u.len());
            assert!((ts / plan.ts).fract().abs() < 1e-9, "{name}: {ts}");
        }
        let creep = &plan.drives[4];
        assert!(plan.duration(creep) > 59.9 && creep.ts == 5e-4 * f64::ceil(120_000.0 / points as f64), "{}", creep.ts);
        assert!(plan.page().contains("`creep_u.csv` has "), "{}", plan.page());
    }
    let message = refusal(json!({"bandwidth": 5, "range": [0, 1], "ts": 1.3e-4, "cycle": 5e-5}));
    assert!(message.contains("must be a multiple of the servo cycle of 0.00005 s, such as 1e-4 s"), "{message}");
}

#[test]
fn the_sampling_period_follows_from_bandwidth_and_resonance() {
    let ts = |input: Value| planned(input).unwrap().ts;
    assert_eq!(ts(json!({"range": [0, 1], "bandwidth": 50})), 1e-3);
    assert_eq!(ts(json!({"range": [0, 1], "bandwidth": 51})), 5e-4);
    assert_eq!(ts(json!({"actuator": "tb3507", "bandwidth": 200})), 5e-5);
    // 70 kHz with both ends free: far above the band.
    assert_eq!(ts(json!({"actuator": "p-885.51", "bandwidth": 50})), 1e-3);
    assert_eq!(ts(json!({"actuator": "p-885.51", "bandwidth": 1000})), 5e-6);
}

#[test]
fn impossible_requests_are_refused_with_the_limit_and_a_remedy() {
    for (input, says) in [
        (json!({"bandwidth": 5}), "range = (not given): is needed: give the lowest and highest voltage"),
        (json!({"bandwidth": 5, "range": [3, 1]}), "range = 3 1: must go from the lowest to the highest"),
        (
            json!({"bandwidth": 5, "range": [0, 160], "driver": "kpz101", "capacitance": 1e-6}),
            "range = 0 160: driver `kpz101` gives 0 to 150 V: take a range within it",
        ),
        (json!({"bandwidth": 5, "range": [-40, 0], "actuator": "pl140"}), "actuator `pl140` allows -30 to 30 V"),
        (
            json!({"bandwidth": 500, "range": [0, 1], "ts": 1e-3}),
            "bandwidth = 500 Hz: must be below 100 Hz, a tenth of the sampling rate (ts = 0.001 s): lower it",
        ),
        (
            json!({"bandwidth": 500, "range": [0, 150], "driver": "kpz101", "capacitance": 1e-6}),
            "a sine of 500 Hz of 71.25 V needs 220.2 kV/s, but driver and load allow 7.5 kV/s (at most 2.184 V)",
        ),
        (json!({"bandwidth": 20, "range": [0, 1], "ts": 2e-6}), "more than 200000 samples: take 1.5e-5 s or more"),
        (json!({"bandwidth": 20, "range": [0, 1], "driver": "kpz101"}), "depends on the load: give its capacitance"),
        (json!({"bandwidth": 20, "actuator": "pl14"}), "did you mean `pl140`?"),
    ] {
        let message = refusal(input.clone());
        assert!(message.contains(says), "{input}: {message}");
    }
}

#[test]
fn a_table_that_is_too_short_for_the_slowest_sine_lengthens_the_sampling_period() {
    let of = |more: Value| {
        let mut input = json!({"actuator": "pl140", "bandwidth": 40, "points": 1024, "joins": false, "cycle": 5e-5});
        input.as_object_mut().unwrap().extend(more.as_object().unwrap().clone());
        planned(input)
    };
    // Six periods of 4 Hz in 1024 samples take 1.465 ms, which is not a multiple of 50 us.
    let plan = of(json!({})).unwrap();
    assert_eq!((plan.ts, plan.drives[1].u.len() <= 1024), (0.0015, true));
    let message = plan.notes.join("\n");
    assert!(message.contains("The sampling period is 1.5 ms instead of 1 ms"), "{message}");
    assert!(message.contains("because it has at most 1024 samples"), "{message}");
    // Slower sampling of the slow drive alone, where the controller joins samples; and none where it is too short.
    assert_eq!(of(json!({"joins": true})).unwrap().ts, 0.001);
    let short = of(json!({"points": 520})).unwrap_err().to_string();
    assert!(short.contains("would have more than 520 samples"), "{short}");
}

#[test]
fn files_and_page_are_complete() {
    let plan = planned(requests()[0].clone()).unwrap();
    let files = plan.files().unwrap();
    let names: Vec<&str> = files.iter().map(|file| &*file.name).collect();
    let drives = ["small_u.csv", "rise1_u.csv", "rise2_u.csv", "rise3_u.csv", "creep_u.csv", "path_u.csv"];
    assert_eq!((names[0], &names[1..7], names[7]), ("demagnetisation_u.csv", &drives[..], "plan.md"));
    assert!(files[0].bytes.starts_with(b"t_s,u_V\n"));
    let page = files[7].text().unwrap();
    assert!(drives.iter().all(|name| page.contains(&format!("| `{name}` |"))), "{page}");
    assert!(page.contains("identify rise1.csv rise2.csv rise3.csv creep.csv --small-signal small.csv -o model.json\n"));
    assert!(page.contains("piezoid validate path.csv --model model.json\n"));
}

const TS: f64 = 1e-3;

/// A gain of 30 with a mode at 120 Hz and creep of one lag of 5 s, whose file states these standard errors.
fn model(gain_error: f64, hz_error: f64) -> Model {
    let (w, zeta) = (TAU * 120.0 * TS, 0.02);
    let modulus = f64::exp(-zeta * w);
    let a = vec![2.0 * modulus * (w * f64::sqrt(1.0 - zeta * zeta)).cos(), -modulus * modulus];
    let linear = Arx::new(TS, a.clone(), vec![0.0, 30.0 * (1.0 - a[0] - a[1])]).unwrap();
    let creep = Creep::new(TS, vec![Lag { tau_s: 5.0, gain: 0.008 }]).unwrap();
    let verdict = json!({
        "error_percent": 0.1, "measured": "free run", "noise_percent": 0.01, "u": [-30.0, 30.0], "unit": "V",
        "hz": [1.0, 10.0], "unproven": [],
    });
    let parameters = json!([
        {"name": "creep gain at 5.000 s [-]", "value": 0.008, "error": gain_error},
        {"name": "mode 1 frequency [Hz]", "value": 120.0, "error": hz_error},
        {"name": "mode 1 damping", "value": 0.02, "error": 1e-6},
    ]);
    let hysteresis = Arc::new(Proportional::new(TS, 1.0).unwrap());
    let model = Model::new(hysteresis, linear, 2.0).unwrap().with_creep(creep).unwrap();
    model.with_provenance(json!({"verdict": verdict, "parameters": parameters}))
}

fn advised(model: &Model) -> String {
    let input = json!({"range": [-30, 30], "bandwidth": 10, "driver": "pl140"});
    PlanOptions::from_json(input).unwrap().run(Some(model)).unwrap().advice.unwrap()
}

#[test]
fn an_uncertain_slow_creep_gain_needs_the_creep_record_and_an_uncertain_mode_the_small_signal() {
    let message = advised(&model(0.0047, 1e-3));
    let begin = "The creep gain at 5 s (0.008, standard error 0.0047) adds most to the error of prediction, ";
    assert!(message.starts_with(begin) && message.contains(" um rms along these drives, of "), "{message}");
    assert!(message.contains("Record creep_u.csv, which is expected to lower this to "), "{message}");
    let message = advised(&model(1e-5, 40.0));
    let begin = "The frequency of mode 1 (120 Hz, standard error 40 Hz) adds most to the error of prediction, ";
    assert!(message.starts_with(begin) && message.contains("Record small_u.csv"), "{message}");
}

#[test]
fn nothing_is_to_be_gained_where_the_error_of_the_model_is_far_larger_than_what_parameters_add() {
    let message = advised(&model(1e-9, 1e-9));
    assert!(message.starts_with("Nothing to gain by further records: the uncertainty of creep and modes adds "));
    assert!(message.contains("; the error of the model is 1.8 um rms, its noise 0.18 um."), "{message}");
}

/// The creep gain that a user was advised to measure 22 more records for: it was the largest standard error over its
/// value, and moves the displacement by a few nanometres.
#[test]
fn a_parameter_without_effect_on_the_displacement_is_no_advice() {
    let first = model(0.0047, 1e-3);
    let lags = vec![Lag { tau_s: 0.005, gain: 3.3e-5 }, Lag { tau_s: 5.0, gain: 0.008 }];
    let creep = Creep::new(TS, lags).unwrap();
    let with = |slow: f64| {
        let mut known = first.provenance().clone();
        let row = json!({"name": "creep gain at 0.005000 s [-]", "value": 3.3e-5, "error": 1.4e-4});
        known["parameters"][0]["error"] = slow.into();
        known["parameters"].as_array_mut().unwrap().push(row);
        first.clone().with_creep(creep.clone()).unwrap().with_provenance(known)
    };
    let input = json!({"range": [-30, 30], "bandwidth": 10, "driver": "pl140"});
    let plan = |model: &Model| PlanOptions::from_json(input.clone()).unwrap().run(Some(model)).unwrap();
    let certain = plan(&with(1e-5)).advice.unwrap();
    assert!(certain.starts_with("Nothing to gain"), "{certain}");
    let both = plan(&with(0.0047));
    let found = both.uncertainty.unwrap();
    let (least, most) = (found.parameters.iter().find(|p| p.value == 3.3e-5).unwrap(), &found.parameters[0]);
    assert!(least.adds < 0.01 && most.name == "creep gain at 5 s" && most.adds > 0.3, "{found:?}");
    assert!(both.advice.unwrap().starts_with("The creep gain at 5 s"));
}

/// The delta method against simulation: creep gain and frequency are drawn 200 times, the model runs free, and gain and
/// offsets are fitted to its runs.
#[test]
fn what_parameters_add_to_a_prediction_is_what_random_ones_do() {
    let model = model(0.0024, 0.3);
    let plan = planned(json!({"range": [-30, 30], "bandwidth": 10, "driver": "pl140", "ts": TS})).unwrap();
    // Of the longer ones a part, which takes less time.
    let drives: Vec<Vec<f64>> = plan.drives.iter().map(|drive| drive.u[..drive.u.len().min(8000)].to_vec()).collect();
    let known = uncertain(&model)[..2].to_vec();
    let of_drives: Vec<_> = drives.iter().map(|u| products(&model, &known, u).unwrap()).collect();
    let (each, all) = added(&known, &predicted(&of_drives));
    let run = |model: &Model| -> Vec<Vec<f64>> {
        let one = |u: &Vec<f64>| model.resume(&mut model.before(u, InitialCondition::Settled), u);
        drives.iter().map(one).map(|y| piezoid_numerics::series::centred(&y)).collect()
    };
    let (first, draws) = (run(&model), 200);
    let product = |a: &[Vec<f64>], b: &[Vec<f64>]| -> f64 {
        let mean = |(a, b): (&Vec<f64>, &Vec<f64>)| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>() / a.len() as f64;
        a.iter().zip(b).map(mean).sum::<f64>() / a.len() as f64
    };
    let normal = piezoid_testing::noise(11, 2 * draws);
    let rms = |moves: [bool; 2]| {
        let square = |k: usize| {
            let moved = known.iter().enumerate().filter(|(p, _)| moves[*p]).fold(model.clone(), |model, (p, row)| {
                row.moved(&model, row.value + row.error * normal[2 * k + p]).unwrap()
            });
            let y = run(&moved);
            let gain = product(&y, &first) / product(&first, &first);
            product(&y, &y) - gain * gain * product(&first, &first)
        };
        ((0..draws).map(square).sum::<f64>() / draws as f64).sqrt()
    };
    let found = [rms([true, false]), rms([false, true]), rms([true, true])];
    assert_close(&[each[0], each[1], all], &found, 0.15, 0.0);
    assert!(all > each[0] && each[0] > 0.0 && each[1] > 0.0, "{each:?} {all}");
}

#[test]
fn a_model_without_standard_errors_or_at_another_rate_is_refused() {
    let input = || json!({"range": [-30, 30], "bandwidth": 10});
    let refused =
        |input: Value, model: &Model| PlanOptions::from_json(input).unwrap().run(Some(model)).unwrap_err().to_string();
    let model = model(0.001, 1.0);
    assert!(refused(input(), &model.clone().with_provenance(Value::Null)).contains("states no standard error"));
    let mut other = input();
    other["ts"] = json!(2e-3);
    assert!(refused(other, &model).contains("the model is sampled every 0.001 s but the plan every 0.002 s"));
}

/// Creep behind a gain K along a sine: the lag has the amplitude A / sqrt(1 + (w tau)^2) and the phase -atan(w tau).
/// The gain explains its part in phase with y, so that the part K A w tau / (1 + (w tau)^2) at right angles remains.
#[test]
fn the_expected_standard_error_is_that_of_theory() {
    let (tau, gain, k, amplitude, hz, sigma, error) = (0.05, 1e-3, 30.0, 20.0, 4.0, 2.0, 5e-3);
    let hysteresis = Arc::new(Proportional::new(TS, 1.0).unwrap());
    let creep = Creep::new(TS, vec![Lag { tau_s: tau, gain }]).unwrap();
    let result = json!({"parameters": [{"name": "creep gain at 0.05000 s [-]", "value": gain, "error": error}]});
    let model = Model::new(hysteresis, Arx::gain(TS, k).unwrap(), 0.0).unwrap().with_creep(creep).unwrap();
    let model = model.with_provenance(result);
    let n = 20_000;
    let u: Vec<f64> = (0..n).map(|t| amplitude * (TAU * hz * TS * f64::from(t)).sin()).collect();
    let known = uncertain(&model);
    assert_eq!((known.len(), known[0].value, known[0].error), (1, gain, error));
    let found = products(&model, &known, &u).unwrap() * (f64::from(n) / (sigma * sigma));
    for records in [1, 4] {
        let wt = TAU * hz * tau;
        let slope = k * amplitude * wt / (1.0 + wt * wt);
        let of_records = f64::from(records) * f64::from(n) * slope * slope / (2.0 * sigma * sigma);
        let theory = 1.0 / (1.0 / (error * error) + of_records).sqrt();
        let after = covariance(&known, &(&found * f64::from(records))).unwrap()[(0, 0)].sqrt() * gain;
        assert_close(&[after], &[theory], 0.05, 0.0);
    }
}

#[test]
fn a_bender_is_not_planned_for_a_driver_whose_limits_are_not_about_its_middle() {
    let message = refusal(json!({"bandwidth": 20, "driver": "e-610", "actuator": "pl140"}));
    assert!(message.contains("is relative to mid-supply for the bender `pl140`"), "{message}");
    assert!(planned(json!({"bandwidth": 20, "driver": "pl140", "actuator": "pl140"})).is_ok());
}

#[test]
fn the_current_of_every_second_is_one_that_the_driver_gives_continuously() {
    let plan = planned(json!({"range": [-50, 50], "bandwidth": 50, "driver": "bd150", "capacitance": 5e-6})).unwrap();
    let limit = piezoid_records::excitation::Amplifier::find("bd150").unwrap().continuous.unwrap();
    for PlannedDrive { name, u, .. } in &plan.drives {
        let squares: Vec<f64> = u.windows(2).map(|w| (5e-6 * (w[1] - w[0]) / plan.ts).powi(2)).collect();
        let second = ((1.0 / plan.ts) as usize).min(squares.len());
        let rms = squares.windows(second).map(|w| w.iter().sum::<f64>() / second as f64).fold(0.0, f64::max).sqrt();
        assert!(rms <= 0.9 * limit * (1.0 + 1e-6), "{name}: {rms} A of {limit} A");
    }
    assert!(plan.notes.join("; ").contains("of the slew or current continuously"), "{:?}", plan.notes);
}

#[test]
fn a_low_bandwidth_shortens_the_moves_of_the_creep_record() {
    let slow = planned(json!({"range": [0, 1], "bandwidth": 0.3})).unwrap();
    assert!(slow.drives[4].u.len() as f64 * slow.ts < 60.01);
    assert!(planned(json!({"range": [0, 1], "bandwidth": 0.001, "ts": 90})).is_ok());
}

#[test]
fn a_parameter_that_others_imitate_gets_no_smaller_by_more_records() {
    let known = [uncertain(&model(f64::INFINITY, 1.0)), uncertain(&model(f64::INFINITY, 1.0))].concat();
    let same = |records: f64| nalgebra::DMatrix::from_element(known.len(), known.len(), records);
    let [few, many] = [1.0, 1e6].map(|records| covariance(&known, &same(records)).unwrap()[(0, 0)].sqrt());
    // Two are unknown, so their whole value counts, and only their sum becomes known.
    assert!(few > many && many > 0.7, "{few} {many}");
    assert_eq!(covariance(&known, &same(1e15)), None);
}
