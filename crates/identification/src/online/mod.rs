//! Recursive identification: gain, offset, hysteresis weights and linear block of a model follow a stream of samples.
//!
//! ```text
//! y_t = g v_t + c + e_t,    v = B(q) / A(q) sum_m f_m C(q) s_m,    s_m = sum_(k in group m) w_k phi_k[u]
//! e_t = y_t - g v_t - c                                     error of the free run with the present parameters
//! dy/dg = v,  dy/dc = 1,  dy/df_m = g B/A C s_m,  dy/da_i = g q^-i v / A,  dy/db_j = g q^-j (sum_m f_m C s_m) / A
//! ```
//! C is creep and the thresholds are fixed. The weights move in groups, by a factor f_m each. Three estimators share
//! the error, each a regularised recursive least squares in factored form (`factor`): gain and offset with a short
//! memory, the factors of the groups and the coefficients a, b with a long one, these in turn. The error is that of the
//! free run, so noise of y leads to no bias (Ljung & Soderstrom 1983, "Theory and Practice of Recursive
//! Identification", MIT Press, sections 3.6 and 5.6, recursive prediction-error methods; Eskinat, Johnson & Luyben
//! 1991, DOI 10.1002/aic.690370211, on Hammerstein models).
//!
//! The product of gain, weights and b is known only as a whole. After every step the factors have the mean 1 that the
//! stroke of their groups weighs, and b the static gain of the start; the ratios go to the gain.
//!
//! What bounds it, whatever the samples:
//! - Steps are damped by the prior of `factor`; factors and linear block return to the start where the input does not
//!   excite them. Below [`OnlineSettings::excitation`] all but the offset stands still.
//! - Gain and factors stay within [`GAIN_RANGE`] and 0 to [`MAX_FACTOR`]. A step of the linear block that would move a
//!   pole to the unit circle, or change the static gain by a factor of two, is not taken.
//! - An error counts at most as half the stroke. An input farther outside the range than the range is wide counts as
//!   the last one within. A reading that is no number is skipped, an input that is none is held.
//!
//! It does not do: thresholds and shape parameters, creep, the driver, the delay, hysteresis in feedback.

mod factor;
mod layout;
mod parameters;
mod program;
mod scales;
mod step;
#[cfg(test)]
mod tests;

pub use parameters::OnlineParameters;

use factor::Factor;
use layout::Layout;
use piezoid_models::hammerstein::Model;
use piezoid_models::hysteresis::Real;
use piezoid_models::linear::decays_within;
use piezoid_numerics::error::{Error, positive};
use piezoid_numerics::system::System;
use scales::Scales;
use std::ops::Range;

/// Lowest and highest gain, relative to that of the start.
pub const GAIN_RANGE: (f64, f64) = (0.25, 4.0);

/// Largest factor of a group of weights.
pub const MAX_FACTOR: f64 = 4.0;

/// Largest number of weights that move.
pub const MAX_WEIGHTS: usize = 64;

/// Largest number of groups of weights.
pub const MAX_GROUPS: usize = 4;

/// Largest number of coefficients of the linear block that move.
pub const MAX_COEFFICIENTS: usize = 7;

/// Shortest memory [samples].
const MIN_MEMORY: f64 = 10.0;

/// Samples in which each slow estimator has its turn: the weights, the linear block, and the prior of the latter. So no
/// sample takes the time of all.
const PHASES: f64 = 3.0;

/// The rms of a row that the prior of a parameter counts as, in halves of the stroke.
const PRIOR: f64 = 0.01;

/// What the start counts as to weights and linear block: rows of half the stroke, in memories.
const START: f64 = 0.1;

/// The offset moves slower than the gain by this factor and one: a drift and no jump.
const OFFSET_PRIOR: f64 = 9.0;

/// Memory of the measure of excitation, in memories of the gain.
const EXCITATION_MEMORIES: f64 = 10.0;

/// Largest entry of a row.
const MAX_ROW: f64 = 100.0;

/// Largest offset from that of the start, in halves of the stroke.
const MAX_OFFSET: f64 = 10.0;

/// No step of the linear block is taken to reflection coefficients beyond this.
const MAX_REFLECTION: f64 = 1.0 - 1e-6;

/// Largest relative change of a scale in one step that is taken.
const MAX_RATIO: f64 = 2.0;

