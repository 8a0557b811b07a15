//! The report on several models: errors side by side, and free runs over each other.

use super::loops::{self, FreeRun};
use crate::each::Each;
use crate::page::{Cell, Fact, Page, PageTable, Section, sentence};
use crate::plot::{Axes, Axis, Figure, Role, Series};
use piezoid::Model;
use piezoid::validation::Bin;
use piezoid_numerics::number::short;
use piezoid_validation::Source;
use piezoid_verbs::{Compared, ComparedModel, ModelComparison, Split};

/// Number of colours.
const COLOURS: usize = 5;

/// The page: one self-contained file.
pub fn comparison(compared: &ModelComparison) -> Page {
    // Of many methods, those with the smallest errors are drawn.
    let drawn = if compared.split.is_some() { COLOURS.min(compared.models.len()) } else { compared.models.len() };
    let models = &compared.models[..drawn];
    let records = models.first().map_or(&[][..], |one| &one.validated.files);
    let names: Vec<&str> = records.iter().map(Compared::short).collect();
    let bins = by_bins(models);
    let where_they_are = (!bins.is_empty()).then(|| Section::new("Where the errors are").each(bins, Section::figure));
    Page::new("Comparison of models")
        .subtitle(format!("free runs on {}", names.join(", ")))
        .section(errors(compared, models, records))
        .each(where_they_are, Page::section)
        .each(records.get(compared.record), |page, record| page.section(runs(models, compared.record, record)))
}

/// The style of the `k`-th model, the same in all figures.
fn styled(series: Series, k: usize) -> Series {
    series.role(Role::accent(k)).dashes(k / COLOURS)
}

fn errors(compared: &ModelComparison, models: &[ComparedModel], records: &[Compared]) -> Section {
    let facts = |best: &ComparedModel| {
        let total = best.validated.total();
        let unit = records.first().map_or(String::new(), |one| one.record.units().y.clone());
        [
            Fact::new(short(total.rms_pp_percent), "%", format!("rms error over peak-to-peak of y, {}", best.name)),
            Fact::new(short(total.nrmse_percent), "%", "its NRMSE: rms error over standard deviation of y"),
            Fact::new(short(total.max_abs), unit, "its largest error"),
        ]
    };
    let verdict = |one: &ComparedModel| {
        let verdict = one.model.as_ref().and_then(|model| one.validated.verdict(model));
        format!("{}: {}.", one.name, verdict.map_or("not proven".into(), |verdict| verdict.to_string()))
    };
    let failed = compared.failed.iter().map(|one| format!("{}: {}", one.name, one.reason));
    Section::new("Models")
        .each(compared.summary(), |section, summary| section.text(sentence(&summary)))
        .each(compared.best(), |section, best| section.facts(facts(best)))
        .table(blocks(&compared.models))
        .each(compared.split.as_ref().map(described), Section::text)
        .each((!compared.failed.is_empty()).then_some(failed), |section, failed| section.list(failed))
        .each(compared.split.as_ref().and_then(|_| leaderboard(compared)), Section::figure)
        .table(by_record(models, records))
        .list(models.iter().filter(|one| one.model.is_some()).map(verdict))
}

/// The split in one sentence.
fn described(split: &Split) -> String {
    match split.held_out {
        Some(share) => format!(
            "Identified from all but the last {} % of each record; the errors are those of this end, in free runs from \
             the start of the record. The tables and figures below are of the smallest errors.",
            short(100.0 * share)
        ),
        None if split.tests_are_training() => {
            "Compared on records that the methods were identified from: the errors do not show how they predict. The \
             tables and figures below are of the smallest errors."
                .into()
        }
        None => "Identified from other records than those compared. The tables and figures below are of the smallest \
                 errors."
            .into(),
    }
}

