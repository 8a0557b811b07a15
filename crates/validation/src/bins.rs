//! The error by frequency and by amplitude.
//!
//! A periodic or oscillating input (a sine, also rising or swept; steps up and down) is split into cycles, from one
//! lower reversal to the next. The frequency of a cycle is one over its duration, its amplitude half its height. Any
//! other input (a PRBS, a multisine) is analysed by its spectrum: rms of error and output in each excited band.
//! Frequencies are grouped in the third-octave bands of IEC 61260, 10^((n - 1/2)/10) to 10^((n + 1/2)/10) Hz,
//! amplitudes in fifths of a decade. The edges are the same for every record, so bins of several records can be merged.
//!
//! The noise floor of a bin has the bandwidth of its error: a cycle contains all frequencies, so it has all the noise,
//! and a band of a spectrum has the share of white noise within it. It is at most the error of the bin. In a bin with
//! little excitation, the relative error is that of other frequencies and of noise ([`Bin::little_excited`]).
//! It does not do: noise that is not white.

use super::{ComparedRun, errors};
use libm::{log10, pow};
use piezoid_numerics::fourier::power;
use piezoid_numerics::series::{range, scatter};
use piezoid_records::waveform::Cycle;
use serde::Serialize;

/// Frequency bands per decade.
const FREQUENCY_BANDS: f64 = 10.0;

/// Amplitude bands per decade.
const AMPLITUDE_BANDS: f64 = 5.0;

/// Share of the input's power from which a band counts as excited.
const MIN_POWER_SHARE: f64 = 1e-4;

/// Power of the input in a band over the largest of all bands, below which it has little excitation; and the same of
/// its power at one frequency, or in one cycle. Both count: a multisine has little power in narrow bands, and pink
/// noise little at each of many frequencies.
const LITTLE_POWER_SHARE: f64 = 2e-2;

/// Rms of the output over its noise below which a bin has little excitation.
const LITTLE_OUTPUT_RATIO: f64 = 3.0;

/// Source of the figures of a bin. Different sources are never merged.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Source {
    /// Cycles of the input, each with its own height of the output.
    Cycles,
    /// The spectra of error and output over the whole record.
    Spectrum,
}

/// The error within a range of frequency or amplitude.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Bin {
    /// Mean frequency or amplitude of its content [Hz or input unit].
    pub at: f64,
    /// Lower edge [Hz or input unit].
    pub low: f64,
    /// Upper edge [Hz or input unit].
    pub high: f64,
    /// Cycles, or the spectrum.
    pub source: Source,
    /// Number of cycles; 0 for a spectrum.
    pub cycles: usize,
    /// Number of samples; for a spectrum that of the record.
    pub n: usize,
    /// Rms error; for a spectrum within the band [output unit].
    pub rmse: f64,
    /// Rms of the output about the mean of each cycle; for a spectrum within the band [output unit].
    pub std: f64,
    /// Mean peak-to-peak of the output over the cycles; for a spectrum that of the record [output unit].
    pub peak_to_peak: f64,
    /// 100 rmse / std.
    pub nrmse_percent: f64,
    /// 100 rmse / peak_to_peak.
    pub rms_pp_percent: f64,
    /// Noise in `rmse`, with the same bandwidth; `None` if the noise floor of a record is unknown [output unit].
    pub noise: Option<f64>,
    /// 100 noise / std.
    pub noise_nrmse_percent: Option<f64>,
    /// 100 noise / peak_to_peak.
    pub noise_rms_pp_percent: Option<f64>,
    /// True if the relative errors say little: the output is below three times its noise, or the input has less than
    /// 2 % of the power of its strongest band.
    pub little_excited: bool,
    /// Share of the mean square of white noise within the bin.
    #[serde(skip)]
    noise_share: f64,
    /// Power of the input in the bin, and at one frequency or in one cycle of it.
    #[serde(skip)]
    input: [f64; 2],
}

