//! Benchmarks of the blocks. Groups hold alternatives for the same work: compare the ratios, not the times.

#![allow(missing_docs)] // the macros of criterion make public items

use criterion::{BenchmarkId, Criterion, Throughput, criterion_group, criterion_main};
use multiversion::{multiversion, target::target_cfg_f};
use piezoid::compensation::{Causal, FeedForward, FeedForwardSettings};
use piezoid::control::{Controller, ControllerInput};
use piezoid::creep::Creep;
use piezoid::driver::DriverModel;
use piezoid::excitation::{Prbs, RisingSine, Sine};
use piezoid::hammerstein::Model;
use piezoid::hysteresis::{HeldInput, Hysteresis, OPERATORS, Operator};
use piezoid::linear::{Arx, Orders};
use piezoid::plant::{Plant, Preset};
use piezoid::progress::Stage;
use piezoid::{Error, IdentifyOptions, Record, System};
use piezoid_control::feedback::predictive::{Predictive, PredictiveSettings, Solver};
use piezoid_models::hysteresis::{Basis, BasisDesign};
use piezoid_models::hysteresis::{Branches, TwoBranch};
use piezoid_models::linear::{AbsoluteError, Regression};
use piezoid_numerics::optimize::swarm::Cost;
use piezoid_report::study::Study;
use std::hint::black_box;
use std::sync::Arc;

const TS: f64 = 5e-4;

fn prbs_record() -> Result<Record, Error> {
    let plant = Plant::named("pl140", TS)?;
    let u = Prbs { order: 12, ..Default::default() }.samples(TS, 4095)?;
    let y = plant.run(&u).y;
    Record::new(TS, u, y)
}

/// Number of lanes, enough to hide the latency of the multiply-add at any vector width up to 512 bit.
const LANES: usize = 128;

/// Multiply-adds in many independent chains: the peak rate of one core.
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

/// The cost function of the swarm: all particles together in the lanes of the vector unit, and one after another;
/// beside them, as many multiply-adds at the peak rate of the core.
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
    let rounds = 50 * regression.len() * 5 / LANES;
    group.bench_function("peak of this core", |b| b.iter(|| chains(black_box(0.999), rounds)));
    group.finish();
}

/// The joint method: one operator on more and more samples, and all operators.
fn identification(c: &mut Criterion) {
    let record = |hertz: f64, n: usize| {
        let u = RisingSine { amplitude: 28.0, frequency: hertz, ..RisingSine::default() }.samples(TS, n)?;
        let y = Plant::named("pl140", TS)?.run(&u).y;
        Record::new(TS, u, y)
    };
    let mut group = c.benchmark_group("joint identification, samples of three rising sines");
    group.sample_size(10);
    for (operator, n) in [("preisach", 10_000), ("preisach", 40_000), ("preisach", 160_000), ("auto", 10_000)] {
        let records = [2.0, 10.0, 50.0].map(|hertz| record(hertz, n)).into_iter().collect::<Result<Vec<_>, _>>();
        let Ok(records) = records else { return };
        let options = IdentifyOptions { operator: operator.into(), ..IdentifyOptions::default() };
        group.throughput(Throughput::Elements(3 * n as u64));
        let id = BenchmarkId::new(operator, 3 * n);
        group.bench_function(id, |b| b.iter(|| piezoid::identify(black_box(&records[..]), &options)));
    }
    group.finish();
}

/// Samples per second of `systems`, all with the same sine as input.
fn side_by_side(c: &mut Criterion, group: &str, systems: Result<Vec<Named>, Error>) {
    let (Ok(systems), Ok(u)) = (systems, sine()) else { return };
    let mut group = c.benchmark_group(group);
    group.throughput(Throughput::Elements(u.len() as u64));
    for (name, system) in &systems {
        group.bench_function(BenchmarkId::from_parameter(name), |b| b.iter(|| system.simulate(black_box(&u))));
    }
    group.finish();
}

/// The linear blocks, the models, and the operators with default fits.
fn simulation(c: &mut Criterion) {
    side_by_side(c, "linear", linear());
    side_by_side(c, "models", models());
    let operator = |row: &&'static Operator| Ok((row.name.into(), fitted(row.name)? as Arc<dyn System>));
    side_by_side(c, "operators", OPERATORS.iter().map(operator).collect());
}