/// Largest coefficient b, in largest coefficients of the start.
const MAX_B: f64 = 10.0;

/// Which parameters move.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Moves {
    /// The gain.
    pub gain: bool,
    /// The offset of the output.
    pub offset: bool,
    /// The weights of the hysteresis, in groups.
    pub weights: bool,
    /// The coefficients of the linear block.
    pub linear: bool,
}

/// How the parameters move.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct OnlineSettings {
    /// Which of them; `None` moves all that the model allows.
    pub moves: Option<Moves>,
    /// Memory of the gain [samples]; the offset has ten times this.
    pub gain_memory: f64,
    /// Memory of weights and linear block [samples].
    pub memory: f64,
    /// Number of groups of weights.
    pub groups: usize,
    /// Rms of the alternating part of the response below which only the offset moves, relative to half the stroke [-].
    pub excitation: f64,
    /// Errors up to this move nothing [output unit].
    pub dead_zone: f64,
}

impl Default for OnlineSettings {
    fn default() -> Self {
        let (gain_memory, memory, groups) = (50.0, 5000.0, 4);
        OnlineSettings { moves: None, gain_memory, memory, groups, excitation: 0.01, dead_zone: 0.0 }
    }
}

/// A model whose parameters move with the samples.
///
/// It is immutable; the state is a plain vector with the parameters in it, and a copy of it is a copy of everything.
///
/// ```
/// use piezoid::{Model, System, hysteresis::Operator, linear::Arx};
/// use piezoid_identification::online::{Online, OnlineSettings};
/// let plays = (Operator::find("prandtl-ishlinskii")?.example)(5e-4)?;
/// let model = Model::new(plays, Arx::new(5e-4, vec![1.6, -0.8], vec![0.1, 0.1])?, 2.0)?;
/// let u: Vec<f64> = (0..400).map(|t| 25.0 * (0.2 * f64::from(t)).sin()).collect();
/// let online = Online::new(&model, &OnlineSettings::default())?;
/// let mut x = online.initial();
/// for (u, y) in u.iter().zip(model.simulate(&u)) {
///     online.step(&mut x, *u, 1.1 * (y - 2.0) + 2.0); // the gain has risen by 10 %
/// }
/// assert!((online.parameters(&x).gain - 1.1).abs() < 0.01);
/// # Ok::<(), piezoid::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Online {
    model: Model,
    moves: Moves,
    scales: Scales,
    /// The weights of each group, as a range of the weights.
    groups: Vec<Range<usize>>,
    layout: Layout,
    gain: Factor,
    weights: Option<Factor>,
    linear: Option<Factor>,
    /// Of the lags of creep: what each moves in a sample, and its gain.
    rates: Vec<f64>,
    shares: Vec<f64>,
    /// Coefficients b before the first that is not 0.
    delay: usize,
    dead_zone: f64,
    remarks: Vec<String>,
}

impl Online {
    /// The estimator that starts at `model`.
    ///
    /// # Errors
    /// [`Error::Unsuited`] for mechanics with hysteresis in feedback, an unstable linear block or one without static
    /// gain, and parameters that cannot move although the settings name them; [`Error::Parameter`] for settings out of
    /// their range.
    pub fn new(model: &Model, settings: &OnlineSettings) -> Result<Self, Error> {
        settings.check()?;
        let (moves, remarks) = moves(model, settings)?;
        let groups = groups(model, moves, settings.groups);
        let settled = |u: f64| {
            let (mut hidden, mut z) = (model.hidden_settled(u), vec![0.0; groups.len()]);
            parts_of(model, &groups, &mut hidden, u, &mut z);
            z
        };
        let scales = Scales::new(model, settled, settings)?;
        let prior = PRIOR * PRIOR;
        let slow = |name, n: usize| Factor::new(name, settings.memory / PHASES, START, &vec![prior; n], true);
        let gain = Factor::new("gain_fit", settings.gain_memory, 1.0, &[prior, OFFSET_PRIOR], false);
        let weights = moves.weights.then(|| slow("weights_fit", groups.len()));
        let linear = moves.linear.then(|| slow("linear_fit", moving_coefficients(model)));
        let orders = [&weights, &linear].map(|factor| factor.as_ref().map_or(0, Factor::order));
        let layout = Layout::new(model, groups.len(), moves.linear, [orders[0], orders[1], gain.order()]);
        Ok(Online {
            moves,
            scales,
            groups,
            layout,
            gain,
            weights,
            linear,
            rates: model.creep().rates().to_vec(),
            shares: model.creep().lags().iter().map(|lag| lag.gain).collect(),
            delay: model.linear().b().iter().take_while(|b| **b == 0.0).count(),
            dead_zone: settings.dead_zone,
            model: model.clone(),
            remarks,
        })
    }

