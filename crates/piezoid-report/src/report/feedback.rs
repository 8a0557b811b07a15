//! Mechanics with hysteresis in feedback, in the report.

use crate::page::{PageTable, Section};
use piezoid::feedback::{FeedbackMode, FeedbackModel, Intersample};
use piezoid_numerics::number::short;

/// The modes and what drives the hysteresis.
pub(super) fn block(section: Section, feedback: &FeedbackModel) -> Section {
    let dynamics = feedback.dynamics();
    let drives = match (dynamics.sensed != 0.0, dynamics.senses_vibration) {
        (_, true) => "the input and the vibration of the modes drive",
        (true, false) => "the input and the displacement of the modes drive",
        (false, false) => "the displacement of the modes drives",
    };
    let between = match dynamics.intersample {
        Intersample::Held => "held between its samples".into(),
        Intersample::Driven(driver) => format!("held before a driver with a lag of {} s", short(driver.lag_s)),
        Intersample::BandLimited => "band-limited between its samples".to_string(),
    };
    let name = feedback.hysteresis().operator().name;
    let text = format!(
        "It gives the response: {drives} the hysteresis, {name}, and the input is {between}. The hysteresis block and the \
         linear block below approximate it, for margins and controllers."
    );
    let columns = ["f [Hz]", "damping", "input", "hysteretic", "sensed", "softening"];
    let table = columns.iter().fold(PageTable::new("Modes").text("mode"), |table, column| table.number(*column));
    let row = |(k, m): (usize, &FeedbackMode)| {
        let [hz, damping, input, hysteretic, sensed, softening] =
            [m.hz, m.damping, m.input, m.hysteretic, m.sensed, m.softening].map(short);
        [(k + 1).to_string(), hz, damping, input, hysteretic, sensed, softening]
    };
    let table = table.rows(dynamics.modes.iter().enumerate().map(row));
    section.heading("Hysteresis in feedback").text(text).table(table)
}
