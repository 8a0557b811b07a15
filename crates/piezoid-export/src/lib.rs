//! Export: the model, its inverse and its controller in the languages of the machines that drive actuators.
//!
//! The exported code is built once, as a [`Program`](piezoid_models::program::Program), and every target prints
//! it: same arithmetic, same order, same bits. No exported file contains a date or a path.

mod c;
mod exported;
mod fixed;
mod fmu;
mod folder;
mod guard;
mod language;
mod rust;
mod served;
mod simulink;
mod st;
mod template;
#[cfg(test)]
mod tests;
mod vectors;
mod waveform;

#[doc(hidden)]
pub use exported::{Entry, ExportedProgram, Port};
#[doc(hidden)]
pub use folder::{EXPORT_LIST_FILE, Placement};
#[doc(hidden)]
pub use served::{FEED_FORWARD, MODEL};
#[doc(hidden)]
pub use vectors::Vectors;

use piezoid::compensation::{Causal, FeedForwardSettings};
use piezoid::control::{Controller, ControllerKind, Scheme, TunedScheme};
use piezoid::excitation::LimitOptions;
use piezoid::formats::ColumnSelection;
use piezoid::hysteresis::{OPERATORS, Operator};
use piezoid::{Error, Model, StatedVerdict};
use piezoid_models::program::Counts;
use piezoid_numerics::options::{OptionKind, OptionRow, Options, options};
use piezoid_verbs::{DataFile, EstimatorOptions, File, TuneOptions};
use serde::{Serialize, Serializer};
use serde_json::{Map, Value, json};

options! {
    /// How to export. [`ExportTarget::takes`] lists the options that only some targets have.
    pub struct ExportOptions {
        /// Name prefix of the exported functions, types and files.
        name: String = "piezo_model".into(), OptionRow::new(NAME);
        /// Use single precision.
        float: bool = false, OptionRow::new(OptionKind::Switch);
        /// Samples of the reference that the feed-forward knows in advance; 0: as few as it needs.
        preview: usize = 0, OptionRow::new(OptionKind::Integer(0, u64::MAX));
        /// A feedback controller to export with the model, tuned to it: any feedback of {list} except
        /// predictive.
        controller: Option<String> = None, OptionRow::new(NAME).list("controllers");
        /// Export the estimator of `online` too, which follows gain, weights and linear block on the target.
        online: bool = false, OptionRow::new(OptionKind::Switch);
        /// Clip the voltage to the limits, instead of refusing a reference that exceeds them.
        clip: bool = false, OptionRow::new(OptionKind::Switch).requires("reference").group(WAVEFORMS);
        /// Servo cycle of the GCS controller.
        servo_cycle: f64 = 5e-5, OptionRow::positive("s").requires("reference").group(WAVEFORMS);
        /// Voltages [V] at 0 % and at 100 % of the NV200 amplifier, as its commands avmin and avmax report them.
        range: Option<(f64, f64)> = None, OptionRow::new(OptionKind::Pair).requires("reference").group(WAVEFORMS);
    } with limits: LimitOptions with tuning: TuneOptions with estimator: EstimatorOptions
}

const NAME: OptionKind = OptionKind::Text("NAME");
const WAVEFORMS: &str = "Waveforms";

impl ExportOptions {
    /// Exports the model to the target of this name. A table of voltages is that for `reference`, one period of the
    /// requested displacement [output unit].
    ///
    /// # Errors
    /// Returns an error for an unknown target, options without effect on it, and a controller or model without code for
    /// it.
    pub fn of(
        &self,
        target: &str,
        model: &Model,
        reference: Option<&[f64]>,
        compiler: Option<Compiler>,
    ) -> Result<Exported, Error> {
        let target = ExportTarget::find(target)?;
        self.fit(target, reference.is_some())?;
        let settings = FeedForwardSettings::within(&self.limits, self.clip)?;
        let drive = self.controller.as_deref().map(|name| self.tuned(name, model, settings)).transpose()?;
        let controller = drive.as_ref().map(TunedScheme::controller);
        (target.make)(&ExportRequest { model, options: self.clone(), settings, controller, reference, compiler })
    }

