//! Compares controllers on the simulated bender before they run on hardware.
//!
//! `cargo run --release -p piezoid --example control`
//!
//! Each scheme is made from a model identified from records, and follows a sine and a triangle of 400 um. The table gives
//! the rms error in % of the height. `gain` is the best straight line, without compensation. Feed-forward with a controller
//! has the smallest errors; a controller alone is too slow for the triangle, because it must not excite the resonance.

use piezoid::compensation::How;
use piezoid::control::{Comparison, Drive, MarginTarget, NamedReference, Reference, Scheme};
use piezoid::excitation::{Prbs, RisingSine};
use piezoid::plant::{Plant, Preset};
use piezoid::progress::unwatched;
use piezoid::{Error, IdentifyOptions, Record, Records, identify};

/// Sampling period [s].
const TS: f64 = 5e-4;

/// The record of a voltage [V]: the displacement [um] that the sensor of the bender reads.
fn measure(u: Vec<f64>) -> Result<Record, Error> {
    let y = Plant::named("pl140", TS)?.run(&u).y;
    Record::new(TS, u, y.iter().map(|y| 1e6 * y).collect())
}

fn main() -> Result<(), Error> {
    let small = measure(Prbs { amplitude: 1.0, ..Prbs::default() }.samples(TS, 4094)?)?;
    let large = measure(RisingSine { amplitude: 28.0, frequency: 20.0, ..RisingSine::default() }.samples(TS, 4000)?)?;
    let options = IdentifyOptions { operator: "generalised-prandtl-ishlinskii".into(), ..IdentifyOptions::default() };
    let model = identify(Records { small_signal: &[small], large_signal: &[large] }, &options)?.model;

    let schemes = ["gain", "feed-forward", "integral-notch", "feed-forward+integral-notch", "predictive"];
    let drive = |name: &&str| Drive::new(Scheme::named(name)?, &model, How::default(), 0, &MarginTarget::default());
    let drives = schemes.iter().map(drive).collect::<Result<Vec<_>, _>>()?;
    let reference = |(kind, hz): (&str, f64)| {
        Ok(NamedReference::new(format!("{kind} {hz} Hz"), TS, (Reference::find(kind)?.samples)(TS, 2000, 400.0, hz)?))
    };
    let references =
        [("sine", 5.0), ("triangle", 20.0)].into_iter().map(reference).collect::<Result<Vec<_>, Error>>()?;

    let spec = (Preset::find("pl140")?.spec)();
    let compared = Comparison::run(("pl140", &spec), drives, references, 1, None, &mut unwatched)?;
    for result in &compared.driven {
        print!("{:30}", result.name());
        for (attempt, reference) in result.attempts.iter().zip(&compared.wanted) {
            match attempt {
                Ok(attempt) => print!("{} {:.3} %   ", reference.name, attempt.tracking.percent_of_stroke),
                Err(refused) => print!("{} refused: {refused}   ", reference.name),
            }
        }
        println!();
    }
    Ok(())
}
