//! The report on control schemes.

use crate::each::Each;
use crate::page::{Fact, Page, PageTable, Section};
use crate::plot::{Axes, Axis, Figure, Role, Series};
use piezoid::control::{Comparison, FEED_FORWARDS, NamedReference, ReferenceResult, SchemeResult};
use piezoid::system::System;
use piezoid_numerics::number::short;
use piezoid_records::waveform::period;

/// Samples shown of a reference that is not periodic.
const SHOWN: usize = 1600;

/// Largest error of the schemes in the detailed panel, relative to the smallest.
const MAX_ERROR_RATIO: f64 = 10.0;

/// Number of colours.
const COLOURS: usize = 5;

/// Number of frequencies of |S|.
const GRID: usize = 400;

/// The page: one self-contained file.
pub fn tracking(compared: &Comparison) -> Page {
    let plant = &compared.plant;
    let subtitle =
        format!("plant {plant}, controllers tuned to a model of it; errors in % of the peak-to-peak of the reference");
    Page::new("Comparison of controllers")
        .subtitle(subtitle)
        .section(errors(compared))
        .each(0..compared.references.len(), |page, k| page.section(along(compared, k)))
        .each([loops(compared), learning(compared), spread(compared)].into_iter().flatten(), Page::section)
}

/// A curve of one scheme, in the same style on the whole page. Each has its own dashes, so that curves that coincide
/// are all seen.
fn curve(compared: &Comparison, d: &SchemeResult, x: &[f64], y: &[f64]) -> Series {
    let uncompensated = |d: &SchemeResult| d.name() == FEED_FORWARDS[0].name;
    let others = compared.results.iter().filter(|d| !uncompensated(d));
    match others.map(SchemeResult::name).position(|name| name == d.name()) {
        None => Series::line(x, y).role(Role::Muted),
        // One pattern further where colours repeat.
        Some(k) => Series::line(x, y).role(Role::accent(k)).dashes(k + k / COLOURS),
    }
}

fn errors(compared: &Comparison) -> Section {
    let table = |title: &str, of: fn(&ReferenceResult, &NamedReference) -> f64| {
        let row = |(k, reference): (usize, &NamedReference)| {
            let cell = |d: &SchemeResult| d.attempts[k].as_ref().map_or("–".into(), |a| short(of(a, reference)));
            [reference.name.clone()].into_iter().chain(compared.results.iter().map(cell)).collect::<Vec<_>>()
        };
        let table = PageTable::new(title).text("reference").each(&compared.results, |t, d| t.number(d.name()));
        table.rows(compared.references.iter().enumerate().map(row))
    };
    let best = |k: usize| {
        let percent = |d: &SchemeResult| Some((d.attempts[k].as_ref().ok()?.tracking.percent_of_stroke, d.name()));
        compared.results.iter().filter_map(percent).min_by(|a, b| a.0.total_cmp(&b.0))
    };
    let worst =
        (0..compared.references.len()).filter_map(|k| Some((best(k)?, k))).max_by(|a, b| a.0.0.total_cmp(&b.0.0));
    let fact = |((percent, name), k): ((f64, String), usize)| {
        let what = "rms error of the best controller on the reference with the largest such error";
        Fact::new(short(percent), "%", format!("{what}: {name}, {}", compared.references[k].name))
    };
    let section = Section::new("Errors")
        .each(worst, |section, worst| section.facts([fact(worst)]))
        .table(table("Rms error [% of the height]", |a, _| a.tracking.percent_of_stroke).note(
            "Errors of the measurement, with sensor noise. Of periodic references, the first whole periods, 0.25 s or \
             more, are left out. \
            “gain” is the best constant gain (with offset) for each reference: no compensation.",
        ))
        .table(table("Largest error [% of the height]", |a, w| 100.0 * a.tracking.max / w.height()))
        .table(table("Effort: rms change of voltage per sample [V]", |a, _| a.tracking.effort));
    let refusal = |d: &SchemeResult| {
        let of = |(w, a): (&NamedReference, &Result<ReferenceResult, _>)| {
            Some(format!("{}, {}: {}", d.name(), w.name, a.as_ref().err()?))
        };
        compared.references.iter().zip(&d.attempts).filter_map(of).collect::<Vec<_>>()
    };
    let refused: Vec<String> = compared.results.iter().flat_map(refusal).collect();
    if refused.is_empty() { section } else { section.text("Errors:").list(refused) }
}

