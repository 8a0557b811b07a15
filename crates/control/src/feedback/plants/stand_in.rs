//! A stand-in for an actuator of which only records are known: a second model of these records, of another class.
//!
//! ```text
//! y = A(u) + s (B(u) - A(u)) - c + noise,    s = rms error of A / rms(B - A)    on the records
//! ```
//! A is the model, B the other one. How two models of different classes differ shows where neither is certain: on other
//! amplitudes, at other rates, in minor loops. How large that difference is follows from the records: with the share s
//! the stand-in differs from A by as much as the actuator does. The constant c is the difference at the start, because
//! the zero of a sensor is no property of an actuator.
//!
//! Random stand-ins lie on either side of A, and their B has the spread of its parameters: with F fits, each without one
//! fold, B + z (F - 1)^(1/2) (B_f - B) for a normal z and a random f has the variance of the jackknife.
//!
//! Reference: B. Efron & C. Stein, Ann. Statist. 9, 586 (1981), DOI 10.1214/aos/1176345462 (jackknife). It does not do:
//! errors that all models here share, coloured noise, limits of a driver.

use piezoid_models::hammerstein::{InitialCondition, Model};
use piezoid_numerics::error::Error;
use piezoid_numerics::number::short;
use piezoid_numerics::system::System;
use piezoid_records::record::{Record, Units};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};
use serde::Deserialize;
use serde_json::{Value, json};
use std::fmt::{self, Display, Formatter};

/// The largest share: beyond it, the difference of the two models says nothing about the actuator.
const MAX_SHARE: f64 = 3.0;

/// The most fits without a fold that a file may hold.
const MAX_SPREAD: usize = 64;

/// Words of the generator reserved for a sample of noise.
const WORDS: u128 = 16;

/// A stand-in for a measured actuator.
#[derive(Debug, Clone, PartialEq)]
pub struct StandIn {
    /// The model A of the actuator.
    model: Model,
    /// The model B, of another class.
    other: Model,
    /// B as fitted without each fold.
    spread: Vec<Model>,
    /// The share s of their difference [-].
    share: f64,
    /// The rms error of A on the records, without noise [output unit].
    error: f64,
    /// Rms noise of the sensor [output unit].
    pub(super) noise: f64,
    /// Gain about the start, and what is added to B: of a draw.
    draw: Draw,
}

/// What a draw differs in.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Draw {
    gain: f64,
    /// The number of a fit without a fold, and the factor of its difference from B.
    part: Option<(usize, f64)>,
}

const NOMINAL: Draw = Draw { gain: 1.0, part: None };

/// The members of a file.
#[derive(Deserialize)]
struct Document {
    stand_in: Members,
}

#[derive(Deserialize)]
struct Members {
    model: Value,
    other: Value,
    #[serde(default)]
    spread: Vec<Value>,
    share: f64,
    error: f64,
    noise: f64,
}

impl StandIn {
    /// The stand-in of `model` and of the `other` one, which was fitted to the same records; `spread` is the other one as
    /// fitted without each fold. On the records `model` has the rms `error` [output unit] beside the rms `noise`, and the
    /// two differ by the rms `apart`.
    ///
    /// # Errors
    /// Returns an error for models with different sampling periods or units, and for numbers that are negative or not
    /// finite.
    pub fn new(
        model: Model,
        (other, spread): (Model, Vec<Model>),
        (error, apart): (f64, f64),
        noise: f64,
    ) -> Result<Self, Error> {
        let share = if apart > 0.0 { (error / apart).min(MAX_SHARE) } else { 0.0 };
        StandIn { model, other, spread, share, error, noise, draw: NOMINAL }.checked()
    }

