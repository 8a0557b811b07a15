//! What is done with a model from a file that may be hostile: by the fuzzer, and by the library's tests.

use piezoid::compensation::{Causal, FeedForward, FeedForwardSettings};
use piezoid::{Model, Record, System, Validate};

/// Uses a model in every way of the library. Values may become infinite or NaN; nothing may panic or run on.
pub(super) fn use_it(model: &Model) {
    let ends = model.known_inputs().unwrap_or((-30.0, 30.0));
    let u: Vec<f64> = (0..48).map(|t| ends.0 + (ends.1 - ends.0) * (0.5 + 0.5 * (0.3 * f64::from(t)).sin())).collect();
    let y = model.simulate(&u);
    assert_eq!(y.len(), u.len());
    let _ = (model.settled(u[0]), model.predict(&u, &y), model.effort(), model.program());
    assert_eq!(Model::from_json(&model.to_json()).map(|again| again.to_json()), Ok(model.to_json()));
    let plain: Vec<f64> = (0..48).map(|t| 25.0 * (0.3 * f64::from(t)).sin()).collect();
    if let Ok(record) = Record::new(model.ts(), plain.clone(), plain.clone()) {
        let _ = model.validate(&record);
    }
    // The zeros of a block of order 500 take a second, at each of these.
    for (clip, delay_samples) in [(false, *Causal::delays(model).start()), (true, 20)] {
        let settings = FeedForwardSettings { clip, iterations: 1, ..Default::default() };
        let _ = FeedForward::new(model, settings).map(|inverse| (inverse.whole(&y), inverse.whole(&plain)));
        let far = [f64::NAN, f64::MAX, 1e300, f64::NEG_INFINITY, f64::MIN, -1e-300];
        let _ = Causal::new(model, settings, delay_samples).map(|causal| {
            let mut x = causal.settled_with_preview(plain[0], &plain[..9]);
            (causal.simulate(&plain), causal.resume(&mut x, &[&far[..], &plain].concat()), causal.settled(f64::NAN))
        });
    }
}
