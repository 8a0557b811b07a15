//! Identification of a model from records: the entry point.

use piezoid_identification::feedback::{Structure, identify_structure};
use piezoid_identification::{Effort, Identified, JointOptions, identify_joint};
use piezoid_models::driver::DriverModel;
use piezoid_models::hysteresis::{HeldInput, Split};
use piezoid_models::linear;
use piezoid_numerics::error::Error;
use piezoid_numerics::optimize::swarm::{self, GlobalBest};
use piezoid_numerics::options::{OptionKind, OptionRow, Options, options};
use piezoid_numerics::progress::{Progress, Stage};
use piezoid_paper::{PaperOptions, identify_paper};
use piezoid_records::excitation;
use piezoid_records::record::Record;
use piezoid_twins::Spec;
use serde::{Deserialize, Serialize};

/// Method of identification.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Method {
    /// All parts together, by the error of the free run.
    #[default]
    Joint,
    /// The paper's six steps.
    Paper,
}

const METHODS: OptionKind = OptionKind::Choice(&[
    ("joint", "all parts together, by minimising the error of the free run"),
    ("paper", "the paper's six steps"),
]);

const SPLITS: OptionKind = OptionKind::Choice(&[
    ("line", "by the side of the line through the reversals, as in the paper"),
    ("direction", "by the direction of the input"),
]);

const READINGS: OptionKind = OptionKind::Choice(&[
    ("held", "the branch of the last direction of the input"),
    ("printed", "the descending branch, because the paper's rule says \"otherwise\""),
]);

const BESTS: OptionKind = OptionKind::Choice(&[
    ("ever", "the best position of any particle so far"),
    ("current", "the best of the current positions: equation (4) as printed"),
]);

pub(super) const EFFORTS: OptionKind = OptionKind::Choice(&[
    (
        "quick",
        "in about a second: a coarse hysteresis and a linear block of order 2, from the last part of each record",
    ),
    ("usual", "all operators that may be the best, each with the best of some shapes"),
    ("thorough", "more shapes and structures, and every operator to its minimum; several times as long"),
]);

const STRUCTURES: OptionKind = OptionKind::Choice(&[
    ("hammerstein", "hysteresis first, then creep and mechanics"),
    (
        "feedback",
        "hysteresis that the mechanics drive: friction in a guide by the displacement, or a ceramic by voltage and \
         vibration, with a mode that softens and a curved sensor; a minute or two",
    ),
    ("auto", "the one that predicts held-out parts of each record better; it takes longer"),
]);

/// Highest order of the linear block.
pub(super) const MAX_ORDER: u64 = 12;

const NAME: OptionKind = OptionKind::Text("NAME");
const COUNT: OptionKind = OptionKind::Integer(1, u64::MAX);
const JOINT: &str = "Joint method";
const PAPER: &str = "Paper's method";