impl Bin {
    /// The bin of content at `at`, with `per_decade` bins per decade.
    fn new(at: f64, per_decade: f64, source: Source, n: usize, [rmse, std, peak_to_peak]: [f64; 3]) -> Self {
        let edge = |k: f64| pow(10.0, ((log10(at) * per_decade).round() + k) / per_decade);
        let cycles = usize::from(source == Source::Cycles);
        let (low, high) = (edge(-0.5), edge(0.5));
        let unrated = Bin {
            at,
            low,
            high,
            source,
            cycles,
            n,
            rmse,
            std,
            peak_to_peak,
            nrmse_percent: 0.0,
            rms_pp_percent: 0.0,
            noise: None,
            noise_nrmse_percent: None,
            noise_rms_pp_percent: None,
            little_excited: false,
            noise_share: 1.0,
            input: [0.0; 2],
        };
        unrated.rated()
    }

    fn rated(self) -> Self {
        let (nrmse_percent, rms_pp_percent) = (100.0 * self.rmse / self.std, 100.0 * self.rmse / self.peak_to_peak);
        let over = |size: f64| self.noise.map(|noise| 100.0 * noise / size);
        let (noise_nrmse_percent, noise_rms_pp_percent) = (over(self.std), over(self.peak_to_peak));
        Bin { nrmse_percent, rms_pp_percent, noise_nrmse_percent, noise_rms_pp_percent, ..self }
    }

    /// The bin of a record with noise of this rms [output unit], if it is known.
    pub(super) fn above(self, noise: Option<f64>) -> Self {
        let within = noise.map(|noise| noise * self.noise_share.sqrt());
        let hidden = within.is_some_and(|noise| self.std < LITTLE_OUTPUT_RATIO * noise);
        let noise = within.map(|noise| noise.min(self.rmse));
        Bin { noise, little_excited: self.little_excited || hidden, ..self }.rated()
    }

    /// Merges two bins with the same edges: squares and heights are averaged over samples.
    fn pooled(self, other: &Bin) -> Self {
        let (a, b) = (self.n as f64, other.n as f64);
        let mix = |x: f64, y: f64| (a * x + b * y) / (a + b);
        let rms = |x: f64, y: f64| mix(x * x, y * y).sqrt();
        let pooled = Bin {
            at: mix(self.at, other.at),
            cycles: self.cycles + other.cycles,
            n: self.n + other.n,
            rmse: rms(self.rmse, other.rmse),
            std: rms(self.std, other.std),
            peak_to_peak: mix(self.peak_to_peak, other.peak_to_peak),
            noise: self.noise.zip(other.noise).map(|(x, y)| rms(x, y)),
            little_excited: self.little_excited && other.little_excited,
            noise_share: mix(self.noise_share, other.noise_share),
            input: [self.input[0] + other.input[0], mix(self.input[1], other.input[1])],
            ..self
        };
        pooled.rated()
    }

    /// Merges the bins of several records or cycles with the same edges and source; sorted from low to high, cycles
    /// first.
    ///
    /// ```
    /// use piezoid::{Record, System, Validate, hammerstein::Model, hysteresis::Proportional, linear::Arx};
    /// use piezoid::validation::Bin;
    /// let gain = std::sync::Arc::new(Proportional::new(1e-3, 1.0)?);
    /// let model = Model::new(gain, Arx::gain(1e-3, 33.0)?, 0.0)?;
    /// let wave = |hz: f64, t: i32| 5.0 * (std::f64::consts::TAU * hz * f64::from(t) * 1e-3).sin();
    /// let sine = |hz: f64| (0..3000).map(|t| wave(hz, t)).collect::<Vec<_>>();
    /// let validations = [4.0, 4.1, 20.0].map(|hz| {
    ///     let y = sine(hz).iter().map(|u| 33.0 * u + 1.0).collect();
    ///     model.validate(&Record::new(1e-3, sine(hz), y)?)
    /// });
    /// let validations = validations.into_iter().collect::<Result<Vec<_>, _>>()?;
    /// let bins = Bin::merged(validations.iter().flat_map(|v| &v.by_frequency));
    /// assert_eq!(bins.len(), 2);
    /// assert!((bins[0].rmse - 1.0).abs() < 1e-9 && (bins[0].at - 4.05).abs() < 0.05 && bins[0].cycles > 20);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    pub fn merged<'a>(bins: impl IntoIterator<Item = &'a Bin>) -> Vec<Bin> {
        let mut all: Vec<Bin> = Vec::new();
        bins.into_iter().for_each(|bin| bin.join(&mut all));
        all.sort_by(|a, b| a.source.cmp(&b.source).then(a.low.total_cmp(&b.low)));
        all
    }

    /// Merges this bin into the one of others with its edges and source.
    fn join(&self, all: &mut Vec<Bin>) {
        match all.iter_mut().find(|known| known.source == self.source && known.low == self.low) {
            Some(known) => *known = known.pooled(self),
            None => all.push(*self),
        }
    }
}

