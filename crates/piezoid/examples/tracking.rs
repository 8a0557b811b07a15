//! How closely a twin of a bender follows references under each scheme of control, its model identified from its records alone.
//!
//! ```text
//! cargo run --release -p piezoid --example tracking -- docs
//! ```

#[allow(dead_code)] // all but the twin on its bench
#[path = "accuracy.rs"]
mod accuracy;

use accuracy::{TS, TWINS, Twin};
use piezoid::compensation::How;
use piezoid::control::{Comparison, Drive, Scheme, Target, Wanted, compare, reference};
use piezoid::excitation::Limits;
use piezoid::plant::find;
use piezoid::progress::unwatched;
use piezoid::{Error, Model};

pub(crate) const SCHEMES: [&str; 11] = [
    "gain",
    "feed-forward",
    "pi",
    "pid",
    "positive-position",
    "integral-notch",
    "disturbance-observer",
    "feed-forward+integral-notch",
    "feed-forward+disturbance-observer",
    "learning",
    "predictive",
];

/// 80 % of the stroke of +-1 mm [um].
const PEAK: f64 = 800.0;

pub(crate) fn references() -> Result<Vec<Wanted>, Error> {
    let mut all = Vec::new();
    for kind in ["sine", "triangle"] {
        for hz in [1.0, 5.0, 20.0, 40.0] {
            all.push((kind, hz));
        }
    }
    all.extend([("staircase", 1.0), ("random", 20.0)]);
    let wanted = |(kind, hz): (&str, f64)| {
        let n = (f64::max(1.0, 4.0 / hz) / TS) as usize;
        Ok(Wanted::new(format!("{kind} {hz} Hz"), TS, (reference(kind)?.samples)(TS, n, PEAK, hz)?))
    };
    all.into_iter().map(wanted).collect()
}

pub(crate) fn tracked(model: &Model, ahead: usize, late: usize) -> Result<Comparison, Error> {
    let limits = Limits { low: Some(-30.0), high: Some(30.0), ..Limits::default() };
    let how = How { limits, clip: true, ..How::default() };
    let drive = |name: &&str| {
        let mut drive = Drive::new(Scheme::named(name)?, model, how, &Target::default())?;
        (drive.ahead, drive.late) = (ahead, late);
        Ok(drive)
    };
    let drives = SCHEMES.iter().map(drive).collect::<Result<Vec<_>, Error>>()?;
    let plant = find(TWINS[0])?;
    compare((plant.name, &(plant.spec)()), drives, references()?, 7, None, &mut unwatched)
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let model = match std::env::args().nth(1) {
        Some(file) => Model::from_json(&std::fs::read_to_string(file)?)?,
        None => Twin::new(TWINS[0])?.joint("auto", false)?.model,
    };
    for ahead in [usize::MAX] {
        let c = tracked(&model, ahead, 0)?;
        println!("ahead {ahead}");
        print!("{:30}", "");
        c.wanted.iter().for_each(|w| print!("{:>14}", w.name));
        println!();
        for d in &c.driven {
            print!("{:30}", d.name());
            for a in &d.attempts {
                match a {
                    Ok(a) => print!("{:14.4}", a.tracking.percent_of_stroke),
                    Err(e) => print!("{:>14}", &e.to_string()[..12]),
                }
            }
            println!();
        }
    }
    Ok(())
}