options! {
    /// How to identify. The defaults suit records of any kind.
    ///
    /// ```
    /// use piezoid::IdentifyOptions;
    /// let options = IdentifyOptions { operator: "preisach".into(), order: Some(3), ..IdentifyOptions::default() };
    /// # assert_eq!(options.seed, 1);
    /// ```
    pub struct IdentifyOptions {
        /// Method of identification.
        method: Method = Method::Joint, OptionRow::new(METHODS);
        /// The hysteresis operator (see {list}), or several separated by commas; auto tries all laws, all also the
        /// learned operators, and auto,-NAME all laws but one. The simplest one that predicts held-out parts as well as
        /// the best is selected. With the paper's method, auto selects two-branch or rate-scheduled.
        operator: String = "auto".into(), OptionRow::new(NAME).list("operators");
        /// Where hysteresis is.
        structure: Structure = Structure::Hammerstein, OptionRow::new(STRUCTURES).group(JOINT);
        /// How much the search tries.
        effort: Effort = Effort::Usual, OptionRow::new(EFFORTS).group(JOINT);
        /// Order of the linear block.
        order: Option<usize> = None, OptionRow::new(OptionKind::Integer(0, MAX_ORDER)).absent("chosen; 2 by the paper's method");
        /// Seed of the swarm.
        seed: u64 = 1, OptionRow::new(OptionKind::Integer(0, u64::MAX));
        /// Number of thresholds, levels or knots of the operator.
        elements: Option<usize> = None, OptionRow::new(OptionKind::Integer(1, 1000)).absent("default of the \
                                                                                             operator").group(JOINT);
        /// Identify creep.
        creep: bool = true, OptionRow::new(OptionKind::Switch).group(JOINT);
        /// Creep that grows as a power of time: its order is fitted, in place of a gain for each of its lags.
        fractional_creep: bool = false, OptionRow::new(OptionKind::Switch).group(JOINT);
        /// The driver used for the records; give it if its current or slew limit was reached (see {list}).
        driver: Option<String> = None, OptionRow::new(NAME).list("drivers").group(JOINT);
        /// Capacitance of the load, for the driver's current limit.
        capacitance: Option<f64> = None, OptionRow::positive("F").requires("driver").group(JOINT);
        /// Time constant of the driver, where it is known.
        driver_lag: Option<f64> = None, OptionRow::not_negative("s").group(JOINT);
        /// Slew rate of the driver, if known.
        driver_slew: Option<f64> = None, OptionRow::positive("V/s").group(JOINT);
        /// The estimator of the linear block (see {list}).
        estimator: Option<String> = None, OptionRow::new(NAME).list("estimators").absent("swarm").group(PAPER);
        /// How the points of a loop are divided between the ascending and the descending branch.
        split: Option<Split> = None, OptionRow::new(SPLITS).absent("line").group(PAPER);
        /// Number of averaged points on each branch, between the reversals.
        bins: Option<usize> = None, OptionRow::new(COUNT).absent("16").group(PAPER);
        /// Which branch is read while the input is held.
        reading: Option<HeldInput> = None, OptionRow::new(READINGS).absent("held").group(PAPER);
        /// Particles of the swarm.
        particles: Option<usize> = None, OptionRow::new(COUNT).absent("50").group(PAPER);
        /// Iterations of the swarm.
        iterations: Option<usize> = None, OptionRow::new(COUNT).absent("500").group(PAPER);
        /// The position that attracts all particles, g_best in equation (2) of the paper.
        global_best: Option<GlobalBest> = None, OptionRow::new(BESTS).absent("ever").group(PAPER);
    }
}

/// The records from which a model is identified.
///
/// A slice of records means large-signal records. They exercise the hysteresis, and the dynamics are identified from
/// them where they excite the dynamics.
#[derive(Debug, Clone, Copy, Default)]
pub struct Records<'r> {
    /// Records for the linear block, such as a PRBS of about 1 V; may be empty.
    pub small_signal: &'r [Record],
    /// Records that exercise the hysteresis, such as rising sines at some frequencies.
    pub large_signal: &'r [Record],
}

impl Records<'_> {
    /// The same as [`identify`] with progress; the callback can cancel it.
    ///
    /// # Errors
    /// The errors of [`identify`], and [`Error::Cancelled`].
    pub fn identify(self, options: &IdentifyOptions, progress: &mut Progress) -> Result<Identified, Error> {
        let Records { small_signal, large_signal } = self;
        match options.settings()? {
            Settings::Joint(settings) => {
                // Where it is requested, the blocks in series only approximate it.
                let effort = if options.structure == Structure::Feedback { Effort::Quick } else { settings.effort };
                let settings = JointOptions { effort, ..settings };
                let found = identify_joint(small_signal, large_signal, &settings, progress)?;
                let records = small_signal.iter().chain(large_signal);
                identify_structure(found, records, options.structure, settings.driver, progress)
            }
            Settings::Paper(settings) => identify_paper(small_signal, large_signal, &settings, progress),
        }
    }
}

/// The settings of the method: options that were checked.
enum Settings {
    Joint(JointOptions),
    Paper(PaperOptions),
}

impl<'r, R: AsRef<[Record]> + ?Sized> From<&'r R> for Records<'r> {
    fn from(records: &'r R) -> Self {
        Records { large_signal: records.as_ref(), ..Records::default() }
    }
}

