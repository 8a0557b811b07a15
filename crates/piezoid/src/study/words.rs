//! What the study found, in words.

use super::{Frequency, PRINTED_MSE, RISING, Study};
use crate::plant::Saturation;

/// Four decimals as in the paper's Table 1, or one digit with its power of ten below them.
pub(super) fn mse(x: f64) -> String {
    if x < 1e-4 { format!("{x:.0e}") } else { format!("{x:.4}") }
}

/// Two decimals, or one digit with its power of ten below them.
pub(super) fn percent(x: f64) -> String {
    if x != 0.0 && x < 5e-3 { format!("{x:.0e}") } else { format!("{x:.2}") }
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
    let [(worst, worst_hz), (linear, _)] = ["held-direction", "linear"].map(rms);
    let of_table_2 = PRINTED_MSE.iter().map(|(hz, _)| (at("table2-arx", *hz), *hz));
    let (most, most_hz) = of_table_2.fold((0.0, 0.0), |most: (f64, f64), x| if x.0 > most.0 { x } else { most });
    let beaten: Vec<String> = study
        .frequencies
        .iter()
        .filter(|f| f.rows.iter().any(|r| r.method != "joint" && 1.01 * r.metrics.mse < at("held-direction", f.hz)))
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
         without hysteresis leaves up to {linear:.1} %.{beaten}{grown} {}",
        mse(at("printed-rule", 5.0)),
        PRINTED_MSE[0].1,
        mse(at("held-direction", 5.0)),
        mse(at("printed-rule", 80.0)),
        PRINTED_MSE[3].1,
        at("table2-arx", 5.0),
        joint(study)
    )
}

/// An error [% of peak-to-peak] that no record with noise would leave.
const EXACT: f64 = 1e-4;

/// What the joint model gains, and where it does not.
fn joint(study: &Study) -> String {
    let error = |f: &Frequency, method: &str| f.row(method).map_or(f64::NAN, |r| r.metrics.rms_pp_percent);
    let (better, worse): (Vec<&Frequency>, Vec<&Frequency>) =
        study.frequencies.iter().partition(|f| error(f, "joint") < error(f, "held-direction"));
    let listed = |some: &[&Frequency]| {
        let hz: Vec<String> = some.iter().map(|f| f.hz.to_string()).collect();
        let errors = some.iter().map(|f| error(f, "joint"));
        let (least, most) = errors.fold((f64::INFINITY, 0.0f64), |(low, high), e| (low.min(e), high.max(e)));
        let range = if some.len() > 1 { format!("{} to {}", percent(least), percent(most)) } else { percent(most) };
        (hz.join(", "), range)
    };
    let rising: Vec<String> = RISING.iter().map(f64::to_string).collect();
    let mut words = format!(
        "The joint model, {} identified once on rising sines of {} Hz, serves all frequencies.",
        study.joint.model.hysteresis().operator().name,
        rising.join(", ")
    );
    if !better.is_empty() {
        let (hz, range) = listed(&better);
        let place = if worse.is_empty() { "At every frequency".into() } else { format!("At {hz} Hz") };
        words += &format!(
            " {place} it leaves less than the branches made for that one alone, {range} % rms of peak-to-peak: it remembers where the \
             voltage has turned, and since it inverts nothing its linear block may have as many modes as the records show."
        );
    }
    if better.iter().any(|f| error(f, "joint") < EXACT) {
        words += " So little is left because this twin obeys that operator and has no noise; nothing measured does.";
    }
    if !worse.is_empty() {
        let (hz, range) = listed(&worse);
        words += &format!(" At {hz} Hz it leaves {range} %, more than the branches made for that frequency.");
    }
    if study.joint.model.driver().is_some() {
        words += " Lag and current limit of the driver were given to it; branches of one frequency have them in their shape.";
    }
    words
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
