//! The modal form of a block: its modes, their shares of the static displacement, and the feed-through.
//!
//! ```text
//! B(q) / A(q) = q^-d (sum_i rho_i / (1 - z_i q^-1) + ...),   z = exp(s Ts),   s = w (-zeta + i sqrt(1 - zeta^2))
//! held mode of share 1:  rho = q^-1 R (z - 1) / s,   R = w / (2 i sqrt(1 - zeta^2))
//! ```
//! The second line is exact for a mass on a spring under a held input (zero-order hold). The share of a mode is the
//! magnitude of its rho over that of the second line, with the sign of their quotient; it does not depend on the delay,
//! apart from the small decay within it. The share of a real pole is what it adds to the DC gain. The rest of the DC
//! gain is feed-through: static, or too fast to be observed. The delay is the phase at low frequency beyond half a
//! sample of the hold and the lags of the poles, 2 zeta / w per mode:
//!
//! ```text
//! tau = -d arg G / dw (w = 0) - Ts / 2 - sum_i share_i 2 zeta_i / w_i
//! ```
//! The poles must differ from each other. Poles at half the sampling rate and above are reported as images, not modes.
//! Poles that only reduce the residual are also interpreted as mechanics and distort feed-through and delay:
//! [`fit_modes`](super::fit_modes) fits the same quantities to records, with their uncertainty.
//!
//! Åström & Wittenmark 1997, Computer-Controlled Systems, 2.3; Meirovitch 2001, Fundamentals of Vibrations.

use super::{Arx, Pole, Root};
use nalgebra::Complex;
use piezoid_numerics::complex::{self, modulus};
use piezoid_numerics::number::{join, round, short};
use piezoid_numerics::system::System;
use serde::Serialize;
use std::f64::consts::{PI, TAU};

/// The mechanical meaning of a pole or a conjugate pair.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum PoleKind {
    /// An oscillation: a mass on a spring.
    Mode,
    /// No oscillation: a lag of an amplifier or a filter.
    Lag,
    /// A pole at half the sampling rate or above: the image of a delay or of faster modes, not at their frequency.
    Image,
}

/// A pole or a conjugate pair, with its share of the output.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PoleShare {
    /// The pole.
    pub pole: Pole,
    /// Share of the static displacement, from 0 to 1.
    pub share: f64,
}

impl PoleShare {
    /// Its mechanical meaning.
    pub fn kind(&self) -> PoleKind {
        let z = self.pole.z;
        // |s| Ts, which is pi at half the sampling rate.
        let angle = modulus(complex::log(Complex::new(z.re, z.im)));
        match () {
            () if angle >= ModalForm::MAX_OBSERVABLE_NYQUIST_SHARE * PI => PoleKind::Image,
            () if z.im > 0.0 => PoleKind::Mode,
            () => PoleKind::Lag,
        }
    }

    /// The mode as an oscillator of this stiffness [N/m] at the point where the displacement is measured. `None` if the
    /// pole is not a mode, or not damped, or the stiffness is not a positive number.
    pub fn oscillator(&self, stiffness: f64) -> Option<Oscillator> {
        let Pole { hz, damping, .. } = self.pole;
        let w = TAU * hz;
        let is_stiff = stiffness > 0.0 && stiffness.is_finite();
        (self.kind() == PoleKind::Mode && damping >= 0.0 && is_stiff)
            .then(|| Oscillator { mass: stiffness / (w * w), damper: 2.0 * damping * stiffness / w })
    }
}

/// The modal form of a block.
#[derive(Debug, Clone, PartialEq)]
pub struct ModalForm {
    /// Output for a constant input of 1 [output unit over input unit].
    pub gain: f64,
    /// The poles with their shares, by rising frequency.
    pub poles: Vec<PoleShare>,
    /// Share of the feed-through.
    pub feed_through: f64,
    /// Input delay [s], from the phase at low frequency; negative if an output was logged after its input acted.
    pub delay: f64,
}

impl ModalForm {
    /// Highest observable frequency of a pole, as a share of half the sampling rate.
    pub const MAX_OBSERVABLE_NYQUIST_SHARE: f64 = 0.9;

    /// The poles that are modes, by rising frequency.
    pub fn modes(&self) -> Vec<PoleShare> {
        self.poles.iter().filter(|p| p.kind() == PoleKind::Mode).copied().collect()
    }

