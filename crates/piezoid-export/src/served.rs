//! Which target serves which hysteresis operator. The rows of [`TARGETS`](super::TARGETS) state it, because trying
//! takes seconds; a test tries every operator with every target.
//!
//! Not checked: parameters of a model that exceed the numbers of a target, such as an offset of 1e5 strokes in fixed
//! point.

use super::ExportTarget;
use piezoid::error::Error;
use piezoid::hysteresis::{OPERATORS, Operator};

/// Part of an export: the model as code.
pub const MODEL: &str = "model";
/// Part of an export: the inverse of the model as code, or the voltages for a reference.
pub const FEED_FORWARD: &str = "feed-forward";

impl ExportTarget {
    /// What the target makes for an operator: [`MODEL`], [`FEED_FORWARD`], both, or nothing.
    pub fn serves(&self, operator: &Operator) -> &'static [&'static str] {
        if self.refuses.contains(&operator.name) { &[] } else { self.makes }
    }

    /// The list, in the syntax of `identify`, without the operators that the target does not support.
    ///
    /// # Errors
    /// Returns an error with the supported operators if the list names an unsupported one, or leaves none.
    pub fn operators(&self, list: &str) -> Result<String, Error> {
        let refused: Vec<&str> =
            Operator::list(list)?.iter().map(|o| o.name).filter(|name| self.refuses.contains(name)).collect();
        if refused.is_empty() {
            return Ok(list.into());
        }
        let known = OPERATORS.iter().filter(|o| !self.serves(o).is_empty()).map(|o| o.name).collect::<Vec<_>>();
        let rule = |what: String| {
            let rule = format!("{what} the export target {}: choose among {}", self.name, known.join(", "));
            Error::parameter("operator", list, rule)
        };
        let named = list.split(',').filter_map(|name| Operator::find(name).ok()).find(|o| refused.contains(&o.name));
        if let Some(operator) = named {
            return Err(rule(format!("{} is not served by", operator.name)));
        }
        let rest = refused.iter().fold(list.to_string(), |list, name| list + ",-" + name);
        Operator::list(&rest).map(|_| rest).map_err(|_| rule("no operator is left for".into()))
    }
}

#[cfg(test)]
mod tests {
    use super::super::{ExportRequest, TARGETS};
    use super::*;
    use piezoid::Model;
    use piezoid::compensation::FeedForwardSettings;
    use piezoid::excitation::Limits;
    use piezoid::linear::Arx;
    use piezoid::system::System;
    use piezoid_numerics::series::ends;

    /// What the export of the example of an operator makes.
    fn makes(target: &ExportTarget, operator: &Operator) -> Vec<&'static str> {
        let block = Arx::new(5e-4, vec![1.7424, -0.9453], vec![0.0, 0.1, 0.1029]).unwrap();
        let model = Model::new((operator.example)(5e-4).unwrap(), block, 0.0).unwrap();
        let wave = |t: i32| (std::f64::consts::TAU / 40.0 * f64::from(t)).cos();
        let u: Vec<f64> = (0..120).map(|t| 20.0 * wave(t)).collect();
        let (low, high) = ends(model.simulate(&u)[80..].iter().copied());
        let r: Vec<f64> = (0..40).map(|t| 0.5 * (low + high) + 0.4 * (high - low) * wave(t)).collect();
        let reference = target.takes.contains(&"reference").then_some(&r[..]);
        let limits = Limits { low: Some(-30.0), high: Some(30.0), ..Limits::default() };
        let settings = FeedForwardSettings { limits, ..FeedForwardSettings::default() };
        let Ok(result) = (target.make)(&ExportRequest { reference, settings, ..ExportRequest::new(&model, "m") })
        else {
            return Vec::new();
        };
        let has = |step: &str| result.functions.iter().any(|function| function.name == step);
        let parts = [(has("step"), MODEL), (has("ff_step") || reference.is_some(), FEED_FORWARD)];
        parts.into_iter().filter_map(|(there, part)| there.then_some(part)).collect()
    }

    #[test]
    fn every_target_makes_what_its_row_states_for_every_operator() {
        for target in TARGETS {
            // Fixed point takes seconds; `tests/export/fixed.rs` of the command line exports every operator.
            let quick = |o: &&&Operator| target.name != "fixed" || ["preisach", "stop"].contains(&o.name);
            for operator in OPERATORS.iter().filter(quick) {
                assert_eq!(target.serves(operator), makes(target, operator), "{} {}", target.name, operator.name);
            }
            assert_eq!(target.operators("auto,-stop").unwrap(), "auto,-stop");
        }
    }

    #[test]
    fn what_a_target_refuses_is_left_out_of_auto_and_an_error_by_name() {
        let target =
            ExportTarget { name: "tiny", refuses: &["preisach", "duhem"], ..*ExportTarget::find("c").unwrap() };
        assert_eq!(target.operators("auto,-preisach").unwrap(), "auto,-preisach,-duhem");
        assert_eq!(target.operators("stop,dahl").unwrap(), "stop,dahl");
        for (list, says) in [
            (
                "stop, preisach",
                "operator = stop, preisach: preisach is not served by the export target tiny: choose among",
            ),
            ("Duhem", "duhem is not served by the export target tiny: choose among proportional, two-branch"),
            ("stopp", "did you mean `stop`"),
        ] {
            let error = target.operators(list).unwrap_err().to_string();
            assert!(error.contains(says), "{error}");
        }
        let all_but = OPERATORS.iter().filter(|o| o.name != "duhem").fold("auto".to_string(), |s, o| s + ",-" + o.name);
        let error = target.operators(&all_but).unwrap_err().to_string();
        assert!(error.contains("no operator is left for the export target tiny"), "{error}");
    }
}
