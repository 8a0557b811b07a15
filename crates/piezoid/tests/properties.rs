//! What holds for every block, record and cost, tried on random ones through the public interface.

#![allow(clippy::expect_used)] // a test may stop at what must not happen

#[path = "common/close.rs"]
mod close;

use close::assert_close;
use piezoid::excitation::{Limits, Prbs};
use piezoid::hysteresis::{Branches, Hysteresis, OPERATORS, Pair, Proportional, RateScheduled, Reading, TwoBranch};
use piezoid::linear::{self, AbsoluteError, Arx, Orders};
use piezoid::optimize::swarm::{self, Cost};
use piezoid::plant::{PLANTS, Plant};
use piezoid::progress::unwatched;
use piezoid::validation::Metrics;
use piezoid::{Model, Record, System, Units};
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::sync::Arc;

const TS: f64 = 5e-4;

fn config(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() }
}

fn bits(values: &[f64]) -> Vec<u64> {
    values.iter().map(|v| v.to_bits()).collect()
}

fn largest(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |m, v| m.max(v.abs()))
}

/// Product of two polynomials, coefficients by rising power of q^-1.
fn times(p: &[f64], q: &[f64]) -> Vec<f64> {
    let mut product = vec![0.0; p.len() + q.len() - 1];
    for (i, p) in p.iter().enumerate() {
        for (j, q) in q.iter().enumerate() {
            product[i + j] += p * q;
        }
    }
    product
}

/// 1 + c1 q^-1 + ... with up to `pairs` pairs of roots of the moduli given, and up to one real root.
fn monic(modulus: impl Strategy<Value = f64> + Clone, pairs: usize) -> impl Strategy<Value = Vec<f64>> {
    let pair = (modulus.clone(), 0.05..3.1f64).prop_map(|(r, angle)| vec![1.0, -2.0 * r * angle.cos(), r * r]);
    let real = (modulus, any::<bool>()).prop_map(|(r, negative)| vec![1.0, if negative { r } else { -r }]);
    (prop::collection::vec(pair, 0..=pairs), prop::option::of(real))
        .prop_map(|(pairs, real)| pairs.iter().chain(&real).fold(vec![1.0], |product, factor| times(&product, factor)))
}

/// A block of the given poles and zeros with a gain of either sign, its input up to `late` samples late.
fn arx(
    poles: impl Strategy<Value = Vec<f64>>,
    zeros: impl Strategy<Value = Vec<f64>>,
    late: usize,
) -> impl Strategy<Value = Arx> {
    let gain = (0.1..10.0f64, any::<bool>()).prop_map(|(k, negative)| if negative { -k } else { k });
    (poles, zeros, gain, 0..=late).prop_map(|(poles, zeros, gain, late)| {
        let a = poles[1..].iter().map(|c| -c).collect();
        let b = std::iter::repeat_n(0.0, late).chain(zeros.iter().map(|c| gain * c)).collect();
        Arx::new(TS, a, b).expect("a block")
    })
}

fn stable() -> impl Strategy<Value = Arx> {
    arx(monic(0.05..0.97f64, 3), monic(0.05..2.0f64, 2), 3)
}

/// Voltages that move both ways and stand still for some samples.
fn drive(n: std::ops::Range<usize>) -> impl Strategy<Value = Vec<f64>> {
    prop::collection::vec((-35.0..35.0f64, 1..4usize), n)
        .prop_map(|steps| steps.into_iter().flat_map(|(u, held)| std::iter::repeat_n(u, held)).collect())
}

/// Knots from -30 to 30 V, as both branches need the same ends.
fn knots() -> impl Strategy<Value = (Vec<f64>, Vec<f64>)> {
    prop::collection::vec((0.01..10.0f64, -40.0..40.0f64), 2..9).prop_map(|steps| {
        let whole: f64 = steps[1..].iter().map(|(step, _)| step).sum();
        let mut passed = -steps[0].0;
        let last = steps.len() - 1;
        let rising = |(k, (step, z))| {
            passed += step;
            (if k == last { 30.0 } else { 60.0 * passed / whole - 30.0 }, z)
        };
        steps.into_iter().enumerate().map(rising).unzip()
    })
}

fn branches() -> impl Strategy<Value = Branches> {
    (knots(), knots()).prop_map(|(up, down)| Branches::new(up, down).expect("branches"))
}

