//! Growth of the linear block: from the simplest structure on, the extension that lowers the error most is added, until
//! none lowers it clearly.
//!
//! The extended fit starts at the fit before it, with the same response, so its own error is never larger. The error
//! that counts is that of the free run on segments of the records that were left out. Where no extension of the linear
//! block helps, a lag before the hysteresis is tried: it does not commute with the hysteresis.
//!
//! Why: docs/decisions/structure-and-operator-selection.md, "The linear block grows from a gain".

use super::JointOptions;
use super::beginnings::begin;
use super::dynamics::{LEAST_DAMPING, RINGS, creep_pole, is_lag, slowest_pole, without_factor};
use super::estimate::Estimate;
use super::extend::{Search, extensions, times};
use super::held_out::Smoothness;
use super::hidden::Hidden;
use super::refine::{Fitted, StepCallback, refine_from, refine_promising};
use super::runs::TrainingRecord;
use super::solve::FreeParameters;
use super::spread::Spread;
use super::structure::rescaled;
use crate::creep::Lag;
use crate::driver::DriverModel;
use crate::error::Error;
use crate::hysteresis::{Basis, BasisDesign, Operator};
use crate::linear::{Arx, Orders, OutputError, PoleShare, Refinement, free_decay_modes};
use crate::number::short;
use crate::progress::Stage;
use crate::record::Record;
use crate::system::System;
use crate::waveform::dominant_frequency;
use libm::{hypot, log};
use std::cmp::Ordering;
use std::f64::consts::TAU;

/// Highest order.
pub(super) const ORDER: usize = 8;

/// Ratio of held-out errors that is a gain, and that of a mode that shows without further evidence.
const GAIN: f64 = 0.95;
const OBVIOUS: f64 = 0.3;

/// Ratio of errors of the whole records that is a gain if the held-out error is no higher: some of their parts are
/// never held out, and may show what the others do not.
const WHOLE: f64 = 0.9;

/// Ratio of minima that the linearised equations must promise for an extension, for a simpler structure with another
/// operator, and for one with the same operator.
const BETTER: f64 = 0.95;
const AS_GOOD: f64 = 1.2;
const NO_WORSE: f64 = 1.0;

/// Held-out error, rms over peak-to-peak, that is rounding.
const NOTHING: f64 = 1e-6;

/// Ratio of held-out errors with a coarse hysteresis, from which a structure is not tried with another operator.
const HOPELESS: f64 = 2.0;

/// Number of frequencies of the inputs from which small modes between them show.
const FEW: usize = 6;

/// Least ratio of the frequency of a mode to those of the inputs, above which it may be small.
const ABOVE: f64 = 2.0;

/// Least share of the static displacement of a mode between the frequencies of the inputs.
const SHARE: f64 = 0.02;

/// Difference of ln(frequency) up to which two modes are the same.
const NEAR: f64 = 0.2;

/// Ratio to the least damping up to which a mode is at this limit.
const AT_LIMIT: f64 = 1.2;

/// A new lag before the hysteresis [samples].
const NEW_LAG: f64 = 0.2;

/// The first pole that cancels a zero in a block of a specified order.
const FURTHER: f64 = 0.5;

/// Makes the basis of an operator for a sampling period [s].
pub(super) type MakeBasis<'a> = &'a dyn Fn(f64) -> Result<Box<dyn Basis>, Error>;

/// A fit, and the last extension of its linear block.
#[derive(Debug)]
pub(super) struct Structure {
    name: String,
    pub(super) fitted: Fitted,
}

impl Structure {
    pub(super) fn new(name: String, fitted: Fitted) -> Self {
        Structure { name, fitted }
    }

    pub(super) fn better(p: &&Structure, q: &&Structure) -> Ordering {
        p.error().total_cmp(&q.error())
    }

    /// The held-out error: rms over peak-to-peak, with rounding.
    fn error(&self) -> f64 {
        hypot(self.fitted.held_out.rms_pp(), NOTHING)
    }

