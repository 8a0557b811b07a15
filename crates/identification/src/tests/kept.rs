//! Searches that find the same models as before, for the same reasons: a change of these results is one of the models
//! that users get from their records.

use super::*;
use piezoid_models::driver::DriverModel;

/// The searches: name, records of small and of large signals, and options.
fn searches() -> Vec<(&'static str, [Vec<Record>; 2], JointOptions)> {
    let (beam, slow) = (plant(5e-4, 1), plant(1e-3, 0));
    let three = [(11.0, 0.0), (29.0, 5.0), (61.0, -2.0)];
    let creep = vec![Lag { tau_s: 0.02, gain: 0.02 }, Lag { tau_s: 0.2, gain: 0.04 }];
    let creeping = slow.clone().with_creep(Creep::new(1e-3, creep).unwrap()).unwrap();
    let block = (Operator::find("bouc-wen").unwrap().example)(5e-4 / 4.0).unwrap();
    let driver = DriverModel::new(1e-3, None).unwrap();
    let driven = Model::from_blocks(Some(driver), block, Arx::gain(5e-4, 1.2).unwrap(), 0.3).unwrap();
    vec![
        ("all-operators", [noisy(vec![prbs(&beam)]), noisy(large_signal(&beam, 0.3, &three))], JointOptions::default()),
        (
            "structure",
            [vec![], noisy(large_signal(&slow, 2.0, &[(2.0, 0.0), (20.0, 1.0), (45.0, 0.0)]))],
            named("prandtl-ishlinskii,rate-scheduled"),
        ),
        (
            "creep",
            [vec![], noisy(large_signal(&creeping, 2.0, &[(1.0, 0.0), (7.0, 0.0)]))],
            JointOptions { order: Some(2), ..named("preisach") },
        ),
        (
            "driver-lag",
            [vec![], noisy(large_signal(&driven, 0.5, &[(5.0, 0.0), (20.0, 0.0), (60.0, 0.0)]))],
            named("bouc-wen,dahl"),
        ),
        ("ringing", [vec![], after_a_step(&beam, 0.02)], named("prandtl-ishlinskii")),
        ("cycled", [noisy(vec![prbs(&beam)]), noisy(after_cycles(&beam))], named("prandtl-ishlinskii")),
        (
            "quick",
            [vec![], noisy(large_signal(&beam, 0.5, &three))],
            JointOptions { effort: Effort::Quick, ..named("auto") },
        ),
    ]
}

/// What a search found, and why.
pub(super) fn text(found: &Identified) -> String {
    let Identified { model, trials, parameters, .. } = found;
    let rows = trials.iter().map(|trial| format!("{trial:?}")).chain(parameters.iter().map(|p| format!("{p:?}")));
    format!("{}\n{}\n{}", found.remarks().join("\n"), rows.collect::<Vec<_>>().join("\n"), model.to_json())
}

#[test]
fn searches_find_the_models_that_they_found() {
    for (name, [small, large], options) in searches() {
        assert_kept(&format!("search-{name}"), &text(&identified(&small, &large, &options)));
    }
}
