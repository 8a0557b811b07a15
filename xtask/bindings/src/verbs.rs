//! The classes of keywords of Python, with their options.

use piezoid::formats::ColumnSelection;
use piezoid::validation::ValidateOptions;
use piezoid::{IdentifyOptions, PrepareOptions};
use piezoid_export::ExportOptions;
use piezoid_numerics::options::{OptionRow, Options};
use piezoid_report::study::StudyOptions;
use piezoid_verbs::{
    CertificateOptions, CompareOptions, CompensateOptions, ControlOptions, OnlineOptions, PlanOptions, SimulateOptions,
    TimingOptions,
};

/// The rows of a table.
pub(crate) type Rows = fn() -> Vec<OptionRow>;

/// The classes of keywords in Python. Left out are options that its functions take in another form: references as
/// arrays, tolerances as fractions, `from` and `to`, of which one is a word of the language, as `start` and `stop`.
pub(crate) const KEYWORDS: [(&str, &str, Rows); 16] = [
    ("CertificateOptions", "`Model.certificate`", CertificateOptions::rows),
    ("ColumnOptions", "`read` and `inspect`", || without(ColumnSelection::rows(), &["from", "to"])),
    ("CompareOptions", "`compare`", || without(CompareOptions::rows(), &["record", "operators", "structures"])),
    ("CompensateOptions", "`Model.compensate`", CompensateOptions::rows),
    ("TimingOptions", "`timing`", TimingOptions::rows),
    ("ControlOptions", "`control`", || {
        let elsewhere = ["controller", "reference", "amplitude", "noise", "tolerance", "draws"];
        without(ControlOptions::rows(), &elsewhere)
    }),
    ("ExportOptions", "`export`", ExportOptions::rows),
    ("IdentifyOptions", "`identify`", IdentifyOptions::rows),
    ("InverseOptions", "`Model.inverse`", || {
        without(CompensateOptions::rows(), &["iterations", "smooth", "notch", "zvd"])
    }),
    ("OnlineOptions", "`Online`", OnlineOptions::rows),
    ("PlanOptions", "`plan`", PlanOptions::rows),
    ("PrepareOptions", "`Record.prepare`", PrepareOptions::rows),
    ("SimulateOptions", "`Plant.simulate`", || without(SimulateOptions::rows(), &["deviation"])),
    ("StudyOptions", "`study`", || without(StudyOptions::rows(), &["plant"])),
    ("SwarmOptions", "`linear.fit`", || {
        let swarm = ["particles", "iterations", "global_best", "seed"];
        IdentifyOptions::rows().into_iter().filter(|row| swarm.contains(&row.name)).collect()
    }),
    ("ValidateOptions", "`Model.validate`", ValidateOptions::rows),
];

fn without(rows: Vec<OptionRow>, names: &[&str]) -> Vec<OptionRow> {
    rows.into_iter().filter(|row| !names.contains(&row.name)).collect()
}