/// One of every kind, random where it has a random form.
fn operators() -> impl Strategy<Value = Vec<Arc<dyn Hysteresis>>> {
    (branches(), branches(), -5.0..5.0f64).prop_map(|(low, high, gain)| {
        let pair = |frequency_hz, branches: &Branches| Pair { frequency_hz, branches: branches.clone() };
        let scheduled = RateScheduled::new(TS, vec![pair(5.0, &low), pair(200.0, &high)], Reading::Held);
        let mut all: Vec<Arc<dyn Hysteresis>> = vec![
            Arc::new(Proportional::new(TS, gain).expect("a gain")),
            Arc::new(TwoBranch::new(TS, low, Reading::Held).expect("a block")),
            Arc::new(TwoBranch::new(TS, high, Reading::Printed).expect("a block")),
            Arc::new(scheduled.expect("two pairs")),
        ];
        all.extend(OPERATORS.iter().map(|o| (o.example)(TS).expect("an example")));
        all
    })
}

/// The contract of every system: a run is repeated steps, from a state of the right length, and may be cut anywhere.
fn keeps_its_contract(system: &dyn System, u: &[f64], cuts: (prop::sample::Index, prop::sample::Index)) {
    let whole = system.simulate(u);
    assert_eq!((system.initial().len(), system.settled(1.0).len()), (system.order(), system.order()), "{system:?}");

    let mut x = system.initial();
    let stepped: Vec<f64> = u.iter().map(|&u| system.step(&mut x, u)).collect();
    assert_eq!(bits(&stepped), bits(&whole), "steps of {system:?}");

    let (first, second) = (cuts.0.index(u.len() + 1), cuts.1.index(u.len() + 1));
    let (first, second) = (first.min(second), first.max(second));
    let mut state = system.initial();
    let mut parts = Vec::new();
    for part in [&u[..first], &u[first..second], &u[second..]] {
        // Only the numbers in the state go on.
        let mut carried: Vec<f64> = state.iter().map(|v| f64::from_bits(v.to_bits())).collect();
        parts.extend(system.resume(&mut carried, part));
        state = carried;
    }
    assert_eq!(bits(&parts), bits(&whole), "parts up to {first} and {second} of {system:?}");
    assert_eq!(bits(&state), bits(&x), "the state after them of {system:?}");
}

fn cuts() -> impl Strategy<Value = (prop::sample::Index, prop::sample::Index)> {
    any::<(prop::sample::Index, prop::sample::Index)>()
}

proptest! {
    #![proptest_config(config(128))]

    #[test]
    fn linear_blocks_and_their_inverses_run_as_repeated_steps_and_may_be_cut_anywhere(
        block in stable(), invertible in arx(monic(0.05..0.97f64, 3), monic(0.05..0.95f64, 2), 0),
        u in drive(1..60), cuts in cuts(),
    ) {
        keeps_its_contract(&block, &u, cuts);
        keeps_its_contract(&invertible.inverse().expect("its zeros are inside"), &u, cuts);
    }

    #[test]
    fn operators_and_models_of_them_run_as_repeated_steps_and_may_be_cut_anywhere(
        operators in operators(), linear in stable(), offset in -10.0..10.0f64, u in drive(1..60), cuts in cuts(),
    ) {
        for operator in operators {
            keeps_its_contract(&*operator, &u, cuts);
            keeps_its_contract(&Model::new(operator, linear.clone(), offset).expect("a model"), &u, cuts);
        }
    }
}

proptest! {
    #![proptest_config(config(6))]

    #[test]
    fn plants_run_as_repeated_steps_and_may_be_cut_anywhere(u in drive(20..60), seed: u64, cuts in cuts()) {
        for preset in PLANTS {
            let plant = Plant::new(&(preset.spec)(), TS).expect("a plant").with_seed(seed);
            keeps_its_contract(&plant, &u, cuts);
            prop_assert_eq!(plant.run(&u).y, plant.simulate(&u));
        }
    }
}

