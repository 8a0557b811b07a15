//! Export: the model, its inverse and its controller in the languages of the machines that drive actuators.
//!
//! What is exported is put together once, as a [`Program`](piezoid::program::Program), and every target prints it: same arithmetic, same
//! order, same bits. Nothing that is written holds a date or a path.

mod c;
mod fixed;
mod fmu;
mod language;
mod rust;
mod simulink;
mod st;
mod template;
#[cfg(test)]
#[path = "../../piezoid/src/testing.rs"]
mod testing;
mod vectors;
mod waveform;
mod whole;

pub use vectors::Vectors;
pub use waveform::Playback;
pub use whole::{Entry, Signal, Whole};

use piezoid::compensation::How;
use piezoid::control::Controller;
use piezoid::error::Error;
use piezoid::hammerstein::Model;

/// What to export.
#[derive(Debug, Clone)]
pub struct Wanted<'w> {
    /// The model.
    pub model: &'w Model,
    /// What functions, types and files are called after: a letter, then letters, digits and underscores.
    pub name: &'w str,
    /// Whether numbers are of single precision.
    pub single: bool,
    /// Limits of the feed-forward.
    pub how: How,
    /// Samples by which the feed-forward is late, which it looks ahead.
    pub preview: usize,
    /// The controller to go with it, if any.
    pub controller: Option<&'w dyn Controller>,
    /// The wanted displacement, for targets that are a table of voltages [output unit]; others do without.
    pub reference: Option<&'w [f64]>,
    /// What compiles C for targets that take a library with them, if there is such a thing.
    pub compiler: Option<Compiler>,
    /// How controllers play such a table.
    pub playback: Playback,
}

impl<'w> Wanted<'w> {
    /// The model under this name, in double precision, its feed-forward within the model's own limits and not late.
    pub fn new(model: &'w Model, name: &'w str) -> Self {
        let (how, playback) = (How::default(), Playback::default());
        let (single, preview, controller, reference, compiler) = (false, 0, None, None, None);
        Wanted { model, name, single, how, preview, controller, reference, compiler, playback }
    }
}

/// A C compiler, which only a front end can run.
#[derive(Debug, Clone, Copy)]
pub struct Compiler {
    /// For which machines, as FMI 3.0 names them: `x86_64-linux`.
    pub platform: &'static str,
    /// Makes a shared library of the sources among these files, which stand in one folder: the same bytes of the same files.
    pub run: fn(&[File]) -> Result<Vec<u8>, Error>,
}

/// A file to write.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct File {
    /// Its path, with `/` between folders.
    pub path: String,
    /// What is in it.
    pub bytes: Vec<u8>,
}

impl File {
    fn text(path: impl Into<String>, text: impl Into<String>) -> Self {
        File { path: path.into(), bytes: text.into().into_bytes() }
    }
}

/// What a target made.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Made {
    /// The files.
    pub files: Vec<File>,
    /// What is worth knowing, one sentence each.
    pub notes: Vec<String>,
}

/// One kind of export: a row of [`TARGETS`].
#[derive(Clone, Copy)]
pub struct Target {
    /// As users write it.
    pub name: &'static str,
    /// One line.
    pub summary: &'static str,
    /// What the files follow.
    pub reference: &'static str,
    /// Which of the settings of [`Wanted`] it heeds, as the command line calls them.
    pub heeds: &'static [&'static str],
    /// Makes the files.
    pub make: fn(&Wanted) -> Result<Made, Error>,
}

impl std::fmt::Debug for Target {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Target").field(&self.name).finish()
    }
}

/// What code heeds.
const CODE: &[&str] = &["float", "preview", "controller"];

/// The targets there are.
pub static TARGETS: &[Target] =
    &[c::TARGET, fmu::FMI2, fmu::FMI3, simulink::TARGET, st::TARGET, rust::TARGET, waveform::TARGET, fixed::TARGET];

/// Export as a method of a model.
///
/// ```
/// use piezoid::{Model, hysteresis::Operator, linear::Arx};
/// use piezoid_export::Export;
/// let plays = (Operator::find("prandtl-ishlinskii")?.example)(5e-4)?;
/// let model = Model::new(plays, Arx::new(5e-4, vec![1.6, -0.8], vec![0.1, 0.1])?, 2.0)?;
/// assert_eq!(model.export("c", "bender")?.files[0].path, "bender.h");
/// # Ok::<(), piezoid::Error>(())
/// ```
pub trait Export {
    /// The model for the target of this name, in double precision; functions and files are called after `name`.
    ///
    /// # Errors
    /// No such target, a name that its language has no room for, a model that it cannot hold.
    fn export(&self, target: &str, name: &str) -> Result<Made, Error>;
}

impl Export for Model {
    fn export(&self, target: &str, name: &str) -> Result<Made, Error> {
        (self::target(target)?.make)(&Wanted::new(self, name))
    }
}

/// The target called `name`.
///
/// ```
/// use piezoid_export::{Wanted, target};
/// use piezoid::{Model, hysteresis::Operator, linear::Arx};
/// let plays = (Operator::find("prandtl-ishlinskii")?.example)(5e-4)?;
/// let model = Model::new(plays, Arx::new(5e-4, vec![1.6, -0.8], vec![0.1, 0.1])?, 2.0)?;
/// let made = (target("c")?.make)(&Wanted::new(&model, "bender"))?;
/// assert_eq!(made.files[0].path, "bender.h");
/// assert!(target("cpp").unwrap_err().to_string().contains("known are c"));
/// # Ok::<(), piezoid::Error>(())
/// ```
///
/// # Errors
/// [`Error::Unknown`] with the names there are.
pub fn target(name: &str) -> Result<&'static Target, Error> {
    let known = || TARGETS.iter().map(|t| t.name);
    TARGETS.iter().find(|t| t.name == name).ok_or_else(|| Error::unknown("target", name, known()))
}

/// Refuses what is no name in the languages of the targets: a letter, then letters, digits and underscores, and none of their words.
fn named(name: &str, reserved: &str) -> Result<(), Error> {
    let fits = name.starts_with(|c: char| c.is_ascii_alphabetic())
        && name.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        && name.len() <= LONGEST
        && !name.ends_with('_')
        && !name.contains("__");
    if !fits {
        let rule = format!(
            "must be a letter, then letters, digits and single underscores, {LONGEST} at most: functions are called after it"
        );
        return Err(Error::parameter("name", format!("`{name}`"), rule));
    }
    if reserved.split_whitespace().any(|word| word.eq_ignore_ascii_case(name)) {
        return Err(Error::parameter("name", format!("`{name}`"), "is a word of the language: take another"));
    }
    Ok(())
}

/// The longest name, which leaves room for what functions and types add to it.
const LONGEST: usize = 40;
