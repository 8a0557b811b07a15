//! Reference shaping: smoothing, and shapers that do not excite a mode.
//!
//! ```text
//! smooth   minimum jerk over S seconds:  30 s^2 (1 - s)^2, s from 0 to 1, as the weights of a mean
//! ZV       A_0 + A_1 q^-n + A_2 q^-(n+1),  zero at the mode's poles exactly, sum 1
//! ZVD      ZV after ZV: a double zero there, so that a mode at a slightly different frequency rings little
//! notch    (1 - 2 cos(w) q^-1 + q^-2) over the same with its poles inside the circle, gain 1 at 0 Hz
//! ```
//! ZV is two impulses half a damped period apart [Singer & Seering]. Half a period is not an integer number of samples,
//! so the second impulse is split between two. All have gain 1 at 0 Hz. All have a delay; for the FIR filters it is
//! half their length, and [`Fir::whole`] removes it.
//!
//! Reference: N. C. Singer & W. P. Seering, J. Dyn. Syst. Meas. Control 112, 76 (1990), DOI 10.1115/1.2894142; T. Flash
//! & N. Hogan, J. Neurosci. 5, 1688 (1985), DOI 10.1523/JNEUROSCI.05-07-01688.1985 (minimum jerk). They do not do:
//! several modes ([`Fir::then`] puts shapers in series).

use super::Fir;
use libm::{cos, exp, sin, tan};
use piezoid_models::hammerstein::Model;
use piezoid_models::linear::Arx;
use piezoid_numerics::error::{Error, positive};
use piezoid_numerics::options::{OptionKind, OptionRow, options};
use piezoid_numerics::system::System;
use std::f64::consts::{PI, TAU};

options! {
/// Shaping of a reference: smoothing first, then a filter that does not excite the model's resonance.
    #[derive(Copy)]
    pub struct Shaping {
/// Smooth steps and corners to minimum-jerk moves of this duration.
        smooth: Option<f64> = None, OptionRow::positive("s");
/// Filter the reference with a notch at the model's resonance.
        notch: bool = false, OptionRow::new(OptionKind::Switch);
/// Shape the reference (ZVD) so that the resonance is not excited.
        zvd: bool = false, OptionRow::new(OptionKind::Switch);
    }
}

/// Width of that notch as a share of its frequency.
const NOTCH: f64 = 0.2;

impl Shaping {
    /// The shaped reference `r` for `model`.
    ///
    /// # Errors
    /// The errors of [`Fir::smooth`], [`Fir::zvd`] and [`Arx::notch`], and an error if the model has no resonance to
    /// shape for.
    pub fn of(&self, model: &Model, mut r: Vec<f64>) -> Result<Vec<f64>, Error> {
        let ts = model.ts();
        if let Some(seconds) = self.smooth {
            r = Fir::smooth(ts, seconds)?.whole(&r);
        }
        if !self.zvd && !self.notch {
            return Ok(r);
        }
        let none = || {
            let name = if self.zvd { "zvd" } else { "notch" };
            Error::parameter(name, "true", "needs a model with a resonance, and this one has none: leave it out")
        };
        let mode = model.linear().resonance().ok_or_else(none)?;
        if self.zvd {
            r = Fir::zvd(ts, mode.hz, mode.damping)?.whole(&r);
        }
        if let (true, Some(first)) = (self.notch, r.first().copied()) {
            let notch = notch(ts, mode.hz, NOTCH * mode.hz)?;
            r = notch.resume(&mut notch.settled(first), &r);
        }
        Ok(r)
    }
}

/// The longest shaper [samples].
const LONGEST: f64 = 1e5;

