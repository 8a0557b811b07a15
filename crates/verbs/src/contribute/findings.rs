//! What makes contributed records less useful than they could be. docs/contributing-records.md says what is best.

use super::ContributedFile;
use piezoid_numerics::number::{join, round};
use piezoid_records::waveform::in_motion;
use serde_json::Value;

/// Cycles have other rates if the fastest are this much faster than the slowest.
const OTHER_RATE: f64 = 2.0;

/// Those of a record with this input, as `inspect` describes it.
pub(super) fn of_one(inspection: &Value, u: &[f64]) -> Vec<String> {
    let problems = inspection["problems"].as_array().into_iter().flatten();
    let mut found: Vec<String> = problems.filter_map(|text| text.as_str().map(Into::into)).collect();
    if in_motion(u) {
        let remedy = "hold the first voltage for some seconds before the drive begins";
        found.push(format!("the record starts in motion, so that the voltages before it are unknown: {remedy}"));
    }
    found
}

/// Those of all records, whose cycles have these rates [Hz], if they have one rate.
pub(super) fn of_all(files: &[ContributedFile], rates: &[Option<f64>]) -> Vec<String> {
    let is = |name: &str| files.iter().any(|file| file.proposed["use"] == name);
    let mut found = Vec::new();
    if files.len() == 1 {
        found.push("there is one record, so that none can be held out: add one of another kind".into());
    } else if !is("validation") {
        let remedy = "add a random path or a staircase within the same range";
        found.push(format!("no record is of another kind than the others, to be held out: {remedy}"));
    }
    if !is("small-signal") {
        let remedy = "add a PRBS or a multisine of about 1 % of the range";
        found.push(format!("there is no small-signal record for modes and lags: {remedy}"));
    }
    let rates: Option<Vec<f64>> = rates.iter().copied().collect();
    if let Some(rates) = rates {
        let [slow, fast] = [f64::min, f64::max].map(|of| rates.iter().copied().reduce(of).unwrap_or_default());
        if fast < OTHER_RATE * slow {
            let hz = round((10.0 * slow).round() / 10.0);
            found.push(format!("all cycles have about {hz} Hz, which does not show rates: add other frequencies"));
        }
    }
    let mut periods: Vec<f64> = Vec::new();
    for file in files {
        if !periods.contains(&file.ts) {
            periods.push(file.ts);
        }
    }
    if periods.len() > 1 {
        let periods: Vec<String> = periods.iter().map(|ts| round(*ts)).collect();
        let why = "one model has one sampling period";
        found.push(format!("the records are sampled every {} s, but {why}: they are used apart", join(&periods)));
    }
    found
}