/// One sample of predictive control with both solvers. The triangle cannot be followed within +-12 V.
fn predictive(c: &mut Criterion) {
    let model = fitted("prandtl-ishlinskii").and_then(|plays| Model::new(plays, resonant()?, 0.0));
    let Ok(model) = model else { return };
    let mut group = c.benchmark_group("predictive");
    let near = PredictiveSettings { voltage: (-30.0, 30.0), slew: Some(6e4), ..Default::default() };
    let displacement = Some((-300.0, 300.0));
    let far = PredictiveSettings { voltage: (-12.0, 12.0), slew: Some(3e3), displacement, ..near.clone() };
    for (name, settings) in [("free", near), ("limited", far)] {
        for (by, solver) in [("active set", Solver::ActiveSet), ("interior point", Solver::InteriorPoint)] {
            for horizon in [10, 20, 40] {
                let multiplications_per_second = 1e12;
                let settings = PredictiveSettings { horizon, solver, multiplications_per_second, ..settings.clone() };
                let Ok(mpc) = Predictive::new(&model, settings) else { continue };
                let r: Vec<f64> = (0..200 + horizon).map(|t| 400.0 * triangle(t as f64 / 100.0)).collect();
                let (mut x, mut plant) = (mpc.settled(0.0), model.settled(0.0));
                let (mut t, mut y) = (0, 0.0);
                group.bench_function(format!("{name}, {by}, {horizon} samples"), |b| {
                    b.iter(|| {
                        let input = ControllerInput { y, ahead: black_box(&r[t..]), ..Default::default() };
                        y = model.step(&mut plant, mpc.step(&mut x, &input));
                        t = (t + 1) % 200;
                    });
                });
            }
        }
    }
    group.finish();
}

/// Feed-forward along a sine by the inverse of 30 plays and a resonance, with and without creep: sample by sample, and
/// over the whole record.
fn feed_forward(c: &mut Criterion) {
    let model = fitted("prandtl-ishlinskii").and_then(|plays| Model::new(plays, resonant()?, 0.0));
    let (Ok(plain), Ok(r)) = (model, sine()) else { return };
    let creep = Creep::logarithmic(TS, 0.01, 0.01, 10.0).and_then(|creep| plain.clone().with_creep(creep));
    let mut group = c.benchmark_group("feed-forward");
    group.throughput(Throughput::Elements(r.len() as u64));
    for (name, model) in [("plays", Ok(plain)), ("plays and creep", creep)] {
        let Ok((model, whole)) =
            model.and_then(|m| Ok((m.clone(), FeedForward::new(&m, FeedForwardSettings::default())?)))
        else {
            continue;
        };
        let r: Vec<f64> = r.iter().map(|r| 0.8 / 30.0 * whole.reach().1 * r).collect();
        for delay in [1, 16] {
            let Ok(causal) = Causal::new(&model, FeedForwardSettings::default(), delay) else { continue };
            group.bench_function(format!("{name}, delay of {delay}"), |b| b.iter(|| causal.simulate(black_box(&r))));
        }
        group.bench_function(format!("{name}, whole"), |b| b.iter(|| whole.whole(black_box(&r))));
    }
    group.finish();
}

/// A triangle from -1 to 1 with period 1.
fn triangle(turns: f64) -> f64 {
    4.0 * ((turns + 0.25).fract() - 0.5).abs() - 1.0
}

/// A resonance with an input delay of one sample.
fn resonant() -> Result<Arx, Error> {
    Arx::new(TS, vec![1.7424, -0.9453], vec![0.0, 3.1, 3.1])
}

/// The basis of the operator called `name`, with its default number of elements.
fn basis(name: &str) -> Result<Box<dyn Basis>, Error> {
    let design = BasisDesign { ts: TS, range: (-30.0, 30.0), elements: None, frequencies: vec![5.0, 20.0, 40.0, 80.0] };
    (Operator::find(name)?.basis)(&design)
}

/// The operator called `name`, with its default number of elements.
fn fitted(name: &str) -> Result<Arc<dyn Hysteresis>, Error> {
    let basis = basis(name)?;
    basis.operator(&vec![0.1; basis.len()])
}

