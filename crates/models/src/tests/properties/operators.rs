//! Operators that are weighted sums of responses, with random thresholds and weights, and bases of random designs.

use super::strategies::*;
use crate::hysteresis::*;
use piezoid_testing::assert_named_close;
use proptest::prelude::*;
use serde_json::json;
use std::sync::Arc;

/// Rising positive thresholds, with a non-negative weight each after that of the input.
fn elements() -> impl Strategy<Value = (Vec<f64>, Vec<f64>)> {
    (prop::collection::vec((0.01..5.0f64, 0.0..1.0f64), 1..40), 0.0..1.0f64).prop_map(|(steps, first)| {
        let (steps, weights): (Vec<f64>, Vec<f64>) = steps.into_iter().unzip();
        let rise = |sum: &mut f64, step: f64| {
            *sum += step;
            Some(*sum)
        };
        let thresholds = steps.into_iter().scan(0.0, rise).collect();
        (thresholds, [vec![first], weights].concat())
    })
}

fn block(name: &str, (thresholds, weights): &(Vec<f64>, Vec<f64>)) -> Arc<dyn Hysteresis> {
    let params = json!({"range": [-35.0, 35.0], "thresholds": thresholds, "weights": weights});
    (Operator::find(name).expect("an operator there is").load)(params, TS).expect("parameters that make sense")
}

fn design(low: f64, width: f64, elements: usize) -> BasisDesign {
    BasisDesign { ts: TS, range: (low, low + width), elements: Some(elements), frequencies: vec![5.0, 50.0] }
}

proptest! {
    #![proptest_config(config(128))]

    #[test]
    fn stops_and_plays_with_the_same_thresholds_are_equivalent(elements in elements(), u in drive(1..80)) {
        // u - w s = u - w (u - p): the weights of the plays, and the remaining weight of the input.
        let (thresholds, weights) = elements.clone();
        let rest = weights[0] - weights[1..].iter().sum::<f64>();
        let plays = block("prandtl-ishlinskii", &(thresholds, [&[rest], &weights[1..]].concat()));
        let scale = largest(&u) * weights.iter().sum::<f64>();
        assert_named_close("z", &block("stop", &elements).simulate(&u), &plays.simulate(&u), 0.0, 1e-13 * scale);
    }

    #[test]
    fn plays_lag_within_their_thresholds_and_wipe_out_history(
        elements in elements(), u in drive(1..60), inside in drive(1..30),
    ) {
        let plays = block("prandtl-ishlinskii", &elements);
        let (thresholds, weights) = &elements;
        let most: f64 = thresholds.iter().zip(&weights[1..]).map(|(r, w)| r * w).sum();
        let gain: f64 = weights.iter().sum();
        for (u, z) in u.iter().zip(plays.simulate(&u)) {
            prop_assert!((z - gain * u).abs() <= most + 1e-12 * gain * 35.0, "{z} at {u}");
        }
        // After the highest and the lowest input, history is wiped out.
        let end = [35.0, -35.0];
        let after = |before: &[f64]| plays.simulate(&[before, &end, &u].concat())[before.len() + 2..].to_vec();
        if thresholds.iter().all(|r| *r <= 35.0) {
            prop_assert_eq!(bits(&after(&u)), bits(&after(&inside)));
        }
    }

    #[test]
    fn kernels_with_non_negative_weights_rise_with_the_input(
        ridge in 0.1..40.0f64, weights in prop::collection::vec(0.0..1.0f64, 15), u in drive(2..60),
    ) {
        let levels: Vec<f64> = (0..5).map(|i| -28.0 + 14.0 * f64::from(i)).collect();
        let params = json!({"range": [-35.0, 35.0], "levels": levels, "ridge": ridge, "weights": weights});
        let row = Operator::find("krasnoselskii-pokrovskii").expect("an operator there is");
        let z = (row.load)(params, TS).expect("parameters that make sense").simulate(&u);
        for t in 1..u.len() {
            let (du, dz) = (u[t] - u[t - 1], z[t] - z[t - 1]);
            prop_assert!(dz * du >= -1e-12 * du.abs() && (du != 0.0 || dz == 0.0), "{dz} after {du}");
        }
        prop_assert!(largest(&z) <= weights.iter().sum::<f64>() * (1.0 + 1e-12));
    }

    #[test]
    fn tellinen_stays_between_its_branches(
        widths in prop::collection::vec(1e-3..0.4f64, 3), bends in prop::collection::vec(-0.2..0.2f64, 3),
        low in -60.0..0.0f64, width in 1.0..100.0f64, places in prop::collection::vec(0.0..1.0f64, 2..60),
    ) {
        let design = design(low, width, 3);
        let basis = (Operator::find("tellinen").expect("an operator there is").basis)(&design).expect("a basis");
        let block = basis.reshaped(&[bends, widths].concat()).expect("a shape").operator(&[1.0]).expect("a weight");
        let sides = serde_json::from_value::<Branches>(block.params().into()).expect("branches");
        let u: Vec<f64> = places.iter().map(|place| low + width * place).collect();
        for (u, z) in u.iter().zip(block.simulate(&u)) {
            let (a, d) = (sides.ascending(*u), sides.descending(*u));
            // If the spline of the distance undershoots, the loop is closed at its middle.
            prop_assert!(a.min(d) - 1e-9 * width <= z && z <= a.max(d) + 1e-9 * width, "{z} at {u}");
        }
    }
}

proptest! {
    #![proptest_config(config(24))]

    #[test]
    fn a_basis_of_any_design_gives_operators_that_are_linear_in_their_weights(
        low in -100.0..0.0f64, width in 1e-3..200.0f64, elements in 3..12usize,
        places in prop::collection::vec(0.0..1.0f64, 1..80), k in -3.0..3.0f64,
    ) {
        let design = design(low, width, elements);
        let u: Vec<f64> = places.iter().map(|place| low + width * place).collect();
        for row in OPERATORS {
            let basis = (row.basis)(&design).expect("a basis");
            let weights: Vec<f64> = (0..basis.len()).map(|i| (0.7 * i as f64 + 0.3).sin()).collect();
            let (mut x, mut phi) = (basis.initial(), vec![0.0; basis.len()]);
            let sum = |u: &f64| {
                basis.step(&mut x, *u, &mut phi);
                k * weights.iter().zip(&phi).map(|(w, phi)| w * phi).sum::<f64>()
            };
            let sums: Vec<f64> = u.iter().map(sum).collect();
            let scaled: Vec<f64> = weights.iter().map(|w| k * w).collect();
            if row.name == "tellinen" && scaled[0] <= 0.0 {
                continue; // its branches must not be exchanged
            }
            let z = basis.operator(&scaled).expect("weights").simulate(&u);
            let scale = width * basis.len() as f64;
            assert_named_close(row.name, &z, &sums, 1e-12, 1e-12 * scale);
        }
    }
}