/// Reference, error and voltage of every scheme along one reference, over two periods if it is periodic.
fn along(compared: &Comparison, k: usize) -> Section {
    let (reference, unit) = (&compared.references[k], compared.unit());
    let length = period(&reference.r).map_or(SHOWN, |period| 2 * period + 1);
    let shown = reference.from..reference.r.len().min(reference.from + length);
    let ts = compared.results[0].tuned.model().ts();
    let t: Vec<f64> = shown.clone().map(|t| t as f64 * ts).collect();
    let mut path = Axes::new(Axis::new("t [s]").tight(), &*format!("y [{unit}]")).height(0.4);
    let mut error = Axes::new(Axis::new("t [s]").tight(), &*format!("r - y [{unit}]")).height(0.35);
    let mut nearest = Axes::new(Axis::new("t [s]").tight(), &*format!("r - y, best controllers [{unit}]")).height(0.35);
    let mut voltage = Axes::new(Axis::new("t [s]").tight(), "u [V]").height(0.4);
    let attempts = || compared.results.iter().filter_map(|d| Some((d, d.attempts[k].as_ref().ok()?)));
    let best = attempts().map(|(_, a)| a.tracking.rms).fold(f64::INFINITY, f64::min);
    for (d, ReferenceResult { run, tracking, .. }) in attempts() {
        let error_of: Vec<f64> = shown.clone().map(|t| run.r[t] - run.y[t]).collect();
        let curve = |y: &[f64]| curve(compared, d, &t, y);
        path = path.with(curve(&run.y[shown.clone()]).named(d.name()));
        voltage = voltage.with(curve(&run.u[shown.clone()]));
        if tracking.rms < MAX_ERROR_RATIO * best {
            nearest = nearest.with(curve(&error_of));
        }
        error = error.with(curve(&error_of));
    }
    let path = path.with(Series::wide(&t, &reference.r[shown]).role(Role::Reference).named("reference"));
    let caption = format!(
        "Displacement, error, error of the schemes within {MAX_ERROR_RATIO} times the smallest rms error, and voltage."
    );
    let figure = Figure::new(reference.name.clone(), caption).panel(path).panel(error).panel(nearest).panel(voltage);
    Section::new(&*reference.name).figure(figure.stacked())
}

/// Margins and |S| of the closed loops.
fn loops(compared: &Comparison) -> Option<Section> {
    let closed: Vec<_> = compared.results.iter().filter_map(|d| Some((d, d.tuned.margins()?))).collect();
    let ts = closed.first()?.0.tuned.model().ts();
    let nyquist = 0.5 / ts;
    let hz: Vec<f64> = (0..GRID).map(|k| nyquist * 10f64.powf(3.5 * (k as f64 / (GRID - 1) as f64 - 1.0))).collect();
    let table = PageTable::new("Margins").text("scheme").number("gain [dB]").number("phase [°]").number("peak of |S|");
    let table = table.number("bandwidth [Hz]").text("stable");
    let table = closed.iter().fold(table, |table, (d, m)| {
        let figures = [m.gain_db, m.phase_deg, m.peak, m.bandwidth_hz].map(short);
        let stable = if m.stable { "yes" } else { "no" };
        table.row([d.name()].into_iter().chain(figures).chain([stable.to_string()]).collect::<Vec<_>>())
    });
    let axes = Axes::new(Axis::log("f [Hz]").tight(), Axis::log("|S|"));
    let axes = closed.iter().enumerate().fold(axes, |axes, (k, (d, _))| match d.tuned.sensitivity(&hz) {
        Some(s) => axes.with(curve(compared, d, &hz, &s).dashes(k).named(d.name())),
        None => axes,
    });
    let caption = "Sensitivity to disturbances: attenuated below 1, amplified above 1.";
    let table = table.note(
        "Margins are computed at the largest slope of the hysteresis, with creep. Bandwidth is the lowest frequency \
         with |S| = -3 dB.",
    );
    Some(Section::new("Loops").table(table).figure(Figure::new("Sensitivity", caption).panel(axes)))
}

/// The error of each learning trial.
fn learning(compared: &Comparison) -> Option<Section> {
    let learnt = |d: &SchemeResult| {
        let of = |(w, a): (&NamedReference, &Result<ReferenceResult, _>)| {
            Some((w.name.clone(), w.height(), a.as_ref().ok()?.feed_forward.trials.clone()))
        };
        compared.references.iter().zip(&d.attempts).filter_map(of).filter(|(.., t)| !t.is_empty()).collect::<Vec<_>>()
    };
    let courses = compared.results.iter().map(learnt).find(|courses| !courses.is_empty())?;
    let axes = Axes::new("trial", Axis::log("rms error [% of the height]"));
    let axes = courses.iter().enumerate().fold(axes, |axes, (k, (name, height, trials))| {
        let n: Vec<f64> = (0..trials.len()).map(|n| n as f64).collect();
        let percent: Vec<f64> = trials.iter().map(|rms| 100.0 * rms / height).collect();
        axes.with(Series::marked(&n, &percent).role(Role::accent(k)).named(name.clone()))
    });
    let caption = "Trial 0 is the feed-forward. A trial with twice the error of the best one is discarded.";
    Some(Section::new("Learning").figure(Figure::new("Error by trial", caption).panel(axes)))
}

