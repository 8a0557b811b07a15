//! The specification of a plant: every parameter of every stage, as a JSON document.
//!
//! Numbers are in SI units; the name of a field ends with its unit. The voltages of a bender are relative to the middle
//! of its supply: driven from 0 to 60 V, it has -30 to 30 V here. Other actuators have the voltages of their data
//! sheets; at rest they are at 0 V. The stages check the values.

use piezoid_numerics::error::Error;
use serde::{Deserialize, Serialize};

/// A plant: driver -> hysteresis -> creep -> beam -> sensor.
///
/// ```
/// use piezoid::plant::{Plant, Spec, Preset};
///
/// let text = Preset::find("pl140")?.spec().to_json()?; // a starting point for a bender of your own
/// let plant = Plant::new(&Spec::from_json(&text)?, 5e-4)?;
/// # Ok::<(), piezoid::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spec {
    /// The amplifier; the default is ideal from -30 to 30 V.
    #[serde(default)]
    pub driver: DriverSpec,
    /// The ceramic.
    pub hysteresis: HysteresisSpec,
    /// Voltage in the middle of the major loop: 0 for a bipolar actuator, half the highest voltage for a unipolar one
    /// [V].
    #[serde(default)]
    pub middle_v: f64,
    /// Creep g per decade of time, as a share of the displacement 0.1 s after a step; 0 for none [-].
    #[serde(default)]
    pub creep_per_decade: f64,
    /// Time constant of the fastest of its four lags, one decade apart [s].
    #[serde(default = "creep_from")]
    pub creep_from_s: f64,
    /// Share of the voltage at the ceramic that the strain of a vibration takes away, by the direct piezoelectric
    /// effect; 0 for none [-].
    #[serde(default)]
    pub coupling: f64,
    /// The mechanics.
    pub beam: BeamSpec,
    /// The sensor; the default is ideal.
    #[serde(default)]
    pub sensor: SensorSpec,
    /// Time at which y is logged.
    #[serde(default)]
    pub logged: Logged,
    /// Inner integration steps per sample.
    #[serde(default = "inner_steps")]
    pub inner_steps: usize,
}

/// The amplifier. The capacitance is used only if the current is limited.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct DriverSpec {
    /// Lowest voltage, at most 0 [V].
    pub min_v: f64,
    /// Highest voltage, at least 0 [V].
    pub max_v: f64,
    /// Time constant of the amplifier; 0 is ideal [s].
    pub lag_s: f64,
    /// Peak current; `None` (`null`) is unlimited [A].
    pub current_a: Option<f64>,
    /// Capacitance of the load [F].
    pub capacitance_f: f64,
}

impl Default for DriverSpec {
    fn default() -> Self {
        DriverSpec { min_v: -30.0, max_v: 30.0, lag_s: 0.0, current_a: None, capacitance_f: 0.0 }
    }
}

/// The law of the ceramic, set by its major loop between +-`range_v` about its middle: `displacement_m` is half its
/// height, and `width` its width in the middle (in the direction of y) over its height.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum HysteresisSpec {
    /// Low & Guo's law, the standard model of piezo benders.
    BoucWen {
        /// Voltage amplitude of the major loop [V].
        range_v: f64,
        /// Half the height of the major loop [m].
        displacement_m: f64,
        /// Width of the major loop in its middle over its height [-].
        width: f64,
        /// Low & Guo's beta [1/V].
        beta_per_v: f64,
        /// Low & Guo's gamma [1/V].
        gamma_per_v: f64,
    },
    /// A continuous density of relays: asymmetric and with the wiping-out property, like measured ceramics.
    Preisach {
        /// Voltage amplitude of the major loop [V].
        range_v: f64,
        /// Half the height of the major loop [m].
        displacement_m: f64,
        /// Width of the major loop in its middle over its height [-].
        width: f64,
        /// Half-width rho at which the density of relays is 1/e of its maximum [V].
        half_width_v: f64,
        /// Asymmetry c: relative to zero, the density is 1 + c at +range and 1 - c at -range [-].
        asymmetry: f64,
    },
    /// A displacement in proportion to the voltage, without hysteresis.
    Linear {
        /// A voltage [V].
        range_v: f64,
        /// The displacement at this voltage [m].
        displacement_m: f64,
    },
}

/// The mechanics: vibration modes, given or from geometry.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum BeamSpec {
    /// The modes; without any, the actuator has no dynamics.
    Modes(Vec<BeamMode>),
    /// The modes of a uniform cantilever.
    Cantilever(Cantilever),
    /// One mode with a hysteretic force that its displacement drives.
    Oscillator(Oscillator),
}

/// m y'' + c y' + k y + z = f,  z' = alpha y' - beta (gamma |y'| z + delta y' |z|), and f is k + alpha
/// times the static displacement of the ceramic.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Oscillator {
    /// m [kg].
    pub mass_kg: f64,
    /// c [kg/s].
    pub damping_kg_per_s: f64,
    /// k [N/m].
    pub stiffness_n_per_m: f64,
    /// alpha [N/m].
    pub alpha_n_per_m: f64,
    /// beta [1/m].
    pub beta: f64,
    /// gamma [-].
    pub gamma: f64,
    /// delta [-].
    pub delta: f64,
}

