//! Properties of the model that a record does not test.

use super::extrapolation::identified_range;
use super::remarks::Remark;
use piezoid_numerics::number::short;

/// Share of the identified range below which an input does not test the hysteresis.
const MIN_RANGE_SHARE: f64 = 0.2;

/// Width of the model's loop below which it does not test the hysteresis [% of its height].
const MIN_LOOP_WIDTH_PERCENT: f64 = 1.0;

pub(super) static RESONANCE: Remark = Remark {
    name: "resonance",
    when: "u has no power within half an octave of the resonance",
    text: |c| {
        let pole = c.model.linear().resonance()?;
        let [hz, damping] = [pole.hz, pole.damping].map(short);
        let text = format!("the resonance at {hz} Hz (damping {damping}): the input has no power near it");
        (!c.facts.excites_resonance).then_some(text)
    },
};

pub(super) static HYSTERESIS: Remark = Remark {
    name: "hysteresis",
    when: "u covers less than 20 % of the identified range, or the loop of the model is narrower than 1 %",
    text: |c| {
        if c.model.hysteresis().operator().name == "proportional" {
            return None;
        }
        let share =
            identified_range(c.model).map(|(low, high)| (c.facts.domain.u[1] - c.facts.domain.u[0]) / (high - low));
        let widest = c.loops.iter().map(|l| l.model.width_percent.abs()).reduce(f64::max);
        match (share, widest) {
            (Some(share), _) if share < MIN_RANGE_SHARE => {
                Some(format!("the hysteresis: the input covers {} % of the identified range", short(100.0 * share)))
            }
            (_, Some(width)) if width < MIN_LOOP_WIDTH_PERCENT => {
                Some(format!("the hysteresis: at this amplitude the loop of the model is only {} % wide", short(width)))
            }
            _ => None,
        }
    },
};