/// A bound on what one rounding a term leaves in z = B^-1 A y: the rounding of the terms of (1), through 1/B.
fn rounding(block: &Arx, u: &[f64], y: &[f64]) -> f64 {
    let b = &block.b()[block.delay()..];
    let sum = |c: &[f64]| c.iter().map(|c| c.abs()).sum::<f64>();
    let through = Arx::new(TS, b[1..].iter().map(|c| -c / b[0]).collect(), vec![1.0 / b[0]]).expect("1/B");
    let mut impulse = vec![0.0; u.len()];
    impulse[0] = 1.0;
    let terms = (1.0 + sum(block.a())) * largest(y) + sum(b) * largest(u);
    16.0 * f64::EPSILON * terms * sum(&through.simulate(&impulse))
}

proptest! {
    #![proptest_config(config(256))]

    #[test]
    fn the_inverse_after_a_block_of_minimum_phase_is_the_identity(
        block in arx(monic(0.05..0.97f64, 3), monic(0.05..0.95f64, 2), 0), u in drive(20..150),
    ) {
        let y = block.simulate(&u);
        let inverse = block.inverse().expect("its zeros are inside the circle");
        assert_close("z", &inverse.simulate(&y), &u, 0.0, rounding(&block, &u, &y));
        // And the block after its inverse.
        let back = block.simulate(&inverse.simulate(&u));
        let reversed = Arx::new(TS, inverse_a(&block), inverse_b(&block)).expect("the inverse, by hand");
        assert_close("y", &back, &u, 0.0, rounding(&reversed, &u, &inverse.simulate(&u)));
    }

    #[test]
    fn the_whole_record_tells_the_input_away_from_its_ends_wherever_the_zeros_lie(
        block in arx(
            monic(0.05..0.9f64, 2),
            (monic(0.05..0.8f64, 1), monic(1.25..3.0f64, 1)).prop_map(|(inside, outside)| times(&inside, &outside)),
            3,
        ),
        seed: u64,
    ) {
        // Two or three zeros of modulus 0.8 forget an end within 150 samples.
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let u: Vec<f64> = (0..450).map(|_| 2.0 * random.random::<f64>() - 1.0).collect();
        let y = block.simulate(&u);
        let z = block.invert_whole(&y).expect("no zero is on the circle");
        prop_assert_eq!(z.len(), y.len());
        assert_close("z", &z[150..300], &u[150..300], 0.0, 1e-8);
    }

    #[test]
    fn least_squares_finds_a_block_and_its_offset_in_their_own_noise_free_data(
        block in arx(monic(0.1..0.95f64, 2), monic(0.1..2.0f64, 1), 2), offset in -100.0..100.0f64,
        seed in 1..1u32 << 11,
    ) {
        // Where a zero cancels a pole other blocks do the same.
        let apart = |z: &linear::Root, p: &linear::Root| (z.re - p.re).hypot(z.im.abs() - p.im.abs());
        let (poles, zeros) = (block.poles(), block.zeros());
        prop_assume!(poles.iter().all(|p| zeros.iter().all(|z| apart(z, &p.z) > 0.05)));
        let clustered = |k: usize| poles[..k].iter().any(|p| apart(&p.z, &poles[k].z) < 0.02);
        prop_assume!(!(0..poles.len()).any(clustered));

        let u = Prbs { seed, ..Prbs::default() }.samples(TS, 600).expect("a PRBS");
        let y: Vec<f64> = block.simulate(&u).iter().map(|y| y + offset).collect();
        let orders = Orders { na: block.a().len(), nb: block.b().len() - block.delay(), delay: block.delay() };
        let estimator = linear::estimator("least-squares").expect("it is in the list");
        let record = Record::new(TS, u, y).expect("a record");
        let settings = swarm::Settings::default();
        let fit = linear::fit(&[record], orders, estimator, &settings, &mut unwatched).expect("a fit");
        assert_close("a", fit.arx.a(), block.a(), 0.0, 1e-7 * (1.0 + largest(block.a())));
        assert_close("b", fit.arx.b(), block.b(), 0.0, 1e-7 * largest(block.b()));
        assert_close("offset", &fit.offsets, &[offset], 1e-7, 1e-7 * largest(block.b()));
    }
}

fn inverse_a(block: &Arx) -> Vec<f64> {
    block.b()[1..].iter().map(|b| -b / block.b()[0]).collect()
}

fn inverse_b(block: &Arx) -> Vec<f64> {
    std::iter::once(1.0).chain(block.a().iter().map(|a| -a)).map(|c| c / block.b()[0]).collect()
}

