//! The study as a document for scripts.

use super::{Frequency, RISING, Study, StudyBlock, StudyRow, TestSignal};
use piezoid::hammerstein::OperatorTrial;
use serde_json::{Map, Value, json};

impl Study {
    /// The studies as one document: `table1`, `table2` over all plants, `convergence` of the first, and each study
    /// under `studies`. Numbers that are not finite are null.
    pub fn to_json(studies: &[Study]) -> Value {
        let all = |table: &dyn Fn(&Study) -> Vec<Value>| studies.iter().flat_map(table).collect::<Vec<_>>();
        let each = |s: &Study| {
            json!({
                "plant": s.plant.name,
                "table1": table1(s),
                "table2": table2(s),
                "convergence": s.convergence,
                "convergence_as_printed": s.convergence_as_printed,
                "optimum": s.optimum,
                "noise_gain": s.noise_gain,
                "joint": joint(s),
                "test_signals": s.test_signals.iter().flat_map(test_signal).collect::<Vec<_>>(),
                "verdict": s.verdict(),
                "notes": s.notes,
            })
        };
        json!({
            "table1": all(&table1),
            "table2": all(&table2),
            "convergence": studies.first().map(|s| &s.convergence),
            "studies": studies.iter().map(each).collect::<Vec<_>>(),
        })
    }
}

fn table1(study: &Study) -> Vec<Value> {
    let row = |f: &Frequency, r: &StudyRow| {
        json!({
            "plant": study.plant.name,
            "frequency_hz": f.hz,
            "method": r.method,
            "amplitude_v": f.amplitude,
            "mse": r.metrics.mse,
            "nrmse_percent": r.metrics.nrmse_percent,
            "rms_pp_percent": r.metrics.rms_pp_percent,
            "loop_width_percent": r.loop_width_percent,
            "printed_mse": Study::PRINTED_MSE.iter().find(|(hz, _)| *hz == f.hz).map(|(_, mse)| mse),
        })
    };
    study.frequencies.iter().flat_map(|f| f.rows.iter().map(move |r| row(f, r))).collect()
}

/// One row per method: errors at the frequencies of Table 1.
fn test_signal(signal: &TestSignal) -> impl Iterator<Item = Value> {
    let row = |(method, mse): &(&str, [f64; 4])| {
        json!({
            "form": signal.form,
            "steps": signal.steps,
            "method": method,
            "mse": mse,
            "deviation_percent": 100.0 * signal.deviation(method),
        })
    };
    signal.mse.iter().map(row)
}

fn table2(study: &Study) -> Vec<Value> {
    let row = |b: &StudyBlock| {
        json!({
            "plant": study.plant.name,
            "estimator": b.name,
            "a": b.arx.a(),
            "b": b.arx.b(),
            "poles": b.arx.poles(),
            "zeros": b.arx.zeros(),
            "dc_gain": b.arx.dc_gain(),
            "inverse_is_stable": b.arx.inverse().is_ok(),
            "residual_sum_abs": b.fit.as_ref().map(|f| f.residuals.sum_abs),
            "residual_rms": b.fit.as_ref().map(|f| f.residuals.rms),
            "offset": b.fit.as_ref().map(|f| f.offsets[0]),
        })
    };
    study.blocks.iter().map(row).collect()
}

fn joint(study: &Study) -> Value {
    let trial = |t: &OperatorTrial| {
        let mut document = json!(t);
        document["shape"] =
            t.shape.iter().map(|&(name, value)| (name.to_string(), value.into())).collect::<Map<_, _>>().into();
        document
    };
    let model = &study.joint.model;
    json!({
        "operator": model.hysteresis().operator().name,
        "training_hz": RISING,
        "creep": model.creep().lags(),
        "a": model.linear().a(),
        "b": model.linear().b(),
        "offset": model.offset(),
        "trials": study.joint.trials.iter().map(trial).collect::<Vec<_>>(),
        "notes": study.joint.notes,
    })
}
