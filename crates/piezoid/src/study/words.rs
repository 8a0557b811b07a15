//! What the study found, in words.

use super::{Frequency, PRINTED_MSE, Study};
use crate::plant::Saturation;

/// Four decimals as in the paper's Table 1, or one digit with its power of ten below them.
pub(super) fn mse(x: f64) -> String {
    if x < 1e-4 { format!("{x:.0e}") } else { format!("{x:.4}") }
}

/// What the errors of a study say, in words.
pub fn verdict(study: &Study) -> String {
    let at = |method: &str, hz: f64| {
        study.frequencies.iter().find(|f| f.hz == hz).and_then(|f| f.row(method)).map_or(f64::NAN, |r| r.metrics.mse)
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
    let beaten: Vec<String> = study
        .frequencies
        .iter()
        .filter(|f| f.rows.iter().any(|r| 1.01 * r.metrics.mse < at("held-direction", f.hz)))
        .map(|f| f.hz.to_string())
        .collect();
    let beaten = match beaten.as_slice() {
        [] => String::new(),
        some => format!(" At {} Hz another method leaves less than the direction held.", some.join(", ")),
    };
    let width = |f: &Frequency| 100.0 * f.own.found.branches.width().abs();
    let widest = study.frequencies.iter().max_by(|f, g| width(f).total_cmp(&width(g)));
    let grown = widest.filter(|f| width(f) > 2.0 * width(&study.frequencies[0])).map_or(String::new(), |f| {
        format!(
            " By the estimated block the loop of z grows to {:.0} % of its height at {} Hz, where at {} Hz it is {:.0} %: most of that is \
             the block's own error, which the branches of one frequency take up and no other signal would.",
            width(f),
            f.hz,
            study.frequencies[0].hz,
            width(&study.frequencies[0])
        )
    });
    format!(
        "At 5 Hz the rule as printed leaves {} mm², beside {:.4} in the paper; holding the direction leaves {}. At 80 Hz the rule as printed \
         leaves {}, beside {:.4}: here its error does not grow with frequency, since fewer samples are held. With the linear block of the \
         paper's Table 2 the error grows from {:.3} mm² at 5 Hz to {most:.3} at {most_hz} Hz; the paper's grows too, and the growth comes \
         with that block. With the direction held the worst frequency is {worst_hz} Hz, with {worst:.2} % rms of peak-to-peak; a model \
         without hysteresis leaves up to {linear:.1} %.{beaten}{grown}",
        mse(at("printed-rule", 5.0)),
        PRINTED_MSE[0].1,
        mse(at("held-direction", 5.0)),
        mse(at("printed-rule", 80.0)),
        PRINTED_MSE[3].1,
        at("table2-arx", 5.0),
    )
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

/// Four decimals as in the paper's Table 2, without a sign on what rounds to zero.
pub fn four_decimals(x: f64) -> String {
    let text = format!("{x:.4}");
    if text == "-0.0000" { "0.0000".into() } else { text }
}