/// Whether this machine fuses the steps of a sum, as [`AbsoluteError`] says it then does.
fn fused() -> bool {
    #[cfg(target_arch = "x86_64")]
    return std::is_x86_feature_detected!("fma") && std::is_x86_feature_detected!("avx2");
    #[cfg(not(target_arch = "x86_64"))]
    return cfg!(target_arch = "aarch64");
}

/// f(theta) of the paper in one plain loop.
fn sum_of_absolute_errors(rows: &[f64], theta: &[f64]) -> f64 {
    let mut sum = 0.0;
    for row in rows.chunks_exact(theta.len() + 1) {
        let mut error = row[0];
        for (psi, theta) in row[1..].iter().zip(theta) {
            error = if fused() { (-psi).mul_add(*theta, error) } else { error - psi * theta };
        }
        sum += error.abs();
    }
    sum
}

proptest! {
    #![proptest_config(config(96))]

    #[test]
    fn a_particles_cost_is_the_plain_sum_to_the_bit_in_any_company_and_below_its_limit_alone(
        seed: u64, d in 1..9usize, n in 1..500usize, particles in 1..100usize, group in 1..40usize,
        poisoned in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut number = || 4.0 * random.random::<f64>() - 2.0;
        let rows: Vec<f64> = (0..n * (d + 1)).map(|_| number()).collect();
        let mut positions: Vec<f64> = (0..particles * d).map(|_| number()).collect();
        let truth: Vec<f64> = positions.chunks_exact(d).map(|theta| sum_of_absolute_errors(&rows, theta)).collect();
        // A particle that is no number must not disturb the others.
        let lost = poisoned.map(|index| index.index(particles));
        if let Some(m) = lost {
            positions[m * d] = f64::NAN;
        }
        let others = || (0..particles).filter(|m| Some(*m) != lost);

        let cost = AbsoluteError::new(&rows, d);
        let evaluate = |positions: &[f64], limits: &[f64]| {
            let mut costs = vec![f64::NAN; limits.len()];
            cost.evaluate(positions, limits, &mut costs);
            costs
        };
        let unlimited = vec![f64::MAX; particles];
        let together = evaluate(&positions, &unlimited);
        let grouped = |size: usize| -> Vec<f64> {
            positions.chunks(size * d).flat_map(|p| evaluate(p, &unlimited[..p.len() / d])).collect()
        };
        let (one_by_one, by_group) = (grouped(1), grouped(group));
        for m in others() {
            prop_assert_eq!(together[m].to_bits(), truth[m].to_bits(), "particle {} of {}: {}", m, particles, truth[m]);
            prop_assert_eq!(one_by_one[m].to_bits(), truth[m].to_bits(), "particle {} alone", m);
            prop_assert_eq!(by_group[m].to_bits(), truth[m].to_bits(), "particle {} in a group of {}", m, group);
        }

        let shares = [0.0, 0.2, 0.9, 1.0, 1.0 + 1e-15, 1.5, 1e300];
        let limits: Vec<f64> = truth.iter().map(|f| f * shares[random.random_range(0..shares.len())]).collect();
        let limited = evaluate(&positions, &limits);
        for m in others() {
            if limited[m] < limits[m] || truth[m] < limits[m] {
                prop_assert_eq!(limited[m].to_bits(), truth[m].to_bits(), "particle {} under {}", m, limits[m]);
            }
        }
        if let Some(m) = lost {
            prop_assert!(!(together[m] < f64::MAX || limited[m] < limits[m]), "what is no number is no best");
        }
    }
}

/// Any finite number there is, and often one that decimals cannot hold.
fn finite() -> impl Strategy<Value = f64> {
    prop_oneof![
        any::<u64>().prop_map(f64::from_bits).prop_filter("finite", |v| v.is_finite()),
        (-1000i32..1000).prop_map(|k| f64::from(k) / 3.0),
        Just(-0.0),
    ]
}

