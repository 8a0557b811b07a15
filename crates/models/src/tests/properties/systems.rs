//! The contract of every system: a run is repeated steps, and can be split anywhere.

use super::strategies::*;
use crate::hammerstein::Model;
use piezoid_numerics::system::System;
use piezoid_twins::{PLANTS, Plant};
use proptest::prelude::*;

/// Asserts that a run is repeated steps, from a state of the right length, and can be split anywhere.
fn assert_contract(system: &dyn System, u: &[f64], cuts: (prop::sample::Index, prop::sample::Index)) {
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
        // Only the numbers in the state are carried over.
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
    fn linear_blocks_and_their_inverses_keep_the_contract(
        block in stable(), invertible in arx(monic(0.05..0.97f64, 3), monic(0.05..0.95f64, 2), 0),
        u in drive(1..60), cuts in cuts(),
    ) {
        assert_contract(&block, &u, cuts);
        assert_contract(&invertible.inverse().expect("its zeros are inside"), &u, cuts);
    }

    #[test]
    fn operators_and_their_models_keep_the_contract(
        operators in operators(), linear in stable(), offset in -10.0..10.0f64, u in drive(1..60), cuts in cuts(),
    ) {
        for operator in operators {
            assert_contract(&*operator, &u, cuts);
            assert_contract(&Model::new(operator, linear.clone(), offset).expect("a model"), &u, cuts);
        }
    }
}

proptest! {
    #![proptest_config(config(6))]

    #[test]
    fn plants_keep_the_contract(u in drive(20..60), seed: u64, cuts in cuts()) {
        for preset in PLANTS {
            let plant = Plant::new(&preset.spec(), TS).expect("a plant").with_seed(seed);
            assert_contract(&plant, &u, cuts);
            prop_assert_eq!(plant.run(&u).y, plant.simulate(&u));
        }
    }
}