    /// The same from the model in a file, and the reference in another.
    ///
    /// # Errors
    /// The errors of [`ExportOptions::of`], and an error for a file without a model or a reference.
    pub fn run(
        &self,
        target: &str,
        file: &File,
        reference: Option<(&DataFile, &ColumnSelection)>,
        compiler: Option<Compiler>,
    ) -> Result<Exported, Error> {
        let model = file.model()?;
        let r = reference.map(|(file, columns)| file.reference(columns, &model)).transpose()?;
        // If there is a reference, it is what asks too much.
        let asks = reference.map_or(&file.name, |(reference, _)| &reference.name);
        let mut result = self.of(target, &model, r.as_deref(), compiler).map_err(|e| e.about(asks))?;
        result.notes.push(model.proven());
        Ok(result)
    }

    /// Returns an error for options that have no effect.
    fn fit(&self, target: &ExportTarget, is_followed: bool) -> Result<(), Error> {
        let arguments = self.changed().into_iter().map(|(row, value)| (row.name, value));
        for (name, value) in arguments.chain(is_followed.then(|| ("reference", "true".into()))) {
            let takers: Vec<&str> = TARGETS.iter().filter(|t| t.takes.contains(&name)).map(|t| t.name).collect();
            if !takers.is_empty() && !takers.contains(&target.name) {
                let rule = format!("does not apply to the target {}, only to {}", target.name, takers.join(", "));
                return Err(Error::parameter(name, value, rule));
            }
        }
        if let (Some((row, value)), false) = (self.estimator.changed().first(), self.online) {
            let error = Error::parameter(row.name, value, "has an effect only together with an estimator: ");
            return Err(error.advised(vec![("online", true.into())]));
        }
        match self.tuning.changed().first() {
            Some((row, value)) if self.controller.is_none() => {
                let error = Error::parameter(row.name, value, "has an effect only together with a controller: ");
                Err(error.advised(vec![("controller", Value::Null)]))
            }
            _ => Ok(()),
        }
    }

    /// The controller of this name for the model.
    fn tuned(&self, name: &str, model: &Model, settings: FeedForwardSettings) -> Result<TunedScheme, Error> {
        if name.contains('+') {
            let rule = "must be a feedback alone, because the feed-forward is always exported";
            return Err(Error::parameter("controller", name, rule));
        }
        let law = ControllerKind::find(name)?;
        if !law.uses_feed_forward {
            let rule = "solves an optimisation in every sample and cannot be exported: choose another feedback, such \
                        as pi";
            return Err(Error::parameter("controller", name, rule));
        }
        self.tuning.drive(Scheme { law: Some(law), ..Scheme::named("gain")? }, model, settings)
    }
}

/// What to export.
#[derive(Debug, Clone)]
pub struct ExportRequest<'w> {
    /// The model.
    pub model: &'w Model,
    /// Options of the export.
    pub options: ExportOptions,
    /// Limits of the feed-forward.
    pub settings: FeedForwardSettings,
    /// The controller to go with it, if any.
    pub controller: Option<&'w dyn Controller>,
    /// One period of the reference, for targets that write a table of voltages [output unit]; `None` for others.
    pub reference: Option<&'w [f64]>,
    /// The C compiler for targets with a shared library (FMUs); `None` if there is none.
    pub compiler: Option<Compiler>,
}

impl<'w> ExportRequest<'w> {
    /// Exports `model` under this name in double precision, with a feed-forward within the model's own limits and
    /// without delay.
    pub fn new(model: &'w Model, name: &str) -> Self {
        let options = ExportOptions { name: name.into(), ..Default::default() };
        let settings = FeedForwardSettings::default();
        ExportRequest { model, options, settings, controller: None, reference: None, compiler: None }
    }

