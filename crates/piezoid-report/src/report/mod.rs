//! The reports: on a model and its validation, block by block, on several models, and on control schemes.

mod certificate;
mod comparison;
mod creep;
mod cycles;
mod errors;
mod feedback;
mod hysteresis;
mod identification;
mod linear;
mod loops;
mod model;
mod origin;
mod record;
mod residuals;
mod tracking;

pub use certificate::certificate;
#[cfg(test)]
pub(crate) use certificate::tests::example as example_certificate;
pub(crate) use certificate::{METHOD, STATEMENT};
pub use comparison::{comparison, leaderboard};
pub use tracking::tracking;

use crate::each::Each;
use crate::page::{Fact, Page, PageTable, Section, sentence};
use piezoid::validation::{Floor, Metrics};
use piezoid::{Identification, Model, StatedVerdict, System, Verdict};
use piezoid_numerics::number::short;
use piezoid_verbs::{Compared, Validated};

/// The report on a model: one self-contained file.
pub fn report(model: &Model, validated: &Validated) -> Page {
    page(model, "Validation", validated.verdict(model).as_ref(), validated, None)
}

/// The report on a model and its training records, as it was identified.
pub fn identification(result: &Identification) -> Page {
    let training = Validated { files: result.training.clone() };
    let section = identification::section(result);
    page(&result.found.model, "Training records", result.found.model.verdict().as_ref(), &training, section)
}

fn page(model: &Model, records: &str, verdict: Option<&Verdict>, validated: &Validated, more: Option<Section>) -> Page {
    let trials = &validated.files[..];
    let operator = model.hysteresis().operator();
    let block = match model.linear().a().len() {
        0 => "a gain without dynamics".into(),
        n => format!("linear block of order {n}"),
    };
    let validation = (!trials.is_empty()).then(|| validation(records, verdict, validated));
    let (title, subtitle) = match model.feedback() {
        Some(_) => ("Hysteresis in feedback", model.to_string()),
        None => {
            let blocks = format!("{} hysteresis, {block}, sampled every {}\u{a0}s", operator.name, model.ts());
            ("Hammerstein model", blocks)
        }
    };
    Page::new(title)
        .subtitle(subtitle)
        .each(validation.into_iter().chain(more), Page::section)
        .each(trials.iter().map(|trial| record::section(trial, trials.len() == 1)), Page::section)
        .section(model::section(model, trials))
        .each(origin::section(model, verdict), Page::section)
}

