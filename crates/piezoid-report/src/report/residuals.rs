//! Residuals of a record: compared with the noise floor, what would lower them, and on demand their tests.

use crate::each::Each;
use crate::page::{Section, sentence};
use crate::plot::{Axes, Figure, Role, Series};
use piezoid::validation::{Floor, Whiteness};
use piezoid_numerics::number::short;
use piezoid_verbs::Compared;

/// Largest lag that is drawn [samples]: at longer ones a correlation only goes on.
const LAGS: usize = 20;

/// Adds the noise floor and what would lower the error most; on demand the correlations with their bounds.
pub(super) fn residuals(section: Section, trial: &Compared) -> Section {
    let unit = &trial.record.units().y;
    let floor = |f: Floor| {
        let (rms, share, times) = (short(f.rms), short(f.rms_pp_percent), short(f.error_over_floor));
        let origin = match f.period.zip(f.periods) {
            Some((period, periods)) => format!(
                "The input repeats every {period} samples. Over {periods} such periods the output, without drift, \
                 differs by {rms} {unit} rms"
            ),
            None => format!(
                "The part of the spectrum that the input does not drive, extended over the other, has {rms} {unit} rms"
            ),
        };
        format!(
            "{origin} ({share} % of peak-to-peak): this is the noise floor. The residual of this model is {times} \
             times as large."
        )
    };
    let section = section
        .each(trial.validation.floor, |section, f| section.text(floor(f)))
        .each(&trial.validation.advice, |section, advice| section.text(sentence(advice)));
    let Some(whiteness) = &trial.validation.whiteness else { return section };
    let verdict = whiteness.verdict.iter().map(|text| sentence(text));
    let figures = [autocorrelation(whiteness), cross_correlation(whiteness), over_input(trial)];
    let caption = "For white residuals the autocorrelation, and for residuals uncorrelated with the input the \
        cross-correlation, stays within the shaded bounds at all lags in 99 of 100 records. Plotted over the input, \
        noise is a band of constant height.";
    let tests = Section::new("").list(verdict).figures(3, "Residuals", caption, figures);
    section.details("Tests of the residuals", tests)
}

fn autocorrelation(w: &Whiteness) -> Figure {
    let shown = &w.autocorrelation[..w.autocorrelation.len().min(LAGS)];
    let lags: Vec<f64> = (1..=shown.len()).map(|k| k as f64).collect();
    correlation("with itself", &lags, shown, w.autocorrelation_bound)
}

fn cross_correlation(w: &Whiteness) -> Figure {
    let half = w.cross_correlation.len() / 2;
    let cut = half.saturating_sub(LAGS);
    let shown = &w.cross_correlation[cut..w.cross_correlation.len() - cut];
    let lags: Vec<f64> = (0..shown.len()).map(|k| k as f64 - (half - cut) as f64).collect();
    correlation("with the input, by lag", &lags, shown, w.cross_correlation_bound)
}

fn over_input(trial: &Compared) -> Figure {
    let (record, v) = (&trial.record, &trial.validation);
    let (u, y) = (&record.u()[v.start..], &record.y()[v.start..]);
    let errors: Vec<f64> = y.iter().zip(&v.simulated[v.start..]).map(|(y, s)| y - s).collect();
    let units = record.units();
    let axes = Axes::new(format!("u [{}]", units.u).as_str(), format!("error [{}]", units.y).as_str())
        .titled("over the input");
    let caption = format!("Residual against the input; largest value {} {}.", short(v.metrics.max_abs), units.y);
    Figure::new("over the input", caption).small().panel(axes.with(Series::dots(u, &errors).role(Role::Residual)))
}

fn correlation(title: &str, lags: &[f64], r: &[f64], bound: f64) -> Figure {
    let level = |at: f64| vec![at; lags.len()];
    let largest = r.iter().fold(0.0, |m: f64, r| m.max(r.abs()));
    let [largest, limit] = [short(largest), short(bound)];
    let caption = format!("Correlation of the residual {title}: at most {largest}; the bound is {limit}.");
    let axes = Axes::new("lag [samples]", "correlation")
        .titled(title)
        .with(Series::band(lags, &level(-bound), &level(bound)).role(Role::Muted))
        .with(Series::line(lags, r).role(Role::Residual))
        .at_y(0.0, "");
    Figure::new(title, caption).small().panel(axes)
}