    /// True if this is clearly better than `other`.
    fn gains_on(&self, other: &Structure) -> bool {
        let of_whole = |t: &Structure| hypot(t.fitted.cost().sqrt(), NOTHING);
        let (held_out, whole) = (self.error() / other.error(), of_whole(self) / of_whole(other));
        held_out < GAIN || (held_out <= 1.0 && whole < WHOLE)
    }

    /// Order and delay, and what was added last.
    fn describe(&self) -> String {
        let Estimate { linear, driver, seeks_lag, .. } = &self.fitted.estimate;
        let (order, delay) = (linear.a().len(), linear.delay());
        let block = if order == 0 { "a gain".into() } else { format!("order {order}") };
        let delayed = if delay == 0 { String::new() } else { format!(", delay {delay}") };
        let lag = driver.filter(|_| *seeks_lag).map_or(String::new(), |d| format!(", driver lag {} s", short(d.lag_s)));
        let by = if self.name.is_empty() { String::new() } else { format!(" by {}", self.name) };
        format!("{block}{delayed}{lag}{by}")
    }
}

/// A structure that was selected.
pub(super) struct Chosen {
    pub(super) fitted: Fitted,
    pub(super) reason: String,
    /// The simpler structures that may be as good with another operator.
    pub(super) simpler: Vec<Estimate>,
    /// True if there were others.
    pub(super) of_several: bool,
}

/// The search for the structure of the linear block.
pub(super) struct Growth {
    search: Search,
    /// The frequency above which a mode is above those of the inputs [Hz].
    above: f64,
    /// True if the inputs have one frequency: hysteresis explains its harmonics, so they show no mode.
    one_frequency: bool,
    /// True if the inputs show modes between their frequencies, and more than one above them.
    is_broad: bool,
    /// True if the driver is known.
    has_driver: bool,
    /// The specified order.
    order: Option<usize>,
    /// How a basis is made.
    design: BasisDesign,
}

impl Growth {
    /// The search in these records, small-signal ones included.
    pub(super) fn new(records: &[Record], settings: &JointOptions, lags: &[Lag], design: &BasisDesign) -> Self {
        let driven = records.iter().filter_map(|record| dominant_frequency(record.u(), record.ts()));
        let mut driven: Vec<f64> = driven.collect();
        driven.sort_by(f64::total_cmp);
        let above = ABOVE * driven.iter().copied().fold(0.0, f64::max);
        // Between a few frequencies of the inputs, a mode could be anywhere.
        let spread: Vec<Spread> = records.iter().map(Spread::of).collect();
        let broad = spread.iter().filter(|spread| spread.lines >= FEW as f64).map(|spread| spread.low);
        let broad: Vec<f64> = broad.collect();
        let many = driven.iter().copied().filter(|_| driven.len() >= FEW);
        let lowest = broad.iter().copied().chain(many).fold(above, f64::min);
        // Whoever specifies the order knows that there are as many poles.
        let lowest = if settings.order.is_some() { 0.0 } else { lowest };
        let fastest = spread.iter().map(|spread| spread.high).fold(0.0, f64::max);
        Growth {
            is_broad: !broad.is_empty() || driven.len() >= FEW,
            one_frequency: broad.is_empty() && driven.first().is_some_and(|slowest| fastest < ABOVE * slowest),
            search: Search {
                modes: free_decay_modes(records),
                slowest: slowest_pole(settings, lags),
                lowest,
                most: settings.order.unwrap_or(ORDER),
            },
            above,
            has_driver: settings.driver.is_some(),
            order: settings.order,
            design: design.clone(),
        }
    }

