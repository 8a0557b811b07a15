//! Identification by the paper's six steps (section 2.3): a small-signal record gives the linear block, its inverse (8)
//! converts large-signal records into the hidden variable z, and the loops of (u, z) give the hysteresis block.
//!
//! If (8) is unstable, the whole-record inverse is used. Without small-signal record, the large-signal records give as
//! much of the linear block as they determine. The notes report both.

// Tests compare with the C library.
#![cfg_attr(test, allow(clippy::disallowed_methods))]

use piezoid_identification::large_signal::{linear_from_large_signal, proportional, require_excitation};
use piezoid_identification::{Identified, LinearPart, called, common_units, unexcited_resonance};
use piezoid_models::hammerstein::{Domain, HiddenLoop, LoopPoints, MIN_OPEN_AGREEMENT, Model, named, remarks};
use piezoid_models::hysteresis::{
    HeldInput, Hysteresis, LoopOptions, Operator, Pair, Proportional, RateScheduled, Split, TwoBranch, is_auto,
};
use piezoid_models::linear::{self, Orders};
use piezoid_numerics::error::Error;
use piezoid_numerics::number::short;
use piezoid_numerics::optimize::swarm;
use piezoid_numerics::progress::Progress;
use piezoid_numerics::system::System;
use piezoid_records::quality::{Consequence, Finding, inspect};
use piezoid_records::record::Record;
use std::sync::Arc;

/// Options of the paper's method. The defaults are the paper's, except the reading of held inputs.
#[derive(Debug, Clone, PartialEq)]
pub struct PaperOptions {
    /// Order of the linear block.
    pub order: usize,
    /// Name of its estimator.
    pub estimator: String,
    /// Settings of the swarm.
    pub swarm: swarm::SwarmSettings,
    /// Name of the hysteresis operator, or `auto`: `two-branch` for one frequency, `rate-scheduled` for several.
    pub operator: String,
    /// How the points of a loop are split into branches.
    pub split: Split,
    /// Averages per branch, between the reversal points.
    pub bins: usize,
    /// The branch while the input is held.
    pub reading: HeldInput,
}

impl Default for PaperOptions {
    fn default() -> Self {
        PaperOptions {
            order: 2,
            estimator: "swarm".into(),
            swarm: swarm::SwarmSettings::default(),
            operator: "auto".into(),
            split: Split::Line,
            bins: 16,
            reading: HeldInput::Held,
        }
    }
}

/// The paper's steps 2, 4 and 5 (1, 3 and 6 are measurements). `linear` are small-signal records (a PRBS),
/// `large_signal` those that exercise the hysteresis, normally one sine per frequency. Either list may be empty.
///
/// # Errors
/// Returns an error if sampling periods differ, units cannot be converted, the linear block cannot be fitted
/// ([`linear::Estimator::fit`]), or points form no loop.
pub fn identify_paper(
    linear: &[Record],
    large_signal: &[Record],
    settings: &PaperOptions,
    progress: &mut Progress,
) -> Result<Identified, Error> {
    let units = common_units(linear.iter().chain(large_signal))?;
    let linear: Vec<Record> = linear.iter().map(|r| r.output_in(&units.y)).collect::<Result<_, _>>()?;
    let large_signal: Vec<Record> = large_signal.iter().map(|r| r.output_in(&units.y)).collect::<Result<_, _>>()?;

    let part = linear_part(&linear, &large_signal, settings, progress)?;
    let mut notes = vec![format!("linear block: {}", part.reason)];
    if !linear.is_empty() {
        notes.extend(unexcited_resonance(&part.arx, linear.iter()));
    }
    let defects = [defects("small-signal record", &linear), defects("large-signal record", &large_signal)].concat();
    notes.extend(defects);
    if let Some(pole) = part.arx.poles().iter().find(|p| p.z.modulus() >= 1.0) {
        notes.push(format!(
            "the linear block is unstable, with a pole at {} in the z plane, so the model grows without bound: try \
             more iterations, a lower order, or another estimator",
            pole.z
        ));
    }
    let mut loops = LoopPoints::default();
    if settings.operator != "proportional" {
        for record in &large_signal {
            let (z, note) = part.arx.hidden(part.offset, record.y())?;
            notes.extend(note.filter(|n| !notes.contains(n)));
            notes.extend(loops.add(record, z)?);
        }
    }
    if settings.operator == "two-branch" {
        loops.pool();
    }
    let mut loops = loops.split(&LoopOptions { bins: settings.bins, split: settings.split, line: None })?;
    notes.extend(remarks(&loops, settings.split));
    if is_auto(&settings.operator)
        && let Some(which) = named(&loops, |found| found.agreement < MIN_OPEN_AGREEMENT)
    {
        loops.retain(|l| l.found.agreement >= MIN_OPEN_AGREEMENT);
        let without = if loops.is_empty() { ": the model has no hysteresis" } else { "" };
        notes.push(format!("hysteresis block: the points found {which} form no loop and are left out{without}"));
    }
    let operator = match (is_auto(&settings.operator), loops.len()) {
        (false, _) => &settings.operator,
        (true, 0) => "proportional",
        (true, 1) => "two-branch",
        (true, _) => "rate-scheduled",
    };
    if is_auto(&settings.operator) && !Operator::list(&settings.operator)?.iter().any(|o| o.name == operator) {
        let rule = format!("leaves out {operator}, which the paper's method takes for these records: name another");
        return Err(Error::parameter("operator", &settings.operator, rule));
    }
    let (hysteresis, offset) = block(operator, &loops, &part, &large_signal, settings.reading)?;
    if large_signal.is_empty() {
        notes.push("hysteresis block: none, because there is no large-signal record".into());
    }
    let model = Model::new(hysteresis, part.arx.clone(), offset)?.with_units(units);
    let model = match Domain::of(linear.iter().chain(&large_signal)) {
        Some(domain) => model.with_identified(domain),
        None => model,
    };
    Ok(Identified {
        model,
        linear: part,
        loops,
        trials: Vec::new(),
        parameters: Vec::new(),
        spread: Vec::new(),
        reasons: Vec::new(),
        left_percent: None,
        cancelled: None,
        notes,
    })
}

