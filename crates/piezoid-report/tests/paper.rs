//! The paper's numbers as tests of the study on the twins, and of the accuracy of the swarm.

#![allow(clippy::expect_used, clippy::panic)] // a test may stop at what must not happen

use piezoid::excitation::{Prbs, SteppedSine};
use piezoid::linear::{self, Orders};
use piezoid::optimize::swarm::{self, GlobalBest};
use piezoid::plant::{Plant, Preset};
use piezoid::progress::Stage;
use piezoid::{Error, Record};
use piezoid_report::study::{self, METHODS, Study, TestSignal};
use serde_json::Value;
use std::ops::ControlFlow;
use std::sync::LazyLock;

/// Sampling period of the study [s].
const TS: f64 = 5e-4;

fn run(plant: &str, seed: u64) -> Study {
    Study::run(Preset::find(plant).expect("a preset"), seed, &mut Stage::ignore).expect("a study of it")
}

static PAPER: LazyLock<Study> = LazyLock::new(|| run("paper", 1));
static PL140: LazyLock<Study> = LazyLock::new(|| run("pl140", 1));

/// Mean squared error [mm^2] and rms error in % of peak-to-peak.
fn errors(study: &Study, method: &str, hz: f64) -> (f64, f64) {
    let frequency = study.frequencies.iter().find(|f| f.hz == hz).expect("a frequency of the study");
    let row = frequency.row(method).expect("a method of the study");
    (row.metrics.mse, row.metrics.rms_pp_percent)
}

#[test]
fn every_estimator_finds_the_pole_of_table_2() {
    assert_eq!(PAPER.blocks.len(), 5);
    for block in &PAPER.blocks {
        let poles = block.arx.poles();
        assert_eq!(poles.len(), 1, "{}: one pair", block.name);
        assert!((poles[0].hz - 146.7).abs() <= 1.0, "{}: {} Hz", block.name, poles[0].hz);
        assert!((poles[0].damping - 0.061).abs() <= 0.005, "{}: damping {}", block.name, poles[0].damping);
    }
}

#[test]
fn the_error_of_the_rule_as_printed_matches_table_1_at_all_four_frequencies() {
    for (hz, printed) in Study::PRINTED_MSE {
        let ((mse, _), (held, _)) = (errors(&PAPER, "printed-rule", hz), errors(&PAPER, "held-direction", hz));
        assert!((mse / printed - 1.0).abs() <= 0.2, "{mse} mm^2 at {hz} Hz, {printed} in Table 1");
        assert!(held <= 5e-5, "{held} mm^2 at {hz} Hz with the direction held");
    }
}

#[test]
fn the_test_signal_of_the_study_is_the_closest_to_table_1() {
    let (first, last) = (TestSignal::STEPS.start(), TestSignal::STEPS.end());
    assert_eq!((*first, *last, PAPER.test_signals.len()), (4, 40, 2 * 37));
    let signal = TestSignal::nearest(&PAPER.test_signals, "printed-rule").expect("a test signal");
    assert_eq!((signal.form, signal.steps), ("stepped-sine", Study::STEPS_USED));
    assert_eq!(Study::STEPS_USED, SteppedSine::default().steps);
    for method in ["printed-rule", "held-direction", "table2-arx"] {
        let study = Study::PRINTED_MSE.map(|(hz, _)| errors(&PAPER, method, hz).0);
        assert_eq!(signal.of(method), study, "the same signal gives the same errors");
    }
    // The number of steps matters: with 20 the error falls with frequency.
    let twenty = PAPER.test_signals.iter().find(|s| s.form == "stepped-sine" && s.steps == 20).expect("20 steps");
    let [slow, .., fast] = twenty.of("printed-rule");
    assert!(fast < 0.5 * slow, "{slow} mm^2 at 5 Hz, {fast} at 80 Hz");
}

#[test]
fn with_the_branch_above_as_upper_branch_the_error_grows_for_most_test_signals() {
    let grows = |method: &str| PAPER.test_signals.iter().filter(|s| s.of(method)[3] > 1.5 * s.of(method)[0]).count();
    let [upper, printed] = [TestSignal::UPPER_RULE, "printed-rule"].map(grows);
    assert!(upper > 60 && printed < 15, "{upper} {printed}");
    let within = |method: &str| PAPER.test_signals.iter().filter(|s| s.deviation(method) <= 0.2).count();
    let [upper, printed] = [TestSignal::UPPER_RULE, "printed-rule"].map(within);
    assert!(upper > 5 && printed == 1, "{upper} {printed}");
    // The reading of the study, with its own test signal, is the closest.
    let upper = TestSignal::nearest(&PAPER.test_signals, TestSignal::UPPER_RULE).expect("a test signal");
    let used = TestSignal::nearest(&PAPER.test_signals, "printed-rule").expect("a test signal");
    assert!(used.deviation("printed-rule") < upper.deviation(TestSignal::UPPER_RULE));
}

