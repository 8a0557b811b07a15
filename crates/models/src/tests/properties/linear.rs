//! Linear blocks, their inverses, their estimation and its cost.

use super::strategies::*;
use crate::linear::{self, AbsoluteError, Arx, Orders};
use piezoid_numerics::optimize::swarm::{self, Cost};
use piezoid_numerics::progress::Stage;
use piezoid_numerics::system::System;
use piezoid_records::excitation::Prbs;
use piezoid_records::record::Record;
use piezoid_testing::assert_named_close;
use proptest::prelude::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// A bound of the rounding error of z = B^-1 A y: one rounding per term of (1), amplified by 1/B.
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
        assert_named_close("z", &inverse.simulate(&y), &u, 0.0, rounding(&block, &u, &y));
        // And the block after its inverse.
        let back = block.simulate(&inverse.simulate(&u));
        let reversed = Arx::new(TS, inverse_a(&block), inverse_b(&block)).expect("the inverse, by hand");
        assert_named_close("y", &back, &u, 0.0, rounding(&reversed, &u, &inverse.simulate(&u)));
    }

    #[test]
    fn the_whole_record_inverse_finds_the_input_away_from_the_ends_for_any_zeros(
        block in arx(
            monic(0.05..0.9f64, 2),
            (monic(0.05..0.8f64, 1), monic(1.25..3.0f64, 1)).prop_map(|(inside, outside)| times(&inside, &outside)),
            3,
        ),
        seed: u64,
    ) {
        // With two or three zeros of modulus 0.8 the effect of an end decays within 150 samples.
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let u: Vec<f64> = (0..450).map(|_| 2.0 * random.random::<f64>() - 1.0).collect();
        let y = block.simulate(&u);
        let z = block.invert_whole(&y).expect("no zero is on the circle");
        prop_assert_eq!(z.len(), y.len());
        assert_named_close("z", &z[150..300], &u[150..300], 0.0, 1e-8);
    }

    #[test]
    fn least_squares_finds_block_and_offset_from_noise_free_data(
        block in arx(monic(0.1..0.95f64, 2), monic(0.1..2.0f64, 1), 2), offset in -100.0..100.0f64,
        seed in 1..1u32 << 11,
    ) {
        // If a zero cancels a pole, the block is not unique.
        let distance = |z: &linear::Root, p: &linear::Root| (z.re - p.re).hypot(z.im.abs() - p.im.abs());
        let (poles, zeros) = (block.poles(), block.zeros());
        prop_assume!(poles.iter().all(|p| zeros.iter().all(|z| distance(z, &p.z) > 0.05)));
        let clustered = |k: usize| poles[..k].iter().any(|p| distance(&p.z, &poles[k].z) < 0.02);
        prop_assume!(!(0..poles.len()).any(clustered));

        let u = Prbs { seed, ..Prbs::default() }.samples(TS, 600).expect("a PRBS");
        let y: Vec<f64> = block.simulate(&u).iter().map(|y| y + offset).collect();
        let orders = Orders { na: block.a().len(), nb: block.b().len() - block.delay(), delay: block.delay() };
        let estimator = linear::Estimator::find("least-squares").expect("it is in the list");
        let record = Record::new(TS, u, y).expect("a record");
        let settings = swarm::SwarmSettings::default();
        let fit = estimator.fit(&[record], orders, &settings, &mut Stage::ignore).expect("a fit");
        assert_named_close("a", fit.arx.a(), block.a(), 0.0, 1e-7 * (1.0 + largest(block.a())));
        assert_named_close("b", fit.arx.b(), block.b(), 0.0, 1e-7 * largest(block.b()));
        assert_named_close("offset", &fit.offsets, &[offset], 1e-7, 1e-7 * largest(block.b()));
    }
}

fn inverse_a(block: &Arx) -> Vec<f64> {
    block.b()[1..].iter().map(|b| -b / block.b()[0]).collect()
}

fn inverse_b(block: &Arx) -> Vec<f64> {
    std::iter::once(1.0).chain(block.a().iter().map(|a| -a)).map(|c| c / block.b()[0]).collect()
}

/// f(theta) of the paper as a plain loop.
fn sum_of_absolute_errors(rows: &[f64], theta: &[f64]) -> f64 {
    let mut sum = 0.0;
    for row in rows.chunks_exact(theta.len() + 1) {
        let mut error = row[0];
        for (psi, theta) in row[1..].iter().zip(theta) {
            error -= psi * theta;
        }
        sum += error.abs();
    }
    sum
}

proptest! {
    #![proptest_config(config(96))]

    #[test]
    fn a_particles_cost_is_bit_identical_to_the_plain_sum_in_any_group_and_below_its_limit(
        seed: u64, d in 1..9usize, n in 1..500usize, particles in 1..100usize, group in 1..40usize,
        poisoned in prop::option::of(any::<prop::sample::Index>()),
    ) {
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        let mut number = || 4.0 * random.random::<f64>() - 2.0;
        let rows: Vec<f64> = (0..n * (d + 1)).map(|_| number()).collect();
        let mut positions: Vec<f64> = (0..particles * d).map(|_| number()).collect();
        let truth: Vec<f64> = positions.chunks_exact(d).map(|theta| sum_of_absolute_errors(&rows, theta)).collect();
        // A NaN particle must not affect the others.
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
            prop_assert!(!(together[m] < f64::MAX || limited[m] < limits[m]), "NaN is not the best");
        }
    }
}
