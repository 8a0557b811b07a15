//! What a search reports while it goes on, and what is left of one that is cancelled.

use super::*;

/// A record of small signals, and three of large ones.
fn records() -> ([Record; 1], Vec<Record>) {
    let plant = plant(5e-4, 1);
    ([prbs(&plant)], large_signal(&plant, 0.3, &[(11.0, 0.0), (29.0, 0.0), (61.0, 0.0)]))
}

#[test]
fn a_cancelled_identification_ends_at_every_stage_with_the_best_model_until_then() {
    let (small, large_signal) = records();
    for small in [&small[..], &[]] {
        let calls = |last: usize| {
            let mut calls = 0;
            let mut count = |_: Stage| {
                calls += 1;
                if calls > last { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
            };
            let found = identify_joint(small, &large_signal, &named("dahl"), &mut count);
            (found, calls)
        };
        let (whole, all) = calls(usize::MAX);
        let whole = whole.unwrap();
        assert!(whole.cancelled.is_none() && all > 5, "{all}");
        assert!(matches!(calls(0), (Err(Error::Cancelled { .. }), 1)));
        for last in [all / 2, all - 1] {
            let (best, observed) = calls(last);
            let best = best.unwrap();
            assert_eq!((observed, best.trials.len()), (last + 1, 1));
            assert!(best.trials[0].error_percent >= 0.99 * whole.trials[0].error_percent, "{:?}", best.trials);
            let stage = best.cancelled_in().unwrap();
            assert!(best.notes.iter().any(|note| note.contains("cancelled in the stage") && note.contains(stage)));
        }
    }
}

#[test]
fn each_finished_operator_hands_out_its_model_and_a_cancelled_search_ends_with_the_best_of_them() {
    let (small, large_signal) = records();
    let names = ["bouc-wen", "dahl", "prandtl-ishlinskii"];
    let handed_out = |last: usize| {
        let (mut models, mut best) = (std::collections::BTreeMap::new(), None);
        let found = identify_joint(&small, &large_signal, &named(&names.join(",")), &mut |stage| {
            if let Some(model) = stage.model.map(|text| Model::from_json(text).unwrap()) {
                best = if stage.best { Some(model.clone()) } else { best.take() };
                let errors: Vec<f64> = stage
                    .figures
                    .iter()
                    .filter(|(name, _)| *name == "error_percent")
                    .map(|(_, value)| *value)
                    .collect();
                if stage.what == "linear block" {
                    assert!(stage.best && stage.figures.is_empty());
                } else {
                    assert_eq!(model.hysteresis().operator().name, stage.what);
                    assert_eq!(stage.figures[0].0, "held_out_percent");
                    models.entry(stage.what.to_string()).or_insert_with(Vec::new).extend(errors);
                }
            }
            if models.values().flatten().count() >= last { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        });
        (found.unwrap(), models, best.unwrap())
    };
    let same = |found: &Identified, best: &Model| {
        let parts = |model: &Model| (model.hysteresis().params(), model.linear().clone(), model.offset());
        assert_eq!(parts(&found.model), parts(best));
    };
    let (whole, models, best) = handed_out(usize::MAX);
    assert_eq!(models.keys().collect::<Vec<_>>(), names);
    for trial in &whole.trials {
        assert_eq!(models[trial.operator].last(), Some(&trial.error_percent), "{trial:?}");
    }
    same(&whole, &best);
    // The fits in all parameters come one after the other.
    for last in 1..=3 {
        let (found, _, best) = handed_out(last);
        assert!(found.cancelled.is_some());
        same(&found, &best);
    }
}

/// The linear block, each operator with it held, then with other shapes, then with all parameters.
#[test]
fn progress_counts_each_fit_of_each_operator() {
    let (small, large_signal) = records();
    let (mut done, mut whole) = (Vec::new(), Vec::new());
    let mut count = |stage: Stage| {
        assert_eq!(stage.total, 10);
        if stage.model.is_some() {
            done.push(stage.done);
        }
        if stage.figures.iter().any(|(name, _)| *name == "error_percent") {
            whole.push(stage.done);
        }
        ControlFlow::Continue(())
    };
    identify_joint(&small, &large_signal, &named("bouc-wen,dahl,prandtl-ishlinskii"), &mut count).unwrap();
    done.dedup();
    whole.dedup();
    assert_eq!((done, whole), ((0..10).collect(), vec![7, 8, 9]));
}
