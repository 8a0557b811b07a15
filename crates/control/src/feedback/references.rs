//! References for tracking tests, each with a peak and a frequency.
//!
//! They are the excitations of [`excitation`](piezoid_records::excitation) in output units, and a random reference.

use crate::compensation::Fir;
use piezoid_numerics::error::{Error, positive, row};
use piezoid_records::excitation::{Multisine, Sine, Staircase, Triangle};
use serde::Serialize;

/// One kind of reference: a row of [`REFERENCES`].
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Reference {
    /// Name in options and files.
    pub name: &'static str,
    /// One line.
    pub summary: &'static str,
    /// `n` samples every `ts` [s], with this peak [output unit] and frequency [Hz].
    #[serde(skip)]
    generate: fn(ts: f64, n: usize, peak: f64, hz: f64) -> Result<Vec<f64>, Error>,
}

/// All references.
pub static REFERENCES: &[Reference] = &[
    Reference {
        name: "sine",
        summary: "one frequency",
        generate: |ts, n, peak, hz| Sine { amplitude: peak, frequency: hz, ..Default::default() }.samples(ts, n),
    },
    Reference {
        name: "triangle",
        summary: "triangle wave, as in a raster scan: constant speed",
        generate: |ts, n, peak, hz| Triangle { amplitude: peak, frequency: hz, ..Default::default() }.samples(ts, n),
    },
    Reference {
        name: "staircase",
        summary: "nine levels with minimum-jerk moves between them: settling and creep",
        generate: staircase,
    },
    Reference {
        name: "random",
        summary: "a smooth random signal with all frequencies up to the given one",
        generate: random,
    },
];

/// A staircase whose steps are moves of half the duration of its shortest level. No actuator can follow a jump.
fn staircase(ts: f64, n: usize, peak: f64, hz: f64) -> Result<Vec<f64>, Error> {
    let steps = Staircase { amplitude: peak, frequency: hz, levels: 9, ..Default::default() }.samples(ts, n)?;
    Ok(Fir::smooth(ts, 1.0 / (48.0 * hz))?.whole(&steps))
}

/// Sines up to `hz` of equal amplitude with random phases, starting from rest within two periods of `hz`. The period is
/// 20 s, or 20 periods of `hz` if that is longer.
fn random(ts: f64, n: usize, peak: f64, hz: f64) -> Result<Vec<f64>, Error> {
    positive("hz", hz, "Hz")?;
    let period = 20.0f64.max(20.0 / hz);
    let sines = Multisine {
        amplitude: peak,
        frequency_low: hz / 20.0,
        frequency_high: hz,
        period,
        seed: 1,
        ..Default::default()
    };
    let rise = 2.0 / (hz * ts);
    let smooth = |share: f64| share * share * (3.0 - 2.0 * share);
    let path = sines.samples(ts, n)?;
    Ok(path.iter().enumerate().map(|(t, r)| r * smooth((t as f64 / rise).min(1.0))).collect())
}

impl Reference {
    /// The reference called `name`.
    ///
    /// ```
    /// let sine = piezoid::control::Reference::find("sine")?;
    /// let r = sine.samples(5e-4, 400, 800.0, 5.0)?;
    /// assert_eq!((r[0], r[100]), (0.0, 800.0));
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// [`Error::Unknown`] with the known names.
    pub fn find(name: &str) -> Result<&'static Self, Error> {
        row("reference", REFERENCES.iter(), |row| row.name, name)
    }

    /// `n` samples every `ts` [s], with this peak [output unit] and frequency [Hz].
    ///
    /// # Errors
    /// Returns an error for a peak, a frequency or a sampling time that is out of range.
    pub fn samples(&self, ts: f64, n: usize, peak: f64, hz: f64) -> Result<Vec<f64>, Error> {
        (self.generate)(ts, n, peak, hz)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_random_one_rises_smoothly_within_two_periods() {
        let (ts, hz) = (5e-4, 5.0);
        let r = Reference::find("random").unwrap().samples(ts, 40_000, 800.0, hz).unwrap();
        let sines = Multisine {
            amplitude: 800.0,
            frequency_low: hz / 20.0,
            frequency_high: hz,
            period: 20.0,
            seed: 1,
            ..Default::default()
        };
        let whole = sines.samples(ts, 40_000).unwrap();
        for (t, share) in [(0, 0.0), (200, 5.0 / 32.0), (400, 0.5), (800, 1.0), (39_999, 1.0)] {
            assert!((r[t] - share * whole[t]).abs() < 1e-9, "{t}: {} of {}", r[t], whole[t]);
        }
    }

    #[test]
    fn every_reference_starts_at_rest_and_stays_within_its_peak() {
        for kind in REFERENCES {
            let r = kind.samples(5e-4, 40_000, 800.0, 5.0).unwrap();
            let most = r.iter().fold(0.0, |m: f64, r| m.max(r.abs()));
            assert!(r.len() == 40_000 && r[0].abs() < 1.0 && most <= 800.0 && most > 600.0, "{}: {most}", kind.name);
            assert!(kind.samples(5e-4, 100, 800.0, 5000.0).is_err(), "{}", kind.name);
            assert_eq!(Reference::find(kind.name).unwrap().summary, kind.summary);
        }
    }

    #[test]
    fn the_staircase_rests_on_nine_levels() {
        let r = Reference::find("staircase").unwrap().samples(5e-4, 800, 800.0, 5.0).unwrap();
        let resting = r.windows(3).filter(|w| (w[0] - w[1]).abs() < 1e-9 && (w[1] - w[2]).abs() < 1e-9);
        let levels: std::collections::BTreeSet<i64> = resting.map(|w| w[1].round() as i64).collect();
        assert_eq!(levels.into_iter().collect::<Vec<_>>(), (-4..=4).map(|k| 200 * k).collect::<Vec<i64>>());
        // Five periods a second.
        for kind in ["staircase", "triangle", "sine"] {
            let r = Reference::find(kind).unwrap().samples(5e-4, 800, 800.0, 5.0).unwrap();
            assert!((r[100] - 800.0).abs() < 1e-6 && (r[700] + 800.0).abs() < 1e-6, "{kind}: {} {}", r[100], r[700]);
        }
    }

    #[test]
    fn the_random_one_repeats_after_twenty_periods_of_a_low_frequency() {
        let r = Reference::find("random").unwrap().samples(5e-3, 16_000, 800.0, 0.5).unwrap();
        // 40 s later, beyond its rise of 4 s.
        for t in [1000, 4321, 7999] {
            assert!((r[t] - r[t + 8000]).abs() < 1e-9, "{t}: {} {}", r[t], r[t + 8000]);
        }
        assert!((1000..3999).any(|t| (r[t] - r[t + 4000]).abs() > 1.0), "it repeats sooner");
    }
}
