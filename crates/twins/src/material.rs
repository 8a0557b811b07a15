//! The ceramic: from voltage to static displacement, by one of two laws or in proportion.

use super::bouc_wen::BoucWenStage;
use super::preisach::PreisachStage;
use super::spec::HysteresisSpec;
use piezoid_numerics::error::{Error, positive};

/// A rate-independent law; its file describes its state.
#[derive(Debug, Clone)]
pub(super) enum Material {
    BoucWen(BoucWenStage),
    Preisach(PreisachStage),
    /// Displacement per volt [m/V].
    Linear(f64),
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
            HysteresisSpec::Linear { range_v, displacement_m } => Material::Linear(
                positive("hysteresis.displacement_m", displacement_m, "metres")?
                    / positive("hysteresis.range_v", range_v, "volts")?,
            ),
        })
    }

    pub(super) fn order(&self) -> usize {
        match self {
            Material::BoucWen(_) => BoucWenStage::ORDER,
            Material::Preisach(_) => PreisachStage::ORDER,
            Material::Linear(_) => 0,
        }
    }

    /// Moves to the voltage `u` [V] and returns the static displacement [m].
    #[inline]
    pub(super) fn displacement(&self, x: &mut [f64], u: f64) -> f64 {
        match self {
            Material::BoucWen(law) => law.displacement(x, u),
            Material::Preisach(law) => law.displacement(x, u),
            Material::Linear(per_volt) => per_volt * u,
        }
    }
}