    fn checked(self) -> Result<Self, Error> {
        let numbers = [("share", self.share), ("error", self.error), ("noise", self.noise)];
        for (name, value) in numbers {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(Error::parameter(name, value, "of a stand-in must be a number of 0 or more"));
            }
        }
        let units = self.model.units();
        for other in self.spread.iter().chain([&self.other]) {
            Record::same_sampling("the model", self.model.ts(), "the other model of the stand-in", other.ts())?;
            for (what, found, expected) in
                [("input", &other.units().u, &units.u), ("output", &other.units().y, &units.y)]
            {
                if found != expected {
                    return Err(Error::units(
                        &format!("the {what} of the other model of the stand-in"),
                        found,
                        expected,
                    ));
                }
            }
        }
        Ok(self)
    }

    /// The model that the stand-in is of.
    pub fn model(&self) -> &Model {
        &self.model
    }

    /// The model of another class.
    pub fn other(&self) -> &Model {
        &self.other
    }

    /// The share of their difference [-].
    pub fn share(&self) -> f64 {
        self.share
    }

    /// The rms error of the model on the records, without noise [output unit].
    pub fn error(&self) -> f64 {
        self.error
    }

    /// Rms noise of the sensor [output unit].
    pub fn noise(&self) -> f64 {
        self.noise
    }

    /// Units of voltage and displacement.
    pub fn units(&self) -> &Units {
        self.model.units()
    }

    /// Sampling period [s].
    pub fn ts(&self) -> f64 {
        self.model.ts()
    }

    /// True if a document is a stand-in.
    pub(super) fn is_in(document: &Value) -> bool {
        document.get("stand_in").is_some()
    }

    /// The stand-in as a file.
    pub fn to_json(&self) -> String {
        let document = |model: &Model| serde_json::from_str::<Value>(&model.to_json()).unwrap_or_default();
        let StandIn { model, other, spread, share, error, noise, .. } = self;
        let spread: Vec<Value> = spread.iter().map(document).collect();
        json!({"stand_in": {
            "share": share, "error": error, "noise": noise,
            "model": document(model), "other": document(other), "spread": spread,
        }})
        .to_string()
    }

    /// The stand-in in the text of a file.
    ///
    /// # Errors
    /// Returns an error for another document, and the errors of [`StandIn::new`] and [`Model::from_json`].
    pub fn from_json(text: &str) -> Result<Self, Error> {
        let refused = |e: serde_json::Error| Error::Content(format!("this is no stand-in ({e}): make it again"));
        let Document { stand_in } = serde_json::from_str(text).map_err(refused)?;
        let Members { model, other, spread, share, error, noise } = stand_in;
        if spread.len() > MAX_SPREAD {
            let rule = format!("is the number of fits in the stand-in, and must be at most {MAX_SPREAD}");
            return Err(Error::parameter("spread", spread.len(), rule));
        }
        let read = |document: &Value| Model::from_json(&document.to_string());
        let spread = spread.iter().map(read).collect::<Result<_, _>>()?;
        let share = share.min(MAX_SHARE);
        StandIn { model: read(&model)?, other: read(&other)?, spread, share, error, noise, draw: NOMINAL }.checked()
    }

    /// Stand-in `i` of those drawn with `seed`, on either side of the model, with the spread of the parameters and a gain
    /// that differs by up to `share`.
    ///
    /// # Errors
    /// Returns an error for a share outside 0 to below 1.
    pub(super) fn drawn(&self, share: f64, seed: u64, i: u64) -> Result<Self, Error> {
        if !(0.0..1.0).contains(&share) {
            return Err(Error::parameter("share", share, "must be from 0 to below 1"));
        }
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(i);
        let gain = 1.0 + share * (2.0 * random.random::<f64>() - 1.0);
        let side = if random.random::<bool>() { 1.0 } else { -1.0 };
        let normal: f64 = StandardNormal.sample(&mut random);
        let folds = self.spread.len();
        let part = (folds > 1).then(|| (random.random_range(0..folds), normal * ((folds - 1) as f64).sqrt()));
        Ok(StandIn { share: side * self.share, draw: Draw { gain, part }, ..self.clone() })
    }

    /// The stand-in as a plant, with noise of `seed`.
    pub fn plant(&self, seed: u64) -> StandInPlant {
        let part = self.draw.part.and_then(|(k, factor)| Some((self.spread.get(k)?.clone(), factor)));
        StandInPlant {
            model: self.model.clone(),
            other: self.other.clone(),
            part,
            share: self.share,
            gain: self.draw.gain,
            noise: self.noise,
            generator: ChaCha8Rng::seed_from_u64(seed),
        }
    }
}

/// What it consists of, in one sentence.
impl Display for StandIn {
    fn fmt(&self, f: &mut Formatter) -> fmt::Result {
        let operator = self.other.hysteresis().operator().name;
        let unit = &self.model.units().y;
        let [percent, error, noise] = [100.0 * self.share, self.error, self.noise].map(short);
        write!(
            f,
            "The stand-in is the model and {percent} % of its difference from a model with {operator}: on the records it \
             differs from the model by {error} {unit} rms, as the actuator does"
        )?;
        if self.share >= MAX_SHARE {
            write!(f, " at least, because both models have the same errors")?;
        }
        if self.noise > 0.0 { write!(f, "; noise {noise} {unit}") } else { Ok(()) }
    }
}

