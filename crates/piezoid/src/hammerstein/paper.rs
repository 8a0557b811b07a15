//! Identification by the paper's six steps (section 2.3): a small-signal record gives the linear block, its inverse (8)
//! turns rich records into the hidden variable z, and the loops of (u, z) give the hysteresis block.
//!
//! Where (8) is unstable the whole-record inverse takes its place; where there is no small-signal record the rich ones
//! give as much of the linear block as they can. Either is told in the notes.

use super::Model;
use super::rich::{LinearPart, dominant_frequency, linear_from_rich, rich_enough};
use crate::error::Error;
use crate::hysteresis::{Branches, Hysteresis, Loop, Pair, Proportional, RateScheduled, Reading, Split, TwoBranch};
use crate::linear::{self, Arx, Orders};
use crate::number::round;
use crate::optimize::swarm;
use crate::progress::Progress;
use crate::record::{Record, Units, same_sampling};
use crate::system::System;
use std::sync::Arc;

/// Frequencies that differ by less than this are one.
const SAME_FREQUENCY: f64 = 0.02;

/// How to identify the paper's way. The defaults are the paper's, but for the reading of held inputs.
#[derive(Debug, Clone, PartialEq)]
pub struct Paper {
    /// Order of the linear block.
    pub order: usize,
    /// Name of its estimator.
    pub estimator: String,
    /// Settings of the swarm.
    pub swarm: swarm::Settings,
    /// Name of the hysteresis operator, or `auto`: `two-branch` for one frequency, `rate-scheduled` for several.
    pub operator: String,
    /// How the points of a loop are told apart.
    pub split: Split,
    /// Averages a branch, between the turning points.
    pub bins: usize,
    /// Which branch is read while the input is held.
    pub reading: Reading,
}

impl Default for Paper {
    fn default() -> Self {
        Paper {
            order: 2,
            estimator: "swarm".into(),
            swarm: swarm::Settings::default(),
            operator: "auto".into(),
            split: Split::Line,
            bins: 16,
            reading: Reading::Held,
        }
    }
}

/// A model and what was found on the way to it.
#[derive(Debug, Clone)]
pub struct Identified {
    /// The model.
    pub model: Model,
    /// The linear block with its fit.
    pub linear: LinearPart,
    /// The loops the hysteresis block was made of, by rising frequency.
    pub loops: Vec<HiddenLoop>,
    /// What its user should know.
    pub notes: Vec<String>,
}

/// A loop of the hidden variable.
#[derive(Debug, Clone, PartialEq)]
pub struct HiddenLoop {
    /// Its frequency [Hz], where the input has one.
    pub frequency_hz: Option<f64>,
    /// Input [input unit].
    pub u: Vec<f64>,
    /// Hidden variable [input unit].
    pub z: Vec<f64>,
    /// Branches and separating line.
    pub found: Loop,
}