    /// Which parameters move.
    pub fn moves(&self) -> Moves {
        self.moves
    }

    /// What does not move although nothing excludes it, and why, one sentence each.
    pub fn remarks(&self) -> &[String] {
        &self.remarks
    }

    /// Sampling period [s].
    pub fn ts(&self) -> f64 {
        self.model.ts()
    }

    /// Length of the state.
    pub fn order(&self) -> usize {
        self.layout.order()
    }

    /// The state at the start: the parameters of the model, the actuator at rest.
    pub fn initial(&self) -> Vec<f64> {
        self.state(self.model.hidden_initial(), 0.0, &vec![0.0; self.groups.len()])
    }

    /// The state at the start, the actuator settled at the input `u`, which counts as in [`Online::step`].
    pub fn settled(&self, u: f64) -> Vec<f64> {
        let u = Real::clamp(u, self.scales.inputs.0, self.scales.inputs.1);
        let hidden = self.model.hidden_settled(u);
        let mut parts = vec![0.0; self.groups.len()];
        parts_of(&self.model, &self.groups, &mut hidden.clone(), u, &mut parts);
        self.state(hidden, u, &parts)
    }

    /// A state whose signals have been constant: the input `u` and the hidden variable of each group.
    fn state(&self, hidden: Vec<f64>, u: f64, parts: &[f64]) -> Vec<f64> {
        let mut x = vec![0.0; self.order()];
        let s = self.layout.state(&mut x);
        s.hidden.copy_from_slice(&hidden);
        *s.input = u;
        let (linear, scales) = (self.model.linear(), &self.scales);
        let crept = |z: f64| z * scales.creep;
        s.factor.fill(1.0);
        s.a.copy_from_slice(linear.a());
        s.b.copy_from_slice(linear.b());
        (*s.gain, *s.offset) = (1.0, self.model.offset());
        for (m, z) in parts.iter().enumerate() {
            let (lags, taps, past) = (self.layout.lags, self.layout.taps, self.layout.past);
            s.lag[m * lags..(m + 1) * lags].fill(*z);
            s.inputs[m * taps..(m + 1) * taps].fill(crept(*z));
            s.outputs[m * past..(m + 1) * past].fill(crept(*z) * scales.still);
        }
        let all = crept(parts.iter().sum());
        s.filtered_in.fill(all / scales.rest);
        s.filtered_out.fill(all * scales.still / scales.rest);
        *s.mean = all * scales.still;
        let Layout { fits: [weights, linear, _], .. } = self.layout;
        let (first, rest) = s.fits.split_at_mut(weights);
        let (second, third) = rest.split_at_mut(linear);
        let fits = [(first, self.weights.as_ref()), (second, self.linear.as_ref()), (third, Some(&self.gain))];
        for (place, factor) in fits {
            place.copy_from_slice(&factor.map(Factor::initial).unwrap_or_default());
        }
        x
    }
}

/// The hidden variable of each group of weights after the next sample; of a single group, that of the model.
fn parts_of(model: &Model, groups: &[Range<usize>], hidden: &mut [f64], u: f64, parts: &mut [f64]) {
    let Some(linear) = model.hysteresis().linear_weights().filter(|_| groups.len() > 1) else {
        parts[0] = model.hidden_step(hidden, u);
        return;
    };
    let mut phi = [0.0; MAX_WEIGHTS];
    linear.basis.step(hidden, u, &mut phi[..linear.weights.len()]);
    for (part, group) in parts.iter_mut().zip(groups) {
        let terms = linear.weights[group.clone()].iter().zip(&phi[group.clone()]);
        *part = terms.fold(0.0, |sum, (w, phi)| sum + w * phi);
    }
}

