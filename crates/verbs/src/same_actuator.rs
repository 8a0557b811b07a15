//! Whether a simulated plant and a model are of the same actuator, as far as voltages and static displacements tell.
//!
//! Both are held at the ends of the voltages that the model is used for. A plant of another actuator is simulated all
//! the same, because controllers can be tried on any plant; but then the errors say nothing about the model. The zero
//! of a sensor is no property of an actuator: if only that differs, the plant's sensor gets the zero of the model's.

use piezoid_control::compensation::FeedForwardSettings;
use piezoid_control::feedback::SimulatedActuator;
use piezoid_models::hammerstein::Model;
use piezoid_numerics::error::Error;
use piezoid_numerics::number::short;
use piezoid_numerics::system::System;
use piezoid_records::record::Units;
use piezoid_twins::{Plant, Spec};

/// Ratio of two strokes from which they are of different actuators.
const FACTOR: f64 = 2.0;

/// Excess of a voltage range without a note, as its share: records overshoot.
const BEYOND: f64 = 0.02;

/// Distance between the displacements in the middle, over the stroke, from which the zeros differ. A smaller distance
/// is an error of the model, which must show.
const ASIDE: f64 = 0.5;

/// The plant to simulate for `model`, and a note if it is another actuator, or if its zero was moved.
///
/// # Errors
/// The errors of [`Plant::new`] and [`FeedForwardSettings::ends`].
pub(super) fn matched(
    (name, actuator): (&str, &SimulatedActuator),
    model: &Model,
    settings: &FeedForwardSettings,
) -> Result<(SimulatedActuator, Option<String>), Error> {
    match actuator {
        SimulatedActuator::Twin(spec) => {
            matched_twin((name, spec), model, settings).map(|(spec, note)| (spec.into(), note))
        }
        SimulatedActuator::StandIn(_) => Ok((actuator.clone(), None)),
    }
}

fn matched_twin(
    (name, spec): (&str, &Spec),
    model: &Model,
    settings: &FeedForwardSettings,
) -> Result<(Spec, Option<String>), Error> {
    let mut spec = spec.clone();
    let (ends, units) = (settings.ends(model)?, model.units());
    // Without the allowance beyond the identified range.
    let (low, high) = model.known_inputs().map_or(ends, |known| (ends.0.max(known.0), ends.1.min(known.1)));
    // An output that is no length is an error of the comparison.
    let (Some(factor), true) = (Units::factor("um", &units.y), low < high) else { return Ok((spec, None)) };
    let plant = Plant::new(&spec, model.ts())?;
    let (least, most) = (spec.driver.min_v, spec.driver.max_v);
    let slack = BEYOND * (high - low);
    let exceeds = low < least - slack || high > most + slack;
    let (from, to) = (low.max(least), high.min(most));
    let of_plant = |u: f64| factor * (plant.tip(&plant.settled(u)) + 1e6 * spec.sensor.zero_m);
    let of_model = |u: f64| model.offset() + model.linear().dc_gain() * model.settled_before_linear(u);
    let stroke = |of: &dyn Fn(f64) -> f64| of(to) - of(from);
    let (plants, models) = (stroke(&of_plant), stroke(&of_model));
    let differs = from < to && !(1.0 / FACTOR..=FACTOR).contains(&(plants / models));
    let (u, y) = (&units.u, &units.y);
    let mut different = Vec::new();
    if exceeds {
        let [low, high, least, most] = [low, high, least, most].map(short);
        different.push(format!(
            "the model is used from {low} to {high} {u}, but the driver of the plant gives {least} to {most} V"
        ));
    }
    if differs {
        let [from, to, plants, models] = [from, to, plants, models].map(short);
        different.push(format!("from {from} to {to} {u} the plant moves by {plants} {y}, the model by {models} {y}"));
    }
    if !different.is_empty() {
        let note = format!(
            "The plant `{name}` is not the actuator of this model: {}. The errors say nothing about the model. Choose \
             the plant of its actuator, or make a plant of your own",
            different.join("; ")
        );
        return Ok((spec, Some(note)));
    }
    let middle = 0.5 * low + 0.5 * high;
    let apart = of_model(middle) - of_plant(middle);
    if apart.abs() <= ASIDE * models.abs() {
        return Ok((spec, None));
    }
    let [at, model_at, plant_at] = [middle, of_model(middle), of_plant(middle)].map(short);
    spec.sensor.zero_m += 1e-6 * apart / factor;
    let note = format!(
        "At {at} {u} the model is at {model_at} {y}, the plant `{name}` at {plant_at} {y}: the zeros of their sensors \
         differ. The zero of the plant is moved by {} {y}, so that both agree at {at} {u}",
        short(apart)
    );
    Ok((spec, Some(note)))
}
