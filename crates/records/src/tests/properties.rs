//! Parts of records, and limits of drives, on random ones.

use crate::excitation::Limits;
use crate::record::{Record, Units};
use piezoid_testing::assert_named_close;
use piezoid_testing::random::{config, drive, largest};
use proptest::prelude::*;

proptest! {
    #![proptest_config(config(128))]

    #[test]
    fn adjacent_parts_make_the_whole_record(
        n in 2..400usize, ts in prop_oneof![1e-7..10.0f64, Just(5e-4), Just(0.005), Just(1.0 / 3.0)],
        cuts in any::<(prop::sample::Index, prop::sample::Index)>(),
    ) {
        let u: Vec<f64> = (0..n).map(|t| t as f64).collect();
        let units = Units { u: "cmdV".into(), y: "mm".into() };
        let record = Record::new(ts, u.clone(), u.iter().map(|u| -u).collect()).expect("a record").with_units(units);
        let at = 1 + cuts.0.index(n - 1);
        // The time of a sample, with any rounding, is that sample.
        let (before, after) = (record.part(0.0, at as f64 * ts), record.part(at as f64 * ts, f64::INFINITY));
        let (before, after) = (before.expect("samples before"), after.expect("samples after"));
        prop_assert_eq!((before.u(), after.u()), (&u[..at], &u[at..]));
        prop_assert_eq!([before.y(), after.y()].concat(), record.y());
        prop_assert_eq!((before.ts(), after.units()), (ts, record.units()));
        // Times of a part of a part are relative to the part's start.
        let again = cuts.1.index(after.len());
        let inner = after.part(again as f64 * ts, f64::INFINITY).expect("at least the last sample");
        prop_assert_eq!(inner.u(), &u[at + again..]);
    }

    #[test]
    fn a_clipped_drive_is_within_the_limits(
        u in drive(1..80), low in -40.0..-1.0f64, high in 1.0..40.0f64, which in any::<[bool; 4]>(), ts in 1e-6..1.0f64,
        slew in 0.1..60.0f64, charge in 0.1..60.0f64, capacitance in 1e-9..1e-4f64,
    ) {
        // A step of a few volts reaches the limits of slew and current.
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
        // A drive within the limits is not changed.
        if limits.refuse(&u, ts).is_ok() {
            assert_named_close("u", &clipped, &u, 0.0, 1e-5 * largest(&u));
        }
    }
}
