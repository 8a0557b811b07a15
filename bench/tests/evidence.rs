//! docs/evidence.md repeats on this machine, where the measured records are.

use piezoid_bench::evidence::{data, stack};
use piezoid_bench::page::{printed, same};
use piezoid_testing::skipped;
use std::error::Error;

#[test]
fn the_errors_on_the_measured_stack_are_those_of_the_page() -> Result<(), Box<dyn Error>> {
    let folder = data().join("picma-p885");
    if !folder.is_dir() {
        skipped("no measured data: set PIEZOID_DATA to the folder that holds picma-p885");
        return Ok(());
    }
    let page = std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/evidence.md"))?;
    for split in stack::splits(&folder)? {
        let begin = format!("<!-- {}: written by", split.name);
        let table = page.split_once(&begin).and_then(|(_, rest)| rest.split_once("<!-- end"));
        let (table, _) = table.ok_or("no table")?;
        let (line, _) = split.line();
        let (model, _) = split.model("model with hysteresis", "auto")?;
        for held in [&line, &model] {
            let cells = printed(table, &[&held.title])?;
            same(held.metrics.rmse, &cells["rms error [um]"])?;
        }
        assert!(model.metrics.rmse < 0.2 * line.metrics.rmse, "{} of {}", model.metrics.rmse, line.metrics.rmse);
    }
    Ok(())
}
