//! The swarm on the paper's problem, timed, for the comparison with pyswarms in `bench/swarm.py`.
//!
//! `swarm rows` prints the regression, one line `y,psi...` per row. `swarm run SEED` prints seconds, cost, and the
//! machine's peak rate of multiply-adds as JSON.

use multiversion::{multiversion, target::target_cfg_f};
use piezoid::excitation::Prbs;
use piezoid::linear::{AbsoluteError, Estimator, Orders, Regression};
use piezoid::optimize::swarm::SwarmSettings;
use piezoid::plant::Plant;
use piezoid::{Error, Record, progress::Stage};
use std::hint::black_box;
use std::time::Instant;

const TS: f64 = 5e-4;

fn main() -> Result<(), Error> {
    let mut arguments = std::env::args().skip(1);
    let verb = arguments.next().unwrap_or_default();
    let seed = arguments.next().and_then(|s| s.parse().ok()).unwrap_or(1);
    // A record of the twin with noise, as an experimenter would measure it.
    let plant = Plant::named("pl140", TS)?;
    let u = Prbs { order: 12, ..Default::default() }.samples(TS, 4095)?;
    let y: Vec<f64> = plant.run(&u).y.iter().map(|y| 1e6 * y).collect();
    let record = Record::new(TS, u.clone(), y.clone())?;
    let settings = SwarmSettings { seed, ..Default::default() };
    let squares = Estimator::find("least-squares")?.fit(&[record], Orders::of(2), &settings, &mut Stage::ignore)?;
    let offset = squares.offsets[0];
    let centred = Record::new(TS, u, y.iter().map(|y| y - offset).collect())?;
    let regression = Regression::new(&[centred], Orders::of(2))?;
    if verb == "rows" {
        for row in regression.rows() {
            println!("{}", row.iter().map(f64::to_string).collect::<Vec<_>>().join(","));
        }
        return Ok(());
    }
    let bounds = regression.search_box(&[squares.arx.a(), squares.arx.b()].concat())?;
    let start = Instant::now();
    let found = settings.clone().minimise(&AbsoluteError::from(&regression), bounds, &mut Stage::ignore)?;
    let seconds = start.elapsed().as_secs_f64();
    let (evaluations, rows) = (settings.particles * (settings.iterations + 1), regression.len());
    println!(
        "{}",
        serde_json::json!({
            "seconds": seconds,
            "cost": found.cost,
            "multiply_adds": evaluations * rows * 5,
            "peak_multiply_adds_per_second": peak(),
        })
    );
    Ok(())
}

/// Peak multiply-adds per second of one core: many independent chains, the best of several trials.
fn peak() -> f64 {
    const ROUNDS: usize = 200_000;
    let once = || {
        let start = Instant::now();
        black_box(chains(black_box(0.999), ROUNDS));
        (ROUNDS * LANES) as f64 / start.elapsed().as_secs_f64()
    };
    (0..20).map(|_| once()).fold(0.0, f64::max)
}

/// Number of lanes, enough to hide the latency of the multiply-add at any vector width up to 512 bit.
const LANES: usize = 128;

#[multiversion(targets("x86_64+avx512f+avx512vl+fma", "x86_64+avx2+fma", "aarch64+neon"))]
fn chains(factor: f64, rounds: usize) -> f64 {
    let mut lanes = [1.0f64; LANES];
    for _ in 0..rounds {
        for lane in &mut lanes {
            *lane = if target_cfg_f!(any(target_feature = "fma", target_arch = "aarch64")) {
                lane.mul_add(factor, 1e-3)
            } else {
                *lane * factor + 1e-3
            };
        }
    }
    lanes.iter().sum()
}
