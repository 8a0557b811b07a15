//! Creep in the report: its lags, and its step response over the decades of time.

use crate::page::{PageTable, Section};
use crate::plot::{Axes, Axis, Figure, Series};
use piezoid::creep::{Creep, Lag};
use piezoid_numerics::number::{round, short};

/// Points of the curve per decade.
const FINE: i32 = 30;

/// Adds the block, if there is any creep.
pub(super) fn block(section: Section, creep: &Creep) -> Section {
    let lags: Vec<Lag> = creep.lags().iter().filter(|lag| lag.gain != 0.0).copied().collect();
    let ends = |f: fn(f64, f64) -> f64| lags.iter().map(|lag| lag.tau_s).reduce(f);
    let (Some(quickest), Some(slowest)) = (ends(f64::min), ends(f64::max)) else { return section };
    let table = PageTable::new("Creep").number("time constant [s]").number("gain [%]");
    let table = table.rows(lags.iter().map(|lag| [round(lag.tau_s), short(100.0 * lag.gain)]));
    let all = short(100.0 * lags.iter().map(|lag| lag.gain).sum::<f64>());
    section
        .heading("Creep")
        .figure(figure(creep, 0.1 * quickest, 10.0 * slowest))
        .table(table.note(format!("Final contribution of each lag, relative to z: {all} % together.")))
}

fn figure(creep: &Creep, from: f64, to: f64) -> Figure {
    // Time constants may be as small or as large as numbers are.
    let [from, to] = [from, to].map(|t| t.clamp(f64::MIN_POSITIVE, f64::MAX));
    let decades = to.log10() - from.log10();
    let n = (f64::from(FINE) * decades).ceil() as i32;
    let t: Vec<f64> = (0..=n).map(|k| from * 10f64.powf(decades * f64::from(k) / f64::from(n))).collect();
    let crept: Vec<f64> = t.iter().map(|&t| 100.0 * creep.after(t)).collect();
    let [begin, end] = [10.0 * from, 0.1 * to];
    let grown = match end > begin {
        true => {
            let decade = 100.0 * (creep.after(end) - creep.after(begin)) / (end.log10() - begin.log10());
            let [begin, end, decade] = [round(begin), round(end), short(decade)];
            format!(" Between {begin} and {end} s it grows by {decade} % per decade.")
        }
        false => String::new(),
    };
    let caption = format!("Creep after a step of the hidden variable, in percent of the step.{grown}");
    Figure::new("Creep after a step", caption).panel(
        Axes::new(Axis::log("t [s]").tight(), Axis::new("creep [%]").from(0.0))
            .height(0.7)
            .with(Series::line(&t, &crept)),
    )
}