fn validation(title: &str, verdict: Option<&Verdict>, validated: &Validated) -> Section {
    let (trials, total) = (&validated.files[..], validated.total());
    let unit = &trials[0].record.units().y;
    let table = PageTable::new("Free run and measurement").text("record").number("samples");
    let table = table.number(format!("rms error [{unit}]")).number(format!("largest [{unit}]"));
    let table = table.number("NRMSE [%]").number("of it noise [%]");
    let table = table.number("rms / peak-to-peak [%]").number("fit [%]");
    let row = |name: &str, m: &Metrics, floor: Option<Floor>| {
        let noise = floor.map_or("-".into(), |f| short(f.nrmse_percent));
        let [rmse, max, nrmse, share, fit] =
            [m.rmse, m.max_abs, m.nrmse_percent, m.rms_pp_percent, m.fit_percent].map(short);
        [name.to_string(), m.n.to_string(), rmse, max, nrmse, noise, share, fit]
    };
    let each = |t: &Compared| row(t.short(), &t.validation.metrics, t.validation.floor);
    let table = table
        .rows(trials.iter().map(each))
        .rows((trials.len() > 1).then(|| row("total", &total, validated.floor())))
        .note("Free run: the model uses the input only, never the measured output.");
    let section = Section::new(title)
        .each(verdict, |section, verdict| section.text(sentence(&verdict.to_string())))
        .facts([
            Fact::new(short(total.nrmse_percent), "%", "NRMSE: rms error over standard deviation of y"),
            Fact::new(short(total.rms_pp_percent), "%", "rms error over peak-to-peak of y"),
            Fact::new(short(total.max_abs), unit.clone(), "largest error"),
        ])
        .table(table)
        .each(validated.summary(), |section, summary| section.text(sentence(&summary)));
    let section = errors::by_all(section, trials);
    let open = validated.not_covered();
    if open.is_empty() { section } else { section.text("Not tested by these records:").list(open) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid::feedback::{FeedbackDynamics, FeedbackMode, FeedbackModel};
    use piezoid::hysteresis::OPERATORS;
    use piezoid::linear::Arx;
    use piezoid::{Record, Validate};
    use serde_json::json;

    const NONE: Validated = Validated { files: Vec::new() };

    #[test]
    fn every_operator_has_a_reproducible_report() {
        for o in OPERATORS {
            let model = Model::new((o.example)(5e-4).unwrap(), Arx::gain(5e-4, 2.0).unwrap(), 0.0).unwrap();
            let u: Vec<f64> = (0..900).map(|t| 12.0 * (f64::from(t) * 0.05).sin() + 1.0).collect();
            let record = Record::new(5e-4, u.clone(), model.simulate(&u)).unwrap();
            let validation = model.validate(&record).unwrap();
            let trials = Validated { files: vec![Compared::new("runs/a<b.csv".into(), record, validation)] };
            let html = report(&model, &trials).html();
            assert_eq!(html, report(&model, &trials).html());
            assert!(html.contains("a&lt;b.csv"));
            assert_eq!(html.matches(" % NRMSE").count(), 1, "the error of the only record in one sentence, once");
            assert_eq!(html.contains("has no minor loops"), !o.minor_loops, "{}", o.name);
            assert_eq!(html.contains("Loops of the hysteresis block"), o.name != "proportional", "{}", o.name);
            assert_eq!(html.contains("is rate-dependent"), !o.rate_independent, "{}", o.name);
            assert!(html.contains("Parameters of the hysteresis block"), "{}", o.name);
        }
    }

    #[test]
    fn errors_and_remarks_are_in_tables_and_figures() {
        let hysteresis = (piezoid::hysteresis::Operator::find("proportional").unwrap().example)(5e-4).unwrap();
        let beam = Arx::new(5e-4, vec![1.7424, -0.9453], vec![3.4, 3.3]).unwrap();
        let model = Model::new(hysteresis, beam, 0.0).unwrap();
        let wave = |hz: f64| (0..4000).map(move |t| 9.0 * (std::f64::consts::TAU * hz * f64::from(t) * 5e-4).sin());
        let records = [5.0, 20.0].map(|hz| {
            let u: Vec<f64> = wave(hz).collect();
            let y = model.simulate(&u).iter().enumerate().map(|(t, y)| y + f64::from((t * t % 7) as u8)).collect();
            Record::new(5e-4, u, y).unwrap()
        });
        let model = model.with_identified(piezoid::hammerstein::Domain::of(&records[..1]).unwrap());
        let compared = |record: Record| Compared::new("r.csv".into(), record.clone(), model.validate(&record).unwrap());
        let trials = Validated { files: records.into_iter().map(compared).collect() };
        let html = report(&model, &trials).html();
        for text in [
            "Good to ",
            "Error by frequency",
            "Loops, measured and model",
            "<details>\n<summary>Tests of the residuals</summary>",
            "with itself",
            "over the input",
            "this is the noise floor",
            "of it noise [%]",
            "NRMSE, of which noise",
            "the resonance at 146.7 Hz",
            "Identified on inputs from",
            "The input changes by up to",
        ] {
            assert!(html.contains(text), "{text}");
        }
        assert!(!html.contains("Error by amplitude"), "one amplitude repeats the overall figures");
    }

    #[test]
    fn loops_are_seen_one_by_one_and_errors_are_joined_within_a_frequency() {
        let hysteresis = (piezoid::hysteresis::Operator::find("dahl").unwrap().example)(5e-4).unwrap();
        let units = piezoid::Units { u: "V".into(), y: "um".into() };
        let model = Model::new(hysteresis, Arx::gain(5e-4, 2.0).unwrap(), 0.0).unwrap().with_units(units.clone());
        let compared = |frequency: f64| {
            let rising = piezoid::excitation::RisingSine { amplitude: 9.0, frequency, ..Default::default() };
            let u = rising.samples(5e-4, 4000).unwrap();
            let y = model.simulate(&u).iter().enumerate().map(|(t, y)| y + 0.1 * (t as f64).sin()).collect();
            let record = Record::new(5e-4, u, y).unwrap().with_units(units.clone());
            Compared::new("r.csv".into(), record.clone(), model.validate(&record).unwrap())
        };
        let html = report(&model, &Validated { files: [20.0, 40.0].map(compared).into() }).html();
        for text in ["Drawn are 3 of 38 cycles", "y − line [µm]", "over 8 of 7"] {
            assert!(html.contains(text), "{text}");
        }
        assert!([">20.", ">40."].iter().all(|hz| html.contains(hz)) && html.matches(" Hz</text>").count() == 2);
        assert!(!html.contains("um]") && !html.contains(" um"), "units as people read them");
    }

    fn beam() -> Model {
        let hysteresis = (piezoid::hysteresis::Operator::find("dahl").unwrap().example)(5e-4).unwrap();
        Model::new(hysteresis, Arx::new(5e-4, vec![1.7424, -0.9453], vec![3.4, 3.3]).unwrap(), 0.0).unwrap()
    }

    #[test]
    fn the_entries_of_identify_are_shown_if_there_are_any() {
        let bare = report(&beam(), &NONE).html();
        assert!(!bare.contains("Operators tried") && !bare.contains("How it was identified"));
        let result = json!({
            "command": "piezoid identify <here>",
            "trials": [
                {"operator": "stop", "parameters": 30, "held_out_percent": null, "verdict": "refused", "refused": "no \
                    & why"},
                {"operator": "duhem", "parameters": 9, "held_out_percent": 0.5, "error_percent": 0.5, "verdict": "as good"},
                {"operator": "dahl", "parameters": 2, "held_out_percent": 0.25, "error_percent": 0.25, "verdict": "taken"},
            ],
            "parameters": [{"name": "mode 1 damping", "value": 0.03, "error": null}],
        });
        let html = report(&beam().with_provenance(result), &NONE).html();
        let at = |text: &str| html.find(text).unwrap_or_else(|| panic!("{text}"));
        assert!(at("0.2500") < at("as good") && at("as good") < at("no &amp; why"), "the best first");
        assert!(at("taken") < at("as good"));
        at("mode 1 damping</td><td class=\"num\">0.03000</td><td class=\"num\">-</td>");
        at("piezoid identify &lt;here&gt;");
        // Other entries do no harm.
        let odd = json!({"trials": [7, {"operator": []}], "parameters": "none"});
        assert!(report(&beam().with_provenance(odd), &NONE).html().contains("Operators tried"));
    }

    #[test]
    fn hysteresis_in_feedback_is_the_title_of_its_model() {
        let mode = FeedbackMode { hz: 90.0, damping: 0.1, input: 1.0, hysteretic: -0.2, sensed: 1.0, softening: 0.0 };
        let dynamics = FeedbackDynamics { modes: vec![mode], sensed: 0.0, ..FeedbackDynamics::default() };
        let friction = (piezoid::hysteresis::Operator::find("dahl").unwrap().example)(5e-4).unwrap();
        let feedback = FeedbackModel::new(5e-4, dynamics, friction).unwrap();
        let title = "<h1>Hysteresis in feedback</h1>";
        let of = |model: &Model| report(model, &NONE).html();
        let html = of(&beam().with_feedback(feedback).unwrap());
        assert!(html.contains(title) && html.contains("the displacement of the modes drives the hysteresis, dahl"));
        assert!(!of(&beam()).contains(title));
    }

    #[test]
    fn each_block_is_shown_if_the_model_has_it() {
        let plain = report(&beam(), &NONE).html();
        for text in ["lowest mode", "mode 1", "Frequency response", "146.7 Hz", "damper [N s/m]"] {
            assert!(plain.contains(text), "{text}");
        }
        let plain = plain.split("<script>").next().unwrap();
        for absent in ["Creep", "Driver", "image"] {
            assert!(!plain.contains(absent), "{absent}");
        }
        let driver = piezoid::driver::DriverModel::new(1e-4, Some(6e4)).unwrap();
        let stop = (piezoid::hysteresis::Operator::find("stop").unwrap().example)(1.25e-4).unwrap();
        let image = Arx::new(5e-4, vec![-0.6], vec![1.0, 0.6]).unwrap();
        let creep = piezoid::creep::Creep::logarithmic(5e-4, 0.015, 0.05, 5.0).unwrap();
        let full = Model::from_blocks(Some(driver), stop, image, 0.0).unwrap().with_creep(creep).unwrap();
        let full = report(&full, &NONE).html();
        for text in [
            "4.500 % together",
            "Creep after a step",
            "at most 6",
            "of delay or of faster modes",
            "poles above 0.9 of half the sampling rate",
        ] {
            assert!(full.contains(text), "{text}");
        }
    }
}