impl OnlineSettings {
    fn check(&self) -> Result<(), Error> {
        for (name, memory) in [("gain_memory", self.gain_memory), ("memory", self.memory)] {
            positive(name, memory, "samples")?;
            if memory < MIN_MEMORY {
                return Err(Error::parameter(name, memory, format!("must be at least {MIN_MEMORY} samples")));
            }
        }
        if !(2..=MAX_GROUPS).contains(&self.groups) {
            return Err(Error::parameter("groups", self.groups, format!("must be from 2 to {MAX_GROUPS}")));
        }
        if self.excitation > 1.0 {
            return Err(Error::parameter("excitation", self.excitation, "must be at most 1, half the stroke"));
        }
        for (name, value) in [("excitation", self.excitation), ("dead_zone", self.dead_zone)] {
            if !(value >= 0.0 && value.is_finite()) {
                return Err(Error::parameter(name, value, "must be 0 or a positive number"));
            }
        }
        Ok(())
    }
}

/// What moves, and remarks on what does not. What is named and cannot move is an error.
fn moves(model: &Model, settings: &OnlineSettings) -> Result<(Moves, Vec<String>), Error> {
    if model.feedback().is_some() {
        let because = "the model has hysteresis in feedback, which is not linear in its parameters: identify it with \
                       --structure hammerstein";
        return Err(Error::Unsuited { what: "recursive identification".into(), because: because.into() });
    }
    let (weights, linear) = (fixed_weights(model), fixed_coefficients(model));
    let named = settings.moves;
    for (reason, is_named, what) in [
        (&weights, named.is_some_and(|moves| moves.weights), "recursive identification of the weights"),
        (&linear, named.is_some_and(|moves| moves.linear), "recursive identification of the linear block"),
    ] {
        if let (Some(because), true) = (reason, is_named) {
            return Err(Error::Unsuited { what: what.into(), because: because.clone() });
        }
    }
    let able = Moves { gain: true, offset: true, weights: weights.is_none(), linear: linear.is_none() };
    let remarks = match named {
        Some(_) => Vec::new(),
        None => [("the weights keep their proportions", weights), ("the linear block keeps its coefficients", linear)]
            .into_iter()
            .filter_map(|(what, reason)| reason.map(|reason| format!("{what}: {reason}")))
            .collect(),
    };
    Ok((named.unwrap_or(able), remarks))
}

/// Why the weights cannot move; `None` if they can.
fn fixed_weights(model: &Model) -> Option<String> {
    let name = model.hysteresis().operator().name;
    let Some(linear) = model.hysteresis().linear_weights() else {
        return Some(format!("exported code has no response of its own for each weight of {name}"));
    };
    let n = linear.weights.len();
    match () {
        () if model.driver().is_some() => Some("the driver moves the input within a sample".into()),
        () if n > MAX_WEIGHTS => Some(format!("{name} has {n} of them, and at most {MAX_WEIGHTS} move")),
        () if n < 2 => Some(format!("{name} has one, which the gain moves")),
        () => None,
    }
}

/// Why the linear block cannot move; `None` if it can.
fn fixed_coefficients(model: &Model) -> Option<String> {
    let n = moving_coefficients(model);
    match n {
        ..2 => Some("it is a gain".into()),
        _ if !decays_within(&mut model.linear().a().to_vec(), MAX_REFLECTION) => {
            Some("a pole is too near the unit circle at this sampling rate".into())
        }
        2..=MAX_COEFFICIENTS => None,
        _ => Some(format!("it has {n} of them, and at most {MAX_COEFFICIENTS} move: identify a lower order")),
    }
}

/// Number of coefficients of the linear block without those of its delay.
fn moving_coefficients(model: &Model) -> usize {
    let linear = model.linear();
    linear.a().len() + linear.b().iter().skip_while(|b| **b == 0.0).count()
}

/// The groups of weights: that of the input, then the thresholds in equal parts. One group if the weights do not move.
fn groups(model: &Model, moves: Moves, most: usize) -> Vec<Range<usize>> {
    let Some(linear) = model.hysteresis().linear_weights().filter(|_| moves.weights) else {
        return std::iter::once(0..1).collect();
    };
    let thresholds = linear.weights.len() - 1;
    let parts = thresholds.min(most - 1);
    let end = |part: usize| 1 + part * thresholds / parts;
    std::iter::once(0..1).chain((0..parts).map(|part| end(part)..end(part + 1))).collect()
}
