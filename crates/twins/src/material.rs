//! The ceramic: from voltage to static displacement, by one of two laws.

use super::bouc_wen::BoucWenStage;
use super::preisach::PreisachStage;
use super::spec::HysteresisSpec;
use piezoid_numerics::error::Error;

/// A rate-independent law; its file describes its state.
#[derive(Debug, Clone)]
pub(super) enum Material {
    BoucWen(BoucWenStage),
    Preisach(PreisachStage),
}

impl Material {
    pub(crate) fn new(spec: &HysteresisSpec) -> Result<Self, Error> {
        Ok(match *spec {
            HysteresisSpec::BoucWen { range_v, displacement_m, width, beta_per_v, gamma_per_v } => {
                Material::BoucWen(BoucWenStage::new(range_v, displacement_m, width, beta_per_v, gamma_per_v)?)
            }
            HysteresisSpec::Preisach { range_v, displacement_m, width, half_width_v, asymmetry } => {
                Material::Preisach(PreisachStage::new(range_v, displacement_m, width, half_width_v, asymmetry)?)
            }
        })
    }

    pub(super) fn order(&self) -> usize {
        match self {
            Material::BoucWen(_) => BoucWenStage::ORDER,
            Material::Preisach(_) => PreisachStage::ORDER,
        }
    }

    /// Moves to the voltage `u` [V] and returns the static displacement [m].
    #[inline]
    pub(super) fn displacement(&self, x: &mut [f64], u: f64) -> f64 {
        match self {
            Material::BoucWen(law) => law.displacement(x, u),
            Material::Preisach(law) => law.displacement(x, u),
        }
    }
}