    /// Extends the last structure of `tried`, and its extensions, until that gains nothing.
    pub(super) fn grow(
        &self,
        tried: &mut Vec<Structure>,
        basis: MakeBasis,
        runs: &mut [TrainingRecord],
        watch: StepCallback,
    ) -> Result<(), Error> {
        let mut behind_lag = self.has_driver;
        let is_not_creep = |linear: &Arx| creep_pole(linear, self.search.slowest).is_none();
        while let Some(Structure { fitted: from, .. }) = tried.last() {
            behind_lag |= from.estimate.driver.is_some();
            let Some(best) = tried.iter().min_by(Structure::better) else { break };
            let mut longer: Vec<Structure> = Vec::new();
            for found in extensions(from, runs, &self.search, &|linear| self.shows(linear), watch)? {
                let starts = found.into_iter();
                let starts = starts.filter_map(|one| Some((one.name, from.estimate.with_linear(one.linear)?)));
                let fits = refine_promising(starts.collect(), from, BETTER, &is_not_creep, runs, watch)?;
                let possible = |t: &Structure| {
                    let linear = &t.fitted.estimate.linear;
                    let obvious = !self.one_frequency && t.error() < OBVIOUS * best.error();
                    (self.shows(linear) || obvious) && !self.is_at_limit(linear)
                };
                longer.extend(fits.into_iter().map(|(name, fit)| Structure::new(name, fit)).filter(possible));
                if longer.iter().any(|t| t.gains_on(best)) {
                    break;
                }
            }
            if !longer.iter().any(|t| t.gains_on(best)) && !behind_lag {
                behind_lag = true;
                longer.extend(self.behind_lag(tried, basis, runs, watch)?);
            }
            longer.sort_by(|p, q| Structure::better(&p, &q));
            let mut longer = longer.into_iter();
            let Some(mut next) = longer.next() else { break };
            if begin(&next.fitted, runs, self.design.range)? {
                let Estimate { linear, .. } = &next.fitted.estimate;
                if let Some(same) = next.fitted.estimate.with_linear(linear.clone()) {
                    let smoothness = Smoothness::Fixed(next.fitted.held_out.lambda);
                    next.fitted = refine_from(same, smoothness, runs, FreeParameters::All, watch)?;
                }
            }
            let gains = next.gains_on(best);
            let next_order = next.fitted.estimate.linear.a().len();
            tried.extend(longer.filter(|t| self.is_of_order(t)));
            tried.push(next);
            // Up to the specified order, steps without gain may be needed.
            if !gains && self.order.is_none_or(|order| next_order >= order) {
                break;
            }
        }
        if let (Some(order), Some(Structure { fitted: last, .. })) = (self.order, tried.last())
            && !tried.iter().any(|t| self.is_of_order(t))
            && let Some(start) = with_order(order, &last.estimate)?
        {
            let fit = refine_from(start, Smoothness::Fixed(last.held_out.lambda), runs, FreeParameters::All, watch)?;
            tried.push(Structure::new("further poles".into(), fit));
        }
        Ok(())
    }

    /// A linear block of lower order that promises as low a minimum, if there is one: poles that nearly cancel zeros
    /// may keep the search from its end.
    fn shrunk(
        &self,
        fitted: &Fitted,
        runs: &mut [TrainingRecord],
        watch: StepCallback,
    ) -> Result<Option<Structure>, Error> {
        let linear = &fitted.estimate.linear;
        let hidden: Vec<Record> = Hidden::crept(fitted, runs)?.into_iter().map(|z| z.record).collect();
        for n in 1..linear.a().len() {
            let orders = Orders { delay: linear.delay(), ..Orders::of(n) };
            let Ok(fit) = OutputError::fit(&hidden, orders, &Refinement::default(), &mut Stage::ignore) else {
                continue;
            };
            let start = fitted.estimate.with_linear(rescaled(&fit.arx, linear.dc_gain())?);
            let starts = start.into_iter().map(|start| (String::new(), start)).collect();
            if let Some((name, fit)) = refine_promising(starts, fitted, NO_WORSE, &|_| true, runs, watch)?.pop() {
                return Ok(Some(Structure::new(name, fit)));
            }
        }
        Ok(None)
    }

