//! What the study found, in words.

use super::figures::FLOOR;
use super::{AMPLITUDE, Frequency, METHODS, RISING, Study, TS, TestSignal};
use piezoid::plant::Saturation;
use piezoid_models::hammerstein::HiddenLoop;
use piezoid_numerics::number::join;
use piezoid_numerics::series::ends;

/// Four decimals as in the paper's Table 1, or one digit with its power of ten below them.
pub(super) fn mse(x: f64) -> String {
    if x < 1e-4 { format!("{x:.0e}") } else { format!("{x:.4}") }
}

/// Two decimals, or one digit with its power of ten below them.
pub(super) fn percent(x: f64) -> String {
    if x != 0.0 && x < 5e-3 { format!("{x:.0e}") } else { format!("{x:.2}") }
}

impl Study {
    /// The conclusions from the errors of a study, in paragraphs with an empty line between them.
    pub fn verdict(&self) -> String {
        paragraphs(self).join("\n\n")
    }
}

/// Beside the paper's Table 1; by another reading; over all frequencies; of the joint model.
pub(super) fn paragraphs(study: &Study) -> [String; 4] {
    [against_table_1(study), by_upper_rule(study), over_frequencies(study), joint(study)]
}

fn error(f: &Frequency, method: &str) -> f64 {
    f.row(method).map_or(f64::NAN, |r| r.metrics.mse)
}

/// The frequencies of which this is so: "5, 20 and 40".
fn at_hz(study: &Study, is: impl Fn(&Frequency) -> bool) -> Option<String> {
    let some: Vec<f64> = study.frequencies.iter().filter(|f| is(f)).map(|f| f.hz).collect();
    (!some.is_empty()).then(|| join(&some))
}

/// What the methods leave at all frequencies, and what the paper reports beyond its Table 1.
fn over_frequencies(study: &Study) -> String {
    let rms = |method: &str| {
        let of = |f: &Frequency| f.row(method).map_or(f64::NAN, |r| r.metrics.rms_pp_percent);
        let all = study.frequencies.iter().map(|f| (of(f), f.hz));
        all.fold((0.0, 0.0), |worst: (f64, f64), x| if x.0 > worst.0 { x } else { worst })
    };
    let [(worst, worst_hz), (linear, _)] = ["held-direction", "linear"].map(rms);
    let needless = at_hz(study, |f| error(f, "linear") < error(f, "printed-rule"))
        .map_or(String::new(), |hz| format!(" At {hz} Hz its error is smaller than that of the rule as printed."));
    let other = |f: &Frequency, method: &str| 1.01 * error(f, method) < error(f, "held-direction");
    let beaten = METHODS.iter().filter(|method| method.name != "joint").filter_map(|method| {
        let hz = at_hz(study, |f| other(f, method.name))?;
        Some(format!(" At {hz} Hz the error of `{}` is smaller than with the direction held.", method.name))
    });
    let beaten: String = beaten.collect();
    let width = |f: &Frequency| 100.0 * f.own.found.branches.width().abs();
    let widest = study.frequencies.iter().max_by(|f, g| width(f).total_cmp(&width(g)));
    let of = |f: &Frequency| (f.hz, width(f));
    let ends = study.frequencies.first().map(of).zip(widest.map(of));
    let grown = ends.filter(|((_, narrow), (_, wide))| *wide > 2.0 * narrow);
    let grown = grown.map_or(String::new(), |((lowest, narrow), (hz, wide))| {
        format!(
            " With the estimated block the width of the loop of the hidden variable z is {wide:.0} % of its height at \
             {hz} Hz, and {narrow:.0} % at {lowest} Hz: at the former frequency the branches also contain the error of \
             the block, and would be wrong for another signal."
        )
    });
    let beyond: Vec<&Frequency> = study.frequencies.iter().filter(|f| f.hz > 80.0).collect();
    let listed = |words: &dyn Fn(&Frequency) -> String| join(&beyond.iter().map(|f| words(f)).collect::<Vec<_>>());
    let turned = |found: fn(&Frequency) -> &HiddenLoop| {
        let inverted = at_hz(study, |f| found(f).found.branches.width() < 0.0);
        inverted.map_or("no frequency".into(), |hz| format!("{hz} Hz"))
    };
    let (printed, hz) = (listed(&|f| mse(error(f, "printed-rule"))), listed(&|f| f.hz.to_string()));
    let (own, by_table_2) = (turned(|f| &f.own), turned(|f| &f.by_table_2));
    format!(
        "For `held-direction` the error is largest at {worst_hz} Hz: {worst:.2} % of peak-to-peak (rms). The error of \
         a model without hysteresis is up to {linear:.1} %.{needless}{beaten}{grown} The paper reports an error that \
         grows rapidly beyond 80 Hz, and an inverted loop above the resonance. Here the error of the rule as printed \
         is {printed} mm² at {hz} Hz. The loop is inverted (the ascending branch lies above) at {own} with the \
         estimated block, and at {by_table_2} with the block of the paper's Table 2."
    )
}

