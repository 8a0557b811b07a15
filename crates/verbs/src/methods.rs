//! The methods that `compare` identifies: operators with one structure, and structures beside it.
//!
//! ```text
//! --operators  stop,preisach   a row each, all with the driver, creep and linear block of the best of them
//!              all             each operator
//!              auto            the operator that `identify` selects
//! --structures hammerstein     these rows
//!              no-creep        the selected operator without creep
//!              order-N         the selected operator with a linear block of order N
//!              linear          no hysteresis
//!              feedback, auto  as in `identify`
//! ```
//! One search finds the structure for all operators (see [`identify_each`]). A method that cannot be fitted has the
//! reason in place of a model.

use crate::identification::{EFFORTS, IdentifyOptions, MAX_ORDER, Records};
use piezoid_identification::feedback::{Structure, identify_structure};
use piezoid_identification::{Clock, Each, Effort, Identified, identify_each};
use piezoid_models::hammerstein::Model;
use piezoid_models::hysteresis::{OPERATORS, Operator};
use piezoid_numerics::error::Error;
use piezoid_numerics::options::{OptionKind, OptionRow, options};
use piezoid_numerics::progress::Progress;

const NAMES: OptionKind = OptionKind::Text("NAMES");
const SHARE: OptionKind = OptionKind::Number { least: 0.0, open: true, below: 1.0 };
const GROUP: &str = "Identified methods";

options! {
    /// Which methods are identified and compared, and from which part of the records.
    pub struct MethodOptions {
        /// Hysteresis operators to identify, separated by commas, a row each (see {list}): all is each operator, auto
        /// the one that identify selects. They share one search for the structure.
        operators: Option<String> = None, OptionRow::new(NAMES).list("operators").group(GROUP)
            .absent("auto, if there are structures");
        /// Structures to identify, separated by commas: hammerstein (each of the operators), no-creep, order-N (both
        /// with the selected operator), linear (no hysteresis), feedback and auto, as in identify.
        structures: Option<String> = None, OptionRow::new(NAMES).group(GROUP)
            .absent("hammerstein, if there are operators");
        /// Share at the end of each training record that no method is fitted to, and on which all are compared; unless
        /// there are other records for this.
        held_out: f64 = 0.25, OptionRow::new(SHARE).group(GROUP);
        /// How much the search tries, as in identify.
        effort: Effort = Effort::Usual, OptionRow::new(EFFORTS).group(GROUP);
        /// Seed of the search.
        seed: u64 = 1, OptionRow::new(OptionKind::Integer(0, u64::MAX)).group(GROUP);
        /// The driver used for the records; give it if its current or slew limit was reached (see {list}).
        driver: Option<String> = None, OptionRow::new(OptionKind::Text("NAME")).list("drivers").group(GROUP);
        /// Capacitance of the load, for the driver's current limit.
        capacitance: Option<f64> = None, OptionRow::positive("F").requires("driver").group(GROUP);
        /// Time constant of the driver, where it is known.
        driver_lag: Option<f64> = None, OptionRow::not_negative("s").group(GROUP);
        /// Slew rate of the driver, if known.
        driver_slew: Option<f64> = None, OptionRow::positive("V/s").group(GROUP);
    }
}

/// A method that was identified, or the reason why it could not be.
#[derive(Debug)]
pub(super) struct Fitted {
    pub(super) name: String,
    pub(super) model: Result<Model, Error>,
    /// The time that it took, with that of a search that it shares with others [s].
    pub(super) seconds: f64,
}

/// A structure to identify.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Shape {
    Hammerstein,
    NoCreep,
    Order(usize),
    Linear,
    Feedback,
    Auto,
}

/// The operators to identify, and those that the search of the structure tries.
#[derive(Debug)]
struct Listed {
    rows: Vec<&'static Operator>,
    has_auto: bool,
    search: String,
}

impl MethodOptions {
    /// True if something is to be identified.
    pub fn is_any(&self) -> bool {
        self.operators.is_some() || self.structures.is_some()
    }