proptest! {
    #![proptest_config(config(128))]

    #[test]
    fn a_model_survives_its_file_to_the_bit(
        operators in operators(),
        a in prop::collection::vec(finite(), 0..5), b in prop::collection::vec(finite(), 1..5),
        offset in finite(), ts in 1e-9..1e6f64, unit in "[a-zA-Z\u{b5}\"\\\\ ]{0,6}", u in drive(1..40),
    ) {
        prop_assume!(b.iter().any(|b| *b != 0.0));
        let units = Units { u: "V".into(), y: unit };
        for operator in operators {
            // Any sampling period, but that of both blocks.
            let again = (operator.operator().load)(serde_json::Value::Object(operator.params()), ts).expect("its own");
            let linear = Arx::new(ts, a.clone(), b.clone()).expect("a block");
            let made = serde_json::json!({"seed": 1, "x": offset});
            let model = Model::new(again, linear, offset).expect("a model");
            let model = model.with_units(units.clone()).with_provenance(made);
            let text = model.to_json();
            let back = Model::from_json(&text).expect("its own file");
            prop_assert_eq!(back.to_json(), text);
            prop_assert_eq!(bits(back.linear().a()), bits(&a));
            prop_assert_eq!(bits(back.linear().b()), bits(&b));
            prop_assert_eq!((back.offset().to_bits(), back.ts().to_bits()), (offset.to_bits(), ts.to_bits()));
            prop_assert_eq!((back.units(), back.provenance()), (model.units(), model.provenance()));
            let same = |x: f64, y: f64| x.to_bits() == y.to_bits() || (x.is_nan() && y.is_nan());
            prop_assert!(back.simulate(&u).iter().zip(model.simulate(&u)).all(|(x, y)| same(*x, y)));
        }
    }

    #[test]
    fn two_branches_know_the_order_of_inputs_and_not_their_timing(
        branches in branches(), steps in prop::collection::vec((-40.0..40.0f64, 1..6usize, any::<bool>()), 1..60),
    ) {
        // The same turning points, each held for a while and reached by way of a point between.
        let (mut u, mut slow, mut places) = (Vec::new(), Vec::new(), Vec::new());
        for (value, held, by_way) in steps {
            if let (Some(before), true) = (u.last(), by_way) {
                slow.push(0.5 * before + 0.5 * value);
            }
            slow.extend(std::iter::repeat_n(value, held));
            places.push(slow.len() - 1);
            u.push(value);
        }
        let quick = TwoBranch::new(TS, branches.clone(), Reading::Held).expect("a block");
        let patient = TwoBranch::new(1.0, branches, Reading::Held).expect("a block");
        // Settled at the first input, since the way there from rest has a direction of its own.
        let run = |block: &TwoBranch, u: &[f64]| block.resume(&mut block.settled(u[0]), u);
        let z = run(&patient, &slow);
        let at_places: Vec<f64> = places.iter().map(|&t| z[t]).collect();
        prop_assert_eq!(bits(&at_places), bits(&run(&quick, &u)));
    }

    #[test]
    fn two_branches_read_the_branch_of_the_direction_and_stay_between_both(
        branches in branches(), u in drive(2..60),
    ) {
        for reading in [Reading::Held, Reading::Printed] {
            let block = TwoBranch::new(TS, branches.clone(), reading).expect("a block");
            let z = block.resume(&mut block.settled(u[0]), &u);
            for t in 0..u.len() {
                let (up, down) = (branches.ascending(u[t]), branches.descending(u[t]));
                prop_assert!(up.min(down) <= z[t] && z[t] <= up.max(down), "{} at {} V", z[t], u[t]);
                if t > 0 && u[t] != u[t - 1] {
                    prop_assert_eq!(z[t], if u[t] > u[t - 1] { up } else { down });
                } else if t > 0 && reading == Reading::Printed {
                    prop_assert_eq!(z[t], down);
                }
            }
        }
    }

    #[test]
    fn a_schedule_of_equal_pairs_is_two_branches(
        branches in branches(), low in 0.1..50.0f64, factor in 1.01..100.0f64, u in drive(2..80),
    ) {
        let pair = |frequency_hz| Pair { frequency_hz, branches: branches.clone() };
        let scheduled = RateScheduled::new(TS, vec![pair(low), pair(low * factor)], Reading::Held).expect("two frequencies");
        let z = TwoBranch::new(TS, branches.clone(), Reading::Held).expect("a block").simulate(&u);
        // (1 - s) z + s z is z but for its rounding.
        assert_close("z", &scheduled.simulate(&u), &z, 1e-15, 0.0);
    }

    #[test]
    fn figures_of_merit_ignore_offset_and_unit(
        samples in prop::collection::vec((-1.0..1.0f64, -1.0..1.0f64), 3..60),
        offset in -10.0..10.0f64, k in 1e-6..1e6f64,
    ) {
        let (y, simulated): (Vec<f64>, Vec<f64>) = samples.into_iter().map(|(y, e)| (y, y + 0.1 * e)).unzip();
        let of = |change: &dyn Fn(f64) -> f64| {
            let all = |of: &[f64]| of.iter().map(|v| change(*v)).collect::<Vec<f64>>();
            Metrics::of(&all(&y), &all(&simulated))
        };
        let spread = y.iter().fold(f64::MIN, |m, v| m.max(*v)) - y.iter().fold(f64::MAX, |m, v| m.min(*v));
        prop_assume!(spread > 0.1);
        let plain = of(&|v| v);
        let numbers = |m: &Metrics, unit: f64| {
            let lengths = [m.rmse / unit, m.max_abs / unit, (m.mse / unit).sqrt() / unit.sqrt()];
            [lengths.as_slice(), &[m.nrmse_percent, m.rms_pp_percent, 100.0 - m.fit_percent]].concat()
        };
        assert_close("shifted", &numbers(&of(&|v| v + offset), 1.0), &numbers(&plain, 1.0), 1e-9, 1e-12);
        assert_close("scaled", &numbers(&of(&|v| -k * v), k), &numbers(&plain, 1.0), 1e-9, 0.0);
        prop_assert!(plain.rmse <= plain.max_abs * (1.0 + 1e-15) && plain.rms_pp_percent <= plain.nrmse_percent);
        prop_assert_eq!(Metrics::of(&y, &y).mse, 0.0);
    }

    #[test]
    fn parts_that_meet_make_the_whole_record(
        n in 2..400usize, ts in prop_oneof![1e-7..10.0f64, Just(5e-4), Just(0.005), Just(1.0 / 3.0)],
        cuts in any::<(prop::sample::Index, prop::sample::Index)>(),
    ) {
        let u: Vec<f64> = (0..n).map(|t| t as f64).collect();
        let units = Units { u: "cmdV".into(), y: "mm".into() };
        let record = Record::new(ts, u.clone(), u.iter().map(|u| -u).collect()).expect("a record").with_units(units);
        let at = 1 + cuts.0.index(n - 1);
        // The time of a sample, however it rounds, is that sample.
        let (before, after) = (record.part(0.0, at as f64 * ts), record.part(at as f64 * ts, f64::INFINITY));
        let (before, after) = (before.expect("samples before"), after.expect("samples after"));
        prop_assert_eq!((before.u(), after.u()), (&u[..at], &u[at..]));
        prop_assert_eq!([before.y(), after.y()].concat(), record.y());
        prop_assert_eq!((before.ts(), after.units()), (ts, record.units()));
        // A part of a part counts from the part's own start.
        let again = cuts.1.index(after.len());
        let inner = after.part(again as f64 * ts, f64::INFINITY).expect("at least the last sample");
        prop_assert_eq!(inner.u(), &u[at + again..]);
    }

    #[test]
    fn what_a_driver_follows_is_within_its_limits(
        u in drive(1..80), low in -40.0..-1.0f64, high in 1.0..40.0f64, which in any::<[bool; 4]>(), ts in 1e-6..1.0f64,
        slew in 0.1..60.0f64, charge in 0.1..60.0f64, capacitance in 1e-9..1e-4f64,
    ) {
        // Slew and current are such that a step of some volts reaches them.
        let limits = Limits {
            low: which[0].then_some(low),
            high: which[1].then_some(high),
            slew: which[2].then_some(slew / ts),
            current: which[3].then_some(capacitance * charge / ts),
            capacitance: which[3].then_some(capacitance),
        };
        let clipped = limits.clip(&u, ts).expect("limits that make sense");
        prop_assert_eq!(clipped.len(), u.len());
        let usage = limits.refuse(&clipped, ts);
        prop_assert!(usage.is_ok(), "{:?}", usage);
        // What is within them is left alone.
        if limits.refuse(&u, ts).is_ok() {
            assert_close("u", &clipped, &u, 0.0, 1e-5 * largest(&u));
        }
    }
}
