//! How an identification went, in its report: the reasons for its choices, its remarks, and the course of its search.

use crate::each::Each;
use crate::page::{Section, sentence};
use crate::plot::{Axes, Axis, Figure, Role, Series};
use piezoid::Identification;
use piezoid_numerics::number::short;

/// The section; `None` if there is nothing to tell.
pub(super) fn section(result: &Identification) -> Option<Section> {
    let found = &result.found;
    let history = found.linear.fit.as_ref().map(|fit| &fit.history[..]).filter(|history| history.len() > 1);
    let reasons: Vec<String> = found.reasons.iter().map(|reason| sentence(reason)).collect();
    let section = Section::new("The identification")
        .each((!reasons.is_empty()).then_some(reasons), Section::list)
        .each(&found.notes, |section, note| section.note("Note", sentence(note)))
        .each(history, |section, history| section.figure(convergence(history)));
    (history.is_some() || !found.remarks().is_empty()).then_some(section)
}

/// The cost by iteration.
fn convergence(history: &[f64]) -> Figure {
    let iterations: Vec<f64> = (0..history.len()).map(|k| k as f64).collect();
    let n = history.len() - 1;
    let [first, last] = [history[0], history[n]].map(short);
    let caption = format!("The cost of the linear block falls from {first} to {last} in {n} iterations.");
    let positive = history.iter().all(|cost| *cost > 0.0);
    let cost = if positive { Axis::log("cost") } else { Axis::new("cost") };
    let panel = Axes::new("iteration", cost).height(0.7).with(Series::line(&iterations, history).role(Role::Model));
    Figure::new("Convergence", caption).panel(panel)
}

#[cfg(test)]
mod tests {
    use crate::report::identification;
    use piezoid::excitation::Prbs;
    use piezoid::progress::Stage;
    use piezoid::{IdentifyOptions, Method, Record, Records};

    #[test]
    fn the_report_of_an_identification_tells_its_training_and_its_search() {
        let u = Prbs::default().samples(1e-3, 1500).unwrap();
        let noise = |t: usize| 0.01 * (((t * t) % 97) as f64 - 48.0);
        let mut level = 0.0;
        let mut lag = |u: &f64| {
            level += 0.3 * (u - level);
            level
        };
        let y = u.iter().enumerate().map(|(t, u)| 3.0 * lag(u) + noise(t)).collect();
        let record = Record::new(1e-3, u, y).unwrap();
        let swarm =
            IdentifyOptions { method: Method::Paper, operator: "proportional".into(), ..IdentifyOptions::default() };
        let (records, names) = (std::slice::from_ref(&record), ["small <1>", "large"]);
        let records = Records { small_signal: records, large_signal: records };
        let result =
            swarm.identify_and_validate(records, &names, ("piezoid identify", &[]), &mut Stage::ignore).unwrap();
        let html = identification(&result).html();
        for text in ["Training records", "The identification", "Convergence", "piezoid identify", " large</h2>"] {
            assert!(html.contains(text), "{text}");
        }
        assert!(!html.contains("Validation"));
        assert_eq!(html.matches(" of stroke (free run on the training records only").count(), 1, "the verdict once");
        assert_eq!(html, identification(&result).html());
    }
}