/// The bins of the cycles of a record, one after the other.
#[derive(Debug, Default)]
pub(super) struct CycleBins {
    by_frequency: Vec<Bin>,
    by_amplitude: Vec<Bin>,
}

impl CycleBins {
    /// Adds a cycle of input, output and free run.
    pub(super) fn add(&mut self, y: &[f64], simulated: &[f64], cycle: &Cycle) {
        // The reversal at its end is the first sample of the next cycle.
        let samples = cycle.samples.start..cycle.samples.end - 1;
        let (y, simulated) = (&y[samples.clone()], &simulated[samples]);
        let n = y.len() as f64;
        let squares: f64 = y.iter().zip(simulated).map(|(y, s)| (y - s).powi(2)).sum();
        let figures = [(squares / n).sqrt(), (scatter(y) / n).sqrt(), range(y)];
        let power = cycle.amplitude * cycle.amplitude;
        let bin = |at: f64, per_decade: f64| Bin {
            input: [power * n, power],
            ..Bin::new(at, per_decade, Source::Cycles, y.len(), figures)
        };
        bin(cycle.hz, FREQUENCY_BANDS).join(&mut self.by_frequency);
        bin(cycle.amplitude, AMPLITUDE_BANDS).join(&mut self.by_amplitude);
    }

    /// The bins by frequency and by amplitude.
    pub(super) fn bins(&self) -> [Vec<Bin>; 2] {
        [marked(Bin::merged(&self.by_frequency)), Bin::merged(&self.by_amplitude)]
    }
}

/// The band number n of a frequency [Hz].
pub(crate) fn band(hz: f64) -> f64 {
    (log10(hz) * FREQUENCY_BANDS).round()
}

/// True if two cycles belong to the same bins of frequency and amplitude.
pub(crate) fn alike(a: &Cycle, b: &Cycle) -> bool {
    let bin = |c: &Cycle| (band(c.hz), (log10(c.amplitude) * AMPLITUDE_BANDS).round());
    bin(a) == bin(b)
}

pub(super) fn by_spectrum(run: &ComparedRun) -> Vec<Bin> {
    let record = run.record;
    let errors = errors(record.y(), run.simulated);
    if errors.iter().any(|e| !e.is_finite()) {
        return Vec::new();
    }
    // `power` leaves out the mean of the error, which belongs to no band.
    let error = power(&errors);
    drop(errors);
    let [input, output] = [record.u(), record.y()].map(power);
    let hz = |k: usize| k as f64 / (record.len() as f64 * record.ts());
    let bins: Vec<usize> = (1..input.len()).collect();
    let stroke = range(record.y());
    let all: f64 = input.iter().sum();
    let bands: Vec<&[usize]> = bins.chunk_by(|a, b| band(hz(*a)) == band(hz(*b))).collect();
    let sum = |power: &[f64], bins: &[usize]| bins.iter().map(|&k| power[k]).sum::<f64>();
    let within = |bins: &&[usize]| {
        let excited = sum(&input, bins);
        let centre = bins.iter().map(|&k| hz(k) * input[k]).sum::<f64>() / excited;
        let figures = [sum(&error, bins).sqrt(), sum(&output, bins).sqrt(), stroke];
        (excited > MIN_POWER_SHARE * all).then(|| Bin {
            noise_share: bins.len() as f64 / input.len() as f64,
            input: [excited, excited / bins.len() as f64],
            ..Bin::new(centre, FREQUENCY_BANDS, Source::Spectrum, record.len(), figures)
        })
    };
    marked(bands.iter().filter_map(within).collect())
}