    /// The modal form as a table: one row per mode and per lag, one for all images, the last for the feed-through. Its
    /// columns: meaning, natural frequency [Hz], damping ratio, share of the static displacement [%], and for a mode on
    /// a spring of 1 N/mm the mass [g] and the damper [N s/m], which are proportional to the stiffness.
    ///
    /// ```
    /// let table2 = piezoid::linear::Arx::new(5e-4, vec![1.7424, -0.9453], vec![0.0012, -0.0004, -0.0003])?;
    /// assert_eq!(table2.modal_form().rows()[0][..4], ["mode 1", "146.7", "0.06103", "156.6"]);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    pub fn rows(&self) -> Vec<[String; 6]> {
        let none = || "-".to_string();
        // Adding zero turns a rounded -0 into 0.
        let percent = |share: f64| match (1e3 * share).round() / 10.0 + 0.0 {
            share if share.is_finite() => format!("{share:.1}"),
            _ => none(),
        };
        let mut modes = 0;
        let observed = self.poles.iter().filter(|p| p.kind() != PoleKind::Image).map(|p| {
            let Pole { hz, damping, .. } = p.pole;
            if p.kind() == PoleKind::Lag {
                let lag = format!("lag of {} s", round(1.0 / (TAU * hz)));
                return [lag, none(), none(), percent(p.share), none(), none()];
            }
            modes += 1;
            let spring = p.oscillator(1e3);
            let of = |number: fn(Oscillator) -> f64| spring.map_or_else(none, |spring| short(number(spring)));
            let [mass, damper] = [of(|o| 1e3 * o.mass), of(|o| o.damper)];
            [format!("mode {modes}"), short(hz), short(damping), percent(p.share), mass, damper]
        });
        let mut rows: Vec<[String; 6]> = observed.collect();
        let rest = |what: &str, share| [what.to_string(), none(), none(), percent(share), none(), none()];
        let images: Vec<f64> = self.poles.iter().filter(|p| p.kind() == PoleKind::Image).map(|p| p.share).collect();
        if !images.is_empty() {
            rows.push(rest("poles above 0.9 of half the sampling rate", images.iter().sum()));
        }
        rows.push(rest("feed-through", self.feed_through));
        rows
    }

    /// A sentence about its images; `None` if it has none.
    pub fn images(&self) -> Option<String> {
        let images: Vec<String> =
            self.poles.iter().filter(|p| p.kind() == PoleKind::Image).map(|p| round(p.pole.hz)).collect();
        let (poles, are) = match images.len() {
            0 => return None,
            1 => ("pole", "is an image"),
            _ => ("poles", "are images"),
        };
        let listed = join(&images);
        Some(format!(
            "The {poles} at {listed} Hz, near half the sampling rate or above, {are} of delay or of faster modes: \
             there may be no mode at that frequency."
        ))
    }
}

/// A mode as a mass on a spring with a damper.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Oscillator {
    /// Moving mass [kg].
    pub mass: f64,
    /// Damping constant [N s/m].
    pub damper: f64,
}

