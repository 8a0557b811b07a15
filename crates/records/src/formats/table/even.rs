//! Uneven times made even by linear interpolation, only for a record that is resampled.
//!
//! ```text
//! x(k Ts) = x[i] + (k Ts - t[i]) / (t[i+1] - t[i]) (x[i+1] - x[i]),   t[i] <= k Ts < t[i+1]
//! ```
//! Straight lines never amplify noise, however close two stamps are. Of a sine they lose up to (omega h)^2 / 8, h being
//! the step: 1.2 % at a twentieth of the sampling rate. Input and output lose the same. Ts is the wanted sampling
//! period, or a whole fraction of it near the median step, so that the filter against aliases can follow.
//!
//! It does not do: bridge long gaps, where nobody knows the samples.

use super::super::time::{GAP, rounded};
use piezoid_numerics::error::Error;
use piezoid_numerics::number::{exact, round};
use serde_json::Value;

/// Maximum number of samples.
const MAX_SAMPLES: f64 = 1e8;

/// An even grid over uneven times.
#[derive(Debug, PartialEq)]
pub(super) struct Even {
    /// Sampling period [s].
    pub(super) ts: f64,
    /// The step of the record's history.
    pub(super) step: String,
    /// For each sample of the grid, the sample before it and the share of the next one.
    places: Vec<(usize, f64)>,
}

impl Even {
    /// The grid over times [s] with a median step, for a sampling period; the first time is `start` [s] in the file.
    pub(super) fn over(t: &[f64], median: f64, expected: Option<f64>, start: f64) -> Result<Even, Error> {
        let expected = expected.unwrap_or(median);
        piezoid_numerics::error::positive("resample", expected, "seconds")?;
        let steps = || t.windows(2).map(|pair| pair[1] - pair[0]);
        let (least, most) = piezoid_numerics::series::ends(steps());
        if let Some(k) = steps().position(|step| step > GAP * median) {
            let ends = [k, k + 1].map(|k| start + t[k] - t[0]);
            let [from, to] = ends.map(|t| rounded(t, 6));
            let problem = format!(
                "there is no sample from {from} s to {to} s, more than {GAP} steps of {} s: cut the record there: ",
                rounded(median, 6)
            );
            // The longer part remains.
            let cut = if 2 * k > t.len() { "to" } else { "from" };
            return Err(Error::Content(problem).advised(vec![(cut, Value::from(rounded(ends[1], 12)))]));
        }
        let ts = expected / (expected / median).round().max(1.0);
        let duration = t[t.len() - 1] - t[0];
        let count = (duration / ts + 1e-6).floor() + 1.0;
        if count > MAX_SAMPLES {
            let least = round(duration / MAX_SAMPLES);
            let rule = format!("the record would have {} samples: choose {least} s or more", exact(count));
            return Err(Error::parameter("resample", format!("{} s", round(expected)), rule));
        }
        let mut places = Vec::with_capacity(count as usize);
        let mut before = 0;
        for k in 0..count as usize {
            let here = t[0] + k as f64 * ts;
            while before + 2 < t.len() && t[before + 1] <= here {
                before += 1;
            }
            let share = (here - t[before]) / (t[before + 1] - t[before]);
            places.push((before, share.clamp(0.0, 1.0)));
        }
        let [least, most, median, every] = [least, most, median, ts].map(round);
        let step = format!(
            "uneven times (steps of {least} s to {most} s, {median} s in the median): interpolated by straight lines, \
             every {every} s"
        );
        Ok(Even { ts, step, places })
    }

    /// The samples on the grid.
    pub(super) fn interpolated(&self, x: &[f64]) -> Vec<f64> {
        self.places.iter().map(|(before, share)| x[*before] + share * (x[before + 1] - x[*before])).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const T: [f64; 5] = [2.0, 2.9, 4.1, 5.0, 6.2];

    #[test]
    fn samples_lie_on_the_straight_lines_between_those_of_the_file() {
        let even = Even::over(&T, 1.05, Some(1.0), 0.0).unwrap();
        assert_eq!(even.ts, 1.0);
        // At 2, 3, 4, 5 and 6 s.
        let expected = [1.0, 3.0 - 8.0 / 12.0, -5.0 + 8.0 / 12.0, 7.0, 7.0 + 10.0 / 1.2];
        let found = even.interpolated(&[1.0, 3.0, -5.0, 7.0, 17.0]);
        assert_eq!(found.len(), expected.len());
        found.iter().zip(expected).for_each(|(found, expected)| assert!((found - expected).abs() < 1e-12));
        let sentence = "uneven times (steps of 0.9 s to 1.2 s, 1.05 s in the median): interpolated by straight lines, \
                        every 1 s";
        assert_eq!(even.step, sentence);
    }

    #[test]
    fn the_period_is_a_whole_fraction_of_the_requested_one_near_the_median() {
        for (requested, ts, count) in [(None, 1.05, 5), (Some(0.5), 0.5, 9), (Some(2.1), 1.05, 5), (Some(4.2), 1.05, 5)]
        {
            let even = Even::over(&T, 1.05, requested, 0.0).unwrap();
            assert_eq!((even.ts, even.interpolated(&T).len()), (ts, count), "{requested:?}");
        }
        assert!(Even::over(&T, 1.05, Some(-1.0), 0.0).is_err());
    }

    #[test]
    fn a_gap_is_not_bridged_and_the_longer_part_is_proposed() {
        let refusal = |t: &[f64]| Even::over(t, 1.0, None, 30.0).unwrap_err();
        let long = refusal(&[5.0, 6.0, 7.0, 18.0, 19.0, 20.0]);
        let message = long.to_string();
        let expected = "there is no sample from 32 s to 43 s, more than 10 steps of 1 s: cut the record there: ";
        assert!(message.starts_with(expected), "{message}");
        assert!(message.ends_with("`from` = 43.0"), "{message}");
        assert!(refusal(&[5.0, 6.0, 7.0, 8.0, 18.5]).to_string().ends_with("`to` = 43.5"));
        assert!(Even::over(&[5.0, 6.0, 16.0, 17.0], 1.0, None, 0.0).is_ok());
    }

    #[test]
    fn too_many_samples_are_refused_with_the_least_period() {
        let message = Even::over(&[0.0, 1.0, 1000.0], 999.0, Some(1e-6), 0.0).unwrap_err().to_string();
        assert!(message.contains("would have 1000000001 samples: choose 1e-5 s or more"), "{message}");
    }
}
