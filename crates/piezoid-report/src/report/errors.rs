//! Errors by frequency and by amplitude, over all records.

use crate::page::{PageTable, Section};
use crate::plot::{Axes, Axis, Figure, Role, Series};
use piezoid::Compared;
use piezoid::number::short;
use piezoid::validation::{Bin, Source};

/// Adds figures and tables of the bins of all records, if there are several bins.
pub(super) fn by_all(section: Section, records: &[Compared]) -> Section {
    let units = records[0].record.units();
    let by_frequency = Bin::merged(records.iter().flat_map(|t| &t.validation.by_frequency));
    let by_amplitude = Bin::merged(records.iter().flat_map(|t| &t.validation.by_amplitude));
    let section = one(section, "Error by frequency", "f [Hz]", &by_frequency, &units.y);
    one(section, "Error by amplitude", &format!("amplitude of the input [{}]", units.u), &by_amplitude, &units.y)
}

/// Adds nothing for a single bin, which repeats the overall figures.
fn one(section: Section, title: &str, label: &str, bins: &[Bin], unit: &str) -> Section {
    if bins.len() < 2 {
        return section;
    }
    let table = PageTable::new(title).number(label).text("of").number(format!("rms error [{unit}]"));
    let table = table.number("rms / std of y [%]").number("rms / peak-to-peak [%]");
    let row = |b: &Bin| {
        let of = match (b.source, b.cycles) {
            (Source::Cycles, 1) => "1 cycle".into(),
            (Source::Cycles, many) => format!("{many} cycles"),
            (Source::Spectrum, _) => "spectrum".to_string(),
        };
        [short(b.at), of, short(b.rmse), short(b.nrmse_percent), short(b.rms_pp_percent)]
    };
    let table = bins.iter().fold(table, |table, b| table.row(row(b)));
    section.figure(figure(title, label, bins)).table(table.note(
        "From the cycles of the input in all records; the frequency of a cycle is 1 / duration, its amplitude half \
         its peak-to-peak. If the input has no cycles, from the spectra of error and output.",
    ))
}

fn figure(title: &str, label: &str, bins: &[Bin]) -> Figure {
    let worst =
        bins.iter().filter(|b| b.nrmse_percent.is_finite()).max_by(|a, b| a.nrmse_percent.total_cmp(&b.nrmse_percent));
    let caption = worst.map_or(String::new(), |w| {
        let unit = label.split(['[', ']']).nth(1).unwrap_or_default();
        let (at, share) = (short(w.at), short(w.nrmse_percent));
        format!(
            "Rms error over the standard deviation of the output. It is largest at {at} {unit}, where it is {share} %."
        )
    });
    let axes = Axes::new(Axis::log(label), Axis::log("rms error / std of y [%]")).height(0.8);
    let kinds = [(Source::Cycles, "cycles", Role::Accent1), (Source::Spectrum, "spectrum", Role::Accent2)];
    let axes = kinds.into_iter().fold(axes, |axes, (source, name, role)| {
        let of = |f: fn(&Bin) -> f64| bins.iter().filter(|b| b.source == source).map(f).collect::<Vec<_>>();
        match of(|b| b.at) {
            at if at.is_empty() => axes,
            at => axes.with(Series::marked(&at, &of(|b| b.nrmse_percent)).role(role).named(name)),
        }
    });
    Figure::new(title, caption).panel(axes)
}
