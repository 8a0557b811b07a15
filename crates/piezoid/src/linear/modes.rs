//! The physical reading of a block: its modes, what each carries of the static displacement, what follows at once.
//!
//! ```text
//! B(q) / A(q) = q^-d (sum_i rho_i / (1 - z_i q^-1) + ...),   z = exp(s Ts),   s = w (-zeta + i sqrt(1 - zeta^2))
//! held mode of share 1:  rho = q^-1 R (z - 1) / s,   R = w / (2 i sqrt(1 - zeta^2))
//! ```
//! A held input drives a mass on a spring into the second line exactly (zero-order hold). The share of a mode is the size
//! of its rho over that of the second line, so it does not depend on the delay, but for the little that the mode decays
//! within it; its sign is that of their quotient. A real pole carries what it adds to the DC gain. What the shares leave of
//! the DC gain follows at once: static, or too fast to be seen. The delay is what the phase at low frequency has beyond the
//! hold's half sample and the lags of the poles, 2 zeta / w a mode:
//!
//! ```text
//! tau = -d arg G / dw (w = 0) - Ts / 2 - sum_i share_i 2 zeta_i / w_i
//! ```
//! For blocks whose poles differ from each other. Poles that only mop up what the order leaves are read as mechanics too, and
//! spoil residual and delay: [`fit_modes`](super::fit_modes) fits the same numbers to records, with their uncertainty.
//!
//! Åström & Wittenmark 1997, Computer-Controlled Systems, 2.3; Meirovitch 2001, Fundamentals of Vibrations.

use super::{Arx, Pole, Root};
use crate::error::{Error, positive};
use nalgebra::Complex;
use std::f64::consts::TAU;

/// What a pole, or a conjugate pair, is to the output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoleShare {
    /// The pole: one that oscillates is a mode.
    pub pole: Pole,
    /// What it carries of the static displacement, 1 being all.
    pub share: f64,
}

/// A block read as mechanics.
#[derive(Debug, Clone, PartialEq)]
pub struct Reading {
    /// Output for a constant input of 1.
    pub gain: f64,
    /// The poles with their shares, by rising frequency.
    pub poles: Vec<PoleShare>,
    /// The share that follows the input at once.
    pub residual: f64,
    /// Input delay [s], by the phase at low frequency; negative where an output was logged after its input acted.
    pub delay: f64,
}

/// A mode as a mass on a spring with a damper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Oscillator {
    /// Moving mass [kg].
    pub mass: f64,
    /// Damping constant [N s/m].
    pub damper: f64,
    /// Stiffness [N/m].
    pub stiffness: f64,
}

impl Oscillator {
    /// The oscillator of `stiffness` [N/m] at the point where the displacement is measured that has this natural
    /// frequency [Hz] and damping ratio. A stiffness of 1 gives mass and damper per unit of stiffness.
    ///
    /// ```
    /// // The PL140 at 500 N/m: 0.46 g move, of the 1.9 g that the free part weighs.
    /// let bender = piezoid::linear::Oscillator::new(166.3, 0.03, 500.0)?;
    /// assert!((1e3 * bender.mass - 0.458).abs() < 1e-3);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// Refused unless frequency and stiffness are positive, and the damping is not negative.
    pub fn new(hz: f64, damping: f64, stiffness: f64) -> Result<Self, Error> {
        let w = TAU * positive("frequency", hz, "hertz")?;
        let stiffness = positive("stiffness", stiffness, "newtons a metre")?;
        if !(damping >= 0.0 && damping.is_finite()) {
            return Err(Error::parameter("damping", damping, "must be a damping ratio, not negative"));
        }
        Ok(Oscillator { mass: stiffness / (w * w), damper: 2.0 * damping * stiffness / w, stiffness })
    }
}

