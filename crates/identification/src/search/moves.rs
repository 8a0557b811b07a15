//! The moves of the search, in their order.
//!
//! A move takes a candidate and returns a better one, or `None`. Each begins with the records in the initial conditions
//! of the candidate, and may leave others: the search sets those of the candidate that it keeps.

use super::fit::refine_to_minimum;
use super::{Candidate, Search, creep_order, initial_conditions, operators, structure_search};
use piezoid_numerics::error::Error;

/// A move.
pub(super) struct Move {
    pub(super) name: &'static str,
    /// True if the move can find something.
    pub(super) applies: fn(&Search) -> bool,
    /// Returns a better candidate, if there is one.
    pub(super) run: fn(&Candidate, &mut Search) -> Result<Option<Candidate>, Error>,
}

/// The same structure, operator and initial conditions at the minimum: a search ends its fits where they can be
/// compared.
fn to_minimum(candidate: &Candidate, search: &mut Search) -> Result<Option<Candidate>, Error> {
    let watch = &mut search.reporter.last_stage(candidate.operator.name);
    Ok(Some(candidate.with_fit(refine_to_minimum(&candidate.fitted, &mut search.runs, watch)?)))
}

/// All moves, from the first candidate on, which has a coarse hysteresis.
pub(super) const MOVES: &[Move] = &[
    Move {
        name: "comparison of the operators",
        applies: |search| search.compares_operators(),
        run: operators::compare,
    },
    // A coarse hysteresis may not show which initial conditions are right.
    Move {
        name: "other initial conditions",
        applies: |search| !search.is_quick(),
        run: initial_conditions::retry_initial_conditions,
    },
    // Small-signal records show the specified order best.
    Move {
        name: structure_search::NAME,
        applies: |search| {
            !search.is_quick() && (search.settings.order.is_none() || search.records.is_large_signal_alone())
        },
        run: structure_search::search_with_operator,
    },
    // What the linear block lacked may have hidden how the operators differ.
    Move {
        name: "comparison of the closest operators",
        applies: |search| search.errors_of(structure_search::NAME).is_some_and(operators::is_worth_repeating),
        run: operators::compare_closest,
    },
    Move {
        name: "all samples",
        applies: |search| !search.is_quick() && search.is_in_parts(),
        run: operators::compare_on_all_samples,
    },
    Move { name: "the minimum", applies: |search| !search.is_quick(), run: to_minimum },
    Move {
        name: "order of creep",
        applies: |search| !search.is_quick() && search.settings.fractional_creep,
        run: creep_order::fit_order,
    },
];
