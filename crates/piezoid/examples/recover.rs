use piezoid::excitation::{Prbs, RisingSine, Staircase};
use piezoid::hammerstein::Model;
use piezoid::hysteresis::Operator;
use piezoid::linear::Arx;
use piezoid::validation::Metrics;
use piezoid::{IdentifyOptions, Record, Records, System};
use std::f64::consts::{SQRT_2, TAU};
const TS: f64 = 5e-4;
fn main() {
    for name in std::env::args().skip(1) {
        let (tn, mn) = name.split_once(':').unwrap_or((&name, &name));
        let truth = Operator::find(tn).unwrap();
        let radius = (-0.06f64 * TAU * 147.0 * TS).exp();
        let turn = TAU * 147.0 * TS * (1.0f64 - 0.06 * 0.06).sqrt();
        let a = [2.0 * radius * turn.cos(), -radius * radius];
        let half = 0.5 * (1.0 - a[0] - a[1]);
        let plant = Model::new(
            (truth.example)(TS).unwrap(),
            Arx::new(TS, a.into(), vec![0.0, 1.1 * half, 0.9 * half]).unwrap(),
            0.3,
        )
        .unwrap();
        let record = |u: Vec<f64>| Record::new(TS, u.clone(), plant.simulate(&u)).unwrap();
        let small = record(Prbs { order: 10, amplitude: 1.0, ..Prbs::default() }.samples(TS, 1023).unwrap());
        let large: Vec<_> = [(5.0, 30.0), (20.0, 30.0), (80.0, 30.0), (5.0, 20.0), (20.0, 20.0), (80.0, 20.0)]
            .into_iter()
            .map(|(frequency, amplitude)| {
                record(RisingSine { amplitude, frequency, ..RisingSine::default() }.samples(TS, 1600).unwrap())
            })
            .collect();
        let t0 = std::time::Instant::now();
        let found = (Records { small_signal: if std::env::var_os("PZ_NOSMALL").is_some() { &[] } else { std::slice::from_ref(&small) }, large_signal: &large })
            .identify(&IdentifyOptions { operator: mn.into(), ..IdentifyOptions::default() }, &mut |_| {
                std::ops::ControlFlow::Continue(())
            })
            .unwrap();
        let s = t0.elapsed().as_secs_f64();
        let modulated = |t: usize| {
            let t = TS * t as f64;
            29.0 * (0.5 + 0.5 * (TAU * 3.7 * SQRT_2 * t).sin()) * (TAU * 17.3 * t).sin()
        };
        let stair = Staircase { amplitude: 29.0, frequency: 3.0, levels: 15, offset: 0.0 }.samples(TS, 4000).unwrap();
        let e = [(0..4000).map(modulated).collect(), stair]
            .map(|u: Vec<f64>| Metrics::of(&plant.simulate(&u), &found.model.simulate(&u)).rms_pp_percent);
        println!(
            "{name} {e:?} [{s:.1} s] held-out {:?} creep {:?} a {:?}",
            found.trials.iter().map(|t| (t.operator, t.held_out_percent)).collect::<Vec<_>>(),
            found.model.creep().lags(),
            found.model.linear().a()
        );
        println!("   {}", found.linear.reason);
        if std::env::var_os("PZ_RES").is_some() {
            println!("{}", &found.model.to_json()[..]);
            for r in std::iter::once(&small).chain(&large) {
                let y = found.model.simulate(r.u());
                let e: Vec<f64> = r.y().iter().zip(&y).map(|(a, b)| a - b).collect();
                let pp = r.y().iter().fold(0.0f64, |m, v| m.max(v.abs()));
                let rms: Vec<String> = e.chunks(r.len() / 20).map(|c| format!("{:.1e}", (c.iter().map(|v| v * v).sum::<f64>() / c.len() as f64).sqrt() / pp)).collect();
                println!("{rms:?}");
            }
        }
    }
}