/// Identifies a model from records.
///
/// ```
/// use piezoid::{IdentifyOptions, identify};
/// # use piezoid::{Record, excitation::RisingSine, plant::{Plant, Preset}};
/// # let u = RisingSine { amplitude: 28.0, frequency: 4.0, ..RisingSine::default() }.samples(1e-3, 2000)?;
/// # let plant = Plant::named("pl140", 1e-3)?;
/// # let record = Record::new(1e-3, u.clone(), plant.run(&u).y)?;
/// let plays = "prandtl-ishlinskii".to_string();
/// let options = IdentifyOptions { operator: plays, order: Some(2), ..IdentifyOptions::default() };
/// let found = identify(&[record], &options)?;
/// assert_eq!(found.model.hysteresis().operator().name, "prandtl-ishlinskii");
/// # Ok::<(), piezoid::Error>(())
/// ```
///
/// # Errors
/// Returns an error if there is no record, if sampling periods differ or units cannot be converted, if nothing can be
/// identified from the records, for options of the other method, and for unknown names.
pub fn identify<'r>(records: impl Into<Records<'r>>, options: &IdentifyOptions) -> Result<Identified, Error> {
    records.into().identify(options, &mut Stage::ignore)
}

impl IdentifyOptions {
    /// The same options with the known driver of a twin: its lag, and its current limit / capacitance.
    pub fn with_driver_of(self, plant: &Spec) -> Self {
        let twin = &plant.driver;
        let driver_slew = twin.current_a.map(|current| current / twin.capacitance_f);
        IdentifyOptions { driver_lag: Some(twin.lag_s).filter(|lag| *lag > 0.0), driver_slew, ..self }
    }

    /// Checks the options before any work begins: none belongs to the other method, and all names are known.
    ///
    /// # Errors
    /// [`Error::Parameter`] and [`Error::Unknown`], with the option.
    pub fn check(&self) -> Result<(), Error> {
        self.settings().map(drop)
    }

    fn settings(&self) -> Result<Settings, Error> {
        piezoid_models::hysteresis::Operator::list(&self.operator)?;
        self.check_method()?;
        match self.method {
            Method::Joint => self.joint().map(Settings::Joint),
            Method::Paper => self.paper().map(Settings::Paper),
        }
    }

    /// Returns an error for options of the other method.
    fn check_method(&self) -> Result<(), Error> {
        let (of, other) = match self.method {
            Method::Joint => (PAPER, "paper"),
            Method::Paper => (JOINT, "joint"),
        };
        match self.changed().into_iter().find(|(row, _)| row.group == of) {
            None => Ok(()),
            Some((row, value)) => {
                let rule =
                    format!("is an option of the method {other} only: leave it out, or choose the method {other}");
                Err(Error::parameter(row.name, value, rule))
            }
        }
    }

    pub(super) fn joint(&self) -> Result<JointOptions, Error> {
        Ok(JointOptions {
            operator: self.operator.clone(),
            order: self.order,
            elements: self.elements,
            creep: self.creep,
            fractional_creep: self.fractional_creep,
            driver: self.driver()?,
            seed: self.seed,
            effort: self.effort,
        })
    }

    /// The driver as a block; `None` if nothing is known of it.
    fn driver(&self) -> Result<Option<DriverModel>, Error> {
        let limits = match &self.driver {
            Some(name) => excitation::Amplifier::find(name)?.loaded(self.capacitance)?,
            None => excitation::Limits::default(),
        };
        let slew = self.driver_slew.into_iter().chain(Some(limits.fastest()).filter(|slew| slew.is_finite()));
        let slew = slew.reduce(f64::min);
        match (self.driver_lag, slew) {
            (None, None) => Ok(None),
            (lag, slew) => DriverModel::new(lag.unwrap_or(0.0), slew).map(Some),
        }
    }