/// Step 5: the hysteresis block of the loops, and its offset [output unit].
fn block(
    operator: &str,
    loops: &[HiddenLoop],
    part: &LinearPart,
    large_signal: &[Record],
    reading: HeldInput,
) -> Result<(Arc<dyn Hysteresis>, f64), Error> {
    let ts = part.arx.ts();
    Ok(match (operator, loops) {
        ("two-branch", [one, ..]) => (Arc::new(TwoBranch::new(ts, one.found.branches.clone(), reading)?), part.offset),
        ("rate-scheduled", [_, ..]) => (Arc::new(RateScheduled::new(ts, pairs(loops)?, reading)?), part.offset),
        ("proportional", _) => {
            let (gain, offset) = proportional(&part.arx, part.offset, large_signal)?;
            (Arc::new(Proportional::new(ts, gain)?), offset)
        }
        ("two-branch" | "rate-scheduled", []) => {
            let remedy = "the hysteresis block needs at least one record that exercises the hysteresis".into();
            return Err(Error::TooShort { what: "the list of large-signal records".into(), have: 0, need: 1, remedy });
        }
        (other, _) => {
            Operator::find(other)?;
            let rule = "must be proportional, two-branch, rate-scheduled or auto with the paper's method";
            return Err(Error::parameter("operator", other, rule));
        }
    })
}

/// Step 2, or its replacement from large-signal records.
fn linear_part(
    linear: &[Record],
    large_signal: &[Record],
    settings: &PaperOptions,
    progress: &mut Progress,
) -> Result<LinearPart, Error> {
    if linear.is_empty() {
        if large_signal.is_empty() {
            let remedy = "give small-signal records, large-signal records, or both".into();
            return Err(Error::TooShort { what: "the list of records".into(), have: 0, need: 1, remedy });
        }
        return linear_from_large_signal(large_signal, settings.order);
    }
    require_excitation(linear, settings.order)?;
    let estimator = linear::Estimator::find(&settings.estimator)?;
    let fit = estimator.fit(linear, Orders::of(settings.order), &settings.swarm, progress)?;
    let (sum, best) = (fit.residuals.sum_abs, fit.least_squares_sum_abs);
    let failed = if fit.estimator == "swarm" && sum > 1.001 * best {
        let (sum, best) = (short(sum), short(best));
        format!(
            "; its cost is {sum}, that of least squares {best}: the search failed, try the estimator least-absolute"
        )
    } else {
        String::new()
    };
    let (order, by, n) = (settings.order, fit.estimator, fit.residuals.n);
    let reason = format!("order {order}, estimated by {by} from {n} small-signal samples{failed}");
    let reason = reason + &fit.order_too_low(linear).unwrap_or_default();
    Ok(LinearPart { arx: fit.arx.clone(), offset: fit.offsets[0], fit: Some(fit), reason })
}

/// The defects of the records, each with the name and number of its record.
fn defects(which: &str, records: &[Record]) -> Vec<String> {
    let each = records.iter().enumerate().flat_map(|(k, record)| {
        let name = called(which, k, records.len());
        let findings = inspect(record).findings.into_iter();
        findings.map(move |Finding { detector, text, .. }| match detector.consequence {
            Consequence::Masked => format!("{name}: {text}; the paper's method still uses these samples"),
            _ => format!("{name}: {text}"),
        })
    });
    each.collect()
}

