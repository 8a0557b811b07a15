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
    let of = |source, series: fn(&[f64], &[f64]) -> Series| drawn(bins, |b| b.source == source, series);
    let cycles = of(Source::Cycles, Series::points).role(Role::Accent1).named("cycles");
    let spectrum = of(Source::Spectrum, Series::marked).role(Role::Accent2).named("spectrum");
    [cycles, spectrum].into_iter().filter(|series| !series.is_empty()).collect()
}

/// The errors of the bins that are excited and `taken`.
fn drawn(bins: &[Bin], taken: impl Fn(&Bin) -> bool, series: impl Fn(&[f64], &[f64]) -> Series) -> Series {
    let bins = bins.iter().filter(|b| !b.little_excited && taken(b));
    let (at, error): (Vec<f64>, Vec<f64>) = bins.map(|b| (b.at, b.nrmse_percent)).unzip();
    series(&at, &error)
}

/// The noise in these errors, with the same bandwidth, and the errors where little is excited.
fn beside(bins: &[Bin]) -> Vec<Series> {
    let noise = |source: Source| {
        let bins = bins.iter().filter(|b| b.source == source && !b.little_excited);
        let (at, noise): (Vec<f64>, Vec<f64>) =
            bins.filter_map(|b| Some((b.at, b.noise_nrmse_percent.filter(|noise| *noise > 0.0)?))).unzip();
        Series::line(&at, &noise).dashes(1).role(Role::Reference)
    };
    let little = bins.iter().filter(|b| b.little_excited).map(|b| (b.at, b.nrmse_percent));
    let (little_at, error): (Vec<f64>, Vec<f64>) = little.unzip();
    let mut noise: Vec<Series> =
        [Source::Cycles, Source::Spectrum].map(noise).into_iter().filter(|s| !s.is_empty()).collect();
    // One entry of the legend for both.
    if let Some(first) = noise.first_mut() {
        *first = first.clone().named("noise in it");
    }
    let little = Series::points(&little_at, &error).role(Role::Muted).named("little excited");
    noise.into_iter().chain(Some(little).filter(|series| !series.is_empty())).collect()
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
        let centre = Bin::merged(of().flat_map(|t| &t.validation.by_frequency));
        let series = match hz {
            Some(_) => drawn(&bins, |_| true, Series::marked).named(format!("{} Hz", short(centre[0].at))),
            None => drawn(&bins, |_| true, Series::points).named("several frequencies"),
        };
        series.role(Role::accent(k)).dashes(k / 5)
    };
    let with_cycles =
        |hz: &Option<f64>| records.iter().any(|t| single(t) == *hz && !t.validation.by_amplitude.is_empty());
    frequencies.into_iter().filter(with_cycles).enumerate().map(series).filter(|series| !series.is_empty()).collect()
}

/// Adds nothing for a single bin, which repeats the overall figures.
fn one(section: Section, title: &str, label: &str, bins: &[Bin], unit: &str, drawn: Vec<Series>) -> Section {
    if bins.len() < 2 {
        return section;
    }
    let table = PageTable::new(title).number(label).text("of").number(format!("rms error [{unit}]"));
    let table = table.number("rms / std of y [%]").number("of it noise [%]").number("rms / peak-to-peak [%]");
    let row = |b: &Bin| {
        let of = match (b.source, b.cycles) {
            (Source::Cycles, 1) => "1 cycle".into(),
            (Source::Cycles, many) => format!("{many} cycles"),
            (Source::Spectrum, _) => "spectrum".to_string(),
        };
        let of = if b.little_excited { format!("{of}, little excited") } else { of };
        let noise = b.noise_nrmse_percent.map_or("-".into(), short);
        [short(b.at), of, short(b.rmse), short(b.nrmse_percent), noise, short(b.rms_pp_percent)]
    };
    section.figure(figure(title, label, bins, drawn)).table(table.rows(bins.iter().map(row)).note(
        "From the cycles of the input in all records; the frequency of a cycle is 1 / duration, its amplitude half \
         its peak-to-peak. If the input has no cycles, from the spectra of error and output.",
    ))
}

fn figure(title: &str, label: &str, bins: &[Bin], drawn: Vec<Series>) -> Figure {
    let excited = bins.iter().filter(|b| !b.little_excited && b.nrmse_percent.is_finite());
    let worst = excited.max_by(|a, b| a.nrmse_percent.total_cmp(&b.nrmse_percent));
    let mut caption = String::from("Rms error over the standard deviation of the output");
    if bins.iter().any(|b| !b.little_excited && b.noise.is_some()) {
        caption += ", and the noise in it, of the same bandwidth";
    }
    caption += ".";
    if let Some(worst) = worst {
        let unit = label.split(['[', ']']).nth(1).unwrap_or_default();
        let (at, share) = (short(worst.at), short(worst.nrmse_percent));
        caption += &format!(" It is largest at {at} {unit}, where it is {share} %.");
    }
    if bins.iter().any(|b| b.little_excited) {
        caption += " Pale: little is excited there (the output is below three times its noise, or the input has less \
                    than 2 % of the power of its strongest band), and the error is that of noise or of other frequencies.";
    }
    let axes = Axes::new(Axis::log(label), Axis::log("rms error / std of y [%]")).height(0.8);
    Figure::new(title, caption).panel(axes.each(drawn.into_iter().chain(beside(bins)), Axes::with))
}