/// The paper's steps 2, 4 and 5 (1, 3 and 6 are measurements): `linear` are small-signal records (a PRBS), `rich` those
/// that exercise the hysteresis, normally one sine a frequency. Either list may be empty.
///
/// # Errors
/// Records of different sampling periods or units; what [`linear::fit`] refuses; loops that are none.
pub fn identify_paper(
    linear: &[Record],
    rich: &[Record],
    how: &Paper,
    progress: &mut Progress,
) -> Result<Identified, Error> {
    let units = common_units(linear.iter().chain(rich))?;
    let linear: Vec<Record> = linear.iter().map(|r| r.output_in(&units.y)).collect::<Result<_, _>>()?;
    let rich: Vec<Record> = rich.iter().map(|r| r.output_in(&units.y)).collect::<Result<_, _>>()?;

    let part = linear_part(&linear, &rich, how, progress)?;
    let mut notes = vec![format!("linear block: {}", part.reason)];
    if let Some(pole) = part.arx.poles().iter().find(|p| p.z.modulus() >= 1.0) {
        notes.push(format!(
            "the linear block is unstable, with a pole at {} in the z plane, so the model grows without bound: try more iterations, a \
             lower order, or another estimator",
            pole.z
        ));
    }
    let mut loops = Vec::new();
    if how.operator != "proportional" {
        for record in &rich {
            let (z, note) = hidden(&part.arx, part.offset, record.y())?;
            notes.extend(note.filter(|n| !notes.contains(n)));
            gather(&mut loops, record, z);
        }
    }
    let operator = match how.operator.as_str() {
        "auto" if rich.is_empty() => "proportional",
        "auto" if loops.len() > 1 => "rate-scheduled",
        "auto" => "two-branch",
        named => named,
    };
    if operator == "two-branch" && loops.len() > 1 {
        pool(&mut loops);
    }
    let loops = loops.into_iter().map(|l| l.split(how)).collect::<Result<Vec<_>, _>>()?;
    let turned: Vec<f64> = loops.iter().filter(|l| !l.found.ascending_below).filter_map(|l| l.frequency_hz).collect();
    if !turned.is_empty() {
        notes.push(format!(
            "at {} Hz the loop has turned round, rising input above falling: the linear block does not hold there, as above a \
             resonance that it misses or that the sampling is too slow for",
            turned.iter().map(|hz| round(*hz)).collect::<Vec<_>>().join(", ")
        ));
    }
    let (ts, mut offset) = (part.arx.ts(), part.offset);
    let hysteresis: Arc<dyn Hysteresis> = match (operator, loops.as_slice()) {
        ("two-branch", [one, ..]) => Arc::new(TwoBranch::new(ts, one.found.branches.clone(), how.reading)),
        ("rate-scheduled", [_, ..]) => Arc::new(RateScheduled::new(ts, pairs(&loops)?)?),
        ("proportional", _) => {
            let (gain, constant) = proportional(&part.arx, part.offset, &rich)?;
            offset = constant;
            Arc::new(Proportional::new(ts, gain)?)
        }
        ("two-branch" | "rate-scheduled", []) => {
            let remedy = "the hysteresis block needs at least one record that exercises the hysteresis".into();
            return Err(Error::TooShort { what: "the list of rich records".into(), have: 0, need: 1, remedy });
        }
        (other, _) => {
            crate::hysteresis::operator(other)?;
            let rule = "the paper's method knows proportional, two-branch, rate-scheduled and auto";
            return Err(Error::parameter("operator", other, rule));
        }
    };
    if rich.is_empty() {
        notes.push("hysteresis block: none, as there is no rich record to find it from".into());
    }
    let model = Model::new(hysteresis, part.arx.clone(), offset)?.with_units(units);
    Ok(Identified { model, linear: part, loops, notes })
}

/// Step 4: z by the inverse of the linear block, causal where that is stable; the note says when it is not.
///
/// # Errors
/// [`Error::NoInverse`] when the block has no stable inverse of either kind.
pub fn hidden(arx: &Arx, offset: f64, y: &[f64]) -> Result<(Vec<f64>, Option<String>), Error> {
    let centred: Vec<f64> = y.iter().map(|y| y - offset).collect();
    match arx.inverse() {
        Ok(inverse) => Ok((inverse.resume(&mut inverse.settled(centred[0]), &centred), None)),
        Err(why) => {
            let z = arx.invert_whole(&centred)?;
            Ok((z, Some(format!("{why}; z comes from the whole record, forward and backward in time"))))
        }
    }
}

/// Step 2, or what the rich records give in its place.
fn linear_part(linear: &[Record], rich: &[Record], how: &Paper, progress: &mut Progress) -> Result<LinearPart, Error> {
    if linear.is_empty() {
        if rich.is_empty() {
            let remedy = "give a small-signal record, a rich one, or both".into();
            return Err(Error::TooShort { what: "the list of records".into(), have: 0, need: 1, remedy });
        }
        return linear_from_rich(rich, how.order);
    }
    rich_enough(linear, how.order)?;
    let fit = linear::fit(linear, Orders::of(how.order), linear::estimator(&how.estimator)?, &how.swarm, progress)?;
    let reason = format!("order {} by {} on {} samples of small signal", how.order, fit.estimator, fit.residuals.n);
    Ok(LinearPart { arx: fit.arx.clone(), offset: fit.offsets[0], fit: Some(fit), reason })
}