/// The paper's Table 1 beside the errors with the test signal of the study.
fn against_table_1(study: &Study) -> String {
    let at =
        |method: &str, hz: f64| study.frequencies.iter().find(|f| f.hz == hz).map_or(f64::NAN, |f| error(f, method));
    let of = |method: &str| Study::PRINTED_MSE.map(|(hz, _)| at(method, hz));
    let over = |method: &str| Study::PRINTED_MSE.map(|(hz, printed)| at(method, hz) / printed);
    let (printed, hz) = (Study::PRINTED_MSE.map(|(_, mse)| mse), Study::PRINTED_MSE.map(|(hz, _)| hz));
    let (least, most) = ends(over("table2-arx"));
    let by_its_own = TestSignal::nearest(&study.test_signals, "table2-arx").map_or(String::new(), |s| {
        let (signal, off) = (s.words(), 100.0 * s.deviation("table2-arx"));
        format!("; with the test signal that suits that block best, a {signal}, the error deviates from Table 1 by up to {off:.0} %")
    });
    let [here, paper] = [of("printed-rule"), printed].map(|errors| join(&errors.map(mse)));
    let [grows, paper_grows] = [of("printed-rule"), printed].map(|[first, .., last]| last / first);
    let held = mse(of("held-direction").into_iter().fold(0.0, f64::max));
    let (hz, chosen, used) = (join(&hz), chosen(study), Study::STEPS_USED);
    format!(
        "The paper states neither the form nor the number of steps of its test signal. {chosen} With a stepped sine of \
         {used} steps, and a linear block that is estimated here, the error of the rule as printed is {here} mm² at {hz} \
         Hz; the paper's Table 1 has {paper}. The error at 80 Hz is {grows:.1} times the error at 5 Hz; in the paper, \
         {paper_grows:.1} times. For `held-direction` (a held voltage keeps its direction) the error is at most {held} \
         mm² at these four frequencies. With the linear block of the paper's Table 2 the error of the rule as printed \
         is {least:.0} to {most:.0} times the paper's{by_its_own}."
    )
}

/// Which test signal is used, and which comes nearest to the paper's Table 1.
fn chosen(study: &Study) -> String {
    let percent = |signal: &TestSignal| format!("{:.0} %", 100.0 * signal.deviation("printed-rule"));
    let used = study.test_signals.iter().find(|s| s.form == "stepped-sine" && s.steps == Study::STEPS_USED);
    let (Some(nearest), Some(used)) = (TestSignal::nearest(&study.test_signals, "printed-rule"), used) else {
        return String::new();
    };
    let (low, high) = (TestSignal::STEPS.start(), TestSignal::STEPS.end());
    let tried = format!("stepped sines of {low} to {high} steps per period and staircases of {low} to {high} levels");
    let (name, off) = (used.words(), percent(used));
    if nearest == used {
        return format!(
            "Among {tried}, the {name} comes nearest to the paper's Table 1 (within {off}), and is used here."
        );
    }
    let (nearest, least) = (nearest.words(), percent(nearest));
    format!(
        "A {name} is used here, because it comes nearest to Table 1 on the twin `paper`. On this twin it deviates by up \
         to {off}; of {tried}, a {nearest} comes nearest, and deviates by up to {least}."
    )
}

/// The errors with the other interpretation of the rule: its "upper" branch is the one that lies above.
fn by_upper_rule(study: &Study) -> String {
    let Some(signal) = TestSignal::nearest(&study.test_signals, TestSignal::UPPER_RULE) else { return String::new() };
    let within = |method: &str| study.test_signals.iter().filter(|s| s.deviation(method) <= NEAR).count();
    let (name, errors) = (signal.words(), join(&signal.of(TestSignal::UPPER_RULE).map(mse)));
    let [off, near] = [signal.deviation(TestSignal::UPPER_RULE), NEAR].map(|share| 100.0 * share);
    let [upper, printed] = [TestSignal::UPPER_RULE, "printed-rule"].map(within);
    let all = study.test_signals.len();
    format!(
        "The paper's rule reads its \"upper\" branch while the voltage rises. Here that is the ascending branch, which \
         on a piezo loop lies below. If the branch that lies above is taken instead, a {name} comes nearest to the \
         paper's Table 1: its errors are {errors} mm² and deviate by up to {off:.0} %. With that choice, {upper} of {all} \
         test signals come within {near:.0} % of Table 1; with the choice used here, {printed}."
    )
}

/// A deviation from Table 1 that counts as near, as a share.
const NEAR: f64 = 0.3;