    fn paper(&self) -> Result<PaperOptions, Error> {
        let usual = PaperOptions::default();
        let order = self.order.unwrap_or(usual.order);
        if order == 0 {
            return Err(Error::parameter("order", order, "must be at least 1 with the paper's method"));
        }
        let estimator = self.estimator.clone().unwrap_or(usual.estimator);
        linear::Estimator::find(&estimator)?;
        let operator = match &*self.operator {
            names if piezoid_models::hysteresis::is_auto(names) => names,
            name => piezoid_models::hysteresis::Operator::find(name)?.name,
        };
        Ok(PaperOptions {
            order,
            estimator,
            operator: operator.into(),
            split: self.split.unwrap_or(usual.split),
            bins: self.bins.unwrap_or(usual.bins),
            reading: self.reading.unwrap_or(usual.reading),
            swarm: self.swarm(),
        })
    }

    /// Settings of the swarm.
    pub fn swarm(&self) -> swarm::SwarmSettings {
        let usual = swarm::SwarmSettings::default();
        swarm::SwarmSettings {
            particles: self.particles.unwrap_or(usual.particles),
            iterations: self.iterations.unwrap_or(usual.iterations),
            seed: self.seed,
            global_best: self.global_best.unwrap_or(usual.global_best),
            ..usual
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_twins::Preset;
    use serde_json::{Value, json};

    /// Every name in a row is a valid value of its option.
    #[test]
    fn every_choice_is_read_and_every_default_is_one_of_its_values() {
        let usual = serde_json::to_value(IdentifyOptions::default()).unwrap();
        for row in IdentifyOptions::rows() {
            if let OptionKind::Choice(known) = row.values {
                for (name, _) in known {
                    let options = IdentifyOptions::from_json(json!({ row.name: name })).unwrap();
                    assert_eq!(serde_json::to_value(options).unwrap()[row.name], *name);
                }
            }
            match &usual[row.name] {
                Value::Null => assert!(!row.absent.is_empty() || row.group == JOINT, "{}", row.name),
                value => assert_eq!(row.fit(value.clone()), Ok(value.clone())),
            }
        }
    }

    #[test]
    fn the_defaults_that_are_told_of_the_papers_method_are_those_it_has() {
        let usual = PaperOptions::default();
        let message = |name: &str| IdentifyOptions::rows().iter().find(|row| row.name == name).unwrap().usual();
        assert_eq!([message("bins"), message("particles")], [usual.bins, usual.swarm.particles].map(|n| n.to_string()));
        assert_eq!(message("iterations"), usual.swarm.iterations.to_string());
        assert_eq!((message("estimator"), usual.swarm.seed), (usual.estimator, IdentifyOptions::default().seed));
    }

    #[test]
    fn an_option_of_the_other_method_is_refused_by_its_name() {
        let refusal = |options: IdentifyOptions| identify(&[] as &[Record], &options).unwrap_err().to_string();
        let joint = IdentifyOptions { bins: Some(8), ..IdentifyOptions::default() };
        assert!(refusal(joint).starts_with("bins = 8: is an option of the method paper"));
        let paper = IdentifyOptions { method: Method::Paper, creep: false, ..IdentifyOptions::default() };
        assert!(refusal(paper).starts_with("creep = false: is an option of the method joint"));
    }

    #[test]
    fn a_list_of_operators_may_leave_some_out_of_auto() {
        let of = |operator: &str| IdentifyOptions { operator: operator.into(), ..IdentifyOptions::default() };
        assert!(of("auto,-preisach,-duhem").check().is_ok());
        for (operator, says) in [
            ("auto,-preisac", "did you mean `preisach`"),
            ("stop,-stop", "operator = stop,-stop: leaves no operator"),
            ("-stop", "leaves no operator: begin with auto"),
        ] {
            let error = of(operator).check().unwrap_err().to_string();
            assert!(error.contains(says), "{error}");
        }
    }

    #[test]
    fn the_driver_of_a_twin_is_known_unless_it_is_ideal() {
        let of = |name: &str| {
            let options = IdentifyOptions::default().with_driver_of(&Preset::find(name).unwrap().spec());
            options.driver().unwrap()
        };
        assert_eq!(of("paper"), None);
        assert_eq!(of("pl140"), Some(DriverModel { lag_s: 1e-4, slew: Some(0.5 / 8.2e-6) }));
    }
}
