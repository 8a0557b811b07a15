//! A stand-in for the actuator of a model: a second model of the same records, whose operator is of another class.
//!
//! The error of the model is the part of its free runs on the records that neither noise nor a constant explains. The
//! error of these runs is first multiplied by the ratio of held-out to fitted error at the identification: a model that
//! fits its own records better than others has learned some of their noise. The result is at least the noise, because
//! records do not show a smaller error.

use super::Source;
use super::origin::{Recipe, sources_of};
use crate::identification::{IdentifyOptions, Method, Records};
use piezoid_control::feedback::StandIn;
use piezoid_identification::{Effort, feedback::Structure};
use piezoid_models::hammerstein::Model;
use piezoid_models::hysteresis::{Class, OPERATORS, Operator};
use piezoid_numerics::error::Error;
use piezoid_numerics::progress::Progress;
use piezoid_numerics::series::mean;
use piezoid_records::record::Record;
use piezoid_validation::{Offset, Validate, ValidateOptions};

/// The stand-in for the actuator of `model`, from the files that it was identified from, in any order; they are read as
/// the model states, unless they were derived from these files.
///
/// # Errors
/// Returns an error if the model does not state its files or a file is missing or differs; the errors of
/// [`stand_in`].
pub fn stand_in_from(model: &Model, files: &[Source], progress: &mut Progress) -> Result<StandIn, Error> {
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
    let found = records.identify(&others(model, records.small_signal.is_empty()), progress)?.finished()?;
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
    let error = ((error * overfit(model)).powi(2) - noise.powi(2)).max(noise.powi(2)).sqrt();
    StandIn::new(model.clone(), (found.model, found.spread), (error, apart), noise)
}

/// How to identify the other model: as this one, but with the operators of other classes that have minor loops, and
/// with a linear block of its own.
fn others(model: &Model, is_large_signal_alone: bool) -> IdentifyOptions {
    let own = Recipe::of(model).and_then(|recipe| recipe.options()).unwrap_or_default();
    let own = if own.method == Method::Joint { own } else { IdentifyOptions::default() };
    let class = model.hysteresis().operator().class;
    // All of them, although records without minor loops do not show which one has the right ones: that is where the
    // two models should differ then.
    let suits = |row: &&&Operator| {
        let is_other = row.class != class && !matches!(row.class, Class::Linear | Class::Branches | Class::Learned);
        is_other && (row.rate_independent || !is_large_signal_alone)
    };
    let names: Vec<&str> = OPERATORS.iter().filter(suits).map(|row| row.name).collect();
    let effort = if own.effort == Effort::Quick { Effort::Usual } else { own.effort };
    let (operator, structure) = (names.join(","), Structure::Hammerstein);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{DataFile, File};
    use piezoid_models::linear::Arx;
    use piezoid_numerics::progress::Stage;
    use piezoid_numerics::system::System;
    use piezoid_records::formats::{ColumnSelection, Table};
    use piezoid_twins::Plant;

    const TS: f64 = 1e-3;

    fn files() -> Vec<DataFile> {
        let file = |(k, hz): (usize, f64)| -> DataFile {
            let u: Vec<f64> = (0..2000)
                .map(|t| 0.014 * f64::from(t) * (std::f64::consts::TAU * hz * TS * f64::from(t)).sin())
                .collect();
            let y = Plant::named("pl140", TS).unwrap().with_seed(k as u64).run(&u).y;
            let name = format!("rise{k}.csv");
            let bytes = Table::write(&name, TS, &[("u_V", &u), ("y_um", &y)]).unwrap();
            File::new(name, bytes).into()
        };
        [4.0, 9.0].into_iter().enumerate().map(file).collect()
    }

    fn sources() -> Vec<Source> {
        Source::all(files(), &ColumnSelection::default())
    }

    fn identified(operator: &str) -> Model {
        let options = IdentifyOptions { operator: operator.into(), order: Some(2), ..IdentifyOptions::default() };
        options.run((Vec::new(), sources()), "", &mut Stage::ignore).unwrap().found.model
    }

    /// With few plays the model has an error that a Preisach operator shows.
    #[test]
    fn a_stand_in_differs_from_the_model_as_much_as_the_records_do() {
        let model = identified("prandtl-ishlinskii");
        let found = stand_in_from(&model, &sources(), &mut Stage::ignore).unwrap();
        assert_ne!(found.other().hysteresis().operator().class, Class::Plays);
        let options = ValidateOptions { offset: Offset::Free, ..ValidateOptions::default() };
        let records: Vec<Record> =
            files().iter().map(|file| file.record(&ColumnSelection::default()).unwrap()).collect();
        let measured = records.iter().map(|record| model.validate_with(record, &options).unwrap().metrics.mse);
        let measured = mean(&measured.collect::<Vec<_>>()).sqrt();
        assert!((0.8..1.3).contains(&(found.error() / measured)), "{} {measured}", found.error());
        let apart = records.iter().map(|record| {
            let plant = found.plant(0);
            let own = model.simulate(record.u());
            let other = plant.simulate(record.u());
            let differences: Vec<f64> = own.iter().zip(&other).map(|(a, b)| a - b).collect();
            let middle = mean(&differences);
            mean(&differences.iter().map(|d| (d - middle).powi(2)).collect::<Vec<_>>())
        });
        let apart = mean(&apart.collect::<Vec<_>>()).sqrt();
        assert!((0.6..1.6).contains(&(apart / found.error())), "{apart} {}", found.error());
    }

    #[test]
    fn the_other_operators_are_of_other_classes_with_minor_loops() {
        let of = |operator: &str, is_large_signal_alone: bool| {
            let hysteresis = (Operator::find(operator).unwrap().example)(TS).unwrap();
            let model = Model::new(hysteresis, Arx::gain(TS, 1.0).unwrap(), 0.0).unwrap();
            others(&model, is_large_signal_alone).operator
        };
        assert!(of("stop", false).starts_with("preisach,krasnoselskii-pokrovskii,bouc-wen,"), "{}", of("stop", false));
        assert!(of("preisach", false).contains("maxwell-slip") && !of("preisach", true).contains("maxwell-slip"));
        assert!(!of("proportional", true).contains("two-branch") && of("narx", true).contains("tellinen"));
    }

    #[test]
    fn a_stand_in_needs_all_records_and_stops_when_it_is_cancelled() {
        let model = identified("proportional");
        let error = stand_in_from(&model, &sources()[..1], &mut Stage::ignore).unwrap_err().to_string();
        assert!(error.contains("rise1.csv"), "{error}");
        let mut stop = |_: Stage| std::ops::ControlFlow::Break(());
        let error = stand_in_from(&model, &sources(), &mut stop).unwrap_err();
        assert!(matches!(error, Error::Cancelled { .. }), "{error}");
    }
}
