//! Where the time of `identify` goes, by stage and kernel, beside a bound: the time of the linearised fits that no
//! search can do without.
//!
//! `cargo xtask bench -- identify [FOLDER...]`: each folder holds `train_*.csv`, and perhaps `small_*.csv`. Without
//! folders, records of twins, and the measured stack if PIEZOID_DATA names the folder that holds `picma-p885`.

use piezoid::excitation::{Multisine, Prbs, RisingSine};
use piezoid::formats::ColumnSelection;
use piezoid::plant::Plant;
use piezoid::{Error, IdentifyOptions, Record, Records, identify};
use piezoid_bench::page::{head, row};
use piezoid_bench::profile::{Profile, Recorder};
use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};

/// What is identified.
struct Case {
    name: String,
    small: Vec<Record>,
    large_signal: Vec<Record>,
}

/// Fits that no search can do without: for each operator that is compared, one for its weights and one for creep; for
/// each structure that is listed, one; and some from there to the minimum.
const FITS_PER_OPERATOR: usize = 2;
const FITS_TO_MINIMUM: usize = 5;

fn main() {
    static PROFILE: std::sync::LazyLock<Profile> = std::sync::LazyLock::new(Profile::default);
    let folders: Vec<String> = std::env::args().skip(1).filter(|word| !word.starts_with('-')).collect();
    if let Err(why) = tracing::subscriber::set_global_default(Recorder(&PROFILE)) {
        eprintln!("error: {why}");
        return;
    }
    let cases = match folders.is_empty() {
        true => own().and_then(|own| Ok(own.into_iter().chain(measured()?).collect::<Vec<_>>())),
        false => folders.iter().map(|folder| in_folder(Path::new(folder))).collect(),
    };
    let printed = cases.and_then(|cases| {
        for case in &cases {
            for operator in ["auto", "prandtl-ishlinskii", "preisach"] {
                report(case, operator, &PROFILE)?;
            }
        }
        Ok(())
    });
    if let Err(why) = printed {
        eprintln!("error: {why}");
        std::process::exit(1);
    }
}

/// Identifies a case, and prints its profile.
fn report(case: &Case, operator: &str, profile: &Profile) -> Result<(), Error> {
    let options = IdentifyOptions { operator: operator.into(), ..IdentifyOptions::default() };
    let samples: usize = case.small.iter().chain(&case.large_signal).map(Record::len).sum();
    profile.take();
    let start = Instant::now();
    let found = identify(Records { small_signal: &case.small, large_signal: &case.large_signal }, &options)?;
    let (wall, sums) = (start.elapsed().as_secs_f64(), profile.take());
    let seconds = |time: &Duration| time.as_secs_f64();
    let kernels = || sums.iter().filter(|((_, kernel), _)| kernel != "-");
    let work: f64 = kernels().map(|(_, (_, time))| seconds(time)).sum();
    let of = |kind: &str| {
        let those = kernels().filter(|((_, kernel), _)| kernel.starts_with(kind));
        those.fold((0, 0.0), |sum, (_, (count, time))| (sum.0 + count, sum.1 + seconds(time)))
    };
    let (fits, fit) = (of("rows").0, of("columns").1 + of("products").1);
    let structures = found.linear.reason.matches('%').count().max(1);
    let needed = FITS_PER_OPERATOR * found.trials.len().max(1) + structures + FITS_TO_MINIMUM;
    let bound = needed as f64 * fit / fits.max(1) as f64;
    println!("\n## {}, {operator}: {samples} samples, {wall:.2} s\n", case.name);
    println!(
        "{fits} fits, {work:.2} s on all threads; {needed} fits are needed: {bound:.2} s, a ratio of {:.1}\n",
        work / bound
    );
    print!("{}", head(["stage", "kernel", "times", "s"], 2));
    for ((stage, kernel), (times, time)) in kernels().filter(|(_, (_, time))| seconds(time) > 0.02 * work) {
        print!("{}", row([stage.as_str(), kernel.as_str(), &times.to_string(), &format!("{:.3}", seconds(time))]));
    }
    let mut stages: BTreeMap<&str, f64> = BTreeMap::new();
    kernels().for_each(|((stage, _), (_, time))| *stages.entry(stage).or_default() += seconds(time));
    stages.iter().for_each(|(stage, time)| print!("{}", row([stage, "all", "", &*format!("{time:.3}")])));
    Ok(())
}

/// Records of the twin `pl140`: those of the README, and a minute of many frequencies.
fn own() -> Result<Vec<Case>, Error> {
    let record = |ts: f64, u: Vec<f64>| {
        let y = Plant::named("pl140", ts)?.run(&u).y;
        Record::new(ts, u, y)
    };
    let rising = |frequency: f64| {
        record(5e-4, RisingSine { amplitude: 28.0, frequency, ..RisingSine::default() }.samples(5e-4, 4000)?)
    };
    let prbs = record(5e-4, Prbs { amplitude: 1.0, ..Prbs::default() }.samples(5e-4, 4000)?)?;
    let tour = [5.0, 20.0, 80.0].into_iter().map(rising).collect::<Result<_, _>>()?;
    let minute = Multisine { amplitude: 28.0, frequency_low: 0.5, frequency_high: 40.0, ..Multisine::default() };
    let minute = record(5e-4, minute.samples(5e-4, 120_000)?)?;
    Ok(vec![
        Case { name: "the README's records".into(), small: vec![prbs], large_signal: tour },
        Case { name: "60 s at 2 kHz".into(), small: Vec::new(), large_signal: vec![minute] },
    ])
}

/// The measured stack, if it is there.
fn measured() -> Result<Option<Case>, Error> {
    let folder = std::env::var_os("PIEZOID_DATA").unwrap_or_default();
    let file = Path::new(&folder).join("picma-p885/model_1Hz.csv");
    let Ok(bytes) = std::fs::read(&file) else {
        eprintln!("skipped: the measured stack: set PIEZOID_DATA to the folder that holds picma-p885");
        return Ok(None);
    };
    let record = Record::from_csv(&bytes, &ColumnSelection::default())?;
    Ok(Some(Case { name: "picma-p885".into(), small: Vec::new(), large_signal: vec![record] }))
}

/// The records in a folder.
fn in_folder(folder: &Path) -> Result<Case, Error> {
    let broken = |why: std::io::Error| Error::Content(format!("{}: {why}", folder.display()));
    let mut files: Vec<_> = std::fs::read_dir(folder).map_err(broken)?.flatten().map(|entry| entry.path()).collect();
    files.sort();
    let of = |kind: &str| -> Result<Vec<Record>, Error> {
        let name = |path: &Path| path.file_name().and_then(|name| name.to_str()).unwrap_or_default().to_string();
        let those = files.iter().filter(|path| name(path).starts_with(kind) && name(path).ends_with(".csv"));
        those.map(|path| Record::from_csv(&std::fs::read(path).map_err(broken)?, &ColumnSelection::default())).collect()
    };
    Ok(Case { name: folder.display().to_string(), small: of("small")?, large_signal: of("train")? })
}