impl Fir {
    /// A centred mean over `seconds` with minimum-jerk weights: a step becomes a minimum-jerk move.
    ///
    /// ```
    /// use piezoid_control::compensation::Fir;
    /// let smooth = Fir::smooth(1e-3, 0.01)?;
    /// let moved = smooth.whole(&[vec![0.0; 20], vec![1.0; 20]].concat());
    /// assert!((moved[19] + moved[20] - 1.0).abs() < 1e-12 && moved[0] == 0.0 && moved[39] > 1.0 - 1e-12);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// Returns an error for a `ts` [s] or length that is not positive, and for more than 100000 samples.
    pub fn smooth(ts: f64, seconds: f64) -> Result<Self, Error> {
        positive("ts", ts, "seconds")?;
        positive("smooth", seconds, "seconds")?;
        // An odd length has a middle.
        let half = (0.5 * seconds / ts).round();
        if 2.0 * half >= LONGEST {
            return Err(Error::parameter("smooth", seconds, format!("must be at most {LONGEST} samples of {ts} s")));
        }
        let half = half as usize;
        let bell = |k: usize| {
            let s = (k + 1) as f64 / (2 * half + 2) as f64;
            (s * (1.0 - s)).powi(2)
        };
        let weights: Vec<f64> = (0..=2 * half).map(bell).collect();
        let sum: f64 = weights.iter().sum();
        Fir::new(ts, weights.iter().map(|w| w / sum).collect(), half)
    }

    /// The zero-vibration shaper of a mode of natural frequency `hz` [Hz] and `damping` ratio.
    ///
    /// # Errors
    /// Returns an error for a frequency that is not below half the sampling rate and a damping ratio outside 0 to below
    /// 1.
    pub fn zv(ts: f64, hz: f64, damping: f64) -> Result<Self, Error> {
        let (decay, angle) = mode(ts, hz, damping)?;
        let n = (PI / angle).floor();
        if n > LONGEST {
            return Err(Error::parameter("hz", hz, format!("must have a half period of at most {LONGEST} samples")));
        }
        // A_0 + A_1 p^-n + A_2 p^-(n+1) = 0 at the pole p = exp(-decay + i angle): its imaginary part gives A_1 / A_2.
        let (a, b) = (sin(n * angle) * exp(n * decay), sin((n + 1.0) * angle) * exp((n + 1.0) * decay));
        let (one, two) = (-b, a);
        let real = one * cos(n * angle) * exp(n * decay) + two * cos((n + 1.0) * angle) * exp((n + 1.0) * decay);
        let sum = one + two - real;
        let mut taps = vec![0.0; n as usize + 2];
        taps[0] += -real / sum;
        taps[n as usize] += one / sum;
        taps[n as usize + 1] += two / sum;
        Fir::new(ts, taps, (n as usize).div_ceil(2))
    }

    /// The zero-vibration-and-derivative shaper of a mode: longer, and more robust to its frequency.
    ///
    /// # Errors
    /// The errors of [`Fir::zv`].
    pub fn zvd(ts: f64, hz: f64, damping: f64) -> Result<Self, Error> {
        let zv = Fir::zv(ts, hz, damping)?;
        zv.then(&zv)
    }
}

/// A notch at `hz` [Hz] that is `width` [Hz] wide between its points of -3 dB.
///
/// # Errors
/// Returns an error for frequencies that are not positive or not below half the sampling rate.
pub fn notch(ts: f64, hz: f64, width: f64) -> Result<Arx, Error> {
    let (_, angle) = mode(ts, hz, 0.0)?;
    positive("width", width, "hertz")?;
    // The bilinear notch: the tangent of half the width gives the poles.
    let t = tan((PI * width * ts).min(0.49 * PI));
    let (c, k) = (cos(angle), 1.0 / (1.0 + t));
    Arx::new(ts, vec![2.0 * c * k, -(1.0 - t) * k], vec![k, -2.0 * c * k, k])
}