/// Error against number of parameters: the methods for which no smaller one has a smaller error are joined and named.
/// `None` if no error and number are known. It holds no times: they differ from run to run.
pub fn leaderboard(compared: &ModelComparison) -> Option<Figure> {
    let point = |one: &ComparedModel| Some((one.all_parameters? as f64, one.error()));
    let points = compared.models.iter().filter_map(|one| Some((one.name.as_str(), point(one)?)));
    let mut points: Vec<(&str, (f64, f64))> =
        points.filter(|(_, (n, e))| *n > 0.0 && *e > 0.0 && e.is_finite()).collect();
    points.sort_by(|(_, a), (_, b)| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let mut least = f64::INFINITY;
    let is_better = |&(_, (_, error)): &(&str, (f64, f64))| {
        let is_better = error < least;
        least = least.min(error);
        is_better
    };
    let (front, others): (Vec<_>, Vec<_>) = points.into_iter().partition(is_better);
    let split = |points: &[(&str, (f64, f64))]| -> (Vec<f64>, Vec<f64>) { points.iter().map(|(_, at)| *at).unzip() };
    let mut axes = Axes::new(Axis::log("parameters"), Axis::log("rms error / peak-to-peak [%]"));
    let (n, errors) = split(&front);
    axes = axes.with(Series::line(&n, &errors).role(Role::Muted));
    let (n, errors) = split(&others);
    axes = axes.with(Series::points(&n, &errors).role(Role::Muted));
    for (k, (name, (n, error))) in front.iter().enumerate() {
        axes = axes.with(Series::points(&[*n], &[*error]).role(Role::accent(k)).named(*name));
    }
    if let Some(floor) = compared.best().and_then(|best| best.validated.floor()) {
        axes = axes.at_y(floor.rms_pp_percent, "noise");
    }
    let listed = |(name, (n, error)): &(&str, (f64, f64))| format!("{name} {} % ({n})", short(*error));
    let rest: Vec<String> = others.iter().map(listed).collect();
    let rest = if rest.is_empty() { String::new() } else { format!(" Others: {}.", rest.join(", ")) };
    let named: Vec<String> = front.iter().map(listed).collect();
    let caption = format!(
        "Error of the free run, over all records, against the number of parameters (in brackets). No smaller method has \
         a smaller error than {}.{rest}",
        named.join(", ")
    );
    (!front.is_empty()).then(|| Figure::new("Error against parameters", caption).panel(axes))
}

/// Errors over all records, and what the models are made of.
fn blocks(models: &[ComparedModel]) -> PageTable {
    let table = PageTable::new("Models").text("model").text("operator").number("rms / peak-to-peak [%]");
    let table = table.number("NRMSE [%]").number("fit [%]").number("noise [%]").number("hysteresis");
    let table = table.number("parameters").number("order").number("creep [%]");
    let least = least(models.iter().map(ComparedModel::error));
    let row = |one: &ComparedModel| {
        let (model, total) = (one.model.as_ref(), one.validated.total());
        let creep = |model: &Model| short(100.0 * model.creep().lags().iter().map(|lag| lag.gain).sum::<f64>());
        let error = Cell::from(short(total.rms_pp_percent));
        let error = if total.rms_pp_percent == least { error.best() } else { error };
        let what = [one.name.clone(), one.operator().unwrap_or("-").into()].map(Cell::from);
        let errors = [error, short(total.nrmse_percent).into(), short(total.fit_percent).into()];
        let none = || "-".to_string();
        let noise = one.validated.floor().map_or_else(none, |floor| short(floor.rms_pp_percent));
        let order = model.map_or_else(none, |model| model.linear().a().len().to_string());
        let [own, all] = [one.parameters(), one.all_parameters].map(|n| n.map_or_else(none, |n| n.to_string()));
        let size = [noise, own, all, order, model.map_or_else(none, creep)].map(Cell::from);
        what.into_iter().chain(errors).chain(size).collect::<Vec<_>>()
    };
    table.rows(models.iter().map(row)).note(
        "Errors of the free run, over all records. Noise: its part of the error, over peak-to-peak. Hysteresis: the \
        numbers that describe the hysteresis block. Parameters: those of all blocks. Order: that of the linear block.",
    )
}

/// The errors of every model on every record.
fn by_record(models: &[ComparedModel], records: &[Compared]) -> PageTable {
    let row = |name: &str, errors: Vec<f64>| {
        let least = least(errors.iter().copied());
        let cell = |error: f64| if error == least { Cell::from(short(error)).best() } else { short(error).into() };
        [Cell::from(name)].into_iter().chain(errors.into_iter().map(cell)).collect::<Vec<_>>()
    };
    let of = |k: usize| models.iter().map(|one| one.validated.files[k].validation.metrics.rms_pp_percent).collect();
    let total = || models.iter().map(ComparedModel::error).collect();
    PageTable::new("Errors by record [% rms of peak-to-peak]")
        .text("record")
        .each(models, |table, one| table.number(one.name.as_str()))
        .rows(records.iter().enumerate().map(|(k, one)| row(one.short(), of(k))))
        .rows((records.len() > 1).then(|| row("total", total())))
        .note("Coloured: the smallest of each row.")
}

fn least(errors: impl Iterator<Item = f64>) -> f64 {
    errors.filter(|error| error.is_finite()).fold(f64::INFINITY, f64::min)
}

/// The errors by frequency and by amplitude, where there are several bins.
fn by_bins(models: &[ComparedModel]) -> Vec<Figure> {
    let unit = models.first().and_then(|one| one.validated.files.first()).map_or("", |one| &one.record.units().u);
    let amplitude = format!("amplitude of the input [{unit}]");
    let named = [("Error by frequency", "f [Hz]"), ("Error by amplitude", &amplitude)];
    let figure = |(which, (title, label)): (usize, (&str, &str))| {
        let bins: Vec<Vec<Bin>> = models.iter().map(|one| one.validated.bins()[which].clone()).collect();
        if bins.iter().all(|bins| bins.len() < 2) {
            return None;
        }
        let mut axes = Axes::new(Axis::log(label), Axis::log("rms error / std of y [%]")).height(0.8);
        for (k, (one, bins)) in models.iter().zip(&bins).enumerate() {
            let of = |source| {
                let (at, error): (Vec<f64>, Vec<f64>) =
                    bins.iter().filter(|b| b.source == source).map(|b| (b.at, b.nrmse_percent)).unzip();
                (!at.is_empty()).then_some((at, error))
            };
            // Cycles of one band may be of different amplitudes: they are joined only by amplitude.
            let cycles = of(Source::Cycles).map(|(at, error)| match which {
                0 => Series::points(&at, &error),
                _ => Series::marked(&at, &error),
            });
            let spectrum = of(Source::Spectrum).map(|(at, error)| Series::marked(&at, &error));
            for (j, series) in cycles.into_iter().chain(spectrum).enumerate() {
                // Listed once.
                axes = axes.with(styled(series, k).named(if j == 0 { one.name.as_str() } else { "" }));
            }
        }
        let joined = [
            "Points: cycles of the input; joined: spectra, of inputs without cycles.",
            "From the cycles of the input.",
        ][which];
        let caption = format!("Rms error over the standard deviation of the output, over all records. {joined}");
        Some(Figure::new(title, caption).panel(axes))
    };
    named.into_iter().enumerate().filter_map(figure).collect()
}

/// The residuals and the loops of all models on one record.
fn runs(models: &[ComparedModel], at: usize, measured: &Compared) -> Section {
    let (record, start) = (&measured.record, measured.validation.start);
    let unit = &record.units().y;
    let time: Vec<f64> = (start..record.len()).map(|t| t as f64 * record.ts()).collect();
    let of = |one: &ComparedModel| one.validated.files[at].validation.metrics.max_abs;
    let axes = Axes::new(Axis::new("t [s]").tight(), Axis::new(format!("error [{unit}]")));
    let axes = models.iter().enumerate().fold(axes, |axes, (k, one)| {
        let error =
            record.y()[start..].iter().zip(&one.validated.files[at].validation.simulated[start..]).map(|(y, s)| y - s);
        axes.with(styled(Series::line(&time, &error.collect::<Vec<_>>()), k).named(one.name.as_str()))
    });
    let largest: Vec<String> = models.iter().map(|one| format!("{} {} {unit}", one.name, short(of(one)))).collect();
    let caption = format!("Measurement minus free run of each model. The largest: {}.", largest.join(", "));
    let section = Section::new(measured.short()).figure(Figure::new("Residuals", caption).panel(axes));
    let free: Vec<FreeRun> = (0..)
        .zip(models)
        .map(|(j, one)| {
            let y = &one.validated.files[at].validation.simulated[..];
            FreeRun { name: &one.name, y, role: Role::accent(j), dashes: j / COLOURS }
        })
        .collect();
    match loops::figures(record, start, loops::worst(measured), &free) {
        Some((figures, words)) => {
            let caption = format!(
                "Output against input, measured and in free run; beside it the same less the least-squares straight \
                line of each measured loop.{words}"
            );
            section.figures(2, "Loops", caption, figures)
        }
        None => section.text("The input of this record has two values: it has no loops to draw."),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid::System;
    use piezoid::hysteresis::Operator;
    use piezoid::linear::Arx;
    use piezoid_verbs::{CompareOptions, File};

    fn compared() -> ModelComparison {
        let model = |name: &str, gain| {
            let hysteresis = (Operator::find(name).unwrap().example)(5e-4).unwrap();
            Model::new(hysteresis, Arx::gain(5e-4, gain).unwrap(), 0.0).unwrap()
        };
        let plant = model("dahl", 2.0);
        let record = |hz: f64| {
            let wave = |t: i32| 1e-3 * f64::from(t) * (0.005 * hz * f64::from(t)).sin();
            let u: Vec<f64> = (0..6000).map(wave).collect();
            let rows = u.iter().zip(plant.simulate(&u)).enumerate();
            let rows: String = rows.map(|(t, (u, y))| format!("{},{u},{y}\n", t as f64 * 5e-4)).collect();
            File::new(format!("r<{hz}>.csv"), format!("t_s,u_V,y_um\n{rows}"))
        };
        let models = [("dahl", 2.1), ("proportional", 1.5), ("dahl", 1.0)];
        let file = |(k, (name, gain)): (usize, &(&str, f64))| File::new(format!("m&{k}"), model(name, *gain).to_json());
        let models: Vec<File> = models.iter().enumerate().map(file).collect();
        let data = piezoid_verbs::Source::all(vec![record(1.0), record(3.0)], &Default::default());
        CompareOptions::default().run(&models, data).unwrap()
    }

    #[test]
    fn every_model_is_in_every_table_and_figure() {
        let html = comparison(&compared()).html();
        for text in [
            "Smallest error in free run: m&amp;0, ",
            "Errors by record",
            "Error by frequency",
            "Error by amplitude",
            "Residuals",
            "without the straight line",
            "r&lt;1&gt;.csv",
            "proportional",
        ] {
            assert!(html.contains(text), "{text}");
        }
        for name in ["m\\u00260", "m\\u00261", "m\\u00262"] {
            assert!(html.matches(&format!("\"{name}\"")).count() >= 5, "{name}: two errors, residuals, two loops");
        }
        assert_eq!(html, comparison(&compared()).html());
    }

    #[test]
    fn the_smallest_error_of_each_row_is_marked() {
        let html = comparison(&compared()).html();
        assert_eq!(html.matches("<td class=\"num best\">").count(), 4, "in total, of two records and their total");
    }
}
