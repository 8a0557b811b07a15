//! docs/control.md: tracking errors of two twins of a bender under each control scheme, with models identified from
//! records alone, and over plants with tolerances.

use crate::page::{self, cell, head, row};
use crate::twin::{TS, TWINS, Twin};
use piezoid::compensation::FeedForwardSettings;
use piezoid::control::{
    CONTROLLERS, Comparison, MarginTarget, NamedReference, Reference, Scheme, SchemeResult, Tolerance, TunedScheme,
};
use piezoid::excitation::Limits;
use piezoid::plant::Preset;
use piezoid::progress::Stage;
use piezoid::{Error, Model};
use piezoid_report::plot::{Axes, Axis, Figure, Role, Series};
use piezoid_verbs::{PATHS, SCHEMES};
use std::path::Path;

/// Peak of the references [um], 80 % of the catalogue's displacement.
const PEAK: f64 = 800.0;

/// Numbers of reference samples known ahead, for the causal schemes.
const AHEAD: [usize; 6] = [20, 8, 4, 2, 1, 0];

/// The reference for plants with tolerances, and the seed.
pub const TRIED: (&str, f64) = ("triangle", 20.0);
const SEED: u64 = 7;

fn reference((kind, hz): (&str, f64)) -> Result<NamedReference, Error> {
    let n = (f64::max(1.0, 4.0 / hz) / TS) as usize;
    Ok(NamedReference::new(format!("{kind} {hz}"), TS, Reference::find(kind)?.samples(TS, n, PEAK, hz)?))
}

/// A scheme tuned for a model; `ahead` samples of the reference are known in advance.
pub fn drive(model: &Model, name: &str, ahead: usize) -> Result<TunedScheme, Error> {
    let limits = Limits { low: Some(-30.0), high: Some(30.0), ..Limits::default() };
    let mut drive = TunedScheme::new(
        Scheme::named(name)?,
        model,
        FeedForwardSettings { limits, ..FeedForwardSettings::default() },
        0,
        &MarginTarget::default(),
    )?;
    drive.ahead = ahead;
    Ok(drive)
}

/// Compares schemes on a twin along these references.
pub fn compared(
    twin: &'static str,
    drives: Vec<TunedScheme>,
    paths: &[(&str, f64)],
    tolerance: Option<&Tolerance>,
) -> Result<Comparison, Error> {
    let plant = Preset::find(twin)?;
    let paths = paths.iter().copied().map(reference).collect::<Result<Vec<_>, _>>()?;
    Comparison::run((plant.name, &plant.spec().into()), drives, paths, SEED, tolerance, &mut Stage::ignore)
}

/// The rms error along each reference [% of its height]; infinite if the reference returned an error.
pub fn errors(result: &SchemeResult) -> Vec<f64> {
    let percent = |a: &Result<piezoid::control::ReferenceResult, Error>| {
        a.as_ref().map_or(f64::INFINITY, |a| a.tracking.percent_of_stroke)
    };
    result.attempts.iter().map(percent).collect()
}

/// A table of errors by reference; each row begins with its names.
fn table<'a>(titles: &[&str], rows: impl Iterator<Item = (Vec<String>, &'a SchemeResult)>) -> String {
    let all = titles.iter().map(|t| t.to_string()).chain(PATHS.map(|(kind, hz)| format!("{kind} {hz}")));
    let body = rows.map(|(names, d)| row(names.into_iter().chain(errors(d).into_iter().map(cell))));
    head(all, titles.len()) + &body.collect::<String>()
}

fn code(name: impl std::fmt::Display) -> String {
    format!("`{name}`")
}

/// Margins of every feedback loop that has a control law.
fn margins(drives: &[TunedScheme]) -> String {
    let titles = [
        "controller",
        "gain margin [dB]",
        "phase margin [°]",
        "peak of the sensitivity",
        "bandwidth [Hz]",
        "smallest bandwidth [Hz]",
    ];
    let figures = drives.iter().filter_map(|d| Some((d.scheme.name(), d.margins()?, d.least_bandwidth_hz()?)));
    let body = figures.map(|(name, m, least)| {
        let figures = [m.gain_db, m.phase_deg, m.peak, m.bandwidth_hz, least].map(cell);
        row([code(name)].into_iter().chain(figures))
    });
    head(titles, 1) + &body.collect::<String>()
}

/// The errors of each scheme over plants with tolerances.
fn spreads(drawn: &Comparison) -> String {
    let titles = ["controller", "nominal plant [%]", "median [%]", "90th percentile [%]", "worst [%]", "unstable"];
    let body = drawn.results.iter().filter_map(|d| Some((d, d.spread.as_ref()?))).map(|(d, spread)| {
        let shares = [0.5, 0.9, 1.0].map(|share| cell(spread.percent_of_stroke(share)));
        let counted = |_| format!("{} of {}", spread.unstable(), spread.trials.len());
        let unstable = d.tuned.scheme.law.map_or("-".into(), counted);
        let nominal = cell(errors(d)[0]);
        row([code(d.name()), nominal].into_iter().chain(shares).chain([unstable]))
    });
    head(titles, 1) + &body.collect::<String>()
}

