//! The linear block in the report: its modes and frequency response.

use crate::each::Each;
use crate::page::{Fact, PageTable, Section};
use crate::plot::{Axes, Axis, Figure, Series};
use piezoid::linear::{Arx, ModalForm};
use piezoid::{Model, System};
use piezoid_numerics::number::short;
use piezoid_numerics::series::ends;
use std::f64::consts::{PI, TAU};

/// Number of frequencies of the curves, evenly spaced over three decades up to half the sampling rate.
const FINE: i32 = 600;

/// Additional frequencies on each side of a mode, the nearest at a tenth of its width.
const BESIDE: i32 = 30;

/// Adds the block with its coefficients and the offset.
pub(super) fn block(section: Section, model: &Model) -> Section {
    let (arx, units) = (model.linear(), model.units());
    let section = section.heading("Linear block");
    let gain = format!("{}/{}", units.y, units.u);
    let section = match arx.a() {
        [] => {
            let spread = match arx.b().len() {
                1 => String::new(),
                n => format!(", spread over the last {n} samples"),
            };
            section.text(format!("A gain of {} {gain}, without dynamics{spread}.", short(arx.dc_gain())))
        }
        _ => {
            let form = arx.modal_form();
            section.facts(facts(&form, &gain, arx.ts())).figure(response(arx, &form, &gain)).table(modes(&form))
        }
    };
    let (a, b) = (listed("a", arx.a()), listed("b", arx.b()));
    section
        .text("As a difference equation, y = a1 y1 + a2 y2 + ... + b0 u + b1 u1 + ... + offset:")
        .listing(format!("{a}{b}offset  {}", model.offset()))
}

fn facts(form: &ModalForm, gain: &str, ts: f64) -> Vec<Fact> {
    let first = form.modes().first().map(|mode| Fact::new(short(mode.pole.hz), "Hz", "lowest mode"));
    let what = match form.delay < -0.25 * ts {
        true => "delay (negative: the output was sampled after the input of its row acted)",
        false => "delay in addition to the zero-order hold",
    };
    let delay = Fact::new(short(1e3 * form.delay), "ms", what);
    [Some(Fact::new(short(form.gain), gain, "static gain")), first, Some(delay)].into_iter().flatten().collect()
}

fn modes(form: &ModalForm) -> PageTable {
    let table = PageTable::new("Modes of the linear block").text("").number("f [Hz]").number("damping ratio");
    let table = table.number("share [%]").number("mass [g]").number("damper [N s/m]");
    let table = table.rows(form.rows()).note(
        "Shares of the static displacement. Mass and damper for a spring of 1 N/mm at the point of measurement: both \
        are proportional to the stiffness.",
    );
    table.each(form.images(), PageTable::note)
}

/// Gain and phase, with the modes marked.
fn response(arx: &Arx, form: &ModalForm, unit: &str) -> Figure {
    let (hz, half) = (frequencies(arx, form), 0.5 / arx.ts());
    let all: Vec<_> = hz.iter().map(|&hz| arx.response(hz)).collect();
    let gain: Vec<f64> = all.iter().map(|r| r.gain).collect();
    // The phase is unwrapped.
    let mut last = all[0].phase;
    let phase = all.iter().map(|r| {
        last += (r.phase - last + PI).rem_euclid(TAU) - PI;
        last.to_degrees()
    });
    let phase: Vec<f64> = phase.collect();
    let modes = form.modes();
    let name = |k: usize, hz: f64| if modes.len() == 1 { format!("{} Hz", short(hz)) } else { format!("{}", k + 1) };
    let panel = |y: Axis, values: &[f64], named: bool| {
        Axes::new(Axis::log("f [Hz]").tight(), y)
            .each(form.images(), |axes, _| axes.over_x(ModalForm::MAX_OBSERVABLE_NYQUIST_SHARE * half, half))
            .each(modes.iter().map(|mode| mode.pole.hz).enumerate(), |axes, (k, hz)| {
                axes.at_x(hz, if named { name(k, hz) } else { String::new() })
            })
            .with(Series::line(&hz, values))
    };
    let top = panel(Axis::log(format!("gain [{unit}]")), &gain, true).height(0.85);
    let low = panel(Axis::new("phase [°]").ticks(&quarters(&phase)), &phase, false).height(0.6);
    Figure::new("Frequency response", caption(&gain, &hz, form)).panel(top).panel(low).stacked()
}

fn caption(gain: &[f64], hz: &[f64], form: &ModalForm) -> String {
    let half = short(hz[hz.len() - 1]);
    let peak = (0..gain.len()).max_by(|&i, &j| gain[i].total_cmp(&gain[j])).filter(|&k| gain[k] > 1.01 * gain[0]);
    let peak = peak.map_or(String::new(), |k| {
        format!(" At {} Hz the gain is {} times the static gain.", short(hz[k]), short(gain[k] / form.gain.abs()))
    });
    let marked = match form.modes().len() {
        0 => "",
        1 => " The dotted line marks the mode.",
        _ => " The dotted lines are its modes, numbered as in the table.",
    };
    let shaded = form.images().map_or(
        "",
        |_| " Shaded: frequencies near half the sampling rate, where poles may be images of delay or of faster modes.",
    );
    format!("Gain and phase up to half the sampling rate, {half} Hz.{peak}{marked}{shaded}")
}

/// Multiples of 90° around the phase, or of 180° for a wide range.
fn quarters(phase: &[f64]) -> Vec<f64> {
    let (low, high) = ends(phase.iter().copied());
    let step = if high - low > 540.0 { 180.0 } else { 90.0 };
    let (first, last) = ((low / step).floor() as i32, (high / step).ceil() as i32);
    (first..=last).map(|k| step * f64::from(k)).collect()
}

/// Three decades up to half the sampling rate, more if a mode is lower, and finer around each mode.
fn frequencies(arx: &Arx, form: &ModalForm) -> Vec<f64> {
    let modes = form.modes();
    let half = 0.5 / arx.ts();
    let low = modes.iter().fold(1e-3 * half, |low, mode| low.min(0.1 * mode.pole.hz));
    let even = (0..=FINE).map(|k| low * (half / low).powf(f64::from(k) / f64::from(FINE)));
    let about = modes.iter().flat_map(|mode| {
        let width = 0.1 * mode.pole.hz * mode.pole.damping.abs().clamp(1e-6, 0.3);
        (-BESIDE..=BESIDE).map(move |k| mode.pole.hz + f64::from(k) * width)
    });
    let mut hz: Vec<f64> = even.chain(about.filter(|hz| (low..half).contains(hz))).collect();
    hz.sort_by(f64::total_cmp);
    hz
}

fn listed(name: &str, values: &[f64]) -> String {
    let each: Vec<String> = values.iter().map(f64::to_string).collect();
    if each.is_empty() { String::new() } else { format!("{name}  {}\n", each.join(", ")) }
}