/// A stand-in as a plant. State: number of samples, c [output unit], output at the start [output unit], then the states
/// of the models.
#[derive(Debug, Clone)]
pub struct StandInPlant {
    model: Model,
    other: Model,
    /// A fit of the other model without a fold, and the factor of the difference.
    part: Option<(Model, f64)>,
    share: f64,
    gain: f64,
    noise: f64,
    generator: ChaCha8Rng,
}

const SAMPLES: usize = 0;
const ASIDE: usize = 1;
const START: usize = 2;
const HEAD: usize = 3;

impl StandInPlant {
    /// The models, and what each counts in the sum.
    fn terms(&self) -> impl Iterator<Item = (&Model, f64)> {
        let of_part = self.part.as_ref().map_or(0.0, |(_, factor)| *factor);
        let terms = [(&self.model, 1.0 - self.share), (&self.other, self.share * (1.0 - of_part))];
        terms.into_iter().chain(self.part.iter().map(|(part, factor)| (part, self.share * factor)))
    }

    /// The state before the inputs `u`.
    pub fn before(&self, u: &[f64], condition: InitialCondition) -> Vec<f64> {
        self.beginning(u.first().copied().unwrap_or_default(), |model| model.before(u, condition))
    }

    /// The state in which each model has that of `of`, with the zero of the sensor at the displacement of A with `u`.
    fn beginning(&self, u: f64, of: impl Fn(&Model) -> Vec<f64>) -> Vec<f64> {
        let mut x = vec![0.0; HEAD];
        let mut sum = 0.0;
        for (k, (model, weight)) in self.terms().enumerate() {
            let state = of(model);
            let y = model.step(&mut state.clone(), u);
            sum += weight * y;
            if k == 0 {
                x[START] = y;
            }
            x.extend(state);
        }
        x[ASIDE] = sum - x[START];
        x
    }

    /// The reading of the sensor for the `sum` of the models.
    fn read(&self, head: &mut [f64], sum: f64) -> f64 {
        let y = head[START] + self.gain * (sum - head[ASIDE] - head[START]);
        let n = head[SAMPLES] as u64;
        head[SAMPLES] += 1.0;
        if self.noise > 0.0 { y + self.noise * self.normal(n) } else { y }
    }

    /// The n-th standard normal number of the seed.
    fn normal(&self, n: u64) -> f64 {
        let mut generator = self.generator.clone();
        generator.set_word_pos(WORDS * u128::from(n));
        StandardNormal.sample(&mut generator)
    }
}

impl System for StandInPlant {
    fn ts(&self) -> f64 {
        self.model.ts()
    }

    fn order(&self) -> usize {
        HEAD + self.terms().map(|(model, _)| model.order()).sum::<usize>()
    }

    fn initial(&self) -> Vec<f64> {
        self.beginning(0.0, Model::initial)
    }

    fn settled(&self, u: f64) -> Vec<f64> {
        self.beginning(u, |model| model.settled(u))
    }

    fn step(&self, x: &mut [f64], u: f64) -> f64 {
        let (head, mut states) = x.split_at_mut(HEAD);
        let mut sum = 0.0;
        for (model, weight) in self.terms() {
            let (state, rest) = states.split_at_mut(model.order());
            sum += weight * model.step(state, u);
            states = rest;
        }
        self.read(head, sum)
    }

    fn respond(&self, x: &mut [f64], signal: &mut [f64]) {
        let (head, mut states) = x.split_at_mut(HEAD);
        let (mut sum, mut own) = (vec![0.0; signal.len()], vec![0.0; signal.len()]);
        for (model, weight) in self.terms() {
            let (state, rest) = states.split_at_mut(model.order());
            own.copy_from_slice(signal);
            model.respond(state, &mut own);
            sum.iter_mut().zip(&own).for_each(|(sum, y)| *sum += weight * y);
            states = rest;
        }
        signal.iter_mut().zip(sum).for_each(|(value, sum)| *value = self.read(head, sum));
    }
}