/// Errors over plants within a tolerance.
fn spread(compared: &Comparison) -> Option<Section> {
    let drawn: Vec<_> = compared.results.iter().filter_map(|d| Some((d, d.spread.as_ref()?))).collect();
    let table =
        PageTable::new("Draws").text("scheme").number("median [%]").number("90th percentile [%]").number("worst [%]");
    let table = table.number("draws").number("unstable");
    let table = drawn.iter().fold(table, |table, (d, spread)| {
        let shares = [0.5, 0.9, 1.0].map(|share| short(spread.percent_of_stroke(share)));
        let unstable = d.tuned.scheme.law.map_or("–".into(), |_| spread.unstable().to_string());
        let counts = [spread.trials.len().to_string(), unstable];
        table.row([d.name()].into_iter().chain(shares).chain(counts).collect::<Vec<_>>())
    });
    let axes = Axes::new(Axis::log("rms error [% of the height]"), "share of the draws [%]");
    let axes = drawn.iter().fold(axes, |axes, (d, spread)| {
        let shares: Vec<f64> = (0..=100).map(f64::from).collect();
        let percent: Vec<f64> = shares.iter().map(|share| spread.percent_of_stroke(share / 100.0)).collect();
        axes.with(curve(compared, d, &percent, &shares).named(d.name()))
    });
    let reference = &compared.references.first()?.name;
    let caption = format!(
        "Reference {reference}: share of the random plants with a smaller error. Every controller is tuned to the model \
         of the nominal \
        plant."
    );
    let text = "Random plants with parameters within the tolerance, with the same controllers.";
    let figure = Figure::new("Distribution of the errors within the tolerance", caption).panel(axes);
    (!drawn.is_empty()).then(|| Section::new("Tolerance").text(text).table(table).figure(figure))
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid::compensation::FeedForwardSettings;
    use piezoid::control::{Comparison, MarginTarget, Reference, Scheme, Tolerance, TunedScheme};
    use piezoid::excitation::Limits;
    use piezoid::hammerstein::Model;
    use piezoid::hysteresis::Operator;
    use piezoid::linear::Arx;
    use piezoid::plant::Preset;
    use piezoid::progress::Stage;

    #[test]
    fn the_page_shows_every_scheme_along_every_reference_and_the_errors() {
        let ts = 5e-4;
        let plays = (Operator::find("prandtl-ishlinskii").unwrap().example)(ts).unwrap();
        let units = piezoid::record::Units { u: "V".into(), y: "um".into() };
        let linear = Arx::new(ts, vec![1.7424, -0.9453], vec![0.0, 3.1, 3.1]).unwrap();
        let model = Model::new(plays, linear, 0.0).unwrap().with_units(units);
        let limits = Limits { low: Some(-30.0), high: Some(30.0), ..Default::default() };
        let drive = |name| {
            let settings = FeedForwardSettings { limits, clip: true, ..Default::default() };
            TunedScheme::new(Scheme::named(name).unwrap(), &model, settings, 0, &MarginTarget::default()).unwrap()
        };
        let reference = |name, hz| {
            NamedReference::new(name, ts, Reference::find(name).unwrap().samples(ts, 800, 300.0, hz).unwrap())
        };
        let drives = ["gain", "learning", "feed-forward+pi"].map(drive).to_vec();
        let (plant, tolerance) = (Preset::find("pl140").unwrap(), Tolerance { draws: 3, ..Default::default() });
        let all = vec![reference("sine", 10.0), reference("random", 20.0)];
        let compared =
            Comparison::run((plant.name, &plant.spec().into()), drives, all, 1, Some(&tolerance), &mut Stage::ignore)
                .unwrap();
        let html = tracking(&compared).html();
        for text in [
            "Distribution of the errors within the tolerance",
            "Error by trial",
            "Sensitivity",
            "feed-forward+pi",
            "not periodic",
            "random",
        ] {
            assert!(html.contains(text), "{text}");
        }
        assert!(!html.split("<script>").next().unwrap().contains("NaN"));
        assert_eq!(html, tracking(&compared).html());
    }
}
