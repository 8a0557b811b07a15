//! The report on several models: errors side by side, and free runs over each other.

use super::loops::{self, FreeRun};
use crate::each::Each;
use crate::page::{Cell, Fact, Page, PageTable, Section, sentence};
use crate::plot::{Axes, Axis, Figure, Role, Series};
use piezoid::validation::Bin;
use piezoid_numerics::number::short;
use piezoid_validation::Source;
use piezoid_verbs::{Compared, ComparedModel, ModelComparison};

/// Number of colours.
const COLOURS: usize = 5;

/// The page: one self-contained file.
pub fn comparison(compared: &ModelComparison) -> Page {
    let models = &compared.models[..];
    let records = models.first().map_or(&[][..], |one| &one.validated.files);
    let names: Vec<&str> = records.iter().map(Compared::short).collect();
    let bins = by_bins(models);
    let where_they_are = (!bins.is_empty()).then(|| Section::new("Where the errors are").each(bins, Section::figure));
    Page::new("Comparison of models")
        .subtitle(format!("free runs on {}", names.join(", ")))
        .section(errors(compared, records))
        .each(where_they_are, Page::section)
        .each(records.get(compared.record), |page, record| page.section(runs(models, compared.record, record)))
}

/// The style of the `k`-th model, the same in all figures.
fn styled(series: Series, k: usize) -> Series {
    series.role(Role::accent(k)).dashes(k / COLOURS)
}

fn errors(compared: &ModelComparison, records: &[Compared]) -> Section {
    let models = &compared.models[..];
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
        let message = one.validated.verdict(&one.model).map_or("not proven".into(), |verdict| verdict.to_string());
        format!("{}: {message}.", one.name)
    };
    Section::new("Models")
        .each(compared.summary(), |section, summary| section.text(sentence(&summary)))
        .each(compared.best(), |section, best| section.facts(facts(best)))
        .table(blocks(models))
        .table(by_record(models, records))
        .list(models.iter().map(verdict))
}

/// Errors over all records, and what the models are made of.
fn blocks(models: &[ComparedModel]) -> PageTable {
    let table = PageTable::new("Models").text("model").text("operator").number("rms / peak-to-peak [%]");
    let table = table.number("NRMSE [%]").number("fit [%]").number("parameters").number("order").number("creep [%]");
    let least = least(models.iter().map(|one| one.validated.total().rms_pp_percent));
    let row = |one: &ComparedModel| {
        let (model, total) = (&one.model, one.validated.total());
        let creep: f64 = model.creep().lags().iter().map(|lag| lag.gain).sum();
        let error = Cell::from(short(total.rms_pp_percent));
        let error = if total.rms_pp_percent == least { error.best() } else { error };
        let what = [one.name.clone(), model.hysteresis().operator().name.into()].map(Cell::from);
        let errors = [error, short(total.nrmse_percent).into(), short(total.fit_percent).into()];
        let order = model.linear().a().len().to_string();
        let size = [one.parameters().to_string(), order, short(100.0 * creep)].map(Cell::from);
        what.into_iter().chain(errors).chain(size).collect::<Vec<_>>()
    };
    table.rows(models.iter().map(row)).note(
        "Errors of the free run, over all records. Parameters: the numbers that describe the hysteresis block. Order: \
        that of the linear block.",
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
    let total = || models.iter().map(|one| one.validated.total().rms_pp_percent).collect();
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
    let unit = models.first().map_or("", |one| &one.model.units().u);
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
    use piezoid::hysteresis::Operator;
    use piezoid::linear::Arx;
    use piezoid::{Model, System};
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
