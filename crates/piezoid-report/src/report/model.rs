//! The model in the report, block by block, from input to output.

use super::{creep, feedback, hysteresis, linear};
use crate::each::Each;
use crate::page::Section;
use piezoid::driver::DriverModel;
use piezoid::hammerstein::{Domain, Model};
use piezoid_numerics::number::{round, short};
use piezoid_verbs::Compared;
use std::f64::consts::TAU;

/// The section on the model.
pub(super) fn section(model: &Model, trials: &[Compared]) -> Section {
    let section = Section::new("The model")
        .each(model.identified(), |section, domain| section.text(known(domain, &model.units().u)))
        .each(model.feedback(), feedback::block)
        .each(model.driver(), |section, driver| section.heading("Driver").text(limits(driver, model)));
    let section = hysteresis::block(section, model, trials);
    let section = creep::block(section, model.creep());
    linear::block(section, model)
}

/// The range of the identification data.
fn known(domain: &Domain, unit: &str) -> String {
    let Domain { u, hz, slew, mean } = *domain;
    let power =
        hz.map_or(String::new(), |[low, high]| format!(", with power from {} to {} Hz", short(low), short(high)));
    // Means that are zero up to rounding.
    let mean = mean.map(|mean| if mean.abs() < 1e-9 * (u[1] - u[0]) { 0.0 } else { mean });
    let ([low, high], [lowest, highest], slew) = (u.map(short), mean.map(short), short(slew));
    format!(
        "Identified on inputs from {low} to {high} {unit}, with means from {lowest} to {highest} {unit}, and rates up \
        to {slew} {unit}/s{power}. Outside this range it extrapolates."
    )
}

fn limits(driver: &DriverModel, model: &Model) -> String {
    let unit = &model.units().u;
    let lag = match driver.lag_s {
        0.0 => "Without a lag".to_string(),
        lag => format!("A lag of {} ms", round(1e3 * lag)),
    };
    let Some(slew) = driver.slew else { return format!("{lag}, and no slew limit.") };
    let sine = model.identified().map(|domain| 0.5 * (domain.u[1] - domain.u[0])).filter(|half| *half > 0.0);
    let sine = sine.map_or(String::new(), |half| {
        let hz = short(slew / (TAU * half));
        format!(
            " A sine of {} {unit} amplitude, the largest in the identification data, reaches the slew limit above \
                 {hz} Hz.",
            round(half)
        )
    });
    format!("{lag}; the voltage changes by at most {} {unit}/s.{sine}", short(slew))
}