/// What the figure of Table 1 over the test signal shows, and how much the steps matter at the highest frequency.
pub(super) fn over_test_signals(study: &Study) -> String {
    let stepped = study.test_signals.iter().filter(|s| s.form == "stepped-sine");
    let last = Study::PRINTED_MSE.len() - 1;
    let by = |p: &(f64, u32), q: &(f64, u32)| p.0.total_cmp(&q.0);
    let errors: Vec<(f64, u32)> = stepped.map(|s| (s.of("printed-rule")[last], s.steps)).collect();
    let (Some(least), Some(most)) = (errors.iter().copied().min_by(by), errors.iter().copied().max_by(by)) else {
        return String::new();
    };
    let (hz, used) = (Study::PRINTED_MSE[last].0, Study::STEPS_USED);
    let (most, few) = (mse(most.0), most.1);
    let (least, many) = (mse(least.0), least.1);
    let samples = 1.0 / (hz * TS);
    format!(
        "Mean squared error at the paper's four frequencies. Solid: sines in steps of equal length, against steps per \
         period; dashed: staircases, steps of equal height, against levels; the horizontal line is the paper's value. \
         Errors below {FLOOR:e} mm² are drawn at {FLOOR:e} mm². With the rule as printed, the error at {hz} Hz falls \
         from {most} mm² with {few} steps to {least} with {many}; a period there has {samples:.0} samples, so that with \
         as many steps or more no sample is held. The rest of the study uses {used} steps."
    )
}

/// What Tables 1 and 2 leave open of their units.
pub(super) fn units(study: &Study) -> String {
    let moved = study.blocks[0].arx.dc_gain() * AMPLITUDE;
    format!(
        "The paper states the unit of neither of its tables. Its Table 1 is taken in mm², its Table 2 in mm/V. By the \
         static gain of Table 2 {AMPLITUDE} V move the tip by {moved:.3} mm, where the catalogue has 1 mm. A sine of \
         that height has a mean square of {:.4} mm², less than every value of Table 1: with {AMPLITUDE} V, the two tables can hardly both be in mm.",
        0.5 * moved * moved
    )
}

/// An error [% of peak-to-peak] that no record with noise would leave.
const EXACT: f64 = 1e-4;

/// What the joint model gains, and where it does not.
fn joint(study: &Study) -> String {
    let rms = |f: &Frequency, method: &str| f.row(method).map_or(f64::NAN, |r| r.metrics.rms_pp_percent);
    let (better, worse): (Vec<&Frequency>, Vec<&Frequency>) =
        study.frequencies.iter().partition(|f| rms(f, "joint") < rms(f, "held-direction"));
    let listed = |some: &[&Frequency]| {
        let hz: Vec<String> = some.iter().map(|f| f.hz.to_string()).collect();
        let (least, most) = ends(some.iter().map(|f| rms(f, "joint")));
        let worst = some.iter().find(|f| rms(f, "joint") == most).map_or(f64::NAN, |f| f.hz);
        let several = format!("{} to {} % of peak-to-peak (rms), largest at {worst} Hz", percent(least), percent(most));
        (hz.join(", "), if some.len() > 1 { several } else { format!("{} % of peak-to-peak (rms)", percent(most)) })
    };
    let rising: Vec<String> = RISING.iter().map(f64::to_string).collect();
    let (operator, rising) = (study.joint.model.hysteresis().operator().name, rising.join(", "));
    let mut words = format!(
        "The joint model, {operator} identified once on rising sines of {rising} Hz, is used at all frequencies."
    );
    if !better.is_empty() {
        let (hz, range) = listed(&better);
        let place = if worse.is_empty() { "At every frequency".into() } else { format!("At {hz} Hz") };
        words += &format!(
            " {place} its error, {range}, is smaller than that of the branches identified at that frequency. The joint \
             method does not invert the linear block. Therefore the block may have as many modes as the records show. \
             The joint model also describes minor loops. This test contains none."
        );
    }
    if better.iter().any(|f| rms(f, "joint") < EXACT) {
        words += " The error is this small because this twin follows exactly that operator and has no noise, unlike \
                  any measured actuator.";
    }
    if !worse.is_empty() {
        let (hz, range) = listed(&worse);
        words += &format!(
            " At {hz} Hz its error, {range}, is larger than that of the branches identified at that frequency."
        );
    }
    if study.joint.model.driver().is_some() {
        words += " The lag and the current limit of the driver are given to it; the other methods do not use them.";
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
        (!records.is_empty())
            .then(|| format!("{what} in these records (number of samples in brackets): {}.", records.join(", ")))
    };
    kinds.iter().filter_map(sentence).collect()
}

/// Four decimals as in the paper's Table 2, without a sign on what rounds to zero.
pub(super) fn four_decimals(x: f64) -> String {
    let text = format!("{x:.4}");
    if text == "-0.0000" { "0.0000".into() } else { text }
}