/// The bins by frequency of a record, those with little of its input marked.
fn marked(mut bins: Vec<Bin>) -> Vec<Bin> {
    let [most, most_at_one] = [0, 1].map(|k| bins.iter().map(|bin| bin.input[k]).fold(0.0, f64::max));
    for bin in &mut bins {
        let [power, at_one] = bin.input;
        bin.little_excited = power < LITTLE_POWER_SHARE * most && at_one < LITTLE_POWER_SHARE * most_at_one;
    }
    bins
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Validate;
    use crate::Validation;
    use piezoid_models::hammerstein::Model;
    use piezoid_models::hysteresis::Proportional;
    use piezoid_models::linear::Arx;
    use piezoid_records::excitation::{Chirp, Multisine, RisingSine, Sine};
    use piezoid_records::record::Record;
    use piezoid_testing::assert_close;
    use std::sync::Arc;

    const TS: f64 = 5e-4;

    /// A gain of 10 validated on the output `y(t, 10 u)`.
    fn validated(u: Vec<f64>, y: impl Fn(usize, f64) -> f64) -> Validation {
        let gain = Arc::new(Proportional::new(TS, 1.0).unwrap());
        let model = Model::new(gain, Arx::gain(TS, 10.0).unwrap(), 0.0).unwrap();
        let y = u.iter().enumerate().map(|(t, u)| y(t, 10.0 * u)).collect();
        model.validate(&Record::new(TS, u, y).unwrap()).unwrap()
    }

    #[test]
    fn a_relative_error_is_the_same_at_every_frequency_and_amplitude() {
        let chirp = Chirp { amplitude: 5.0, frequency_start: 2.0, frequency_end: 60.0, ..Chirp::default() };
        let validation = validated(chirp.samples(TS, 20_000).unwrap(), |_, y| 1.01 * y);
        assert!(validation.by_frequency.len() > 10, "{}", validation.by_frequency.len());
        for bin in &validation.by_frequency {
            assert!((bin.low..bin.high).contains(&bin.at), "{bin:?}");
            // At 60 Hz the samples miss the exact peaks.
            assert_close(&[bin.nrmse_percent], &[1.0 / 1.01], 0.05, 0.0);
        }
        let rising = RisingSine { amplitude: 30.0, frequency: 5.0, ..RisingSine::default() };
        let validation = validated(rising.samples(TS, 20_000).unwrap(), |_, y| 1.01 * y);
        assert!(
            validation.by_amplitude.len() >= 5 && validation.by_frequency.len() == 1,
            "{:?}",
            validation.by_amplitude
        );
        for bin in &validation.by_amplitude {
            assert_close(&[bin.rms_pp_percent], &[1.0 / 1.01 / 8f64.sqrt()], 0.1, 0.0);
        }
    }

    #[test]
    fn an_error_at_one_frequency_of_a_multisine_is_in_one_bin() {
        let wide =
            Multisine { amplitude: 5.0, frequency_low: 2.0, frequency_high: 200.0, seed: 5, ..Multisine::default() };
        let hum = |t: usize| (std::f64::consts::TAU * 50.0 * t as f64 * TS).sin();
        let validation = validated(wide.samples(TS, 20_000).unwrap(), |t, y| y + hum(t));
        assert!(validation.by_amplitude.is_empty() && validation.loops.is_empty());
        let loudest = validation.by_frequency.iter().max_by(|a, b| a.rmse.total_cmp(&b.rmse)).unwrap();
        assert!((loudest.low..loudest.high).contains(&50.0));
        assert_close(&[loudest.rmse], &[0.5f64.sqrt()], 1e-2, 0.0);
        let others = validation.by_frequency.iter().filter(|b| b.low != loudest.low);
        assert!(others.clone().count() > 12 && others.clone().all(|b| b.rmse < 1e-3), "{:?}", validation.by_frequency);
        let output: f64 = validation.by_frequency.iter().map(|b| b.std * b.std).sum::<f64>().sqrt();
        assert_close(&[output], &[validation.metrics.std], 2e-2, 0.0);
    }

    #[test]
    fn merging_weights_by_samples_and_keeps_sources_separate() {
        let sine = |n| Sine { amplitude: 5.0, frequency: 10.0, ..Sine::default() }.samples(TS, n).unwrap();
        let (short, long) = (validated(sine(1000), |_, y| y + 2.0), validated(sine(3000), |_, y| y + 1.0));
        let (a, b) = (short.by_frequency[0], long.by_frequency[0]);
        let both = Bin::merged([&a, &b]);
        let expected = ((a.n as f64 * 4.0 + b.n as f64) / (a.n + b.n) as f64).sqrt();
        assert_eq!((both.len(), both[0].cycles), (1, a.cycles + b.cycles));
        assert_close(&[both[0].rmse, both[0].peak_to_peak], &[expected, 100.0], 1e-9, 0.0);
        assert_eq!(Bin::merged([&a, &Bin { source: Source::Spectrum, ..b }]).len(), 2);
    }

    /// A multisine from 2 to 200 Hz with white noise on y: in each band, noise and error are the same quantity.
    #[test]
    fn the_noise_of_a_bin_has_the_bandwidth_of_its_error() {
        let wide =
            Multisine { amplitude: 5.0, frequency_low: 2.0, frequency_high: 200.0, seed: 5, ..Multisine::default() };
        let e = piezoid_testing::noise(8, 20_000);
        let validation = validated(wide.samples(TS, 20_000).unwrap(), |t, y| y + 0.3 * e[t]);
        assert_close(&[validation.floor.unwrap().rms], &[0.3], 0.1, 0.0);
        let bins = &validation.by_frequency;
        assert!(bins.len() > 12 && bins.iter().all(|bin| !bin.little_excited), "{bins:?}");
        for bin in bins {
            let noise = bin.noise.unwrap();
            assert!(noise <= bin.rmse && noise < 0.5 * 0.3, "{bin:?}");
            assert_close(&[bin.noise_nrmse_percent.unwrap()], &[100.0 * noise / bin.std], 1e-12, 0.0);
            // Fewer frequencies in a band scatter more.
            assert!(bin.at < 20.0 || noise > 0.7 * bin.rmse, "{bin:?}");
        }
        // A cycle has all frequencies, and so all the noise.
        let sine = Sine { amplitude: 5.0, frequency: 10.0, ..Sine::default() }.samples(TS, 20_000).unwrap();
        let validation = validated(sine, |t, y| y + 0.3 * e[t]);
        assert_close(&[validation.by_frequency[0].noise.unwrap()], &[0.3], 0.1, 0.0);
    }

    #[test]
    fn a_band_with_little_input_or_output_is_named() {
        let sines = |frequency_low: f64, frequency_high: f64, seed: u32| {
            let sines = Multisine { frequency_low, frequency_high, seed, ..Multisine::default() };
            sines.samples(TS, 20_000).unwrap()
        };
        let sum = |a: &[f64], b: &[f64], share: f64| a.iter().zip(b).map(|(a, b)| 10.0 * a + share * b).collect();
        let large = sines(2.0, 90.0, 5);
        let bins = validated(sum(&large, &sines(150.0, 400.0, 5), 0.8), |_, y| 1.01 * y).by_frequency;
        assert!(bins.iter().all(|bin| bin.source == Source::Spectrum && bin.little_excited == (bin.at > 100.0)));
        assert!(bins.iter().any(|bin| bin.at > 100.0), "{bins:?}");
        // Small fast cycles on slow large ones: their error is that of the large ones.
        let seed = Multisine::default().seed;
        let bins =
            validated(sum(&sines(2.0, 20.0, seed), &sines(40.0, 400.0, seed), 0.2), |_, y| 1.01 * y).by_frequency;
        let worst = bins.iter().max_by(|a, b| a.nrmse_percent.total_cmp(&b.nrmse_percent)).unwrap();
        assert!(worst.source == Source::Cycles && worst.nrmse_percent > 20.0 && worst.little_excited, "{bins:?}");
        // An output below its noise.
        let e = piezoid_testing::noise(8, 20_000);
        let bins = validated(large, |t, y| 1e-3 * y + e[t]).by_frequency;
        assert!(bins.iter().all(|bin| bin.little_excited), "{bins:?}");
    }
}
