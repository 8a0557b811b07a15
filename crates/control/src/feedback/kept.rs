//! Controllers and feed-forwards that are tuned as before, and follow as they did.

use super::{CONTROLLERS, FEED_FORWARDS, MarginTarget, Scheme, TunedScheme};
use crate::compensation::FeedForwardSettings;
use piezoid_models::creep::Creep;
use piezoid_models::hammerstein::Model;
use piezoid_models::hysteresis::Operator;
use piezoid_models::linear::Arx;
use piezoid_records::excitation::Limits;
use piezoid_testing::assert_kept;
use std::f64::consts::TAU;

const TS: f64 = 5e-4;

/// A beam with plays and creep, with `share` of the nominal gain.
fn model(share: f64) -> Model {
    let plays = (Operator::find("prandtl-ishlinskii").unwrap().example)(TS).unwrap();
    let block = Arx::new(TS, vec![1.7424, -0.9453], vec![0.0, 3.5 * share, 3.2 * share]).unwrap();
    Model::new(plays, block, 5.0).unwrap().with_creep(Creep::logarithmic(TS, 0.01, 0.05, 5.0).unwrap()).unwrap()
}

#[test]
fn every_scheme_is_tuned_as_it_was_and_follows_as_it_did() {
    let mut lines = Vec::new();
    let limits = Limits { low: Some(-30.0), high: Some(30.0), slew: Some(2e4), ..Limits::default() };
    let settings = FeedForwardSettings { limits, clip: true, iterations: 0 };
    let (nominal, plant) = (model(1.0), model(1.1));
    let r: Vec<f64> = (0..600).map(|t| 5.0 + 300.0 * (TAU * 20.0 * TS * f64::from(t)).sin()).collect();
    let hz = [2, 5, 10, 20, 50, 100, 146, 200, 500, 900].map(f64::from);
    let laws = || std::iter::once(None).chain(CONTROLLERS.iter().map(Some));
    let schemes = FEED_FORWARDS.iter().flat_map(|feed_forward| laws().map(|law| Scheme { feed_forward, law }.name()));
    for scheme in schemes.filter_map(|name| Scheme::named(&name).ok()) {
        for delay in [0, 2] {
            let (name, target) = (scheme.name(), MarginTarget::default());
            let tuned = TunedScheme::new(scheme, &nominal, settings, delay, &target).unwrap();
            let feed_forward = tuned.feed_forward(&plant, &r).unwrap();
            let run = tuned.run(&plant, &r, &feed_forward).unwrap();
            lines.push(format!("{name} {delay} {:?} {:?}", tuned.margins(), tuned.least_bandwidth_hz()));
            lines.push(format!("{:?} {:?}", feed_forward.trials, feed_forward.line));
            lines.push(format!("{:?} {} {:?}", run.tracking(100, 600.0), run.limited, tuned.sensitivity(&hz)));
            lines.push(run.u.iter().skip(37).step_by(61).map(f64::to_string).collect::<Vec<_>>().join(" "));
        }
    }
    assert_kept("schemes", &lines.join("\n"));
}