/// A vibration mode at the tip.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BeamMode {
    /// Undamped natural frequency [Hz].
    pub frequency_hz: f64,
    /// Damping ratio, between 0 and 1 [-].
    pub damping: f64,
    /// Share of the static displacement; the rest to 1 has no dynamics [-].
    pub(crate) share: f64,
    /// s: its stiffness is divided by 1 + s e at a distance e from the static displacement; 0 if it is linear [1/m].
    #[serde(default)]
    pub(crate) softening_per_m: f64,
}

/// A uniform cantilever, bent along its whole free length by the piezo moment.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Cantilever {
    /// Free length [m].
    pub(crate) length_m: f64,
    /// Thickness [m].
    pub(crate) thickness_m: f64,
    /// Young's modulus [Pa].
    pub(crate) youngs_modulus_pa: f64,
    /// Density [kg/m^3].
    pub(crate) density_kg_per_m3: f64,
    /// Damping ratio of each mode, which also sets the number of modes [-].
    pub damping: Vec<f64>,
}

/// The displacement sensor and its converter.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SensorSpec {
    /// Time constant; 0 is ideal [s].
    pub lag_s: f64,
    /// White noise per sample, rms [m].
    pub noise_rms_m: f64,
    /// c of y + c y^2 / range, the curve of the readings; 0 if it is straight. It needs a range [-].
    pub(crate) curvature: f64,
    /// Range of the readings, +- this; `None` (`null`) is unlimited [m].
    pub(crate) range_m: Option<f64>,
    /// Bits of the converter over the range; `None` (`null`) is no quantisation.
    pub(crate) bits: Option<u32>,
    /// Reading at rest, added after clipping to the range: a position sensor may have any zero [m].
    pub zero_m: f64,
}

/// Time at which a sample of y is logged, in the interval of its u.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Logged {
    /// At the start, just before u acts.
    #[default]
    Before,
    /// At the end, after u has acted for one sampling period.
    After,
}

impl Spec {
    /// Range of the sensor, +- this; `None` if unlimited [m].
    pub fn sensor_range(&self) -> Option<f64> {
        self.sensor.range_m
    }

    /// Reads a specification.
    ///
    /// # Errors
    /// Returns an error, with its line, if the text is not JSON, lacks a field or has an unknown one. Values are
    /// checked when the plant is built.
    pub fn from_json(text: &str) -> Result<Self, Error> {
        serde_json::from_str(text).map_err(|e| {
            let message = e.to_string();
            let problem = message.split(" at line ").next().unwrap_or_default();
            Error::Line {
                line: e.line().max(1) as u64,
                column: Some(e.column().to_string()),
                problem: format!("{problem}; start from the parameters of a listed plant, such as pl140"),
            }
        })
    }

    /// Writes the specification, one field per line.
    ///
    /// # Errors
    /// None for a valid specification.
    pub fn to_json(&self) -> Result<String, Error> {
        serde_json::to_string_pretty(self).map_err(|e| Error::Content(format!("the plant cannot be written: {e}")))
    }
}

fn inner_steps() -> usize {
    20
}

fn creep_from() -> f64 {
    0.1
}

impl HysteresisSpec {
    /// Volts per metre of the major loop.
    pub(super) fn volts_per_m(&self) -> f64 {
        self.range_v() / self.displacement_m()
    }

    fn range_v(&self) -> f64 {
        let (HysteresisSpec::BoucWen { range_v, .. }
        | HysteresisSpec::Preisach { range_v, .. }
        | HysteresisSpec::Linear { range_v, .. }) = self;
        *range_v
    }

    /// Half the height of the major loop, or the displacement at the range [m].
    pub(super) fn displacement_m(&self) -> f64 {
        let (HysteresisSpec::BoucWen { displacement_m, .. }
        | HysteresisSpec::Preisach { displacement_m, .. }
        | HysteresisSpec::Linear { displacement_m, .. }) = self;
        *displacement_m
    }
}

/// Returns an error if the rule does not hold.
pub fn require(holds: bool, name: &str, value: f64, rule: &str) -> Result<f64, Error> {
    if holds { Ok(value) } else { Err(Error::parameter(name, value, rule)) }
}

/// Returns an error unless a value is 0 or a positive finite number.
pub fn non_negative(name: &str, value: f64, unit: &str) -> Result<f64, Error> {
    require(value >= 0.0 && value.is_finite(), name, value, &format!("must be 0 or a positive number of {unit}"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn missing_fields_have_their_defaults() {
        let spec = Spec::from_json(
            r#"{"hysteresis": {"bouc_wen": {"range_v": 30, "displacement_m": 1e-3, "width": 0.13, "beta_per_v": 0.02,
                "gamma_per_v": 0.005}}, "beam": {"modes": []}}"#,
        )
        .unwrap();
        assert_eq!((spec.driver, spec.sensor), (DriverSpec::default(), SensorSpec::default()));
        assert_eq!((spec.middle_v, spec.creep_per_decade, spec.creep_from_s, spec.coupling), (0.0, 0.0, 0.1, 0.0));
        assert_eq!((spec.logged, spec.inner_steps), (Logged::Before, 20));
    }

    #[test]
    fn the_error_about_an_unknown_field_has_its_line() {
        let message = |text| Spec::from_json(text).unwrap_err().to_string();
        let unknown = message("{\n\"driver\": {\"lag\": 1e-4},\n\"beam\": {\"modes\": []}}");
        assert!(unknown.starts_with("line 2, column") && unknown.contains("unknown field `lag`"), "{unknown}");
        assert!(message("{\"beam\": {\"modes\": []}}").contains("missing field `hysteresis`"));
        assert!(message("").contains("line 1"));
    }
}
