//! What the ceramic moves: a beam of linear or softening modes, or an oscillator with hysteresis.

use super::beam::Beam;
use super::oscillator::OscillatorStage;
use super::spec::BeamSpec;
use piezoid_numerics::error::Error;

/// The mechanics; each file describes its state.
#[derive(Debug, Clone)]
pub(super) enum Mechanics {
    Beam(Beam),
    Oscillator(OscillatorStage),
}

impl Mechanics {
    /// The mechanics advanced in steps of `h` [s].
    pub(crate) fn new(spec: &BeamSpec, h: f64) -> Result<Self, Error> {
        Ok(match spec {
            BeamSpec::Modes(modes) => Mechanics::Beam(Beam::new(modes, h)?),
            BeamSpec::Cantilever(cantilever) => Mechanics::Beam(Beam::new(&cantilever.modes()?, h)?),
            BeamSpec::Oscillator(spec) => Mechanics::Oscillator(OscillatorStage::new(spec, h)?),
        })
    }

    pub(super) fn order(&self) -> usize {
        match self {
            Mechanics::Beam(beam) => beam.order(),
            Mechanics::Oscillator(_) => OscillatorStage::ORDER,
        }
    }

    /// Tip displacement [m] for the static displacement `l` [m] of the ceramic.
    #[inline]
    pub(super) fn tip(&self, x: &[f64], l: f64) -> f64 {
        match self {
            Mechanics::Beam(beam) => beam.tip(x, l),
            Mechanics::Oscillator(_) => x[0],
        }
    }

    /// The settled state for the static displacement `l` [m].
    pub(super) fn settle(&self, x: &mut [f64], l: f64) {
        match self {
            Mechanics::Beam(beam) => beam.settle(x, l),
            Mechanics::Oscillator(oscillator) => oscillator.settle(x, l),
        }
    }

    /// Advances one step under the static displacement `l` [m].
    #[inline]
    pub(super) fn advance(&self, x: &mut [f64], l: f64) {
        match self {
            Mechanics::Beam(beam) => beam.advance(x, l),
            Mechanics::Oscillator(oscillator) => oscillator.advance(x, l),
        }
    }
}
