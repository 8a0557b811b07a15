//! A model in one line.

use super::Model;
use piezoid_numerics::number::{join, round, short};
use piezoid_numerics::system::System;

/// Operator, gain, modes, creep and sampling period: what an engineer checks first.
///
/// ```
/// use piezoid::{Model, hysteresis::Operator, linear::Arx};
/// let block = Arx::new(5e-4, vec![1.7424, -0.9453], vec![0.0, 3.3, 3.3])?;
/// let model = Model::new((Operator::find("dahl")?.example)(5e-4)?, block, 0.0)?;
/// assert_eq!(model.to_string(), "dahl, gain 32.53 um/V, mode at 146.7 Hz (damping 0.06103), sampled every 5e-4 s");
/// # Ok::<(), piezoid::Error>(())
/// ```
impl std::fmt::Display for Model {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if let Some(feedback) = self.feedback() {
            let modes = &feedback.dynamics().modes;
            let each: Vec<String> =
                modes.iter().map(|m| format!("{} Hz (damping {})", short(m.hz), short(m.damping))).collect();
            let (name, modes) = (feedback.hysteresis().operator().name, join(&each));
            return write!(f, "{name} in feedback with {modes}, sampled every {} s", round(self.ts()));
        }
        let (arx, units) = (self.linear(), self.units());
        write!(f, "{}, gain {} {}/{}", self.hysteresis().operator().name, short(arx.dc_gain()), units.y, units.u)?;
        let modes = arx.modal_form().modes();
        let each: Vec<String> =
            modes.iter().map(|m| format!("{} Hz (damping {})", short(m.pole.hz), short(m.pole.damping))).collect();
        match each.len() {
            0 => {}
            1 => write!(f, ", mode at {}", each[0])?,
            _ => write!(f, ", modes at {}", join(&each))?,
        }
        let creep: f64 = self.creep().lags().iter().map(|lag| lag.gain).sum();
        if creep != 0.0 {
            write!(f, ", creep {} %", short(100.0 * creep))?;
        }
        write!(f, ", sampled every {} s", round(self.ts()))
    }
}
