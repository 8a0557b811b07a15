//! The report on a model: what it is, and how it meets records it has not seen.

use crate::hammerstein::Model;
use crate::number::short;
use crate::page::{Fact, Page, Section, Table, Text};
use crate::plot::{Axes, Axis, Figure, Role, Series};
use crate::record::Record;
use crate::system::System;
use crate::validation::{Metrics, Validation};

/// The longest stretch of time that a figure of a record shows [samples].
const SHOWN: usize = 4000;

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
    let page = trials.iter().fold(page, |page, trial| page.section(one(trial)));
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
    Section::new("Proof")
        .facts([
            Fact::new(short(total.nrmse_percent), "%", "NRMSE: rms error over standard deviation of y"),
            Fact::new(short(total.rms_pp_percent), "%", "rms error over peak-to-peak of y"),
            Fact::new(short(total.max_abs), unit.clone(), "largest error"),
        ])
        .table(table.note("Free run: the model sees the input alone, never the measured output."))
}

fn one(trial: &Trial) -> Section {
    let Trial { name, record, validation } = *trial;
    let section = Section::new(name);
    let section = validation.remarks.iter().fold(section, |s, remark| s.warning("Beyond the model", remark.as_str()));
    let section = match validation.taken_off {
        Some(mean) => {
            let (mean, unit) = (short(mean), &record.units().y);
            section.note("Offset", format!("A mean error of {mean} {unit} was taken off before anything was compared."))
        }
        None => section,
    };
    section.figure(time_series(trial)).figure(loops(trial))
}

fn time_series(trial: &Trial) -> Figure {
    let Trial { record, validation, .. } = *trial;
    let units = record.units();
    let range = validation.start..record.len().min(validation.start + SHOWN);
    let t: Vec<f64> = range.clone().map(|k| k as f64 * record.ts()).collect();
    let (y, simulated) = (&record.y()[range.clone()], &validation.simulated[range]);
    let error: Vec<f64> = y.iter().zip(simulated).map(|(y, s)| y - s).collect();
    let left = short(validation.metrics.rms_pp_percent);
    let part = if record.len() - validation.start > SHOWN { "the first part of the record" } else { "the record" };
    let of = &record.y()[validation.start..];
    let errors = of.iter().zip(&validation.simulated[validation.start..]).map(|(y, s)| (y - s).abs());
    let worst = errors.enumerate().fold((0, 0.0), |worst, (k, e)| if e > worst.1 { (k, e) } else { worst }).0;
    let at = short((validation.start + worst) as f64 * record.ts());
    let caption = format!(
        "Measurement and free run over {part}, and what is left: {left} % of peak-to-peak over all of it. The largest error is at {at} s."
    );
    Figure::new("Time series", caption)
        .panel(
            Axes::new("t [s]", Axis::new(format!("y [{}]", units.y)))
                .height(0.6)
                .with(Series::line(&t, y).role(Role::Measured).named("measured"))
                .with(Series::line(&t, simulated).role(Role::Model).named("model")),
        )
        .panel(
            Axes::new("t [s]", Axis::new(format!("error [{}]", units.y)))
                .height(0.4)
                .with(Series::line(&t, &error).role(Role::Residual)),
        )
        .stacked()
}

fn loops(trial: &Trial) -> Figure {
    let Trial { record, validation, .. } = *trial;
    let units = record.units();
    let range = validation.start..record.len().min(validation.start + SHOWN);
    let u = &record.u()[range.clone()];
    let part = if range.end < record.len() { "the first part of the record" } else { "the record" };
    let caption = format!(
        "Output over input in {part}, as measured and as the model runs free. Over all of it the two differ by {} % of the height, rms.",
        short(validation.metrics.rms_pp_percent)
    );
    Figure::new("Loops", caption).panel(
        Axes::new(Axis::new(format!("u [{}]", units.u)), Axis::new(format!("y [{}]", units.y)))
            .with(Series::line(u, &record.y()[range.clone()]).role(Role::Measured).named("measured"))
            .with(Series::line(u, &validation.simulated[range]).role(Role::Model).named("model")),
    )
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
}
