//! The report on a model: what it is, and how it meets records it has not seen.

mod errors;
mod record;
mod residuals;

use crate::hammerstein::Model;
use crate::number::short;
use crate::page::{Fact, Page, Section, Table, Text};
use crate::record::Record;
use crate::system::System;
use crate::validation::{Metrics, Validation};

/// A record and the model's free run over it.
#[derive(Debug, Clone, Copy)]
pub struct Trial<'a> {
    /// What the record is called: its file's name.
    pub name: &'a str,
    /// The record.
    pub record: &'a Record,
    /// The model's run.
    pub validation: &'a Validation,
}

/// The report: one file that opens from disk.
pub fn report(model: &Model, trials: &[Trial]) -> Page {
    let operator = model.hysteresis().operator();
    let page = Page::new("Hammerstein model").subtitle(format!(
        "{} hysteresis, {}, sampled every {} s",
        operator.name,
        match model.linear().a().len() {
            0 => "a gain without dynamics".into(),
            n => format!("linear block of order {n}"),
        },
        model.ts()
    ));
    let page = if trials.is_empty() { page } else { page.section(proof(trials)) };
    let page = trials.iter().fold(page, |page, trial| page.section(record::section(trial)));
    page.section(blocks(model))
}

fn proof(trials: &[Trial]) -> Section {
    let each: Vec<Metrics> = trials.iter().map(|t| t.validation.metrics).collect();
    let total = Metrics::total(&each);
    let unit = &trials[0].record.units().y;
    let table = Table::new("Free run against measurement").text("record").number("samples");
    let table = table.number(format!("rms error [{unit}]")).number(format!("largest [{unit}]"));
    let table = table.number("NRMSE [%]").number("rms / peak-to-peak [%]").number("fit [%]");
    let row = |name: &str, m: &Metrics| {
        let figures = [m.rmse, m.max_abs, m.nrmse_percent, m.rms_pp_percent, m.fit_percent].map(short);
        [name.to_string(), m.n.to_string()].into_iter().chain(figures).collect::<Vec<_>>()
    };
    let table = trials.iter().fold(table, |table, t| table.row(row(t.name, &t.validation.metrics)));
    let table = if trials.len() > 1 { table.row(row("total", &total)) } else { table };
    let section = Section::new("Proof")
        .facts([
            Fact::new(short(total.nrmse_percent), "%", "NRMSE: rms error over standard deviation of y"),
            Fact::new(short(total.rms_pp_percent), "%", "rms error over peak-to-peak of y"),
            Fact::new(short(total.max_abs), unit.clone(), "largest error"),
        ])
        .table(table.note("Free run: the model sees the input alone, never the measured output."));
    let section = errors::by_all(section, trials);
    match unproven(trials) {
        open if open.is_empty() => section,
        open => section.text("What none of these records shows, however good the figures are:").list(open),
    }
}

/// What no record can tell.
fn unproven(trials: &[Trial]) -> Vec<String> {
    let subject = |text: &str| text.split(':').next().unwrap_or_default().to_string();
    let of = |t: &Trial, text: &str| t.validation.unproven.iter().any(|other| subject(other) == subject(text));
    let first = trials.first().map_or(&[][..], |t| &t.validation.unproven);
    first.iter().filter(|text| trials.iter().all(|t| of(t, text))).cloned().collect()
}

