//! Models and their files, and the branches of hysteresis.

use super::strategies::*;
use crate::hammerstein::Model;
use crate::hysteresis::{HeldInput, Pair, RateScheduled, TwoBranch};
use crate::linear::Arx;
use piezoid_numerics::system::System;
use piezoid_records::record::Units;
use piezoid_testing::assert_named_close;
use proptest::prelude::*;

/// Any finite number, often one that is not a finite decimal.
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
    fn a_model_is_bit_identical_after_its_file(
        operators in operators(),
        a in prop::collection::vec(finite(), 0..5), b in prop::collection::vec(finite(), 1..5),
        offset in finite(), ts in 1e-9..1e6f64, unit in "[a-zA-Z\u{b5}\"\\\\ ]{0,6}", u in drive(1..40),
    ) {
        prop_assume!(b.iter().any(|b| *b != 0.0));
        let units = Units { u: "V".into(), y: unit };
        for operator in operators {
            // Any sampling period, the same for both blocks.
            let again = (operator.operator().load)(serde_json::Value::Object(operator.params()), ts).expect("its own");
            let linear = Arx::new(ts, a.clone(), b.clone()).expect("a block");
            let result = serde_json::json!({"seed": 1, "x": offset});
            let model = Model::new(again, linear, offset).expect("a model");
            let model = model.with_units(units.clone()).with_provenance(result);
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
    fn two_branches_depend_on_the_order_of_inputs_not_on_their_timing(
        branches in branches(), steps in prop::collection::vec((-40.0..40.0f64, 1..6usize, any::<bool>()), 1..60),
    ) {
        // The same reversal points, each held for a while and reached via an intermediate point.
        let (mut u, mut slow, mut places) = (Vec::new(), Vec::new(), Vec::new());
        for (value, held, by_way) in steps {
            if let (Some(before), true) = (u.last(), by_way) {
                slow.push(0.5 * before + 0.5 * value);
            }
            slow.extend(std::iter::repeat_n(value, held));
            places.push(slow.len() - 1);
            u.push(value);
        }
        let quick = TwoBranch::new(TS, branches.clone(), HeldInput::Held).expect("a block");
        let patient = TwoBranch::new(1.0, branches, HeldInput::Held).expect("a block");
        // Settled at the first input, because the path from rest has its own direction.
        let run = |block: &TwoBranch, u: &[f64]| block.resume(&mut block.settled(u[0]), u);
        let z = run(&patient, &slow);
        let at_places: Vec<f64> = places.iter().map(|&t| z[t]).collect();
        prop_assert_eq!(bits(&at_places), bits(&run(&quick, &u)));
    }

    #[test]
    fn two_branches_use_the_branch_of_the_direction_and_stay_between_both(
        branches in branches(), u in drive(2..60),
    ) {
        for reading in [HeldInput::Held, HeldInput::Printed] {
            let block = TwoBranch::new(TS, branches.clone(), reading).expect("a block");
            let z = block.resume(&mut block.settled(u[0]), &u);
            for t in 0..u.len() {
                let (up, down) = (branches.ascending(u[t]), branches.descending(u[t]));
                prop_assert!(up.min(down) <= z[t] && z[t] <= up.max(down), "{} at {} V", z[t], u[t]);
                if t > 0 && u[t] != u[t - 1] {
                    prop_assert_eq!(z[t], if u[t] > u[t - 1] { up } else { down });
                } else if t > 0 && reading == HeldInput::Printed {
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
        let pairs = vec![pair(low), pair(low * factor)];
        let scheduled = RateScheduled::new(TS, pairs, HeldInput::Held).expect("two frequencies");
        let z = TwoBranch::new(TS, branches.clone(), HeldInput::Held).expect("a block").simulate(&u);
        // (1 - s) z + s z is z except for rounding.
        assert_named_close("z", &scheduled.simulate(&u), &z, 1e-15, 0.0);
    }
}