#[test]
fn with_the_direction_held_errors_stay_small_up_to_above_the_resonance() {
    for hz in [5.0, 20.0, 40.0, 80.0] {
        let (mse, _) = errors(&PAPER, "held-direction", hz);
        assert!(mse <= 0.001, "{mse} mm^2 at {hz} Hz");
    }
    assert_eq!(Study::FREQUENCIES[Study::FREQUENCIES.len() - 1], 250.0);
    for hz in Study::FREQUENCIES {
        let (_, percent) = errors(&PAPER, "held-direction", hz);
        assert!(percent <= 2.0, "{percent} % of peak-to-peak at {hz} Hz");
    }
}

#[test]
fn the_error_grows_with_frequency_as_in_the_paper_without_the_block_of_its_table_2() {
    let growth = |method| errors(&PAPER, method, 80.0).0 / errors(&PAPER, method, 5.0).0;
    let printed = Study::PRINTED_MSE[3].1 / Study::PRINTED_MSE[0].1;
    assert!((growth("printed-rule") / printed - 1.0).abs() < 0.2, "{} times", growth("printed-rule"));
    for (hz, printed) in Study::PRINTED_MSE {
        let (mse, _) = errors(&PAPER, "table2-arx", hz);
        assert!(mse > 5.0 * printed, "error with Table 2's block: {mse} mm^2 at {hz} Hz");
    }
    let signal = TestSignal::nearest(&PAPER.test_signals, "table2-arx").expect("a test signal");
    assert!(signal.deviation("table2-arx") > 0.4, "{} with Table 2's block", signal.words());
    let width = |hz: f64| {
        let f = PAPER.frequencies.iter().find(|f| f.hz == hz).expect("a frequency of the study");
        [&f.own, &f.by_table_2].map(|l| l.found.branches.width().abs())
    };
    let ([own_5, _], [own_80, printed_80]) = (width(5.0), width(80.0));
    assert!((own_80 / own_5 - 1.0).abs() < 0.1, "the twin's loop is {own_5} and {own_80} wide");
    assert!(printed_80 > 3.0 * own_80, "Table 2 makes it {printed_80} wide");
}

#[test]
fn one_joint_model_predicts_new_frequencies_better_than_branches_made_for_each() {
    assert_eq!(PAPER.joint.model.hysteresis().operator().name, "bouc-wen", "the twin's own law is found");
    for hz in Study::FREQUENCIES {
        let (_, percent) = errors(&PAPER, "joint", hz);
        assert!(percent <= 1e-4, "{percent} % of peak-to-peak at {hz} Hz");
    }
    assert!(PL140.joint.model.driver().is_some() && PAPER.joint.model.driver().is_none());
    // The steps reach the driver's current limit, at 250 Hz all of the time: it is given, but a sample has one mean
    // voltage.
    for (hz, most, share) in Study::FREQUENCIES.map(|hz| if hz < 250.0 { (hz, 0.6, 0.06) } else { (hz, 5.5, 0.7) }) {
        let ((_, joint), (_, held)) = (errors(&PL140, "joint", hz), errors(&PL140, "held-direction", hz));
        assert!(joint <= most && joint <= share * held, "{joint} % of peak-to-peak at {hz} Hz, beside {held}");
    }
}

#[test]
fn the_loop_of_the_joint_model_has_the_same_width_at_all_frequencies_of_one_amplitude() {
    let width = |f: &study::Frequency| f.joint.found.branches.width();
    let [first, rest @ ..] = PAPER.frequencies.as_slice() else { panic!("no frequencies") };
    for f in rest.iter().filter(|f| f.amplitude == first.amplitude) {
        // With fewer samples per period the averages on a branch are coarser.
        assert!((width(f) / width(first) - 1.0).abs() < 0.05, "{} Hz: {} and {}", f.hz, width(f), width(first));
    }
}