    /// The same export in single precision if `single`, otherwise in double precision.
    pub fn single(mut self, single: bool) -> Self {
        self.options.float = single;
        self
    }

    /// Samples by which the feed-forward knows the reference in advance.
    fn preview(&self) -> usize {
        match self.options.preview {
            0 => *Causal::delays(self.model).start(),
            n => n,
        }
    }

    /// The feed-forward.
    fn causal(&self) -> Result<Causal, Error> {
        Causal::delayed(self.model, self.settings, ("preview", self.preview()))
    }

    /// Name prefix of the exported functions, types and files.
    fn name(&self) -> &str {
        &self.options.name
    }
}

/// A C compiler, which only a front end can run.
#[derive(Debug, Clone, Copy)]
pub struct Compiler {
    /// Platform of the library, as FMI 3.0 names it: `x86_64-linux`.
    pub platform: &'static str,
    /// Compiles the C sources among these files, all in one folder, to a shared library. The same files give the same
    /// bytes.
    pub run: fn(&[File]) -> Result<Vec<u8>, Error>,
}

/// The result of an export.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Exported {
    /// The files.
    pub files: Vec<File>,
    /// The functions to call, the model first; none in a table of voltages.
    pub functions: Vec<ExportedFunction>,
    /// Remarks, one sentence each.
    pub notes: Vec<String>,
}

/// A function of the exported code, and its operations on real numbers in one sample.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ExportedFunction {
    /// `step`, `ff_step`, `control_step` or `online_step`.
    pub name: &'static str,
    /// One line.
    pub about: String,
    /// Mean number of operations per sample of the self-test.
    pub mean: Counts,
    /// Largest number of operations in one sample of the self-test.
    pub most_seen: usize,
    /// Upper bound of the operations in one sample, for any input and state.
    pub bound: usize,
    /// The same of each kind. Their sum may be larger, because the sides of a choice may have different kinds.
    pub bounds: Counts,
}

impl Exported {
    /// The result for machines: the names and sizes of the files, the operations of the functions, the notes.
    pub fn to_json(&self) -> Value {
        let file = |file: &File| json!({"file": file.name, "bytes": file.bytes.len()});
        let function = |f: &ExportedFunction| {
            let kinds = |Counts { sums, products, quotients, comparisons }: Counts| {
                json!({
                    "additions": sums, "multiplications": products, "divisions": quotients, "comparisons": comparisons,
                })
            };
            json!({
                "function": f.name, "about": f.about,
                "operations": {
                    "mean": kinds(f.mean), "most_seen": f.most_seen, "bound": f.bound, "bound_by_kind": kinds(f.bounds),
                },
            })
        };
        json!({
            "files": self.files.iter().map(file).collect::<Vec<_>>(),
            "functions": self.functions.iter().map(function).collect::<Vec<_>>(), "notes": self.notes,
        })
    }
}

/// One kind of export: a row of [`TARGETS`].
#[derive(Debug, Clone, Copy)]
pub struct ExportTarget {
    /// As users write it.
    pub name: &'static str,
    /// One line.
    pub summary: &'static str,
    /// Standard or manual that the files conform to.
    pub reference: &'static str,
    /// Names of the options that only some targets have and this one has; `reference` if it exports the voltages for
    /// one.
    pub takes: &'static [&'static str],
    /// True if every file stands for itself, so that a folder may hold several such exports.
    pub stands_alone: bool,
    /// The parts that it exports: [`MODEL`], [`FEED_FORWARD`] or both.
    pub makes: &'static [&'static str],
    /// Names of the hysteresis operators that it does not support.
    pub refuses: &'static [&'static str],
    /// Makes the files.
    pub make: fn(&ExportRequest) -> Result<Exported, Error>,
}