    /// The best structure so far with a lag before the hysteresis: a new one, or one that was behind it, as a lag or as
    /// a delay.
    fn behind_lag(
        &self,
        tried: &[Structure],
        basis: MakeBasis,
        runs: &mut [TrainingRecord],
        watch: StepCallback,
    ) -> Result<Option<Structure>, Error> {
        let Some(Structure { fitted: best, .. }) = tried.iter().min_by(Structure::better) else { return Ok(None) };
        let linear = &best.estimate.linear;
        let (ts, delay) = (linear.ts(), linear.delay());
        let moved = linear.poles().into_iter().filter(is_lag).map(|pole| {
            let a = without_factor(&linear.denominator(), pole.z.re);
            let b = linear.b().iter().map(|b| b / (1.0 - pole.z.re)).collect();
            (1.0 / (TAU * pole.hz), Arx::new(ts, a[1..].iter().map(|a| -a).collect(), b))
        });
        let undelayed = || Arx::new(ts, linear.a().to_vec(), linear.b()[delay..].to_vec());
        let instead = (delay > 0).then(|| (delay as f64 * ts, undelayed()));
        let start = |(lag_s, linear): (f64, Result<Arx, Error>)| {
            let driver = (Some(DriverModel::new(lag_s, None)?), true);
            let name = "a lag before the hysteresis".to_string();
            Ok((name, adopt(&best.estimate, driver, &best.estimate.lags, linear?, basis)?))
        };
        let starts = moved.chain([(NEW_LAG * ts, Ok(linear.clone()))]).chain(instead).map(start);
        let starts = starts.collect::<Result<_, Error>>()?;
        let found = refine_promising(starts, best, BETTER, &|_| true, runs, watch)?;
        let found = found.into_iter().filter(|(_, fit)| self.shows(&fit.estimate.linear));
        Ok(found.map(|(name, fit)| Structure::new(name, fit)).min_by(|p, q| Structure::better(&p, &q)))
    }

    /// True if a mode is at the least damping that the search allows: it stands for something else, as a line of the
    /// input's spectrum or what its own state in each record can explain.
    fn is_at_limit(&self, linear: &Arx) -> bool {
        linear.poles().iter().any(|pole| pole.damping < AT_LIMIT * LEAST_DAMPING && !self.is_seen(pole.hz))
    }

    /// True if free decays show a mode of this frequency [Hz].
    pub(super) fn is_seen(&self, hz: f64) -> bool {
        self.search.modes.iter().any(|mode| log(mode.hz / hz).abs() < NEAR)
    }

    /// True if each mode of a linear block shows in the records, or if the order is specified. The harmonics of a few
    /// frequencies show one mode above them.
    fn shows(&self, linear: &Arx) -> bool {
        if self.order.is_some() {
            return true;
        }
        let modes = linear.modal_form().modes().into_iter();
        let rings = |p: &PoleShare| p.pole.z.im > 0.0 && p.pole.damping < RINGS;
        let driven: Vec<PoleShare> = modes.filter(|p| rings(p) && !self.is_seen(p.pole.hz)).collect();
        let is_driven = |p: &PoleShare| {
            let within = p.pole.hz >= self.search.lowest && p.share >= SHARE;
            !self.one_frequency && (p.pole.hz >= self.above || within)
        };
        driven.iter().all(is_driven) && (self.is_broad || driven.len() <= 1)
    }

    /// True if the linear block has the specified order.
    fn is_of_order(&self, structure: &Structure) -> bool {
        self.order == Some(structure.fitted.estimate.linear.a().len())
    }

    /// The simplest structure that is as good as the best, of at least one.
    pub(super) fn choose(&self, mut tried: Vec<Structure>) -> Chosen {
        let is_specified = tried.iter().any(|t| self.is_of_order(t));
        let why = match is_specified {
            true => "the best of the specified order is selected",
            false => "the simplest that is as good as the best is selected",
        };
        let may = |t: &&Structure| !is_specified || self.is_of_order(t);
        let chosen = tried.iter().position(|t| may(&t) && !tried.iter().filter(may).any(|other| other.gains_on(t)));
        let chosen = chosen.unwrap_or(tried.len().saturating_sub(1));
        let listed = tried.iter().map(|t| format!("{} {} %", t.describe(), short(100.0 * t.error())));
        let listed: Vec<String> = listed.collect();
        let of_several = tried.len() > 1;
        let structure = tried.remove(chosen);
        let reason = format!("{}: held-out error, rms/pp: {}; {why}", structure.describe(), listed.join(", "));
        tried.truncate(chosen);
        tried.retain(|t| t.error() < HOPELESS * structure.error());
        let simpler = tried.into_iter().map(|t| t.fitted.estimate).collect();
        Chosen { fitted: structure.fitted, reason, simpler, of_several }
    }

