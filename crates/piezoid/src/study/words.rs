//! What the study found, in words.

use super::{Frequency, PRINTED_MSE, Study};
use crate::linear::{self, Fit, Orders};
use crate::optimize::swarm;
use crate::plant::Saturation;
use crate::progress::unwatched;
use crate::record::Record;

/// Four decimals as in the paper's Table 1, or one digit with its power of ten below them.
pub(super) fn mse(x: f64) -> String {
    if x < 1e-4 { format!("{x:.0e}") } else { format!("{x:.4}") }
}

/// What the errors of a study say, in words.
pub fn verdict(study: &Study) -> String {
    let at = |method: &str, hz: f64| {
        study.frequencies.iter().find(|f| f.hz == hz).and_then(|f| f.row(method)).map_or(f64::NAN, |r| r.mse)
    };
    let rms = |method: &str| {
        let of = |f: &Frequency| f.row(method).map_or(f64::NAN, |r| r.metrics.rms_pp_percent);
        study
            .frequencies
            .iter()
            .map(|f| (of(f), f.hz))
            .fold((0.0, 0.0), |worst: (f64, f64), x| if x.0 > worst.0 { x } else { worst })
    };
    let ((worst, worst_hz), (linear, _)) = (rms("held-direction"), rms("linear"));
    let of_table_2 = PRINTED_MSE.iter().map(|(hz, _)| (at("table2-arx", *hz), *hz));
    let (most, most_hz) = of_table_2.fold((0.0, 0.0), |most: (f64, f64), x| if x.0 > most.0 { x } else { most });
    format!(
        "At 5 Hz the rule as printed leaves {} mm², beside {:.4} in the paper; holding the direction leaves {}. With the linear block \
         of Table 2 the error grows from {:.3} mm² at 5 Hz to {most:.3} at {most_hz} Hz; the paper's grows too, and the growth comes \
         with that block. With the direction held the worst frequency is {worst_hz} Hz, with {worst:.2} % rms of peak-to-peak; a model \
         without hysteresis leaves up to {linear:.1} %.",
        mse(at("printed-rule", 5.0)),
        PRINTED_MSE[0].1,
        mse(at("held-direction", 5.0)),
        at("table2-arx", 5.0),
    )
}

/// What a block of twice the order says, where the paper's order 2 leaves a visible part of the record unexplained.
pub(super) fn second_mode(small_signal: &Record, second_order: &Fit) -> Option<String> {
    let power: f64 = small_signal.y().iter().map(|y| y * y).sum();
    let left = second_order.residuals.rms / (power / small_signal.len() as f64).sqrt();
    let squares = linear::estimator("least-squares").ok()?;
    let records = std::slice::from_ref(small_signal);
    let fit = linear::fit(records, Orders::of(4), squares, &swarm::Settings::default(), &mut unwatched).ok()?;
    let times = second_order.residuals.rms / fit.residuals.rms;
    let sharpest =
        fit.arx.poles().into_iter().filter(|p| p.z.im > 0.0).min_by(|p, q| p.damping.total_cmp(&q.damping))?;
    (left > 0.02 && times > 2.0).then(|| {
        format!(
            "Order 2 has room for one mode and leaves {:.0} % of this record's rms in prediction; order 4 predicts {times:.0} times as \
             well and puts the resonance at {:.1} Hz with damping {:.3}. Modes above half the sampling rate, as every bender has, fold back below it, \
             and the paper's block has to bend to them.",
            100.0 * left,
            sharpest.hz,
            sharpest.damping
        )
    })
}

/// The records in which a limit of the plant was reached, one sentence a limit.
pub(super) fn limits_in_words(limits: &[(String, Saturation)]) -> Vec<String> {
    type Count = fn(&Saturation) -> usize;
    let kinds: [(&str, Count); 3] = [
        ("The driver clamped its voltage", |s| s.clamped),
        ("The driver's current limit was reached", |s| s.current_limited),
        ("The sensor was driven out of its range", |s| s.sensor_clipped),
    ];
    let sentence = |(what, count): &(&str, Count)| {
        let hit = limits.iter().filter(|(_, s)| count(s) > 0);
        let records: Vec<String> = hit.map(|(record, s)| format!("{record} ({})", count(s))).collect();
        (!records.is_empty()).then(|| format!("{what} in these records (samples): {}.", records.join(", ")))
    };
    kinds.iter().filter_map(sentence).collect()
}