/// Errors along triangles of the first twin by frequency, and over tolerances.
fn figure(tracked: &Comparison, drawn: &Comparison) -> Figure {
    // A pattern of dashes a scheme, so that lines that coincide are all seen.
    let drawn_as = |series: Series, name: &str| match SCHEMES.iter().position(|s| *s == name) {
        Some(0) | None => series.role(Role::Muted),
        Some(k) => series.role(Role::accent(k - 1)).dashes(k - 1),
    };
    let (at, hz): (Vec<usize>, Vec<f64>) =
        PATHS.iter().enumerate().filter(|(_, p)| p.0 == "triangle").map(|(k, p)| (k, p.1)).unzip();
    let axes = Axes::new(Axis::log("f [Hz]").ticks(&hz), Axis::log("rms error [% of the height]")).titled("triangles");
    let by_frequency = tracked.results.iter().fold(axes, |axes, d| {
        let all = errors(d);
        let of: Vec<f64> = at.iter().map(|k| all[*k]).collect();
        axes.with(drawn_as(Series::marked(&hz, &of), &d.name()).named(d.name()))
    });
    let title = format!("{} {} Hz, tolerance of 20 %", TRIED.0, TRIED.1);
    let axes = Axes::new(Axis::log("rms error [% of the height]"), "share of 200 draws [%]").titled(title);
    let shares: Vec<f64> = (0..=100).map(f64::from).collect();
    let shown = drawn.results.iter().filter(|d| SCHEMES.contains(&&*d.name()));
    let by_share = shown.filter_map(|d| Some((d, d.spread.as_ref()?))).fold(axes, |axes, (d, spread)| {
        let percent: Vec<f64> = shares.iter().map(|share| spread.percent_of_stroke(share / 100.0)).collect();
        axes.with(drawn_as(Series::line(&percent, &shares), &d.name()))
    });
    let caption = "Tracking error of the twin pl140 with a model identified from its records: by frequency of a triangle \
                   of 80 % of the stroke, and over 200 plants whose parameters lie within 20 %.";
    Figure::new("Tracking error by controller", caption).panel(by_frequency).panel(by_share)
}

/// Writes the tables into control.md of this folder, and draws control.svg.
pub fn write(docs: &Path) -> Result<(), Box<dyn std::error::Error>> {
    let page = docs.join("control.md");
    let models = TWINS.iter().map(|twin| Ok(Twin::new(twin)?.joint("auto", false)?.model));
    let models: Vec<Model> = models.collect::<Result<_, Error>>()?;
    let all = |model: &Model, names: &[&str], ahead| {
        names.iter().map(|name| drive(model, name, ahead)).collect::<Result<Vec<_>, Error>>()
    };

    let tracked =
        |(twin, model): (&&'static str, &Model)| compared(twin, all(model, &SCHEMES, usize::MAX)?, &PATHS, None);
    let tracked = TWINS.iter().zip(&models).map(tracked).collect::<Result<Vec<_>, Error>>()?;
    let rows = tracked.iter().flat_map(|c| c.results.iter().map(|d| (vec![code(&c.plant), code(d.name())], d)));
    page::write(&page, "tracking", &table(&["twin", "controller"], rows))?;

    let causal = ["feed-forward", "feed-forward+integral-notch", "predictive"];
    let known = |ahead: usize| Ok((ahead, compared(TWINS[0], all(&models[0], &causal, ahead)?, &PATHS, None)?));
    let known = AHEAD.into_iter().map(known).collect::<Result<Vec<_>, Error>>()?;
    let rows = known.iter().flat_map(|(n, c)| c.results.iter().map(move |d| (vec![n.to_string(), code(d.name())], d)));
    page::write(&page, "ahead", &table(&["samples ahead", "controller"], rows))?;

    let feedbacks: Vec<&str> = CONTROLLERS.iter().map(|c| c.name).collect();
    page::write(&page, "margins", &margins(&all(&models[0], &feedbacks, usize::MAX)?))?;
    let with: Vec<String> = feedbacks.iter().map(|name| format!("feed-forward+{name}")).collect();
    let with = with.iter().map(String::as_str).filter(|name| !name.ends_with("predictive"));
    let tried: Vec<&str> =
        ["gain", "feed-forward"].into_iter().chain(feedbacks.iter().copied()).chain(with).chain(["learning"]).collect();
    let drives = all(&models[0], &tried, usize::MAX)?;
    let drawn = compared(TWINS[0], drives, &[TRIED], Some(&Tolerance { seed: SEED, ..Tolerance::default() }))?;
    page::write(&page, "tolerance", &spreads(&drawn))?;
    Ok(std::fs::write(docs.join("control.svg"), figure(&tracked[0], &drawn).svg())?)
}
