//! An oscillator with Bouc-Wen hysteresis that its displacement drives, from its records alone.

use super::free_run::{Counted, FreeRun, runs, states};
use super::{FIRST_STEPS, FeedbackFit, Found, best, search};
use piezoid_models::feedback::{FeedbackDynamics, FeedbackMode, FeedbackModel, Intersample};
use piezoid_models::hysteresis::{BasisDesign, Operator};
use piezoid_models::linear::{Arx, Orders, OutputError, Refinement};
use piezoid_numerics::error::Error;
use piezoid_numerics::progress::Progress;
use piezoid_numerics::system::System;
use piezoid_records::record::Record;

/// Most samples after which a reading is taken that are tried: a converter acts after its sample, and the sensor may be
/// read before that.
const LONGEST_DELAY: usize = 1;

/// Steps of the integration in a period of the mode, for an error of 1e-4 and of 3e-6 of the vibration, and most steps
/// in a sample.
const COARSE: f64 = 80.0;
const FINE: f64 = 480.0;
const MAX_SUBSTEPS: usize = 20;

/// Starts: the stiffness of the hysteresis over that of the mode, and its bend over the range.
const STARTS: [(f64, f64); 4] = [(0.3, 0.3), (0.3, 2.0), (1.0, 0.3), (1.0, 2.0)];

impl FeedbackFit {
    /// An oscillator (one mode driven by the input) with Bouc-Wen hysteresis that its displacement drives, and the
    /// likeliest of these kinds of `inputs`.
    ///
    /// ```
    /// use piezoid::feedback::{FeedbackFit, Intersample};
    /// use piezoid::{PrepareOptions, Record, excitation::Multisine, plant::Plant, progress::Stage};
    /// let ts = 1.0 / 15_000.0;
    /// let drive = Multisine { amplitude: 100.0, frequency_low: 5.0, frequency_high: 150.0, ..Multisine::default() };
    /// let u = drive.samples(ts, 20_480)?;
    /// let y = Plant::named("bouc-wen-benchmark", ts)?.run(&u).y;
    /// let slower = PrepareOptions { decimate: Some(20), ..PrepareOptions::default() };
    /// let record = slower.run(&Record::new(ts, u, y)?)?;
    /// let fit = FeedbackFit::oscillator(&[record], &[Intersample::BandLimited], &mut Stage::ignore)?;
    /// assert!((fit.model.dynamics().modes[0].hz - 25.2).abs() < 1.0);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// Returns an error if the records show no resonance, or have different sampling periods; [`Error::Cancelled`].
    pub fn oscillator(records: &[Record], inputs: &[Intersample], progress: &mut Progress) -> Result<Self, Error> {
        FeedbackFit::oscillator_of(records, Counted::All, inputs, progress)
    }

    /// The oscillator of the samples that count.
    pub(super) fn oscillator_of(
        records: &[Record],
        counted: Counted,
        inputs: &[Intersample],
        progress: &mut Progress,
    ) -> Result<Self, Error> {
        let block = OutputError::fit(records, Orders::of(2), &Refinement::default(), progress)?.arx;
        let found =
            best(kinds(inputs).map(|kind| hysteretic(linear((records, counted), &block, kind, progress)?, progress)))?;
        let dynamics = found.model.dynamics().clone();
        let substeps = substeps(FINE, dynamics.modes[0].hz * block.ts());
        let start = found.model.with_dynamics(FeedbackDynamics { substeps, ..dynamics })?;
        FeedbackFit::of_counted(&start, records, counted, progress)
    }
}

/// Each kind of input with each delay after which y can be read.
pub(super) fn kinds(inputs: &[Intersample]) -> impl Iterator<Item = (Intersample, usize)> {
    inputs.iter().flat_map(|between| {
        // A band-limited input has no converter.
        let delays = if *between == Intersample::BandLimited { 0 } else { LONGEST_DELAY };
        (0..=delays).map(|delay| (*between, delay))
    })
}

/// The mode of an output-error block of second order, without hysteresis, with this kind of input and delay.
fn linear<'r>(
    (records, counted): (&'r [Record], Counted),
    block: &Arx,
    (intersample, delay): (Intersample, usize),
    progress: &mut Progress,
) -> Result<Found<'r>, Error> {
    let Some(pole) = block.resonance() else {
        let because = "no resonance shows in the records: excite it".into();
        return Err(Error::Unidentifiable { what: "an oscillator".into(), because });
    };
    let (hz, damping, input) = (pole.hz, pole.damping.max(1e-3), block.dc_gain());
    let modes = vec![FeedbackMode { hz, damping, input, hysteretic: 1.0, sensed: 1.0, softening: 0.0 }];
    let substeps = substeps(COARSE, hz * block.ts());
    let dynamics = FeedbackDynamics { substeps, intersample, delay, modes, sensed: 0.0, ..FeedbackDynamics::default() };
    let start = oscillator(block.ts(), dynamics, (0.0, 1.0), 1.0)?;
    search(&FreeRun::of(&start, &runs(records, counted, |record| states(&start, record))), FIRST_STEPS, progress)
}

/// The best of several starts with hysteresis, each with the frequency and the gain of the mode without it.
fn hysteretic<'r>(linear: Found<'r>, progress: &mut Progress) -> Result<Found<'r>, Error> {
    let FeedbackDynamics { ref modes, offset, .. } = *linear.model.dynamics();
    let mode = modes[0];
    let displacements = linear.runs.iter().flat_map(|run| run.record.y());
    let half = displacements.fold(0.0f64, |half, y| half.max((y - offset).abs()));
    let mut from = |(stiffness, bend): (f64, f64)| {
        let softer = (1.0 + stiffness).sqrt();
        let (hz, damping, input) = (mode.hz / softer, mode.damping * softer, mode.input * (1.0 + stiffness));
        let modes = vec![FeedbackMode { hz, damping, input, ..mode }];
        let dynamics = FeedbackDynamics { modes, ..linear.model.dynamics().clone() };
        let start = oscillator(linear.model.ts(), dynamics, (stiffness, bend / half), half)?;
        search(&FreeRun::of(&start, &linear.runs), FIRST_STEPS, progress)
    };
    best(STARTS.into_iter().map(&mut from))
}

/// Steps in a sample for so many in a period of a mode whose frequency, over that of sampling, is `relative_hz`.
fn substeps(in_period: f64, relative_hz: f64) -> usize {
    ((in_period * relative_hz).ceil() as usize).clamp(1, MAX_SUBSTEPS)
}

/// An oscillator with Bouc-Wen hysteresis of this stiffness and beta, for displacements of +-`half`.
fn oscillator(
    ts: f64,
    dynamics: FeedbackDynamics,
    (stiffness, beta): (f64, f64),
    half: f64,
) -> Result<FeedbackModel, Error> {
    let ts_of_step = ts / dynamics.substeps as f64;
    let design = BasisDesign { ts: ts_of_step, range: (-half, half), elements: None, frequencies: vec![] };
    let basis = (Operator::find("bouc-wen")?.basis)(&design)?.reshaped(&[beta, 0.0])?;
    FeedbackModel::weighted(ts, dynamics, basis.into(), vec![0.0, stiffness])
}
