//! What the blocks cost. Groups hold alternatives for the same work side by side: read the ratios, not the times.

#![allow(missing_docs)] // criterion's macros make public items of their own

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use piezoid::excitation::{Prbs, Sine};
use piezoid::hammerstein::Model;
use piezoid::hysteresis::{Branches, Design, Hysteresis, OPERATORS, Reading, TwoBranch, operator};
use piezoid::linear::{AbsoluteError, Arx, Orders, Regression, estimator, fit};
use piezoid::optimize::swarm::{Cost, Settings};
use piezoid::plant::{Plant, find};
use piezoid::progress::unwatched;
use piezoid::{Error, Record, System};
use std::hint::black_box;
use std::sync::Arc;

const TS: f64 = 5e-4;

fn prbs_record() -> Result<Record, Error> {
    let plant = Plant::new(&(find("pl140")?.spec)(), TS)?;
    let u = Prbs { order: 12, ..Prbs::default() }.samples(TS, 4095)?;
    let y = plant.run(&u).y.iter().map(|y| 1e6 * y).collect();
    Record::new(TS, u, y)
}

/// The swarm's cost: particles on the lanes of the vector unit against one after another.
fn cost(c: &mut Criterion) {
    let Ok(regression) = prbs_record().and_then(|r| Regression::new(&[r], Orders::of(2))) else { return };
    let cost = AbsoluteError::from(&regression);
    let mut group = c.benchmark_group("swarm cost, 50 particles x 4093 rows x 5");
    let positions: Vec<f64> = (0..250).map(|i| 0.3 * f64::from(i).sin()).collect();
    group.throughput(Throughput::Elements(50 * regression.len() as u64 * 5));
    group.bench_function("together", |b| {
        let mut costs = [0.0; 50];
        b.iter(|| cost.evaluate(black_box(&positions), &[f64::MAX; 50], &mut costs));
    });
    group.bench_function("one by one", |b| {
        let mut costs = [0.0; 50];
        b.iter(|| {
            for (theta, cost_of) in positions.chunks_exact(5).zip(&mut costs) {
                cost.evaluate(black_box(theta), &[f64::MAX], std::slice::from_mut(cost_of));
            }
        });
    });
    group.finish();
}

/// The estimators of the paper's block on the same record.
fn estimators(c: &mut Criterion) {
    let Ok(record) = prbs_record() else { return };
    let records = [record];
    let mut group = c.benchmark_group("linear block from 4095 samples");
    group.sample_size(20);
    for name in ["swarm", "least-squares", "least-absolute"] {
        let Ok(by) = estimator(name) else { continue };
        group.bench_function(name, |b| {
            b.iter(|| fit(black_box(&records), Orders::of(2), by, &Settings::default(), &mut unwatched));
        });
    }
    group.finish();
}

/// Samples a second of the blocks and of the twins.
fn simulation(c: &mut Criterion) {
    let (Ok(systems), Ok(u)) = (systems(), sine()) else { return };
    let mut group = c.benchmark_group("simulation");
    group.throughput(Throughput::Elements(u.len() as u64));
    for (name, system) in &systems {
        group.bench_function(BenchmarkId::from_parameter(name), |b| b.iter(|| system.simulate(black_box(&u))));
    }
    group.finish();
}

/// Samples a second of the operators as they are fitted by default, and of plays before the paper's linear block.
fn operators(c: &mut Criterion) {
    let (Ok(u), Ok(plays), Ok(arx)) = (sine(), fitted("prandtl-ishlinskii"), arx()) else { return };
    let Ok(model) = Model::new(plays.clone(), arx.clone(), 0.0) else { return };
    let mut group = c.benchmark_group("operators");
    group.throughput(Throughput::Elements(u.len() as u64));
    group.bench_function("model of 30 plays and arx of order 2", |b| b.iter(|| model.simulate(black_box(&u))));
    group.bench_function("30 plays, then arx of order 2", |b| b.iter(|| arx.simulate(&plays.simulate(black_box(&u)))));
    for row in OPERATORS {
        let Ok(block) = fitted(row.name) else { continue };
        group.bench_function(row.name, |b| b.iter(|| block.simulate(black_box(&u))));
    }
    group.finish();
}

/// The operator called `name` with its own number of elements.
fn fitted(name: &str) -> Result<Arc<dyn Hysteresis>, Error> {
    let design = Design { ts: TS, range: (-30.0, 30.0), elements: None, frequencies: vec![5.0, 20.0, 40.0, 80.0] };
    let basis = (operator(name)?.basis)(&design)?;
    basis.operator(&vec![0.1; basis.len()])
}

fn arx() -> Result<Arx, Error> {
    Arx::new(TS, vec![1.7424, -0.9453], vec![3.1, 3.1, 0.0])
}

type Named = (&'static str, Box<dyn System>);

fn systems() -> Result<Vec<Named>, Error> {
    let arx = arx()?;
    let u: Vec<f64> = (0..17).map(|k| 3.75 * f64::from(k) - 30.0).collect();
    let z = |side: f64| u.iter().map(|u| u + side * (1.0 - u * u / 900.0)).collect();
    let branches = Branches::new((u.clone(), z(-1.0)), (u.clone(), z(1.0)))?;
    let block = TwoBranch::new(TS, branches, Reading::Held)?;
    let model = Model::new(Arc::new(block.clone()), arx.clone(), 0.0)?;
    let plant = |name| Plant::new(&(find(name)?.spec)(), TS);
    Ok(vec![
        ("arx of order 2", Box::new(arx)),
        ("two-branch", Box::new(block)),
        ("the paper's model", Box::new(model)),
        ("twin paper", Box::new(plant("paper")?)),
        ("twin pl140", Box::new(plant("pl140")?)),
    ])
}

fn sine() -> Result<Vec<f64>, Error> {
    Sine { amplitude: 30.0, frequency: 20.0, ..Sine::default() }.samples(TS, 10_000)
}

criterion_group!(benches, cost, estimators, simulation, operators);
criterion_main!(benches);
