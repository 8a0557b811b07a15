//! A stand-in for the actuator of a model: a second model of the same records, whose operator is of another class.
//!
//! The error of the model is the part of its free runs on the records that neither noise nor a constant explains, times
//! the ratio of held-out to fitted error at its identification: a model that fits its own records better than others has
//! learned some of their noise.

use super::origin::{Recipe, sources_of};
use super::{DataFile, Source};
use crate::identification::{IdentifyOptions, Method, Records};
use piezoid_control::feedback::StandIn;
use piezoid_identification::{Effort, feedback::Structure};
use piezoid_models::hammerstein::Model;
use piezoid_models::hysteresis::{Class, OPERATORS};
use piezoid_numerics::error::Error;
use piezoid_numerics::progress::Progress;
use piezoid_numerics::series::mean;
use piezoid_records::record::Record;
use piezoid_validation::{Offset, Validate, ValidateOptions};

/// The stand-in for the actuator of `model`, from the files that it was identified from, in any order.
///
/// # Errors
/// Returns an error if the model does not state its files or a file is missing or differs; the errors of
/// [`stand_in`].
pub fn stand_in_from(model: &Model, files: &[DataFile], progress: &mut Progress) -> Result<StandIn, Error> {
    let (small, large) = sources_of(model, files)?;
    let read = |sources: Vec<Source>| sources.iter().map(Source::record).collect::<Result<Vec<_>, Error>>();
    let (small, large) = (read(small)?, read(large)?);
    stand_in(model, Records { small_signal: &small, large_signal: &large }, progress)
}

/// The stand-in for the actuator of `model`, from records of it.
///
/// # Errors
/// The errors of [`identify`](crate::identify), and [`Error::Cancelled`].
pub fn stand_in(model: &Model, records: Records, progress: &mut Progress) -> Result<StandIn, Error> {
    let found = records.identify(&others(model), progress)?.finished()?;
    let judged = if records.large_signal.is_empty() { records.small_signal } else { records.large_signal };
    let y = &model.units().y;
    let judged = judged.iter().map(|record| record.output_in(y)).collect::<Result<Vec<Record>, Error>>()?;
    let options = ValidateOptions { offset: Offset::Free, ..ValidateOptions::default() };
    let (mut samples, mut error, mut noise, mut apart) = (0.0, 0.0, 0.0, 0.0);
    for record in &judged {
        let [own, other] = [model, &found.model].map(|model| model.validate_with(record, &options));
        let (own, other) = (own?, other?);
        let n = record.len() as f64;
        let differences: Vec<f64> = own.simulated.iter().zip(&other.simulated).map(|(a, b)| a - b).collect();
        let middle = mean(&differences);
        samples += n;
        error += n * own.metrics.mse;
        noise += n * own.floor.map_or(0.0, |floor| floor.rms.powi(2));
        apart += differences.iter().map(|d| (d - middle).powi(2)).sum::<f64>();
    }
    let [error, noise, apart] = [error, noise, apart].map(|sum| (sum / samples).sqrt());
    let error = ((error * overfit(model)).powi(2) - noise.powi(2)).max(0.0).sqrt();
    StandIn::new(model.clone(), (found.model, found.spread), (error, apart), noise)
}

/// How to identify the other model: as this one, but with the operators of other classes that have minor loops, and with
/// a linear block of its own.
fn others(model: &Model) -> IdentifyOptions {
    let own = Recipe::of(model).and_then(|recipe| recipe.options()).unwrap_or_default();
    let own = if own.method == Method::Joint { own } else { IdentifyOptions::default() };
    let class = model.hysteresis().operator().class;
    let is_other = |row: Class| row != class && !matches!(row, Class::Linear | Class::Branches);
    let without: String =
        OPERATORS.iter().filter(|row| !is_other(row.class)).map(|row| format!(",-{}", row.name)).collect();
    let effort = if own.effort == Effort::Quick { Effort::Usual } else { own.effort };
    let (operator, structure) = (format!("auto{without}"), Structure::Hammerstein);
    IdentifyOptions { operator, structure, effort, order: None, elements: None, fractional_creep: false, ..own }
}

/// The held-out error of a model over the fitted one, at least 1; 1 if its file does not state them.
fn overfit(model: &Model) -> f64 {
    let trials = model.provenance()["trials"].as_array();
    let taken = trials.into_iter().flatten().find(|trial| trial["verdict"] == "taken");
    let of = |name: &str| taken.and_then(|trial| trial[name].as_f64());
    match (of("held_out_percent"), of("free_run_percent")) {
        (Some(held_out), Some(fitted)) if fitted > 0.0 => (held_out / fitted).max(1.0),
        _ => 1.0,
    }
}