/// The branches of each loop with its frequency.
fn pairs(loops: &[HiddenLoop]) -> Result<Vec<Pair>, Error> {
    let pair = |l: &HiddenLoop| {
        let frequency_hz = l.frequency_hz.ok_or_else(|| Error::Unidentifiable {
            what: "the frequency of a large-signal record".into(),
            because: "its input has no complete period: record longer, or use the operator two-branch".into(),
        })?;
        Ok(Pair { frequency_hz, branches: l.found.branches.clone() })
    };
    loops.iter().map(pair).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_models::hysteresis::OPERATORS;
    use piezoid_models::linear::Arx;
    use piezoid_numerics::progress::Stage;
    use piezoid_records::excitation::{Prbs, Sine};
    use piezoid_records::record::Units;
    use piezoid_validation::Validate;
    use piezoid_validation::ValidateOptions;

    const TS: f64 = 5e-4;

    fn beam() -> Arx {
        Arx::new(TS, vec![1.7424, -0.9453], vec![3.4, 3.3]).unwrap()
    }

    fn record(system: &dyn System, u: Vec<f64>) -> Record {
        let y = system.simulate(&u);
        Record::new(TS, u, y).unwrap()
    }

    fn sine(hz: f64) -> Vec<f64> {
        Sine { amplitude: 28.0, frequency: hz, ..Sine::default() }.samples(TS, 4000).unwrap()
    }

    fn prbs() -> Record {
        record(&beam(), Prbs::default().samples(TS, 2047).unwrap())
    }

    #[test]
    fn every_operator_is_identified_from_its_own_records() {
        for o in &OPERATORS[..3] {
            let truth = Model::new((o.example)(TS).unwrap(), beam(), 12.0).unwrap();
            let large_signal = [5.0, 80.0].map(|hz| record(&truth, sine(hz)));
            let (large_signal, test) =
                if o.rate_independent { (&large_signal[..1], 5.0) } else { (&large_signal[..], 80.0) };
            let settings = PaperOptions { operator: o.name.into(), ..PaperOptions::default() };
            let offset_record = prbs().y().iter().map(|y| y + 12.0).collect();
            let linear = [Record::new(TS, prbs().u().to_vec(), offset_record).unwrap()];
            let found = identify_paper(&linear, large_signal, &settings, &mut Stage::ignore).unwrap();
            let validation = record(&truth, sine(test).iter().map(|u| 0.98 * u).collect());
            let options = ValidateOptions { skip: 0.5, ..ValidateOptions::default() };
            let percent = found.model.validate_with(&validation, &options).unwrap().metrics.rms_pp_percent;
            assert!(percent < 0.6, "{}: {percent} %", o.name);
        }
    }

    #[test]
    fn auto_is_two_branch_for_one_frequency_and_rate_scheduled_for_several() {
        let truth = Model::new((OPERATORS[1].example)(TS).unwrap(), beam(), 0.0).unwrap();
        let name = |large_signal: &[Record]| {
            let found = identify_paper(&[prbs()], large_signal, &PaperOptions::default(), &mut Stage::ignore).unwrap();
            (found.model.hysteresis().operator().name, found.loops.len())
        };
        let [slow, again, fast] = [5.0, 5.0, 40.0].map(|hz| record(&truth, sine(hz)));
        assert_eq!(name(&[]), ("proportional", 0));
        assert_eq!(name(&[slow.clone(), again]), ("two-branch", 1));
        let without = PaperOptions { operator: "auto,-rate-scheduled".into(), ..PaperOptions::default() };
        let both = [fast.clone(), slow.clone()];
        let error = identify_paper(&[prbs()], &both, &without, &mut Stage::ignore).unwrap_err().to_string();
        assert!(error.contains("leaves out rate-scheduled, which the paper's method takes"), "{error}");
        assert_eq!(name(&[fast, slow]), ("rate-scheduled", 2));
    }

    #[test]
    fn records_in_other_length_units_are_converted_and_other_units_are_an_error() {
        let truth = Model::new((OPERATORS[1].example)(TS).unwrap(), beam(), 0.0).unwrap();
        let large_signal = record(&truth, sine(5.0));
        let found = |large_signal: Record| {
            identify_paper(&[prbs()], &[large_signal], &PaperOptions::default(), &mut Stage::ignore)
        };
        let in_mm = found(large_signal.output_in("mm").unwrap()).unwrap();
        assert_eq!(in_mm.model.units().y, "um");
        let plain = found(large_signal.clone()).unwrap();
        let width = |i: &Identified| i.loops[0].found.branches.width();
        piezoid_testing::assert_close(&[width(&in_mm)], &[width(&plain)], 1e-9, 0.0);
        let counts = large_signal.with_units(Units { u: "V".into(), y: "counts".into() });
        assert!(found(counts).unwrap_err().to_string().contains("in counts, but um is needed"));
    }

    #[test]
    fn a_block_without_causal_inverse_is_inverted_over_the_whole_record_with_a_note() {
        let delayed = Arx::new(TS, vec![1.7424, -0.9453], vec![0.0, 3.4, 3.3]).unwrap();
        let u = sine(5.0);
        let (z, note) = delayed.hidden(0.0, &delayed.simulate(&u)).unwrap();
        piezoid_testing::assert_close(&z, &u[..z.len()], 0.0, 1e-6);
        assert!(z.len() > 3990);
        assert!(note.unwrap().contains("non-causally"));
    }

    #[test]
    fn a_sine_is_not_a_small_signal_record() {
        let error = identify_paper(&[record(&beam(), sine(5.0))], &[], &PaperOptions::default(), &mut Stage::ignore)
            .unwrap_err();
        assert!(error.to_string().contains("one frequency (5 Hz)"), "{error}");
    }
}
