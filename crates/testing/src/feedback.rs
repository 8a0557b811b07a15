//! Models of mechanics with hysteresis in feedback: one of each kind.

use serde_json::{Value, json};

/// Sampling period [s].
const TS: f64 = 5e-4;

/// Names and model files. Their first resonance is at 160 Hz, and +-40 V hold about +-40 um:
///
/// - `guided`: Bouc-Wen friction that the displacement drives, a held input;
/// - `bender`: a Preisach operator that vibration drives too, behind a driver; a mode that softens, a second one,
///   creep, a curved sensor with a delay;
/// - `loaded`: plays that input and displacement drive, creep, a curved sensor, a second mode, a direct path;
/// - `stiffened`: plays that vibration drives too, a mode that stiffens;
/// - `filtered`: Bouc-Wen hysteresis that the displacement drives too, a band-limited input.
pub fn in_feedback() -> Vec<(&'static str, Value)> {
    let mode = json!({
        "hz": 160.0, "damping": 0.03, "input": 0.0, "hysteretic": 0.9, "sensed": -0.02, "softening": 0.0,
    });
    let with = |changes: &[(&str, f64)]| {
        let mut mode = mode.clone();
        changes.iter().for_each(|(name, value)| mode[name] = json!(value));
        mode
    };
    let driver = json!({"driven": {"lag_s": 1e-4, "slew": 1e5}});
    let creep = json!([{"tau_s": 0.02, "gain": 0.05}, {"tau_s": 1.0, "gain": 0.04}]);
    let guided = json!({"modes": [with(&[("input", 1.5), ("hysteretic", -0.4), ("sensed", 1.0)])], "sensed": 0.0});
    let bender = json!({
        "modes": [with(&[("softening", 1e-3)]), with(&[("hz", 900.0), ("hysteretic", 0.07)])],
        "intersample": driver, "delay": 1, "senses_vibration": true, "direct": [0.0, 0.03], "creep": creep,
        "curve": 1e-4, "offset": 3.0,
    });
    let loaded = json!({
        "modes": [mode, with(&[("hz", 700.0), ("damping", 0.05), ("hysteretic", 0.05), ("sensed", 0.01)])],
        "direct": [0.0, 0.02], "creep": creep, "curve": -2e-4, "offset": -4.0,
    });
    let stiffened = json!({"modes": [with(&[("softening", -3e-3)])], "senses_vibration": true});
    let filtered = json!({"modes": [mode], "intersample": "band-limited", "delay": 2});
    vec![
        ("guided", model(&bouc_wen(), guided)),
        ("bender", model(&preisach(), bender)),
        ("loaded", model(&plays(), loaded)),
        ("stiffened", model(&plays(), stiffened)),
        ("filtered", model(&bouc_wen(), filtered)),
    ]
}

/// A model file; its blocks in series are a gain.
fn model(hysteresis: &Value, changes: Value) -> Value {
    let mut dynamics = json!({
        "substeps": 20, "intersample": "held", "delay": 0, "modes": [], "sensed": 1.0, "senses_vibration": false,
        "direct": [0.0, 0.0], "creep": [], "curve": 0.0, "offset": 0.0,
    });
    let changes = changes.as_object().cloned().unwrap_or_default();
    changes.into_iter().for_each(|(name, value)| dynamics[name] = value);
    json!({
        "piezoid": 1, "ts": TS, "units": {"u": "V", "y": "um"}, "offset": dynamics["offset"],
        "hysteresis": {"operator": "proportional", "gain": 1.0}, "linear": {"a": [], "b": [1.0]},
        "feedback": {"hysteresis": hysteresis, "dynamics": dynamics},
        "identified": {"u": [-40.0, 40.0], "hz": [1.0, 300.0], "slew": 6e4, "mean": [0.0, 0.0]},
    })
}

fn bouc_wen() -> Value {
    json!({
        "operator": "bouc-wen", "range": [-30.0, 30.0], "beta": 0.02, "gamma_over_beta": 0.25, "weights": [1.0, 0.3],
    })
}

fn plays() -> Value {
    json!({
        "operator": "prandtl-ishlinskii", "range": [-30.0, 30.0], "thresholds": [3.0, 6.0, 12.0, 18.0],
        "weights": [0.8, 0.08, 0.08, 0.08, 0.08],
    })
}

fn preisach() -> Value {
    let levels: Vec<f64> = (-5..=5).map(|k| 10.0 * f64::from(k)).collect();
    let weights: Vec<f64> = (0..55).map(|k| 0.25 + 0.02 * f64::from(k % 4)).collect();
    json!({
        "operator": "preisach", "range": [-30.0, 30.0], "levels": levels, "slope": 0.8, "reversible": vec![8.0; 10],
        "weights": weights,
    })
}