fn blocks(model: &Model) -> Section {
    let (arx, units) = (model.linear(), model.units());
    let operator = model.hysteresis().operator();
    let range = model.hysteresis().range();
    let hysteresis = Text::from("Hysteresis: ").code(operator.name).plain(format!(
        ", {}{}. Source: {}.",
        operator.summary,
        range.map_or(String::new(), |(low, high)| format!("; identified from {low:.3} to {high:.3} {}", units.u)),
        operator.reference
    ));
    let section = Section::new("The model").text(hysteresis);
    let section = match model.identified() {
        Some(d) => section.text(format!(
            "Identified on inputs from {} to {} {u}, of means from {} to {} {u}, changing by up to {} {u}/s{}: beyond that it \
             extrapolates.",
            short(d.u[0]),
            short(d.u[1]),
            short(d.mean[0]),
            short(d.mean[1]),
            short(d.slew),
            d.hz.map_or(String::new(), |[low, high]| format!(", with power from {} to {} Hz", short(low), short(high))),
            u = units.u
        )),
        None => section,
    };
    let section = match arx.a() {
        [] => section.text(format!(
            "Linear block: a gain of {:.5} {}/{}, without dynamics.",
            arx.dc_gain(),
            units.y,
            units.u
        )),
        _ => {
            let table =
                Table::new("Poles of the linear block").number("natural frequency [Hz]").number("damping ratio");
            let row = |p: crate::linear::Pole| [format!("{:.2}", p.hz), format!("{:.4}", p.damping)];
            let gain = format!("Static gain {:.5} {}/{}.", arx.dc_gain(), units.y, units.u);
            section.table(arx.poles().into_iter().fold(table, |table, p| table.row(row(p))).note(gain))
        }
    };
    let coefficients = format!("a = {:?}\nb = {:?}\noffset = {}", arx.a(), arx.b(), model.offset());
    let section = section.listing(coefficients);
    match model.provenance()["command"].as_str() {
        Some(command) => section.text(Text::from("Made by ").code(command).plain(".")),
        None => section,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::hysteresis::OPERATORS;
    use crate::linear::Arx;
    use crate::validation::{Settings, validate};

    #[test]
    fn every_operator_has_a_report_that_is_the_same_twice_and_tells_the_remarks() {
        for o in OPERATORS {
            let model = Model::new((o.example)(5e-4).unwrap(), Arx::gain(5e-4, 2.0).unwrap(), 0.0).unwrap();
            let u: Vec<f64> = (0..900).map(|t| 12.0 * (f64::from(t) * 0.05).sin() + 1.0).collect();
            let record = Record::new(5e-4, u.clone(), model.simulate(&u)).unwrap();
            let validation = validate(&model, &record, Settings::default()).unwrap();
            let trials = [Trial { name: "a<b.csv", record: &record, validation: &validation }];
            let html = report(&model, &trials).html();
            assert_eq!(html, report(&model, &trials).html());
            assert!(html.contains("a&lt;b.csv"));
            assert_eq!(html.contains("has no minor loops"), !o.minor_loops, "{}", o.name);
        }
    }

    #[test]
    fn where_the_error_lies_and_what_it_is_stands_in_tables_and_figures() {
        let hysteresis = (crate::hysteresis::operator("proportional").unwrap().example)(5e-4).unwrap();
        let beam = Arx::new(5e-4, vec![1.7424, -0.9453], vec![3.4, 3.3]).unwrap();
        let model = Model::new(hysteresis, beam, 0.0).unwrap();
        let wave = |hz: f64| (0..4000).map(move |t| 9.0 * (std::f64::consts::TAU * hz * f64::from(t) * 5e-4).sin());
        let records = [5.0, 20.0].map(|hz| {
            let u: Vec<f64> = wave(hz).collect();
            let y = model.simulate(&u).iter().enumerate().map(|(t, y)| y + f64::from((t * t % 7) as u8)).collect();
            Record::new(5e-4, u, y).unwrap()
        });
        let model = model.with_identified(crate::hammerstein::Domain::of(&records[..1]).unwrap());
        let seen = records.each_ref().map(|r| validate(&model, r, Settings::default()).unwrap());
        let trials = [0, 1].map(|k| Trial { name: "r.csv", record: &records[k], validation: &seen[k] });
        let html = report(&model, &trials).html();
        for said in [
            "Error by frequency",
            "Loops, measured and model",
            "with itself",
            "over the input",
            "no model leaves less",
            "the resonance at 146.7 Hz",
            "Identified on inputs from",
            "The input changes by up to",
        ] {
            assert!(html.contains(said), "{said}");
        }
        assert!(!html.contains("Error by amplitude"), "one amplitude says no more than the figures");
    }
}
