//! The policy of the search: every threshold that decides what is tried, and what is kept.
//!
//! Numerical tolerances are not here: they stand beside their mathematics. Ratios of errors are ratios of rms errors
//! over peak-to-peak, unless a field says otherwise.
//!
//! Why: docs/decisions/structure-and-operator-selection.md, "A grown block has limits, a specified order has none".

use crate::Effort;

/// The constants of the search.
#[derive(Debug)]
pub(crate) struct SearchPolicy {
    // Creep.
    /// Shortest time constant of creep [samples]: what is faster is part of the linear block.
    pub(crate) shortest_creep_lag: f64,
    /// Longest time constant of creep over the duration of the longest record: slower creep looks like drift.
    pub(crate) longest_creep_lag: f64,

    // The first linear block.
    /// Longest delay of small-signal records, and of the gain that starts the structure search [samples].
    pub(crate) max_delay: usize,
    /// Longest delay that z may have before the structure search [samples], and least number of such delays in the
    /// shortest record.
    pub(crate) max_hidden_delay: usize,
    pub(crate) hidden_delays_in_record: usize,
    /// Ratio of the delayed to the direct gain from which the output counts as delayed.
    pub(crate) delayed_gain_ratio: f64,
    /// Ratio of sums of squares up to which a longer delay counts as equal.
    pub(crate) longer_delay_ratio: f64,
    /// Ratio of held-out errors up to which a block without a lag as slow as creep is preferred: creep has its own
    /// block.
    pub(crate) block_without_creep_ratio: f64,
    /// Rows of the Preisach grid that represents the hysteresis until the operators are compared.
    pub(crate) coarse_rows: usize,

    // Initial conditions.
    /// Ratio of squared free-run errors, or of held-out errors, below which a less likely initial condition is
    /// selected.
    pub(crate) initial_condition_ratio: f64,

    // Structure search: what is tried.
    /// Ratio of neighbouring time constants of new lags, and the shortest [samples].
    pub(crate) lag_grid_ratio: f64,
    pub(crate) shortest_lag: f64,
    /// Ratio of neighbouring frequencies of new modes, their highest frequency over the sampling rate, and their
    /// damping ratios.
    pub(crate) mode_grid_ratio: f64,
    pub(crate) highest_mode: f64,
    pub(crate) mode_damping: [f64; 2],
    /// Least number of cycles of a new mode in the longest record.
    pub(crate) min_mode_cycles: f64,
    /// Number of neighbouring frequencies of new modes of which the best is one extension.
    pub(crate) mode_band: usize,
    /// Ratio of minima that the linearised equations must promise before an extension is refined.
    pub(crate) promised_minimum_ratio: f64,
    /// The same for a structure that was simpler with another operator, and for one of lower order with the same.
    pub(crate) promised_simpler_ratio: f64,
    pub(crate) promised_lower_order_ratio: f64,
    /// Ratio of held-out errors with a coarse hysteresis from which a structure is not tried with the operator.
    pub(crate) hopeless_structure_ratio: f64,
    /// Time constant of a new lag before the hysteresis [samples].
    pub(crate) new_driver_lag: f64,
    /// The first pole that cancels a zero in a block of a specified order; the next are its powers.
    pub(crate) cancelled_pole: f64,

    // Structure search: what is a gain.
    /// Ratio of held-out errors below which an extension is kept.
    pub(crate) held_out_gain_ratio: f64,
    /// Ratio of errors of whole records below which it is kept too, if the held-out error is no higher: their first
    /// segments are never held out, and may have the only step.
    pub(crate) whole_record_gain_ratio: f64,
    /// Ratio of held-out errors below which a mode is kept that the records do not show otherwise.
    pub(crate) obvious_mode_ratio: f64,

    // Structure search: which modes the records show.
    /// Number of frequencies of the inputs from which small modes between them show; between fewer, a mode could be
    /// anywhere.
    pub(crate) many_frequencies: usize,
    /// Ratio of the frequency of a mode to those of the inputs from which it may be small.
    pub(crate) above_inputs_ratio: f64,
    /// Least share of the static displacement of a mode between the frequencies of the inputs.
    pub(crate) min_mode_share: f64,
    /// Difference of ln(frequency) up to which two modes are the same.
    pub(crate) same_mode_distance: f64,
    /// Ratio to the least damping up to which a mode is at this limit: there it can be any sine, because each record
    /// has a state of its own.
    pub(crate) least_damping_ratio: f64,

