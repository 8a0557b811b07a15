//! A model of every operator gives the numbers that it gave in every version, bit by bit.

use crate::hammerstein::Model;
use crate::hysteresis::OPERATORS;
use piezoid_numerics::system::System;
use piezoid_testing::golden::numbers;
use piezoid_testing::vectors;

#[test]
fn every_operator_gives_the_numbers_that_it_gave_in_every_version() {
    let files = vectors();
    for (path, file) in &files {
        let model = Model::from_json(&file["model"].to_string()).unwrap();
        let of = |key| numbers(&file["step"], key);
        assert_eq!(model.simulate(&of("inputs")), of("outputs"), "{}", path.display());
    }
    let mut names = OPERATORS.iter().map(|operator| operator.name).chain(["driven"]);
    let missing = names.find(|name| !files.iter().any(|(path, _)| path.ends_with(format!("{name}.json"))));
    assert_eq!(missing, None, "no file: write it with `cargo xtask generate vectors`");
}
