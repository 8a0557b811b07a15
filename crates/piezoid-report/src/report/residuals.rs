//! What the model leaves of a record: against the noise floor, and against noise itself.

use crate::page::{Section, sentence};
use crate::plot::{Axes, Figure, Role, Series};
use piezoid::Compared;
use piezoid::number::short;
use piezoid::validation::Whiteness;

/// Adds what is known of the noise floor, and the correlations of what is left with their bounds.
pub(super) fn residuals(section: Section, trial: &Compared) -> Section {
    let unit = &trial.record.units().y;
    let section = match trial.validation.floor {
        Some(f) => section.text(format!(
            "The input repeats every {} samples. Between {} such periods the output scatters by {} {unit} ({} % of peak-to-peak), \
             drift taken off: no model leaves less. This one leaves {} times as much.",
            f.period,
            f.periods,
            short(f.rms),
            short(f.rms_pp_percent),
            short(f.error_over_floor)
        )),
        None => section,
    };
    let Some(whiteness) = &trial.validation.whiteness else { return section };
    let said = whiteness.verdict.iter().map(|text| sentence(text));
    let figures = [autocorrelation(whiteness), cross_correlation(whiteness), over_input(trial)];
    let caption = "Its correlation with itself and with the input keeps within the bounds (shaded) at all lags in 99 of 100 \
                   records, if it is white noise, or apart from the input. Over the input, noise is a band of one height.";
    section.figures(3, "What is left", caption, figures).list(said)
}

fn autocorrelation(w: &Whiteness) -> Figure {
    let lags: Vec<f64> = (1..=w.autocorrelation.len()).map(|k| k as f64).collect();
    correlation("with itself", "lag [samples]", &lags, &w.autocorrelation, w.autocorrelation_bound)
}

fn cross_correlation(w: &Whiteness) -> Figure {
    let half = (w.cross_correlation.len() / 2) as f64;
    let lags: Vec<f64> = (0..w.cross_correlation.len()).map(|k| k as f64 - half).collect();
    correlation(
        "with the input so long before",
        "lag [samples]",
        &lags,
        &w.cross_correlation,
        w.cross_correlation_bound,
    )
}

fn over_input(trial: &Compared) -> Figure {
    let (record, v) = (&trial.record, &trial.validation);
    let (u, y) = (&record.u()[v.start..], &record.y()[v.start..]);
    let errors: Vec<f64> = y.iter().zip(&v.simulated[v.start..]).map(|(y, s)| y - s).collect();
    let units = record.units();
    let axes = Axes::new(format!("u [{}]", units.u).as_str(), format!("error [{}]", units.y).as_str())
        .titled("over the input");
    let caption = format!("What is left over the input: {} {} at most.", short(v.metrics.max_abs), units.y);
    Figure::new("over the input", caption).small().panel(axes.with(Series::dots(u, &errors).role(Role::Residual)))
}

fn correlation(title: &str, label: &str, lags: &[f64], r: &[f64], bound: f64) -> Figure {
    let level = |at: f64| vec![at; lags.len()];
    let largest = r.iter().fold(0.0, |m: f64, r| m.max(r.abs()));
    let caption =
        format!("Correlation of what is left {title}: {} at most, the bound is {}.", short(largest), short(bound));
    let axes = Axes::new(label, "correlation")
        .titled(title)
        .with(Series::band(lags, &level(-bound), &level(bound)).role(Role::Muted))
        .with(Series::line(lags, r).role(Role::Residual))
        .at_y(0.0, "");
    Figure::new(title, caption).small().panel(axes)
}