    // Operators.
    /// Distance from the ends of the input range, as its share, from which a reversal starts a minor loop.
    pub(crate) minor_loop_margin: f64,
    /// Number of such reversals that show minor loops: with fewer, operators that differ only there are left out.
    pub(crate) min_minor_loops: usize,
    /// Ratio of held-out errors, with the linear block held, up to which an operator is refined in all parameters.
    pub(crate) refined_operator_ratio: f64,
    /// Number of operators, the best with the linear block held, that are refined before the others.
    pub(crate) first_refined: usize,
    /// The ratio of held-out errors up to which other shapes and initial conditions of an operator are searched.
    pub(crate) searched_shape_ratio: f64,
    /// Ratio of errors in parts of the records up to which operators are compared in all samples: more data may favour
    /// one with more parameters.
    pub(crate) finalist_ratio: f64,
    /// Number of shapes of an operator that are refined, and ratio of held-out errors up to which the second is.
    pub(crate) refined_shapes: usize,
    pub(crate) second_shape_ratio: f64,
    /// Ratio of errors up to which a simpler operator is as good, even if the difference is uncertain.
    pub(crate) as_good_operator_ratio: f64,
    /// Factor by which the errors of an operator whose minor loops jump count more. On major loops alone it can absorb
    /// faults of the linear block, frequency by frequency, and no other input shows them.
    pub(crate) jumping_operator_factor: f64,
    /// Ratio of held-out errors up to which free runs decide between two operators. A fault that all operators share,
    /// as a linear block that is not settled yet, would hide in the free run how they differ.
    pub(crate) free_run_decides_ratio: f64,
    /// Ratio of the held-out errors after and before the structure search from which the comparison is not repeated.
    pub(crate) repeated_comparison_ratio: f64,
    /// Ratio of errors in the comparison up to which an operator takes part in its repetition.
    pub(crate) close_operator_ratio: f64,
}

/// How much a search tries.
#[derive(Debug)]
pub(crate) struct Breadth {
    /// Number of large-signal samples, of all records together, up to which these are searched whole, and number of
    /// samples in the parts of longer ones.
    pub(crate) whole_samples: usize,
    pub(crate) part_samples: usize,
    /// Highest order of the linear block, unless the order is specified.
    pub(crate) max_order: usize,
    /// Maximum number of extensions of the first linear block, one after the other.
    pub(crate) extensions: usize,
    /// Number of extensions that are refined with all other parts. The linearised promise of a single one, with z held,
    /// is often wrong.
    pub(crate) refined_extensions: usize,
    /// Ratio of minima with few signals up to which the held-out error with all weights decides.
    pub(crate) equal_minimum_ratio: f64,
    /// Number of samples for the search of the shape, of all records together.
    pub(crate) shape_samples: usize,
    /// Number of shapes that are tried, and number more for each shape parameter.
    pub(crate) shapes: usize,
    pub(crate) shapes_per_parameter: usize,
    /// Number of them, the best, from which the search of the shape goes on.
    pub(crate) shape_starts: usize,
    /// Ratio of rms errors to the least, before the refinement or held out after it, up to which a refinement goes on.
    pub(crate) reachable_operator_ratio: f64,
}

impl Effort {
    /// How much a search tries.
    pub(crate) fn breadth(self) -> &'static Breadth {
        match self {
            Effort::Quick => &QUICK,
            Effort::Usual => &USUAL,
            Effort::Thorough => &THOROUGH,
        }
    }
}

const QUICK: Breadth = Breadth { max_order: 2, extensions: 1, ..USUAL };

const USUAL: Breadth = Breadth {
    whole_samples: 150_000,
    part_samples: 60_000,
    max_order: 8,
    extensions: usize::MAX,
    refined_extensions: 3,
    equal_minimum_ratio: 1.05,
    shape_samples: 10_000,
    shapes: 16,
    shapes_per_parameter: 8,
    shape_starts: 2,
    reachable_operator_ratio: 1.5,
};

const THOROUGH: Breadth = Breadth {
    whole_samples: 1_000_000,
    part_samples: 300_000,
    max_order: 8,
    extensions: usize::MAX,
    refined_extensions: 6,
    equal_minimum_ratio: 1.2,
    shape_samples: 40_000,
    shapes: 64,
    shapes_per_parameter: 32,
    shape_starts: 4,
    reachable_operator_ratio: f64::INFINITY,
};

/// The policy.
pub(crate) const POLICY: SearchPolicy = SearchPolicy {
    shortest_creep_lag: 10.0,
    longest_creep_lag: 10.0,

    max_delay: 3,
    max_hidden_delay: 256,
    hidden_delays_in_record: 10,
    delayed_gain_ratio: 1.5,
    longer_delay_ratio: 1.01,
    block_without_creep_ratio: 1.1,
    coarse_rows: 12,

    initial_condition_ratio: 0.9,

    lag_grid_ratio: 2.0,
    shortest_lag: 0.5,
    mode_grid_ratio: 1.3,
    highest_mode: 0.45,
    mode_damping: [0.03, 0.2],
    min_mode_cycles: 10.0,
    mode_band: 4,
    promised_minimum_ratio: 0.95,
    promised_simpler_ratio: 1.2,
    promised_lower_order_ratio: 1.0,
    hopeless_structure_ratio: 2.0,
    new_driver_lag: 0.2,
    cancelled_pole: 0.5,

    held_out_gain_ratio: 0.95,
    whole_record_gain_ratio: 0.9,
    obvious_mode_ratio: 0.3,

    many_frequencies: 6,
    above_inputs_ratio: 2.0,
    min_mode_share: 0.02,
    same_mode_distance: 0.2,
    least_damping_ratio: 1.2,

    minor_loop_margin: 0.1,
    min_minor_loops: 8,
    refined_operator_ratio: 3.0,
    first_refined: 2,
    searched_shape_ratio: 30.0,
    finalist_ratio: 1.5,
    refined_shapes: 2,
    second_shape_ratio: 1.5,
    as_good_operator_ratio: 1.02,
    jumping_operator_factor: 2.0,
    free_run_decides_ratio: 1.5,
    repeated_comparison_ratio: 0.7,
    close_operator_ratio: 1.1,
};
