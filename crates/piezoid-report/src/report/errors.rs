//! Errors by frequency and by amplitude, over all records.

use crate::each::Each;
use crate::page::{PageTable, Section};
use crate::plot::{Axes, Axis, Figure, Role, Series};
use piezoid::validation::Bin;
use piezoid_numerics::number::short;
use piezoid_validation::Source;
use piezoid_verbs::Compared;

/// Adds figures and tables of the bins of all records, if there are several bins.
pub(super) fn by_all(section: Section, records: &[Compared]) -> Section {
    let units = records[0].record.units();
    let by_frequency = Bin::merged(records.iter().flat_map(|t| &t.validation.by_frequency));
    let by_amplitude = Bin::merged(records.iter().flat_map(|t| &t.validation.by_amplitude));
    let amplitude = format!("amplitude of the input [{}]", units.u);
    let section = one(section, "Error by frequency", "f [Hz]", &by_frequency, &units.y, by_source(&by_frequency));
    one(section, "Error by amplitude", &amplitude, &by_amplitude, &units.y, of_each_frequency(records))
}

/// The series of errors by frequency. Bands of a spectrum are joined, but not cycles: they are of different amplitudes.
fn by_source(bins: &[Bin]) -> Vec<Series> {
    let of = |source, series: fn(&[f64], &[f64]) -> Series| {
        let bins = bins.iter().filter(|b| b.source == source);
        let (at, error): (Vec<f64>, Vec<f64>) = bins.map(|b| (b.at, b.nrmse_percent)).unzip();
        series(&at, &error)
    };
    let cycles = of(Source::Cycles, Series::points).role(Role::Accent1).named("cycles");
    let spectrum = of(Source::Spectrum, Series::marked).role(Role::Accent2).named("spectrum");
    [cycles, spectrum].into_iter().filter(|series| !series.is_empty()).collect()
}

/// The series of errors by amplitude, one for each frequency; records of several frequencies are one series, unjoined.
fn of_each_frequency(records: &[Compared]) -> Vec<Series> {
    let single = |t: &Compared| match t.validation.by_frequency[..] {
        [bin] => Some(bin.low),
        _ => None,
    };
    let mut frequencies: Vec<Option<f64>> = records.iter().map(single).collect();
    frequencies.sort_by(|a, b| a.unwrap_or(f64::INFINITY).total_cmp(&b.unwrap_or(f64::INFINITY)));
    frequencies.dedup();
    let series = |(k, hz): (usize, Option<f64>)| {
        let of = || records.iter().filter(move |t| single(t) == hz);
        let bins = Bin::merged(of().flat_map(|t| &t.validation.by_amplitude));
        let (at, error): (Vec<f64>, Vec<f64>) = bins.iter().map(|b| (b.at, b.nrmse_percent)).unzip();
        let centre = Bin::merged(of().flat_map(|t| &t.validation.by_frequency));
        let series = match hz {
            Some(_) => Series::marked(&at, &error).named(format!("{} Hz", short(centre[0].at))),
            None => Series::points(&at, &error).named("several frequencies"),
        };
        series.role(Role::accent(k)).dashes(k / 5)
    };
    let with_cycles =
        |hz: &Option<f64>| records.iter().any(|t| single(t) == *hz && !t.validation.by_amplitude.is_empty());
    frequencies.into_iter().filter(with_cycles).enumerate().map(series).collect()
}

/// Adds nothing for a single bin, which repeats the overall figures.
fn one(section: Section, title: &str, label: &str, bins: &[Bin], unit: &str, drawn: Vec<Series>) -> Section {
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
    section.figure(figure(title, label, bins, drawn)).table(table.rows(bins.iter().map(row)).note(
        "From the cycles of the input in all records; the frequency of a cycle is 1 / duration, its amplitude half \
         its peak-to-peak. If the input has no cycles, from the spectra of error and output.",
    ))
}

fn figure(title: &str, label: &str, bins: &[Bin], drawn: Vec<Series>) -> Figure {
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
    Figure::new(title, caption).panel(axes.each(drawn, Axes::with))
}