/// The row as a document, with the exported parts by operator as `operators`.
impl Serialize for ExportTarget {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        let served = |operator: &&Operator| (operator.name.into(), json!(self.serves(operator)));
        let operators: Map<String, Value> = OPERATORS.iter().map(served).collect();
        let ExportTarget { name, summary, reference, takes, .. } = self;
        let row = json!({
            "name": name, "summary": summary, "reference": reference, "operators": operators, "takes": takes,
        });
        row.serialize(to)
    }
}

impl ExportTarget {
    /// The target called `name`.
    ///
    /// ```
    /// use piezoid_export::{ExportRequest, ExportTarget};
    /// use piezoid::{Model, hysteresis::Operator, linear::Arx};
    /// let plays = (Operator::find("prandtl-ishlinskii")?.example)(5e-4)?;
    /// let model = Model::new(plays, Arx::new(5e-4, vec![1.6, -0.8], vec![0.1, 0.1])?, 2.0)?;
    /// let made = (ExportTarget::find("c")?.make)(&ExportRequest::new(&model, "bender"))?;
    /// assert_eq!(made.files[0].name, "bender.h");
    /// assert!(ExportTarget::find("cpp").unwrap_err().to_string().contains("known are c"));
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Unknown`] with the known names.
    pub fn find(name: &str) -> Result<&'static Self, Error> {
        let known = || TARGETS.iter().map(|t| t.name);
        TARGETS.iter().find(|t| t.name == name).ok_or_else(|| Error::unknown("target", name, known()))
    }
}

/// What most targets for code have in common.
const CODE: ExportTarget = ExportTarget {
    name: "",
    summary: "",
    reference: "",
    takes: &["float", "preview", "controller", "delay_samples", "gain_margin", "phase_margin"],
    stands_alone: false,
    makes: &[MODEL, FEED_FORWARD],
    refuses: &[],
    make: |_| Ok(Exported::default()),
};

/// All targets.
pub static TARGETS: &[ExportTarget] =
    &[c::TARGET, fmu::FMI2, fmu::FMI3, simulink::TARGET, st::TARGET, rust::TARGET, waveform::TARGET, fixed::TARGET];

/// Export as a method of a model.
///
/// ```
/// use piezoid::{Model, hysteresis::Operator, linear::Arx};
/// use piezoid_export::Export;
/// let plays = (Operator::find("prandtl-ishlinskii")?.example)(5e-4)?;
/// let model = Model::new(plays, Arx::new(5e-4, vec![1.6, -0.8], vec![0.1, 0.1])?, 2.0)?;
/// assert_eq!(model.export("c", "bender")?.files[0].name, "bender.h");
/// # Ok::<(), piezoid::Error>(())
/// ```
pub trait Export {
    /// The model for the target of this name, in double precision; functions and files are called after `name`.
    ///
    /// # Errors
    /// Returns an error for an unknown target, a name that is too long or reserved, and a model without code for it.
    fn export(&self, target: &str, name: &str) -> Result<Exported, Error>;
}

impl Export for Model {
    fn export(&self, target: &str, name: &str) -> Result<Exported, Error> {
        (ExportTarget::find(target)?.make)(&ExportRequest::new(self, name))
    }
}

/// Returns an error unless `name` is a letter, then letters, digits and underscores, and no reserved word of the
/// target.
fn named(name: &str, reserved: &str) -> Result<(), Error> {
    let fits = name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && name.len() <= LONGEST
        && !name.ends_with('_')
        && !name.contains("__");
    let rule = if !fits {
        format!(
            "must begin with a letter, followed by letters, digits and single underscores, {LONGEST} characters at \
             most, because functions get this name"
        )
    } else if reserved.split_whitespace().any(|word| word.eq_ignore_ascii_case(name)) {
        "is a reserved word of the target language: choose another name".into()
    } else {
        return Ok(());
    };
    Err(Error::parameter("name", format!("`{name}`"), rule))
}

/// The longest name, which leaves room for what functions and types add to it.
const LONGEST: usize = 40;