impl Arx {
    /// The block read as mechanics.
    ///
    /// ```
    /// let table2 = piezoid::linear::Arx::new(5e-4, vec![1.7424, -0.9453], vec![0.0012, -0.0004, -0.0003])?;
    /// let mode = &table2.reading().poles[0];
    /// assert!((mode.pole.hz - 146.7).abs() < 0.1);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    pub fn reading(&self) -> Reading {
        let (gain, poles) = (self.dc_gain(), self.poles());
        let all: Vec<Complex<f64>> = poles
            .iter()
            .flat_map(|p| [Some(p.z), (p.z.im != 0.0).then_some(Root { im: -p.z.im, ..p.z })])
            .flatten()
            .map(|z| Complex::new(z.re, z.im))
            .collect();
        let shares = poles.iter().map(|&pole| PoleShare { pole, share: self.carried(&pole, &all) / gain });
        let poles: Vec<PoleShare> = shares.collect();
        let lag = |p: &PoleShare| match p.pole {
            Pole { z, .. } if z.im == 0.0 && z.re < 0.0 => 0.0,
            Pole { z, hz, .. } if z.im == 0.0 => p.share / (TAU * hz),
            Pole { hz, damping, .. } => p.share * 2.0 * damping / (TAU * hz),
        };
        Reading {
            gain,
            residual: 1.0 - poles.iter().map(|p| p.share).sum::<f64>(),
            delay: self.lag_at_rest() - 0.5 * self.time_step() - poles.iter().map(lag).sum::<f64>(),
            poles,
        }
    }

    /// What a pole adds to the DC gain, `all` being the poles of the block with their conjugates.
    fn carried(&self, pole: &Pole, all: &[Complex<f64>]) -> f64 {
        let z = Complex::new(pole.z.re, pole.z.im);
        let numerator = self.b()[self.delay()..].iter().rev().fold(Complex::new(0.0, 0.0), |sum, &b| sum / z + b);
        let others =
            all.iter().filter(|&&other| other != z).fold(Complex::new(1.0, 0.0), |p, other| p * (1.0 - other / z));
        let rho = numerator / others;
        if pole.z.im == 0.0 {
            return (rho / (1.0 - z)).re;
        }
        let s = z.ln() / self.time_step();
        let unit = s.norm_sqr() / Complex::new(0.0, 2.0 * s.im) * (z - 1.0) / s;
        (rho / unit).re.signum() * rho.norm() / unit.norm()
    }

    /// -d arg G / dw at w = 0 [s].
    fn lag_at_rest(&self) -> f64 {
        let centre = |c: &[f64], first: f64| c.iter().zip(0..).map(|(c, k)| (first + f64::from(k)) * c).sum::<f64>();
        let (b, still) = (self.b().iter().sum::<f64>(), 1.0 - self.a().iter().sum::<f64>());
        self.time_step() * (centre(self.b(), 0.0) / b + centre(self.a(), 1.0) / still)
    }

    fn time_step(&self) -> f64 {
        crate::system::System::ts(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear::modal_error::tests::held;
    use crate::testing::assert_close;

    #[test]
    fn held_modes_are_read_back_with_their_shares_and_their_delay() {
        for delay in [-5e-4, 0.0, 5e-4, 1.5e-3] {
            let arx = held(&[(166.3, 0.03, 27.0), (700.0, 0.1, 2.0)], 1.0, delay);
            let reading = arx.reading();
            let [first, second] = [&reading.poles[0], &reading.poles[1]];
            assert_close(&[first.pole.hz, first.pole.damping, first.share], &[166.3, 0.03, 0.9], 1e-9, 0.0);
            assert_close(&[second.pole.hz, second.pole.damping], &[700.0, 0.1], 1e-9, 0.0);
            assert_close(&[second.share, reading.residual], &[2.0 / 30.0, 1.0 / 30.0], 1e-8, 0.0);
            // The static residual waits for no hold: half a sample less, on its share.
            assert_close(&[reading.gain], &[30.0], 1e-9, 0.0);
            assert_close(&[reading.delay], &[delay], 0.0, 2e-5);
        }
    }

    #[test]
    fn a_delay_within_a_sample_hardly_changes_the_shares() {
        let reading = held(&[(166.3, 0.03, 27.0)], 3.0, 2e-4).reading();
        assert_close(&[reading.poles[0].share, reading.residual], &[0.9, 0.1], 0.0, 0.006);
        assert_close(&[reading.delay], &[2e-4], 0.0, 5e-5);
    }

    #[test]
    fn a_lag_of_first_order_carries_what_it_adds_to_the_gain() {
        let z = (-5e-4f64 / 0.02).exp();
        let reading = Arx::new(5e-4, vec![z], vec![0.0, 5.0 * (1.0 - z)]).unwrap().reading();
        assert_close(&[reading.gain, reading.poles[0].share], &[5.0, 1.0], 1e-12, 0.0);
        assert_close(&[reading.delay], &[0.0], 0.0, 2e-6);
    }

    #[test]
    fn a_spring_without_stiffness_is_refused() {
        assert!(Oscillator::new(100.0, 0.1, 0.0).unwrap_err().to_string().starts_with("stiffness = 0"));
        let unit = Oscillator::new(100.0, 0.1, 1.0).unwrap();
        assert_close(&[unit.damper / (2.0 * unit.mass.sqrt())], &[0.1], 1e-12, 0.0);
    }
}