    /// Checks the names before any work begins.
    ///
    /// # Errors
    /// [`Error::Unknown`] and [`Error::Parameter`], with the option.
    pub fn check(&self) -> Result<(), Error> {
        self.listed()?;
        self.shapes()?;
        self.identification().check()
    }

    fn shapes(&self) -> Result<Vec<Shape>, Error> {
        const KNOWN: [&str; 6] = ["hammerstein", "no-creep", "order-2", "linear", "feedback", "auto"];
        let shape = |name: &str| match (name, name.strip_prefix("order-").map(str::parse::<usize>)) {
            ("hammerstein", _) => Ok(Shape::Hammerstein),
            ("no-creep", _) => Ok(Shape::NoCreep),
            ("linear", _) => Ok(Shape::Linear),
            ("feedback", _) => Ok(Shape::Feedback),
            ("auto", _) => Ok(Shape::Auto),
            (_, Some(Ok(order))) if order <= MAX_ORDER as usize => Ok(Shape::Order(order)),
            (_, Some(_)) => {
                let rule = format!("order-N is a linear block of order N, a whole number from 0 to {MAX_ORDER}");
                Err(Error::parameter("structures", name, rule))
            }
            _ => Err(Error::unknown("structure", name, KNOWN)),
        };
        let names = self.structures.as_deref().unwrap_or("hammerstein").split(',').map(str::trim);
        let mut shapes = Vec::new();
        for name in names {
            let shape = shape(name)?;
            if !shapes.contains(&shape) {
                shapes.push(shape);
            }
        }
        Ok(shapes)
    }