/// Decay and angle [rad] of a mode per sample.
fn mode(ts: f64, hz: f64, damping: f64) -> Result<(f64, f64), Error> {
    positive("ts", ts, "seconds")?;
    positive("hz", hz, "hertz")?;
    if hz >= 0.5 / ts {
        let rule = format!("must be below {} Hz, half the sampling rate", 0.5 / ts);
        return Err(Error::parameter("hz", hz, rule));
    }
    if !(0.0..1.0).contains(&damping) {
        return Err(Error::parameter("damping", damping, "must be from 0 to below 1"));
    }
    let w = TAU * hz * ts;
    Ok((w * damping, w * (1.0 - damping * damping).sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_models::hysteresis::Proportional;
    use piezoid_numerics::system::System;
    use piezoid_testing::assert_close;
    use std::sync::Arc;

    const TS: f64 = 5e-4;

    /// A mode of gain 1.
    fn oscillator(hz: f64, damping: f64) -> Arx {
        let (decay, angle) = mode(TS, hz, damping).unwrap();
        let a = vec![2.0 * (-decay).exp() * angle.cos(), -(-2.0 * decay).exp()];
        let b = 1.0 - a.iter().sum::<f64>();
        Arx::new(TS, a, vec![b]).unwrap()
    }

    /// Largest deviation from 1 after a shaped step.
    fn rings(shaper: &Fir, mode: &Arx) -> f64 {
        let y = mode.simulate(&shaper.simulate(&[1.0; 400]));
        y[shaper.order()..].iter().fold(0.0, |m, y| m.max((y - 1.0).abs()))
    }

    #[test]
    fn a_shaped_step_does_not_ring_and_zvd_rings_little_for_another_frequency() {
        for (hz, damping) in [(156.7, 0.006), (146.7, 0.061), (40.0, 0.0), (20.0, 0.3), (700.0, 0.02)] {
            let (zv, zvd) = (Fir::zv(TS, hz, damping).unwrap(), Fir::zvd(TS, hz, damping).unwrap());
            let exact = oscillator(hz, damping);
            assert!(rings(&zv, &exact) < 1e-9 && rings(&zvd, &exact) < 1e-9, "{hz}");
            assert!(zv.taps.iter().all(|f| *f >= 0.0));
            assert_close(&[zv.taps.iter().sum()], &[1.0], 1e-12, 0.0);
            let off = oscillator(1.05 * hz, damping);
            assert!(rings(&zvd, &off) < 0.3 * rings(&zv, &off), "{hz}");
        }
    }

    #[test]
    fn a_notch_blocks_its_frequency_and_passes_others() {
        let notch = notch(TS, 160.0, 20.0).unwrap();
        assert!(notch.response(160.0).gain < 1e-9);
        let at = |hz| notch.response(hz).gain;
        assert_close(&[at(0.0), at(1.0), at(999.0)], &[1.0; 3], 0.0, 1e-3);
        assert_close(&[at(150.3), at(170.3)], &[0.5f64.sqrt(); 2], 0.02, 0.0);
    }

    #[test]
    fn a_smoothed_step_has_no_corner_and_no_shift() {
        let bell = Fir::smooth(TS, 0.02).unwrap();
        assert_eq!((bell.taps.len(), bell.ahead()), (41, 20));
        let step: Vec<f64> = (0..200).map(|t| f64::from(u8::from(t >= 100))).collect();
        let moved = bell.whole(&step);
        let jump = moved.windows(3).map(|w| (w[2] - 2.0 * w[1] + w[0]).abs()).fold(0.0, f64::max);
        assert!(moved.windows(2).all(|w| w[1] >= w[0]) && jump < 0.02, "{jump}");
        // s^3 (10 - 15 s + 6 s^2) at s = 11 / 42.
        assert_close(&[0.5 * (moved[89] + moved[90])], &[0.1166], 0.0, 2e-3);
    }

    #[test]
    fn invalid_modes_are_errors() {
        assert!(Fir::zv(TS, 1000.0, 0.1).unwrap_err().to_string().starts_with("hz = 1000"));
        assert!(Fir::zvd(TS, 100.0, 1.0).unwrap_err().to_string().starts_with("damping = 1"));
        assert!(Fir::smooth(TS, 0.0).is_err() && notch(TS, 100.0, 0.0).is_err() && Fir::smooth(TS, 1e9).is_err());
    }

    #[test]
    fn a_reference_is_smoothed_first_then_shaped_for_the_resonance() {
        let plain = Arc::new(Proportional::new(TS, 1.0).unwrap());
        let model = Model::new(plain.clone(), oscillator(160.0, 0.02), 0.0).unwrap();
        let resonance = model.linear().resonance().unwrap();
        let r: Vec<f64> = (0..300).map(|t| if t < 100 { 5.0 } else { 9.0 }).collect();
        let shaped = |smooth, notch, zvd| Shaping { smooth, notch, zvd }.of(&model, r.clone()).unwrap();
        assert_eq!(shaped(None, false, false), r);
        let smooth = Fir::smooth(TS, 0.02).unwrap().whole(&r);
        assert_eq!(shaped(Some(0.02), false, false), smooth);
        let zvd = Fir::zvd(TS, resonance.hz, resonance.damping).unwrap();
        assert_eq!(shaped(Some(0.02), false, true), zvd.whole(&smooth));
        // Settled at the first value, and blind at the resonance.
        let notched = shaped(None, true, false);
        assert_close(&notched[..100], &[5.0; 100], 1e-9, 0.0);
        let wave: Vec<f64> = (0..2000).map(|t| (TAU * resonance.hz * TS * f64::from(t)).cos()).collect();
        let left = Shaping { notch: true, ..Shaping::default() }.of(&model, wave).unwrap();
        assert!(left[1500..].iter().all(|v| v.abs() < 1e-3), "{:?}", &left[1990..]);
        let stiff = Model::new(plain, Arx::gain(TS, 1.0).unwrap(), 0.0).unwrap();
        for (notch, zvd, name) in [(true, false, "notch"), (false, true, "zvd")] {
            let message = Shaping { smooth: None, notch, zvd }.of(&stiff, r.clone()).unwrap_err().to_string();
            assert!(message.starts_with(name) && message.contains("needs a model with a resonance"), "{message}");
        }
        assert_eq!(Shaping { smooth: Some(0.02), ..Shaping::default() }.of(&stiff, r.clone()).unwrap(), smooth);
    }

    #[test]
    fn a_notch_is_as_wide_as_requested_between_its_points_of_minus_3_db() {
        for (hz, width) in [(160.0, 20.0), (160.0, 300.0), (400.0, 700.0)] {
            let notch = notch(TS, hz, width).unwrap();
            // The bilinear transform moves the middle of the two points, not their distance.
            let middle = ((TAU * hz * TS).cos() * (PI * width * TS).cos()).acos() / (TAU * TS);
            let at = [middle - 0.5 * width, middle + 0.5 * width].map(|hz| notch.response(hz).gain);
            assert_close(&at, &[0.5f64.sqrt(); 2], 1e-9, 0.0);
        }
        assert!(notch(TS, 160.0, 2000.0).unwrap().is_stable());
    }

    #[test]
    fn the_notch_of_a_reference_is_a_fifth_of_the_resonance_wide() {
        let model = Model::new(Arc::new(Proportional::new(TS, 1.0).unwrap()), oscillator(160.0, 0.02), 0.0).unwrap();
        let resonance = model.linear().resonance().unwrap();
        let notch = notch(TS, resonance.hz, 0.2 * resonance.hz).unwrap();
        let r = [[5.0; 50], [9.0; 50]].concat();
        let shaped = Shaping { notch: true, ..Shaping::default() }.of(&model, r.clone()).unwrap();
        assert_close(&shaped, &notch.resume(&mut notch.settled(5.0), &r), 1e-12, 0.0);
    }

    #[test]
    fn shapers_in_the_middle_of_a_record_are_known_half_their_length_ahead() {
        // s (1 - s) at 1/4, 1/2 and 3/4 is 3, 4 and 3 sixteenths; squared.
        let smooth = Fir::smooth(1.0, 2.0).unwrap();
        assert_close(&smooth.taps, &[9.0 / 34.0, 16.0 / 34.0, 9.0 / 34.0], 1e-12, 0.0);
        // Half a period of 6.4 samples, and twice as much.
        let (zv, zvd) = (Fir::zv(TS, 156.7, 0.006).unwrap(), Fir::zvd(TS, 156.7, 0.006).unwrap());
        assert_eq!([zv.taps.len(), zv.ahead(), zvd.taps.len(), zvd.ahead()], [8, 3, 15, 6]);
        assert_eq!(Fir::smooth(1.0, 99_998.0).unwrap().taps.len(), 99_999);
        let long = Fir::smooth(1.0, 100_000.0).unwrap_err().to_string();
        assert!(long.contains("must be at most 100000 samples of 1 s"), "{long}");
        let slow = Fir::zv(TS, 0.005, 0.1).unwrap_err().to_string();
        assert!(slow.starts_with("hz = 0.005: must have a half period of at most"), "{slow}");
    }
}
