//! A model of every operator, from one structure search.

use crate::identified::Identified;
use crate::records::Records;
use crate::{Effort, JointOptions, QUICK_SAMPLES, result, searched};
use piezoid_models::hysteresis::Operator;
use piezoid_numerics::error::Error;
use piezoid_numerics::progress::Progress;
use piezoid_records::record::Record;

/// The time since any moment [s], which the library does not know itself: of a front end's clock, or always 0.
pub type Clock<'a> = &'a (dyn Fn() -> f64 + Sync);

/// The model of one operator.
#[derive(Debug)]
pub struct EachOperator {
    /// The operator.
    pub operator: &'static Operator,
    /// Its model, or the reason why there is none.
    pub found: Result<Identified, Error>,
    /// The time that its own fits took, after the search [s].
    pub seconds: f64,
}

/// The models of several operators.
#[derive(Debug)]
pub struct Each {
    /// The result of the search: the same as that of [`identify_joint`](crate::identify_joint), except that the best
    /// model of a cancelled search of long records may be another.
    pub selected: Identified,
    /// The time that the search took [s].
    pub seconds: f64,
    /// The operators, in the order given. Those that a cancelled search did not finish are missing.
    pub operators: Vec<EachOperator>,
    /// The [`Error::Cancelled`] that ended the work, if it was cancelled.
    pub cancelled: Option<Error>,
}

/// Identifies as [`identify_joint`](crate::identify_joint), then a model of each operator in `rows` with the driver,
/// creep and linear block that were found, all parameters fitted to their minimum: each row costs its own fits alone.
///
/// ```
/// # use piezoid::{Record, excitation::RisingSine, plant::Plant};
/// # use piezoid_identification::{JointOptions, identify_each};
/// # use piezoid_models::hysteresis::Operator;
/// # let u = RisingSine { amplitude: 28.0, frequency: 4.0, ..RisingSine::default() }.samples(1e-3, 2000)?;
/// # let record = Record::new(1e-3, u.clone(), Plant::named("pl140", 1e-3)?.run(&u).y)?;
/// let rows = Operator::list("prandtl-ishlinskii,proportional")?;
/// let settings = JointOptions { operator: "prandtl-ishlinskii".into(), order: Some(2), ..JointOptions::default() };
/// let progress = &mut piezoid::progress::Stage::ignore;
/// let each = identify_each((&[], &[record]), &settings, &rows, &|| 0.0, progress)?;
/// let order = |k: usize| each.operators[k].found.as_ref().map(|found| found.model.linear().a().len());
/// assert_eq!(order(0), order(1));
/// # Ok::<(), piezoid::Error>(())
/// ```
///
/// # Errors
/// The errors of [`identify_joint`](crate::identify_joint).
pub fn identify_each(
    (small, large_signal): (&[Record], &[Record]),
    settings: &JointOptions,
    rows: &[&'static Operator],
    clock: Clock,
    progress: &mut Progress,
) -> Result<Each, Error> {
    settings.check()?;
    let start = clock();
    let records = Records::of(small, large_signal)?;
    let ends = if settings.effort == Effort::Quick { Some(records.ends(QUICK_SAMPLES)?) } else { None };
    let ends = ends.as_ref().unwrap_or(&records);
    searched(&records, ends, settings, progress, |search, best| {
        let selected = result::identified(best.clone(), search, &records, settings)?;
        let seconds = clock() - start;
        let mut each = Each { cancelled: selected.cancelled.clone(), selected, seconds, operators: Vec::new() };
        if each.cancelled.is_none() {
            let finished = search.each(&best, rows, clock);
            each.cancelled = search.cancelled.take();
            for (operator, candidate, seconds) in finished {
                let found = candidate.and_then(|candidate| {
                    search.end_with_alone(&candidate);
                    result::identified(candidate, search, &records, settings)
                });
                each.operators.push(EachOperator { operator, found, seconds });
            }
        }
        Ok(each)
    })
}
