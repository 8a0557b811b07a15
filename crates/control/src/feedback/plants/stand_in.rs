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
//! Random stand-ins lie on either side of A, and their B has the spread of its parameters: with F fits, each without
//! one fold, B + z (F - 1)^(1/2) (B_f - B) for a normal z and a random f has the variance of the jackknife.
//!
//! Reference: B. Efron & C. Stein, Ann. Statist. 9, 586 (1981), DOI 10.1214/aos/1176345462 (jackknife). It does not do:
//! errors that all models here share, coloured noise, limits of a driver.

use piezoid_models::hammerstein::{InitialCondition, Model};
use piezoid_numerics::error::Error;
use piezoid_numerics::noise::Noise;
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
    /// The stand-in of `model` and of the `other` one, which was fitted to the same records; `spread` is the other one
    /// as fitted without each fold. On the records `model` has the rms `error` [output unit] beside the rms `noise`,
    /// and both differ by the rms `apart`.
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

    /// # Errors
    /// Returns an error if its input is no voltage in V, as drivers and controllers have it.
    pub(super) fn in_volts(&self) -> Result<(), Error> {
        let unit = &self.units().u;
        if unit == "V" { Ok(()) } else { Err(Error::units("the input of the stand-in", unit, "V")) }
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
        let refused = |e: serde_json::Error| {
            Error::Content(format!("this is no stand-in ({e}): give a file that `stand-in` wrote"))
        };
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

    /// Stand-in `i` of those drawn with `seed`, on either side of the model, with the spread of the parameters and a
    /// gain that differs by up to `share`.
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
            rms: self.noise,
            noise: Noise::new(seed),
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
    rms: f64,
    noise: Noise,
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
        if self.rms > 0.0 { y + self.rms * self.noise.at(n) } else { y }
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

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use piezoid_models::hammerstein::Domain;
    use piezoid_models::hysteresis::{Operator, Proportional};
    use piezoid_models::linear::Arx;
    use std::sync::Arc;

    const TS: f64 = 1e-3;

    fn model(operator: &str, offset: f64) -> Model {
        let hysteresis = (Operator::find(operator).unwrap().example)(TS).unwrap();
        Model::new(hysteresis, Arx::new(TS, vec![0.5], vec![0.0, 0.5]).unwrap(), offset).unwrap()
    }

    /// A stand-in with this share of the difference from a model with an offset of 7, without noise.
    pub(in super::super) fn with_share(share: f64) -> StandIn {
        let spread = [1.0, 2.0, 4.0].map(|offset| model("stop", offset));
        let other = (model("preisach", 7.0), spread.into());
        let domain = Domain { u: [-20.0, 60.0], hz: None, slew: 1e4, mean: [0.0, 20.0] };
        let first = model("prandtl-ishlinskii", 0.0).with_identified(domain);
        StandIn::new(first, other, (share, 1.0), 0.0).unwrap()
    }

    fn drive() -> Vec<f64> {
        (0..400).map(|t| 5.0 + (5.0 + 0.04 * f64::from(t)) * (0.05 * f64::from(t)).sin()).collect()
    }

    fn response(stand_in: &StandIn, seed: u64) -> Vec<f64> {
        let (plant, u) = (stand_in.plant(seed), drive());
        plant.resume(&mut plant.settled(u[0]), &u)
    }

    fn of_model(model: &Model) -> Vec<f64> {
        let u = drive();
        model.resume(&mut model.settled(u[0]), &u)
    }

    #[test]
    fn it_lies_between_both_models_and_begins_where_the_first_one_does() {
        let (a, b) = (of_model(&model("prandtl-ishlinskii", 0.0)), of_model(&model("preisach", 7.0)));
        for share in [0.0, 0.25, 1.0, 2.0] {
            let y = response(&with_share(share), 0);
            for t in 0..a.len() {
                let expected = a[t] + share * ((b[t] - b[0]) - (a[t] - a[0]));
                assert!((y[t] - expected).abs() < 1e-9, "{share}: {} instead of {expected} at {t}", y[t]);
            }
        }
    }

    #[test]
    fn every_initial_condition_is_that_of_both_models() {
        let (u, stand_in) = (drive(), with_share(0.25));
        let plant = stand_in.plant(0);
        let run = |model: &Model, condition| model.resume(&mut model.before(&u, condition), &u);
        for condition in [InitialCondition::Rest, InitialCondition::FromBelow, InitialCondition::FromAbove] {
            let [a, b] = [stand_in.model(), stand_in.other()].map(|model| run(model, condition));
            let y = plant.resume(&mut plant.before(&u, condition), &u);
            for t in 0..u.len() {
                let expected = a[t] + 0.25 * ((b[t] - b[0]) - (a[t] - a[0]));
                assert!((y[t] - expected).abs() < 1e-9, "{condition:?}: {} instead of {expected} at {t}", y[t]);
            }
        }
    }

    #[test]
    fn models_that_agree_have_no_share_and_a_share_ends_at_its_limit() {
        let pair = |error, apart| {
            let other = (model("stop", 0.0), Vec::new());
            StandIn::new(model("stop", 0.0), other, (error, apart), 0.0).unwrap()
        };
        assert_eq!([pair(1.0, 0.0).share(), pair(1.0, 0.1).share(), pair(1.0, 4.0).share()], [0.0, MAX_SHARE, 0.25]);
        assert!(pair(1.0, 0.1).to_string().contains("at least, because both models have the same errors"));
        assert!(!pair(1.0, 4.0).to_string().contains("at least"));
    }

    #[test]
    fn steps_are_the_whole_run_to_the_bit_with_noise_of_its_rms() {
        let stand_in = StandIn { noise: 0.5, ..with_share(0.5) };
        for stand_in in [stand_in.clone(), stand_in.drawn(0.1, 3, 1).unwrap()] {
            let (plant, u) = (stand_in.plant(4), drive());
            let mut x = plant.settled(u[0]);
            assert_eq!(x.len(), plant.order());
            let steps: Vec<f64> = u.iter().map(|u| plant.step(&mut x, *u)).collect();
            assert_eq!(steps, response(&stand_in, 4));
            assert_ne!(steps, response(&stand_in, 5));
        }
        let quiet = response(&with_share(0.5), 4);
        let noise: f64 = response(&stand_in, 4).iter().zip(&quiet).map(|(a, b)| (a - b) * (a - b)).sum();
        let rms = (noise / quiet.len() as f64).sqrt();
        assert!((0.45..0.55).contains(&rms), "{rms}");
    }

    #[test]
    fn draws_lie_on_either_side_of_the_model_with_the_spread_and_repeat() {
        let stand_in = with_share(0.5);
        let draws: Vec<StandIn> = (0..40).map(|i| stand_in.drawn(0.0, 1, i).unwrap()).collect();
        let above = draws.iter().filter(|drawn| drawn.share > 0.0).count();
        assert!((10..30).contains(&above), "{above}");
        assert!(draws.iter().all(|drawn| drawn.draw.gain == 1.0 && drawn.draw.part.is_some()));
        assert_eq!(draws[7], stand_in.drawn(0.0, 1, 7).unwrap());
        let variance: f64 = draws.iter().filter_map(|drawn| drawn.draw.part).map(|(_, z)| z * z).sum::<f64>() / 40.0;
        // (F - 1) for F = 3.
        assert!((1.0..3.5).contains(&variance), "{variance}");
        let gains = (0..40).map(|i| stand_in.drawn(0.2, 1, i).unwrap().draw.gain);
        assert!(gains.clone().all(|gain| (0.8..1.2).contains(&gain)) && gains.clone().any(|gain| gain > 1.1));
        assert!(stand_in.drawn(1.0, 1, 0).is_err());
    }

    #[test]
    fn its_file_gives_it_again_and_a_wrong_one_an_error() {
        let stand_in = with_share(0.5);
        let text = stand_in.to_json();
        assert_eq!(StandIn::from_json(&text).unwrap(), stand_in);
        let changed = |from: &str, to: &str| {
            let other = text.replace(from, to);
            assert_ne!(other, text, "{from}");
            StandIn::from_json(&other).unwrap_err().to_string()
        };
        assert!(changed("\"share\":0.5", "\"share\":-1").starts_with("share = -1"), "{text}");
        assert!(changed("\"noise\":0.0", "\"noise\":1e999").contains("no stand-in"));
        assert!(changed("\"share\":0.5,", "").contains("missing field `share`"));
        let quick = Model::new(Arc::new(Proportional::new(2e-3, 1.0).unwrap()), Arx::gain(2e-3, 1.0).unwrap(), 0.0);
        let apart = StandIn::new(quick.unwrap(), (model("stop", 0.0), Vec::new()), (1.0, 1.0), 0.0);
        assert!(apart.unwrap_err().to_string().contains("the other model of the stand-in every 0.001 s"));
    }

    #[test]
    fn a_draw_adds_its_part_of_the_spread_and_has_its_gain_about_the_start() {
        let drawn = with_share(0.5).drawn(0.2, 3, 2).unwrap();
        let (share, Draw { gain, part }) = (drawn.share, drawn.draw);
        let (k, factor) = part.unwrap();
        assert!(share.abs() == 0.5 && gain != 1.0 && factor != 0.0, "{:?}", drawn.draw);
        let [a, b, without] = [&drawn.model, &drawn.other, &drawn.spread[k]].map(of_model);
        let y = response(&drawn, 0);
        for t in 0..a.len() {
            let moved = |x: &[f64]| x[t] - x[0];
            let other = moved(&b) + factor * (moved(&without) - moved(&b));
            let expected = a[0] + gain * (moved(&a) + share * (other - moved(&a)));
            assert!((y[t] - expected).abs() < 1e-9, "{} instead of {expected} at {t}", y[t]);
        }
    }

    #[test]
    fn the_factor_of_the_spread_grows_with_the_root_of_the_fits_without_the_first() {
        let factor = |fits: usize, i: u64| {
            let stand_in = StandIn { spread: vec![model("stop", 1.0); fits], ..with_share(0.5) };
            stand_in.drawn(0.0, 1, i).unwrap().draw.part.map(|(_, factor)| factor)
        };
        // The same normal number by 1 and by 2.
        (0..5).for_each(|i| assert_eq!(factor(5, i), factor(2, i).map(|factor| 2.0 * factor)));
        assert_eq!([factor(1, 0), factor(0, 0)], [None, None]);
    }

    #[test]
    fn from_its_initial_state_it_is_both_models_from_theirs() {
        let (u, stand_in) = (drive(), with_share(0.25));
        let [a, b] = [stand_in.model(), stand_in.other()];
        let [first_a, first_b] = [a, b].map(|model| model.step(&mut model.initial(), 0.0));
        let ([a, b], y) = ([a, b].map(|model| model.simulate(&u)), stand_in.plant(0).simulate(&u));
        for t in 0..u.len() {
            let expected = a[t] + 0.25 * ((b[t] - first_b) - (a[t] - first_a));
            assert!((y[t] - expected).abs() < 1e-9, "{} instead of {expected} at {t}", y[t]);
        }
    }

    #[test]
    fn its_sentence_states_share_error_and_noise() {
        let quiet = with_share(0.25);
        let noisy = StandIn { noise: 0.5, ..with_share(0.25) };
        assert_eq!([noisy.share(), noisy.error(), noisy.noise()], [0.25, 0.25, 0.5]);
        let text = quiet.to_string();
        assert!(text.contains("the model and 25.00 % of its difference from a model with preisach"), "{text}");
        assert!(text.ends_with("by 0.2500 um rms, as the actuator does"), "{text}");
        assert!(noisy.to_string().ends_with("as the actuator does; noise 0.5000 um"), "{noisy}");
    }

    #[test]
    fn units_that_differ_or_are_no_voltage_and_too_many_fits_are_errors() {
        let with = |u: &str, y: &str| model("stop", 0.0).with_units(Units { u: u.into(), y: y.into() });
        let of = |other: Model, part: Model| StandIn::new(with("A", "um"), (other, vec![part]), (1.0, 1.0), 0.0);
        let amperes = of(with("A", "um"), with("A", "um")).unwrap();
        assert!(amperes.in_volts().is_err() && with_share(0.5).in_volts().is_ok());
        for (other, part, what) in [(("V", "um"), ("A", "um"), "input"), (("A", "um"), ("A", "mm"), "output")] {
            let message = of(with(other.0, other.1), with(part.0, part.1)).unwrap_err().to_string();
            assert!(message.contains(&format!("the {what} of the other model")), "{message}");
        }
        let written = |fits: usize| StandIn { spread: vec![model("stop", 1.0); fits], ..with_share(0.5) }.to_json();
        assert!(StandIn::from_json(&written(MAX_SPREAD)).is_ok());
        assert!(StandIn::from_json(&written(MAX_SPREAD + 1)).unwrap_err().to_string().starts_with("spread = 65"));
    }
}