#[test]
fn an_unstable_causal_inverse_is_noted_with_its_zeros() {
    let swarm = &PL140.blocks[1];
    assert_eq!(swarm.name, "swarm");
    let note = PL140.notes.iter().find(|n| n.contains("no stable causal inverse"));
    assert_eq!(note.is_some(), swarm.arx.inverse().is_err(), "{:?}", PL140.notes);
    // The modes of the bender above the Nyquist frequency move a zero out of the unit circle, so the note must exist.
    let note = note.expect("a note");
    for zero in swarm.arx.zeros() {
        assert!(note.contains(&zero.to_string()), "{note} does not name {zero}");
    }
    assert!(!PAPER.notes.iter().any(|n| n.contains("inverse")), "{:?}", PAPER.notes);
}

/// Fails on a null, the JSON form of a number that is not finite, except for columns that do not apply to a row.
fn assert_whole(value: &Value, path: &str) {
    match value {
        Value::Null => {
            let applies = !path.ends_with(".printed_mse")
                && !(["table2[0].", "table2[4]."].iter().any(|row| path.contains(row))
                    && (path.contains(".residual_") || path.ends_with(".offset")))
                && !path.ends_with(".refused");
            assert!(!applies, "{path} is null");
        }
        Value::Array(list) => list.iter().enumerate().for_each(|(k, v)| assert_whole(v, &format!("{path}[{k}]"))),
        Value::Object(map) => map.iter().for_each(|(k, v)| assert_whole(v, &format!("{path}.{k}"))),
        _ => {}
    }
}

#[test]
fn every_number_of_both_studies_is_finite_in_tables_figures_and_page() {
    for study in [&*PAPER, &*PL140] {
        let document = Study::to_json(std::slice::from_ref(study));
        assert_whole(&document["studies"][0], study.plant.name);
        let runs = study.frequencies.iter().flat_map(|f| f.rows.iter().flat_map(|r| &r.simulated).chain(f.test.y()));
        assert!(runs.chain(&study.convergence).all(|v| v.is_finite()));
        let page = Study::page(std::slice::from_ref(study)).html();
        let figures = study.figures().into_iter().map(|(name, figure)| (name, figure.svg()));
        for (name, text) in figures.chain([("page".to_string(), page)]) {
            // Without the scripts at the end of the page.
            let text = text.split("<script>").next().unwrap_or_default();
            let words = text.split(|c: char| !c.is_alphanumeric());
            let wrong = words.into_iter().find(|w| matches!(*w, "NaN" | "nan" | "inf" | "Infinity"));
            assert_eq!(wrong, None, "{} of {}", name, study.plant.name);
        }
    }
}

#[test]
fn the_document_has_the_tables_that_scripts_rely_on() {
    let document = Study::to_json(&[PAPER.clone(), PL140.clone()]);
    let rows = |table: &str| document[table].as_array().expect("a list").clone();
    assert_eq!(rows("table1").len(), 2 * Study::FREQUENCIES.len() * METHODS.len());
    for row in rows("table1") {
        assert!(row["method"].is_string() && row["plant"].is_string(), "{row}");
        for key in ["frequency_hz", "mse", "nrmse_percent", "rms_pp_percent", "loop_width_percent"] {
            assert!(row[key].is_f64(), "{key} of {row}");
        }
    }
    for method in ["printed-rule", "held-direction", "linear", "table2-arx", "joint"] {
        assert!(rows("table1").iter().any(|row| row["method"] == method), "{method}");
    }
    let estimators: Vec<Value> = rows("table2").iter().map(|row| row["estimator"].clone()).collect();
    assert_eq!(estimators[..5], ["printed", "swarm", "least-absolute", "least-squares", "printed-80hz"]);
    assert_eq!(estimators[5..], estimators[..5]);
    for row in rows("table2") {
        assert!(row["poles"][0]["hz"].is_f64() && row["poles"][0]["damping"].is_f64(), "{row}");
        assert!(row["zeros"][0]["re"].is_f64() && row["zeros"][0]["im"].is_f64(), "{row}");
        assert_eq!((row["a"].as_array().map(Vec::len), row["b"].as_array().map(Vec::len)), (Some(2), Some(3)));
    }
    let signals = document["studies"][0]["test_signals"].as_array().expect("a list").clone();
    assert_eq!(signals.len(), 2 * 37 * 4);
    for row in signals {
        assert!(row["form"].is_string() && row["method"].is_string() && row["steps"].is_u64(), "{row}");
        assert!(row["mse"].as_array().is_some_and(|mse| mse.len() == 4) && row["deviation_percent"].is_f64(), "{row}");
    }
    let convergence: Vec<f64> = rows("convergence").iter().filter_map(Value::as_f64).collect();
    assert_eq!(convergence, PAPER.convergence);
    assert_eq!(convergence.len(), 501, "the start and the paper's 500 iterations");
    assert!(convergence.windows(2).all(|w| w[1] <= w[0]));
}