/// The points of a loop before it is split.
struct Points {
    frequency_hz: Option<f64>,
    u: Vec<f64>,
    z: Vec<f64>,
}

impl Points {
    fn split(self, how: &Paper) -> Result<HiddenLoop, Error> {
        let found = Branches::of_loop(&self.u, &self.z, how.bins, how.split)?;
        Ok(HiddenLoop { frequency_hz: self.frequency_hz, u: self.u, z: self.z, found })
    }
}

/// Adds a record's points to those of the same frequency. Of three periods or more the first is left out: a loop is
/// closed only after the first turn.
fn gather(loops: &mut Vec<Points>, record: &Record, z: Vec<f64>) {
    let frequency_hz = dominant_frequency(record.u(), record.ts());
    let period = frequency_hz.map_or(0, |hz| (1.0 / (hz * record.ts())).ceil() as usize);
    let skip = if 3 * period <= record.len() { period } else { 0 };
    let (u, z) = (&record.u()[skip..], &z[skip..]);
    let same = |known: &&mut Points| match (known.frequency_hz, frequency_hz) {
        (Some(a), Some(b)) => (a / b - 1.0).abs() < SAME_FREQUENCY,
        (a, b) => a == b,
    };
    match loops.iter_mut().find(same) {
        Some(known) => {
            known.u.extend(u);
            known.z.extend(z);
        }
        None => loops.push(Points { frequency_hz, u: u.to_vec(), z: z.to_vec() }),
    }
    loops.sort_by(|p, q| p.frequency_hz.unwrap_or(0.0).total_cmp(&q.frequency_hz.unwrap_or(0.0)));
}

/// Makes one loop of all.
fn pool(loops: &mut Vec<Points>) {
    let all = std::mem::take(loops);
    let (u, z) = all.into_iter().fold((Vec::new(), Vec::new()), |(mut u, mut z), l| {
        u.extend(l.u);
        z.extend(l.z);
        (u, z)
    });
    loops.push(Points { frequency_hz: None, u, z });
}

fn pairs(loops: &[HiddenLoop]) -> Result<Vec<Pair>, Error> {
    let pair = |l: &HiddenLoop| {
        let frequency_hz = l.frequency_hz.ok_or_else(|| Error::Unidentifiable {
            what: "the frequency of a rich record".into(),
            because: "its input holds no whole period; record longer, or use --operator two-branch".into(),
        })?;
        Ok(Pair { frequency_hz, branches: l.found.branches.clone() })
    };
    loops.iter().map(pair).collect()
}

/// The gain k and offset c that bring k G u + c closest to the outputs of `records`; 1 and `offset` without any.
pub(crate) fn proportional(arx: &Arx, offset: f64, records: &[Record]) -> Result<(f64, f64), Error> {
    if records.is_empty() {
        return Ok((1.0, offset));
    }
    let filtered: Vec<Record> = records
        .iter()
        .map(|r| Record::new(r.ts(), arx.resume(&mut arx.settled(r.u()[0]), r.u()), r.y().to_vec()))
        .collect::<Result<_, _>>()?;
    let (gain, offset, _) = super::rich::affine(&filtered)?;
    Ok((gain, offset))
}

/// The units of the first record; the others must agree in sampling and input unit.
fn common_units<'a>(mut records: impl Iterator<Item = &'a Record>) -> Result<Units, Error> {
    let Some(first) = records.next() else { return Ok(Units::default()) };
    for record in records {
        same_sampling("the first record", first.ts(), "another record", record.ts())?;
        if record.units().u != first.units().u {
            return Err(Error::Units {
                what: "the input of a record".into(),
                found: record.units().u.clone(),
                wanted: first.units().u.clone(),
            });
        }
    }
    Ok(first.units().clone())
}
