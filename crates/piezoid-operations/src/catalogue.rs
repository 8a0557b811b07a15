//! The catalogue: all operations with their options, and all families of the library, as a document for menus, forms,
//! lists and generated pages.

use crate::{Operation, picture};
use piezoid::control::{CONTROLLERS, ControllerKind, FEED_FORWARDS, FeedForwardKind, REFERENCES, Reference};
use piezoid::excitation::{ACTUATORS, Actuator, Amplifier, DRIVERS, EXCITATIONS, Excitation};
use piezoid::formats::{ColumnSelection, FORMATS, Format};
use piezoid::hysteresis::{OPERATORS, Operator};
use piezoid::linear::{ESTIMATORS, Estimator};
use piezoid::plant::{PLANTS, Preset};
use piezoid_export::{ExportTarget, TARGETS};
use piezoid_numerics::options::{OptionRow, Options};
use piezoid_report::study::{METHODS, StudyMethod};
use serde::Serialize;

/// All rows. Those of a family have a `name` and a `summary`; most have a `reference`.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct Catalogue {
    /// The operations, with their roles and options, and the module of the page that has them.
    pub operations: Vec<&'static Operation>,
    /// The options of data files.
    pub columns: Vec<OptionRow>,
    /// The hysteresis operators.
    pub operators: Vec<OperatorRow>,
    /// The drive signals, with their options.
    pub excitations: &'static [Excitation],
    /// The simulated actuators.
    pub plants: &'static [Preset],
    /// The drivers, with the figures of their data sheets in SI units.
    pub drivers: &'static [Amplifier],
    /// The actuators, likewise.
    pub actuators: &'static [Actuator],
    /// The controllers, feed-forwards first.
    pub controllers: Vec<ControlRow>,
    /// The references of tracking tests.
    pub references: &'static [Reference],
    /// The export targets: what each makes for each operator, and the options that not all targets take.
    pub targets: &'static [ExportTarget],
    /// The estimators of the linear block.
    pub estimators: &'static [Estimator],
    /// The formats of data files.
    pub formats: &'static [Format],
    /// The methods that the study compares.
    pub methods: &'static [StudyMethod],
}

/// An operator, with its picture.
#[derive(Debug, Clone, Serialize)]
pub struct OperatorRow {
    /// The operator.
    #[serde(flatten)]
    pub operator: &'static Operator,
    /// The loop of a typical one: path data of an SVG of 96 by 64.
    pub picture: String,
}

/// A feed-forward or a feedback.
#[derive(Debug, Clone, Copy, Serialize)]
#[serde(untagged)]
pub enum ControlRow {
    /// A feed-forward.
    FeedForward(&'static FeedForwardKind),
    /// A feedback.
    Feedback(&'static ControllerKind),
}

/// The catalogue.
///
/// ```
/// let catalogue = serde_json::json!(piezoid_operations::catalogue());
/// assert_eq!(catalogue["operators"][0]["name"], piezoid::hysteresis::OPERATORS[0].name);
/// assert_eq!(catalogue["operations"][0]["name"], "inspect");
/// ```
pub fn catalogue() -> Catalogue {
    let feed_forwards = FEED_FORWARDS.iter().map(ControlRow::FeedForward);
    Catalogue {
        operations: Operation::all().collect(),
        columns: ColumnSelection::rows(),
        operators: OPERATORS.iter().map(|operator| OperatorRow { operator, picture: picture::of(operator) }).collect(),
        excitations: EXCITATIONS,
        plants: PLANTS,
        drivers: DRIVERS,
        actuators: ACTUATORS,
        controllers: feed_forwards.chain(CONTROLLERS.iter().map(ControlRow::Feedback)).collect(),
        references: REFERENCES,
        targets: TARGETS,
        estimators: ESTIMATORS,
        formats: FORMATS,
        methods: METHODS,
    }
}