    /// The simplest structure with the operator of a fit that is as good as the best: of those simpler than its own,
    /// its own, and extensions.
    pub(super) fn settle(
        &self,
        fitted: Fitted,
        simpler: Vec<Estimate>,
        row: &Operator,
        runs: &mut [TrainingRecord],
        watch: StepCallback,
    ) -> Result<Chosen, Error> {
        let basis = |ts: f64| (row.basis)(&BasisDesign { ts, ..self.design.clone() });
        let mut tried = Vec::new();
        for Estimate { driver, seeks_lag, lags, linear, .. } in simpler {
            let start = adopt(&fitted.estimate, (driver, seeks_lag), &lags, linear, &basis)?;
            let found = refine_promising(vec![(String::new(), start)], &fitted, AS_GOOD, &|_| true, runs, watch)?;
            tried.extend(found.into_iter().map(|(name, fit)| Structure::new(name, fit)));
        }
        if self.order.is_none() {
            tried.extend(self.shrunk(&fitted, runs, watch)?);
        }
        tried.push(Structure::new(String::new(), fitted));
        self.grow(&mut tried, &basis, runs, watch)?;
        Ok(self.choose(tried))
    }
}

/// The same response with a linear block of a higher order: further poles cancel further zeros.
fn with_order(order: usize, estimate: &Estimate) -> Result<Option<Estimate>, Error> {
    let linear = &estimate.linear;
    let (mut a, mut b) = (linear.denominator(), linear.b().to_vec());
    for k in 1..=order.saturating_sub(linear.a().len()) {
        let factor = [1.0, -FURTHER.powi(k as i32)];
        (a, b) = (times(&a, &factor), times(&b, &factor));
    }
    Ok(estimate.with_linear(Arx::new(linear.ts(), a[1..].iter().map(|a| -a).collect(), b)?))
}

/// The hysteresis of an estimate with another driver, and whether its lag is sought, other creep and another linear
/// block.
pub(super) fn adopt(
    estimate: &Estimate,
    (driver, seeks_lag): (Option<DriverModel>, bool),
    lags: &[Lag],
    linear: Arx,
    basis: MakeBasis,
) -> Result<Estimate, Error> {
    let shape: Vec<f64> = estimate.basis.shape().iter().map(|shape| shape.value).collect();
    let faster = if driver.is_some() { DriverModel::SUBSTEPS as f64 } else { 1.0 };
    let basis = basis(linear.ts() / faster)?.reshaped(&shape)?;
    Ok(Estimate { driver, seeks_lag, basis, weights: estimate.weights.clone(), lags: lags.to_vec(), linear })
}

#[cfg(test)]
mod tests {
    use super::super::testing::pair;
    use super::*;

    #[test]
    fn a_mode_at_the_least_damping_is_at_a_limit_unless_a_free_decay_shows_it() {
        let u: Vec<f64> = (0..2000).map(|t| (0.05 * f64::from(t)).sin()).collect();
        let records = [Record::new(5e-4, u.clone(), u).unwrap()];
        let design = BasisDesign { ts: 5e-4, range: (-1.0, 1.0), elements: None, frequencies: Vec::new() };
        let mut growth = Growth::new(&records, &JointOptions::default(), &[], &design);
        let block = |damping: f64| pair(5e-4, 100.0, damping);
        assert!(growth.is_at_limit(&block(0.0021)) && !growth.is_at_limit(&block(0.003)));
        growth.search.modes = block(0.0021).poles();
        assert!(!growth.is_at_limit(&block(0.0021)));
    }
}
