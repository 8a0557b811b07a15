//! A drive as the wave of a burst: from the offset to the drive, the drive, and slowly back to the offset.
//!
//! ```text
//! w = (v - c) / (A/2),   c = min(max(v_0, (max v - 10)/2), (10 + min v)/2),   A/2 = max |v - c|
//! ```
//! with the voltages v of the generator. That is `|c| + A/2 <= 10 V` for each drive within ±10 V.

use crate::Drive;
use crate::moves::{LARGEST_STEP, half_cosine, way};
use piezoid::Error;
use piezoid_numerics::series::upsampled;

/// Highest voltage of the generator into a high impedance [V].
pub(crate) const HIGHEST: f64 = 10.0;

/// The least amplitude into a high impedance, peak to peak [V].
pub(crate) const LEAST: f64 = 2e-3;

/// Samples that a wave has at least and at most, and the largest of its values.
const FEWEST: usize = 8;
pub(crate) const MEMORY: usize = 1 << 20;
const FULL: f64 = 32767.0;

/// Samples of a wave for a sample of a drive whose voltages are joined by lines.
const JOINED: usize = 16;

#[derive(Debug)]
pub(crate) struct Wave {
    /// Values from -32767 to 32767.
    pub(crate) codes: Vec<i16>,
    /// Offset, and amplitude from peak to peak [V at the generator].
    pub(crate) offset: f64,
    pub(crate) amplitude: f64,
    /// Time of a sample [s].
    pub(crate) period: f64,
    /// Time before the drive, and from its first sample to the end of its last one [s].
    pub(crate) lead: f64,
    pub(crate) length: f64,
}

impl Wave {
    /// The wave of a drive behind an amplifier of this gain, with a largest slew rate [V/s] and a range [V].
    pub(crate) fn new(drive: &Drive, gain: f64, fastest: f64, range: (f64, f64)) -> Result<Self, Error> {
        let v: Vec<f64> = drive.u.iter().map(|u| u / gain).collect();
        let (Some(first), Some(last)) = (v.first().copied(), v.last().copied()) else {
            return Err(Error::Content("the drive is empty".into()));
        };
        let (low, high) = v.iter().fold((first, first), |(low, high), v| (low.min(*v), high.max(*v)));
        let offset = first.max(0.5 * (high - HIGHEST)).min(0.5 * (HIGHEST + low));
        let half = (high - offset).max(offset - low).max(0.5 * LEAST);
        let every = if drive.joined { JOINED.min(MEMORY / (2 * v.len())).max(1) } else { 1 };
        let period = drive.ts / every as f64;
        let samples = |time: f64| (time / period).ceil().min(1e9) as usize;
        let steps = |from: f64, to: f64| {
            let way = gain * way(from, to);
            let few = way / (LARGEST_STEP * (range.1 - range.0));
            if way > 0.0 { samples(drive.ramp.max(way / fastest)).max(few.ceil() as usize).max(1) } else { 0 }
        };
        let (there, back) = (steps(offset, first), steps(last, offset));
        let settle = if there > 0 { samples(drive.settle) } else { 0 };
        let all = there + settle + every * v.len() + back;
        if all > MEMORY {
            return Err(Error::Content(format!(
                "the drive with the slow move after it has {all} samples, but the generator holds {MEMORY}: make the \
                 drive or --ramp shorter, or sample it less often"
            )));
        }
        let before = half_cosine(offset, first, there).chain(std::iter::repeat_n(first, settle));
        let whole = before.chain(upsampled(&v, every, drive.joined)).chain(half_cosine(last, offset, back));
        let mut codes: Vec<i16> =
            whole.map(|v| (FULL * (v - offset) / half).round().clamp(-FULL, FULL) as i16).collect();
        // The level before and after the burst is that of the first sample.
        codes.insert(0, 0);
        codes.resize(codes.len().max(FEWEST), 0);
        let lead = (1 + there + settle) as f64 * period;
        Ok(Wave { codes, offset, amplitude: 2.0 * half, period, lead, length: v.len() as f64 * drive.ts })
    }

    /// Time of the whole burst [s].
    pub(crate) fn time(&self) -> f64 {
        self.codes.len() as f64 * self.period
    }

    /// The values as a block, the high byte first.
    pub(crate) fn block(&self) -> Vec<u8> {
        let length = (2 * self.codes.len()).to_string();
        let mut block = format!("#{}{length}", length.len()).into_bytes();
        block.extend(self.codes.iter().flat_map(|code| code.to_be_bytes()));
        block
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wave_begins_and_ends_at_its_offset_and_has_the_drive_in_between() {
        let range = (-200.0, 200.0);
        for (u, joined) in [
            (vec![0.0, 50.0, 100.0, 30.0], false),
            (vec![-200.0, 0.0, 200.0], false),
            (vec![200.0, 100.0, 150.0, 10.0], true),
            (vec![-40.0; 9], false),
            (vec![0.0], false),
        ] {
            let drive = Drive { what: "", u: &u, ts: 0.01, ramp: 0.5, settle: 0.1, joined };
            let wave = Wave::new(&drive, 20.0, 1000.0, range).unwrap();
            assert!(wave.offset.abs() + 0.5 * wave.amplitude <= HIGHEST + 1e-9, "{u:?}: {wave:?}");
            assert_eq!((wave.codes.first(), wave.codes.last()), (Some(&0), Some(&0)), "{u:?}");
            let voltage = |code: i16| 20.0 * (wave.offset + 0.5 * wave.amplitude * f64::from(code) / FULL);
            let lead = (wave.lead / wave.period).round() as usize;
            let every = (drive.ts / wave.period).round() as usize;
            for (k, u) in u.iter().enumerate() {
                assert!((voltage(wave.codes[lead + k * every]) - u).abs() < 5e-3, "{u}");
            }
            let steps = |part: &[i16]| part.windows(2).all(|w| (voltage(w[1]) - voltage(w[0])).abs() <= 20.01);
            assert!(steps(&wave.codes[..=lead]) && steps(&wave.codes[lead + every * u.len() - 1..]), "{u:?}");
        }
    }

    #[test]
    fn a_drive_whose_way_back_does_not_fit_is_refused() {
        let u = vec![0.0, 1.0];
        let drive = Drive { what: "", u: &u, ts: 1e-6, ramp: 2.0, settle: 0.0, joined: false };
        let message = Wave::new(&drive, 1.0, f64::INFINITY, (-1.0, 1.0)).unwrap_err().to_string();
        assert!(message.contains("2000002 samples, but the generator holds 1048576"), "{message}");
    }
}