impl Arx {
    /// The modal form of the block.
    ///
    /// ```
    /// let table2 = piezoid::linear::Arx::new(5e-4, vec![1.7424, -0.9453], vec![0.0012, -0.0004, -0.0003])?;
    /// let mode = &table2.modal_form().poles[0];
    /// assert!((mode.pole.hz - 146.7).abs() < 0.1);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    pub fn modal_form(&self) -> ModalForm {
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
        ModalForm {
            gain,
            feed_through: 1.0 - poles.iter().map(|p| p.share).sum::<f64>(),
            delay: self.lag_at_rest() - 0.5 * self.ts() - poles.iter().map(lag).sum::<f64>(),
            poles,
        }
    }

    /// The contribution of a pole to the DC gain; `all` are the poles of the block with their conjugates.
    fn carried(&self, pole: &Pole, all: &[Complex<f64>]) -> f64 {
        let z = Complex::new(pole.z.re, pole.z.im);
        let numerator = self.b()[self.delay()..].iter().rev().fold(Complex::new(0.0, 0.0), |sum, &b| sum / z + b);
        let others =
            all.iter().filter(|&&other| other != z).fold(Complex::new(1.0, 0.0), |p, other| p * (1.0 - other / z));
        let rho = numerator / others;
        if pole.z.im == 0.0 {
            return (rho / (1.0 - z)).re;
        }
        let s = complex::log(z) / self.ts();
        let unit = s.norm_sqr() / Complex::new(0.0, 2.0 * s.im) * (z - 1.0) / s;
        (rho / unit).re.signum() * modulus(rho) / modulus(unit)
    }

    /// -d arg G / dw at w = 0 [s].
    fn lag_at_rest(&self) -> f64 {
        let centre = |c: &[f64], first: f64| c.iter().zip(0..).map(|(c, k)| (first + f64::from(k)) * c).sum::<f64>();
        let (b, still) = (self.b().iter().sum::<f64>(), 1.0 - self.a().iter().sum::<f64>());
        self.ts() * (centre(self.b(), 0.0) / b + centre(self.a(), 1.0) / still)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::linear::modal_error::tests::held;
    use piezoid_testing::assert_close;

    #[test]
    fn modes_under_a_held_input_are_found_with_their_shares_and_delay() {
        for delay in [-5e-4, 0.0, 5e-4, 1.5e-3] {
            let arx = held(&[(166.3, 0.03, 27.0), (700.0, 0.1, 2.0)], 1.0, delay);
            let form = arx.modal_form();
            let [first, second] = [&form.poles[0], &form.poles[1]];
            assert_close(&[first.pole.hz, first.pole.damping, first.share], &[166.3, 0.03, 0.9], 1e-9, 0.0);
            assert_close(&[second.pole.hz, second.pole.damping], &[700.0, 0.1], 1e-9, 0.0);
            assert_close(&[second.share, form.feed_through], &[2.0 / 30.0, 1.0 / 30.0], 1e-8, 0.0);
            // The feed-through has no hold: half a sample less, on its share.
            assert_close(&[form.gain], &[30.0], 1e-9, 0.0);
            assert_close(&[form.delay], &[delay], 0.0, 2e-5);
        }
    }

    #[test]
    fn a_delay_within_a_sample_hardly_changes_the_shares() {
        let form = held(&[(166.3, 0.03, 27.0)], 3.0, 2e-4).modal_form();
        assert_close(&[form.poles[0].share, form.feed_through], &[0.9, 0.1], 0.0, 0.006);
        assert_close(&[form.delay], &[2e-4], 0.0, 5e-5);
    }

    #[test]
    fn the_share_of_a_first_order_lag_is_its_gain() {
        let z = (-5e-4f64 / 0.02).exp();
        let form = Arx::new(5e-4, vec![z], vec![0.0, 5.0 * (1.0 - z)]).unwrap().modal_form();
        assert_close(&[form.gain, form.poles[0].share], &[5.0, 1.0], 1e-12, 0.0);
        assert_close(&[form.delay], &[0.0], 0.0, 2e-6);
    }

    #[test]
    fn the_shares_of_a_table_add_up_to_100_percent_and_its_numbers_are_those_of_the_oscillator() {
        let rows = held(&[(166.3, 0.03, 27.0), (700.0, 0.1, 2.0)], 1.0, 0.0).modal_form().rows();
        let share = |row: &[String; 6]| row[3].parse::<f64>().unwrap();
        assert_close(&[rows.iter().map(share).sum()], &[100.0], 0.0, 0.1 + 1e-9);
        assert_eq!(rows[0], ["mode 1", "166.3", "0.03000", "90.0", "0.9159", "0.05742"]);
        assert_eq!((rows[1][0].as_str(), rows.len(), rows[2][0].as_str()), ("mode 2", 3, "feed-through"));
    }

    #[test]
    fn images_of_fast_modes_and_poles_of_a_delay_are_not_modes() {
        let beyond = held(&[(166.3, 0.03, 27.0), (1042.0, 0.03, 2.0)], 1.0, 0.0).modal_form();
        assert_eq!(beyond.poles.iter().map(PoleShare::kind).collect::<Vec<_>>(), [PoleKind::Mode, PoleKind::Image]);
        assert!(beyond.rows()[1][0] == "poles above 0.9 of half the sampling rate" && beyond.rows()[1][1] == "-");
        assert!(beyond.images().unwrap().starts_with("The pole at 959 Hz"), "{:?}", beyond.images());
        assert!(beyond.modes().len() == 1 && beyond.poles[1].oscillator(1.0).is_none());
        let alternating = Arx::new(5e-4, vec![-0.6], vec![1.0, 0.6]).unwrap().modal_form();
        assert_eq!(alternating.poles[0].kind(), PoleKind::Image);
        let lag = Arx::new(5e-4, vec![(-5e-4f64 / 0.02).exp()], vec![0.0, 1.0]).unwrap().modal_form();
        assert_eq!((lag.rows()[0][0].as_str(), lag.images()), ("lag of 0.02 s", None));
    }

    #[test]
    fn mass_and_damper_follow_from_the_stiffness() {
        let mode = |hz, damping| held(&[(hz, damping, 27.0)], 0.0, 0.0).modal_form().poles[0];
        // The PL140 at 500 N/m: 0.46 g move, of the 1.9 g that the free part weighs.
        assert_close(&[1e3 * mode(166.3, 0.03).oscillator(500.0).unwrap().mass], &[0.458], 1e-3, 0.0);
        let held = mode(100.0, 0.1);
        let unit = held.oscillator(1.0).unwrap();
        assert_close(&[unit.damper / (2.0 * unit.mass.sqrt())], &[held.pole.damping], 1e-12, 0.0);
        assert_close(&[held.pole.damping], &[0.1], 1e-9, 0.0);
        assert!([0.0, -1.0, f64::NAN, f64::INFINITY].iter().all(|stiffness| held.oscillator(*stiffness).is_none()));
    }
}
