//! Random plants around a nominal one: each parameter differs by up to a share of its nominal value.

use crate::spec::{BeamSpec, HysteresisSpec, Spec};
use piezoid_numerics::error::Error;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;

impl Spec {
    /// Plant `i` of those drawn with `seed` around this one. Its parameters differ by up to `share` of their values.
    ///
    /// ```
    /// let bender = piezoid::plant::Preset::find("pl140")?.spec();
    /// let [one, other] = [0, 1].map(|i| bender.drawn(0.2, 7, i));
    /// assert_ne!(one?, other?);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// Returns an error for a share outside 0 to below 1.
    pub fn drawn(&self, share: f64, seed: u64, i: u64) -> Result<Spec, Error> {
        if !(0.0..1.0).contains(&share) {
            return Err(Error::parameter("share", share, "must be from 0 to below 1"));
        }
        let mut random = ChaCha8Rng::seed_from_u64(seed);
        random.set_stream(i);
        let mut about = |value: &mut f64| *value *= 1.0 + share * (2.0 * random.random::<f64>() - 1.0);
        let mut spec = self.clone();
        match &mut spec.beam {
            BeamSpec::Cantilever(beam) => {
                about(&mut beam.youngs_modulus_pa);
                about(&mut beam.density_kg_per_m3);
                beam.damping.iter_mut().for_each(&mut about);
            }
            BeamSpec::Modes(modes) => {
                let (mut stiffness, mut mass) = (1.0, 1.0);
                about(&mut stiffness);
                about(&mut mass);
                for mode in modes {
                    mode.frequency_hz *= f64::sqrt(stiffness / mass);
                    about(&mut mode.damping);
                }
            }
            BeamSpec::Oscillator(oscillator) => {
                about(&mut oscillator.mass_kg);
                about(&mut oscillator.damping_kg_per_s);
                about(&mut oscillator.stiffness_n_per_m);
                about(&mut oscillator.alpha_n_per_m);
            }
        }
        match &mut spec.hysteresis {
            HysteresisSpec::BoucWen { displacement_m, width, .. }
            | HysteresisSpec::Preisach { displacement_m, width, .. } => {
                about(displacement_m);
                about(width);
            }
            HysteresisSpec::Linear { displacement_m, .. } => about(displacement_m),
        }
        about(&mut spec.creep_per_decade);
        about(&mut spec.driver.capacitance_f);
        about(&mut spec.driver.lag_s);
        Ok(spec)
    }
}