    fn listed(&self) -> Result<Listed, Error> {
        let names = self.operators.as_deref().unwrap_or("auto");
        let (mut rows, mut has_auto): (Vec<&'static Operator>, bool) = (Vec::new(), false);
        let mut without = String::new();
        for name in names.split(',').map(str::trim) {
            match (name, name.strip_prefix('-')) {
                ("auto", _) => has_auto = true,
                ("all", _) => rows.extend(OPERATORS),
                (_, Some(name)) => {
                    let name = Operator::find(name)?.name;
                    rows.retain(|row| row.name != name);
                    without += &format!(",-{name}");
                }
                _ => rows.push(Operator::find(name)?),
            }
        }
        let mut once: Vec<&'static Operator> = Vec::new();
        rows.retain(|row| {
            let is_new = once.iter().all(|other| other.name != row.name);
            once.push(row);
            is_new
        });
        let listed: Vec<&str> = rows.iter().map(|row| row.name).collect();
        let search = if has_auto { format!("auto{without}") } else { listed.join(",") };
        match rows.is_empty() && !has_auto {
            true => Err(Error::parameter("operators", names, "leaves no operator: name one, all or auto")),
            false => Ok(Listed { rows, has_auto, search }),
        }
    }

    /// The options of `identify` that all methods have.
    fn identification(&self) -> IdentifyOptions {
        let MethodOptions { effort, seed, capacitance, driver_lag, driver_slew, .. } = *self;
        let driver = self.driver.clone();
        IdentifyOptions { effort, seed, driver, capacitance, driver_lag, driver_slew, ..IdentifyOptions::default() }
    }

    /// Identifies every method from the records, and passes it on when it is fitted.
    ///
    /// # Errors
    /// The errors of [`MethodOptions::check`], and [`Error::Cancelled`], after those that were finished.
    pub(super) fn identify(
        &self,
        records: Records,
        clock: Clock,
        progress: &mut Progress,
        finished: &mut dyn FnMut(Fitted),
    ) -> Result<(), Error> {
        let (listed, shapes) = (self.listed()?, self.shapes()?);
        let rows = if shapes.contains(&Shape::Hammerstein) { &listed.rows[..] } else { &[] };
        let each = shapes.iter().any(|shape| shape.needs_search()).then(|| {
            let settings = IdentifyOptions { operator: listed.search.clone(), ..self.identification() }.joint()?;
            identify_each((records.small_signal, records.large_signal), &settings, rows, clock, progress)
        });
        if let Some(Err(cancelled @ Error::Cancelled { .. })) = each {
            return Err(cancelled);
        }
        for shape in shapes {
            let (start, mut shared) = (clock(), 0.0);
            match (shape, &each) {
                (Shape::Hammerstein, Some(Ok(each))) => listed.pass_on(each, finished),
                (Shape::Hammerstein, Some(Err(why))) => {
                    let failed = |name| Fitted { name, model: Err(why.clone()), seconds: 0.0 };
                    listed.names().into_iter().for_each(|name| finished(failed(name)));
                }
                _ => {}
            }
            if let (true, Some(Ok(Each { seconds, cancelled, .. }))) = (shape.needs_search(), &each) {
                shared = *seconds;
                if let Some(cancelled) = cancelled {
                    return Err(cancelled.clone());
                }
            }
            if shape != Shape::Hammerstein {
                let found = self.one(shape, each.as_ref(), records, progress).and_then(Identified::finished);
                let model = match found {
                    Err(cancelled @ Error::Cancelled { .. }) => return Err(cancelled),
                    found => found.map(|found| found.model),
                };
                finished(Fitted { name: shape.name(), model, seconds: shared + clock() - start });
            }
        }
        Ok(())
    }

    /// A structure other than that of the operators; `each` is the search that they share.
    fn one(
        &self,
        shape: Shape,
        each: Option<&Result<Each, Error>>,
        records: Records,
        progress: &mut Progress,
    ) -> Result<Identified, Error> {
        let usual = self.identification();
        let selected = || match each {
            Some(each) => each.as_ref().map(|each| &each.selected).map_err(Error::clone),
            None => Err(Error::Content("there is no search for the structure".into())),
        };
        let operator = || selected().map(|found| found.model.hysteresis().operator().name.to_string());
        let options = match shape {
            Shape::Linear => IdentifyOptions { operator: "proportional".into(), ..usual },
            Shape::Feedback => IdentifyOptions { structure: Structure::Feedback, ..usual },
            Shape::NoCreep => IdentifyOptions { operator: operator()?, creep: false, ..usual },
            Shape::Order(n) => IdentifyOptions { operator: operator()?, order: Some(n), ..usual },
            Shape::Hammerstein | Shape::Auto => {
                let all = records.small_signal.iter().chain(records.large_signal);
                return identify_structure(selected()?.clone(), all, Structure::Auto, usual.joint()?.driver, progress);
            }
        };
        records.identify(&options, progress)
    }

    /// The names of all methods, in their order.
    ///
    /// # Errors
    /// The errors of [`MethodOptions::check`].
    pub(super) fn names(&self) -> Result<Vec<String>, Error> {
        if !self.is_any() {
            return Ok(Vec::new());
        }
        let listed = self.listed()?;
        let names = |shape: Shape| match shape {
            Shape::Hammerstein => listed.names(),
            other => vec![other.name()],
        };
        Ok(self.shapes()?.into_iter().flat_map(names).collect())
    }
}

impl Listed {
    fn names(&self) -> Vec<String> {
        let auto = self.has_auto.then(|| "auto".to_string());
        auto.into_iter().chain(self.rows.iter().map(|row| row.name.to_string())).collect()
    }

    /// Passes on the operators of a search, the selected one first if it has a row of its own.
    fn pass_on(&self, each: &Each, finished: &mut dyn FnMut(Fitted)) {
        if self.has_auto && each.selected.cancelled.is_none() {
            finished(Fitted { name: "auto".into(), model: Ok(each.selected.model.clone()), seconds: each.seconds });
        }
        for one in &each.operators {
            let model = one.found.as_ref().map(|found| found.model.clone()).map_err(Error::clone);
            finished(Fitted { name: one.operator.name.into(), model, seconds: each.seconds + one.seconds });
        }
    }
}

impl Shape {
    /// True if it begins with the search of the structure.
    fn needs_search(self) -> bool {
        !matches!(self, Shape::Linear | Shape::Feedback)
    }

    fn name(self) -> String {
        match self {
            Shape::Hammerstein => "hammerstein".into(),
            Shape::NoCreep => "no-creep".into(),
            Shape::Order(n) => format!("order-{n}"),
            Shape::Linear => "linear".into(),
            Shape::Feedback => "feedback".into(),
            Shape::Auto => "structure auto".into(),
        }
    }
}