/// The paper's linear block.
fn arx() -> Result<Arx, Error> {
    Arx::new(TS, vec![1.7424, -0.9453], vec![3.1, 3.1, 0.0])
}

/// The paper's hysteresis block.
fn two_branch() -> Result<TwoBranch, Error> {
    let u: Vec<f64> = (0..17).map(|k| 3.75 * f64::from(k) - 30.0).collect();
    let z = |side: f64| u.iter().map(|u| u + side * (1.0 - u * u / 900.0)).collect();
    TwoBranch::new(TS, Branches::new((u.clone(), z(-1.0)), (u.clone(), z(1.0)))?, HeldInput::Held)
}

type Named = (String, Arc<dyn System>);

fn linear() -> Result<Vec<Named>, Error> {
    let of_order = |n: i32| {
        let a = (1..=n).map(|k| 0.5 * (-0.6f64).powi(k)).collect();
        Arx::new(TS, a, (0..=n).map(|k| 0.7f64.powi(k)).collect())
    };
    let mut systems: Vec<Named> = Vec::new();
    for n in [1, 2, 3, 4, 6, 8, 16] {
        systems.push((format!("arx of order {n}"), Arc::new(of_order(n)?)));
    }
    systems.push(("creep of 4 lags".into(), Arc::new(Creep::logarithmic(TS, 0.01, 0.01, 10.0)?)));
    Ok(systems)
}

/// Models with the paper's linear block, by the block before it.
fn models() -> Result<Vec<Named>, Error> {
    let model = |hysteresis| Model::new(hysteresis, arx()?, 0.0);
    let driver = DriverModel::new(1e-4, Some(6e4))?;
    let faster = TS / DriverModel::SUBSTEPS as f64;
    let design = BasisDesign { ts: faster, range: (-30.0, 30.0), elements: None, frequencies: Vec::new() };
    let plays = (Operator::find("prandtl-ishlinskii")?.basis)(&design)?.operator(&[0.1; 31])?;
    Ok(vec![
        ("the paper's: two branches".into(), Arc::new(model(Arc::new(two_branch()?))?)),
        ("30 plays".into(), Arc::new(model(fitted("prandtl-ishlinskii")?)?)),
        ("preisach".into(), Arc::new(model(fitted("preisach")?)?)),
        (
            "30 plays and creep of 4 lags".into(),
            Arc::new(model(fitted("prandtl-ishlinskii")?)?.with_creep(Creep::logarithmic(TS, 0.01, 0.01, 10.0)?)?),
        ),
        ("30 plays behind a driver".into(), Arc::new(Model::from_blocks(Some(driver), plays, arx()?, 0.0)?)),
        ("30 plays, sample by sample".into(), Arc::new(Stepped(model(fitted("prandtl-ishlinskii")?)?))),
    ])
}

/// The study as `piezoid study` runs it, with figures and page, on each twin and on both. Required: 5 s on two cores.
fn study(c: &mut Criterion) {
    let mut group = c.benchmark_group("study");
    group.sample_size(10);
    let whole = |names: &[&str]| -> Result<usize, Error> {
        let studies = names
            .iter()
            .map(|name| Study::run(Preset::find(name)?, 1, &mut Stage::ignore))
            .collect::<Result<Vec<_>, _>>()?;
        let drawn: usize = studies.iter().flat_map(Study::figures).map(|(_, figure)| figure.svg().len()).sum();
        Ok(drawn + Study::page(&studies).html().len())
    };
    for names in [&["paper"][..], &["pl140"], &["paper", "pl140"]] {
        group.bench_function(names.join(" and "), |b| b.iter(|| whole(black_box(names))));
    }
    group.finish();
}

/// A system without its own `simulate`.
#[derive(Debug)]
struct Stepped(Model);

impl System for Stepped {
    fn ts(&self) -> f64 {
        self.0.ts()
    }

    fn order(&self) -> usize {
        self.0.order()
    }

    fn step(&self, x: &mut [f64], u: f64) -> f64 {
        self.0.step(x, u)
    }
}

fn sine() -> Result<Vec<f64>, Error> {
    Sine { amplitude: 30.0, frequency: 20.0, ..Default::default() }.samples(TS, 10_000)
}

criterion_group!(benches, cost, identification, simulation, feed_forward, predictive, study);
criterion_main!(benches);