#[test]
fn the_same_seed_gives_the_same_bytes_and_another_seed_others() {
    let (first, again) = ([PAPER.clone(), PL140.clone()], [run("paper", 1), run("pl140", 1)]);
    let json = |studies: &[Study]| serde_json::to_string_pretty(&Study::to_json(studies)).expect("a document");
    assert!(json(&first) == json(&again), "the documents differ");
    assert!(Study::page(&first).html() == Study::page(&again).html(), "the pages differ");
    assert!(json(&first) != json(&[run("paper", 2), first[1].clone()]), "the seed changes nothing");
}

#[test]
fn a_study_can_be_cancelled_at_any_stage() {
    let stages = [("swarm", 0), ("swarm", 77), ("one model", 0), ("one model", 2), ("loops", 3), ("test signal", 1)];
    for (stage, at) in stages {
        let mut observed = 0;
        let mut stop = |s: Stage| {
            let here = s.what.contains(stage) && s.done >= at;
            assert!(observed == 0, "called again after cancellation");
            observed += usize::from(here);
            if here { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        };
        match Study::run(Preset::find("paper").expect("a preset"), 1, &mut stop) {
            Err(Error::Cancelled { done, total, .. }) => assert!(done == at && total > at, "{done} of {total}"),
            other => panic!("{stage} {at}: {:?}", other.map(|s| s.notes)),
        }
    }
}

/// The swarm on the paper's small-signal record with twenty seeds, compared with the exact optimum of linear
/// programming.
///
/// On the plant of the paper, whose record has no noise, about one seed in fifty ends further above the optimum (the
/// worst of 400: 1.4e-6). The worst of these twenty, seed 16, ends at 1.06e-6.
#[track_caller]
fn swarm_meets_the_optimum(plant: &str) {
    let u = Prbs { order: 12, amplitude: 1.0, ..Default::default() }.samples(TS, 4095).expect("a PRBS");
    let y = Plant::named(plant, TS).expect("a plant").run(&u).y;
    let record = [Record::new(TS, u, y.iter().map(|y| 1e-3 * y).collect()).expect("a record")];
    let cost = |estimator, seed, global_best| {
        let settings = swarm::SwarmSettings { seed, global_best, ..swarm::SwarmSettings::default() };
        let estimator = linear::Estimator::find(estimator).expect("an estimator");
        estimator.fit(&record, Orders::of(2), &settings, &mut Stage::ignore).expect("a fit").residuals.sum_abs
    };
    let optimum = cost("least-absolute", 1, GlobalBest::Ever);
    for global_best in [GlobalBest::Ever, GlobalBest::Current] {
        let above: Vec<f64> = (1..=20).map(|seed| cost("swarm", seed, global_best) / optimum - 1.0).collect();
        let met = above.iter().all(|above| (-1e-9..=1.1e-6).contains(above));
        assert!(met, "{plant}, {global_best:?}: {above:?} above {optimum} mm");
    }
}

#[test]
fn the_figures_in_the_documentation_are_those_of_the_study() {
    let figures = PAPER.figures();
    let places = |svg: &str| {
        let numbers = svg.split(|c: char| !(c.is_ascii_digit() || c == '.' || c == '-'));
        numbers.filter_map(|word| word.parse::<f64>().ok()).collect::<Vec<f64>>()
    };
    for (name, kept) in [
        ("paper-error", include_str!("../../../docs/error.svg")),
        ("paper-test-signal", include_str!("../../../docs/test_signal.svg")),
        ("paper-deviation", include_str!("../../../docs/deviation.svg")),
    ] {
        let (_, drawn) = figures.iter().find(|(drawn, _)| drawn == name).expect("the figure");
        let (kept, drawn) = (places(kept), places(&drawn.svg()));
        // The last digits of the search may differ between machines, and move a point by a tenth.
        let alike = kept.iter().zip(&drawn).all(|(k, d)| (k - d).abs() <= 0.2 + 1e-2 * d.abs());
        assert!(kept.len() == drawn.len() && alike, "{name}: draw docs/ again with `cargo xtask generate docs`");
    }
}

#[test]
fn the_swarm_meets_the_least_absolute_optimum_on_the_papers_plant() {
    swarm_meets_the_optimum("paper");
}

#[test]
fn the_swarm_meets_the_least_absolute_optimum_on_the_pl140() {
    swarm_meets_the_optimum("pl140");
}
