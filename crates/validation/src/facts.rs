//! What remarks need of a record: of all of it, or of its sections one after the other.

use super::extrapolation::InnerReversals;
use piezoid_models::hammerstein::{Domain, Model};
use piezoid_numerics::series::mean;
use piezoid_records::quality::{Finding, InSections, around, excites};
use piezoid_records::record::Record;
use piezoid_records::waveform::cycle_rate;

/// Facts about a record.
#[derive(Debug)]
pub(super) struct Facts {
    pub(super) domain: Domain,
    /// Time over which frequencies are found [s].
    pub(super) duration: f64,
    /// Rates of the cycles of the sections that have them [Hz], if the hysteresis depends on them.
    pub(super) cycle_rates: Vec<f64>,
    /// True if the input has power near the resonance of the model, if that has one.
    pub(super) excites_resonance: bool,
    /// Defects.
    pub(super) findings: Vec<Finding>,
}

impl Facts {
    /// The facts about a record.
    pub(super) fn of(model: &Model, record: &Record) -> Self {
        let mut found = InSections::default();
        found.add(record, 0);
        Facts { findings: found.findings(), ..Facts::of_section(model, record) }
    }

    /// The facts about a section, without its defects.
    pub(super) fn of_section(model: &Model, section: &Record) -> Self {
        let (u, ts) = (section.u(), section.ts());
        let resonance = model.linear().resonance();
        Facts {
            domain: Domain::of_input(u, ts),
            duration: section.duration(),
            cycle_rates: model.hysteresis().frequencies().and_then(|_| cycle_rate(u, ts)).into_iter().collect(),
            excites_resonance: resonance.is_some_and(|pole| excites(u, ts, around(pole.hz))),
            findings: Vec::new(),
        }
    }

    /// The facts about this section and the next.
    pub(super) fn and(mut self, next: Facts) -> Self {
        self.cycle_rates.extend(next.cycle_rates);
        self.domain = Domain::together([self.domain, next.domain]).unwrap_or(next.domain);
        self.duration = self.duration.min(next.duration);
        self.excites_resonance |= next.excites_resonance;
        self
    }
}

/// Number of reversals inside the range of the hysteresis of a model; 0 if it has none.
pub(super) fn inner_reversals_of(model: &Model, u: &[f64]) -> usize {
    let mut inner = inner_reversals(model);
    inner.iter_mut().for_each(|inner| u.iter().for_each(|u| inner.add(*u)));
    inner.map_or(0, |inner| inner.count)
}

/// Their search.
pub(super) fn inner_reversals(model: &Model) -> Option<InnerReversals> {
    model.hysteresis().range().map(|(low, high)| InnerReversals::new(low, high))
}

/// The likeness of output and free run: sums about their means.
#[derive(Debug)]
pub(super) struct Shape {
    means: [f64; 2],
    product: f64,
    powers: [f64; 2],
}

impl Shape {
    /// For an output and a free run of these means.
    pub(super) fn new(means: [f64; 2]) -> Self {
        Shape { means, product: 0.0, powers: [0.0; 2] }
    }

    pub(super) fn of(y: &[f64], simulated: &[f64]) -> Self {
        let mut shape = Shape::new([y, simulated].map(mean));
        y.iter().zip(simulated).for_each(|(y, s)| shape.add(*y, *s));
        shape
    }

    pub(super) fn add(&mut self, y: f64, simulated: f64) {
        let [y, s] = [y - self.means[0], simulated - self.means[1]];
        self.product += y * s;
        self.powers = [self.powers[0] + y * y, self.powers[1] + s * s];
    }

    /// The output over the free run, and the rms of `n` samples of the free run about its mean.
    pub(super) fn factor_and_size(&self, n: usize) -> (f64, f64) {
        (self.product / self.powers[1], (self.powers[1] / n as f64).sqrt())
    }

    /// The output over the free run, and their correlation.
    pub(super) fn factor_and_correlation(&self) -> (f64, f64) {
        let [power_y, power_model] = self.powers;
        (self.product / power_model, self.product / (power_y * power_model).sqrt())
    }
}
