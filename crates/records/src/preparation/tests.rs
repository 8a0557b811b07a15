//! The steps against theory.

use super::kernel::Kernel;
use super::*;
use piezoid_testing::{assert_close, noise};
use std::f64::consts::TAU;

const TS: f64 = 1e-4;

fn series(n: usize, of: impl Fn(f64) -> f64) -> Vec<f64> {
    (0..n).map(|t| of(t as f64 * TS)).collect()
}

fn sine(hz: f64) -> impl Fn(f64) -> f64 {
    move |t| (TAU * hz * t + 0.3).sin()
}

fn record(u: Vec<f64>, y: Vec<f64>) -> Record {
    Record::new(TS, u, y).unwrap()
}

fn prepared(options: &PrepareOptions, record: &Record) -> Record {
    options.run(record).unwrap()
}

fn refused(options: PrepareOptions, record: &Record) -> String {
    options.run(record).unwrap_err().to_string()
}

/// Options with one change.
fn with(change: impl Fn(&mut PrepareOptions)) -> PrepareOptions {
    let mut options = PrepareOptions::default();
    change(&mut options);
    options
}

/// A series without the samples that its ends reach.
fn inner(x: &[f64], ends: usize) -> &[f64] {
    &x[ends..x.len() - ends]
}

#[test]
fn nothing_happens_by_default() {
    let record = record(series(50, sine(20.0)), series(50, sine(10.0)));
    let same = prepared(&PrepareOptions::default(), &record);
    assert_eq!((&same, same.history()), (&record, &[][..]));
    let one = with(|o| (o.decimate, o.delay) = (Some(1), Some(0.0)));
    assert_eq!(prepared(&one, &record), record);
    assert_eq!(prepared(&with(|o| o.resample = Some(TS)), &record), record);
}

#[test]
fn the_filters_have_the_response_that_the_documentation_states() {
    // The kernel, how finely it is sampled, and the end of its pass band and the start of its stop band.
    for (kernel, per_sample, pass, stop) in [
        (Kernel::anti_alias(), 2, 0.8, 1.0),
        (Kernel::anti_alias(), 5, 0.8, 1.0),
        (Kernel::anti_alias(), 64, 0.8, 1.0),
        (Kernel::between(), 8, 0.8, 1.2),
    ] {
        let taps = kernel.taps(per_sample);
        let middle = (taps.len() / 2) as f64;
        let response = |share: f64| -> f64 {
            let angle = std::f64::consts::PI * share / per_sample as f64;
            taps.iter().enumerate().map(|(k, tap)| tap * (angle * (k as f64 - middle)).cos()).sum()
        };
        for k in 0..=200 {
            let share = 0.01 * f64::from(k);
            let gain = response(share);
            assert!(share > pass || (gain - 1.0).abs() < 1e-4, "{per_sample}, {share}: {gain}");
            assert!(share < stop || gain.abs() < 3.55e-5, "{per_sample}, {share}: {gain:e}");
        }
    }
}

#[test]
fn a_decimated_sine_is_kept_below_and_gone_above_the_new_nyquist_frequency() {
    for factor in [2, 5, 10, 64] {
        let (options, n) = (with(|o| o.decimate = Some(factor)), 200 * factor);
        let nyquist = 0.5 / (factor as f64 * TS);
        let at = |hz: f64| {
            let result = prepared(&options, &record(series(n, sine(hz)), series(n, sine(hz))));
            assert_eq!((result.len(), result.u()), (200, result.y()), "both channels alike");
            assert!((result.ts() / (factor as f64 * TS) - 1.0).abs() < 1e-12);
            result
        };
        for share in [0.0, 0.1, 0.5, 0.79] {
            let expected: Vec<f64> = series(n, sine(share * nyquist)).into_iter().step_by(factor).collect();
            assert_close(inner(at(share * nyquist).y(), 30), inner(&expected, 30), 0.0, 1e-4);
        }
        // Sines that would fold onto low frequencies: 60 dB at least.
        for share in [1.0, 1.1, 1.9, 2.0].iter().filter(|share| **share < factor as f64) {
            let worst = inner(at(share * nyquist).y(), 30).iter().fold(0.0, |m: f64, y| m.max(y.abs()));
            assert!(worst < 1e-3, "factor {factor}, {share} of Nyquist: {worst:e}");
        }
    }
}

#[test]
fn a_resampled_signal_is_the_signal_at_the_new_times() {
    let signal = |t: f64| sine(70.0)(t) + 0.5 * sine(811.0)(t) + 0.2 * sine(1900.0)(t) + 3.0;
    // 2 kHz is 0.8 of the Nyquist frequency of 0.2 ms.
    for ts in [2e-4, 1.37e-4, 1.000_01e-4, 0.9e-4, 0.3e-4] {
        let result = prepared(&with(|o| o.resample = Some(ts)), &record(series(3000, signal), series(3000, signal)));
        assert_eq!(result.ts(), ts);
        assert!((result.duration() - 0.3).abs() < 2.0 * ts.max(TS));
        let expected: Vec<f64> = (0..result.len()).map(|k| signal(k as f64 * ts)).collect();
        let ends = (30.0 * (ts / TS).max(1.0) * TS / ts).ceil() as usize;
        assert_close(inner(result.y(), ends), inner(&expected, ends), 0.0, 1e-4);
        assert_eq!(result.u(), result.y());
    }
}

#[test]
fn ends_keep_constants_and_lines() {
    let line = record(series(300, |t| 5.0 + 1e3 * t), vec![7.0; 300]);
    for options in [with(|o| o.decimate = Some(4)), with(|o| o.resample = Some(0.7e-4))] {
        let result = prepared(&options, &line);
        let expected: Vec<f64> = (0..result.len()).map(|k| 5.0 + 1e3 * k as f64 * result.ts()).collect();
        assert_close(result.u(), &expected, 0.0, 1e-4);
        assert_close(result.y(), &vec![7.0; result.len()], 1e-14, 0.0);
    }
}

#[test]
fn a_delay_of_any_part_of_a_sample_is_taken_out() {
    let n = 2000;
    let signal = |t: f64| sine(50.0)(t) + 0.5 * sine(1234.0)(t) + 0.3 * sine(3900.0)(t);
    for delay in [0.25e-4, 1e-4, 3.7e-4, -0.5e-4, -12.9e-4] {
        let delayed = record(series(n, signal), series(n, |t| signal(t - delay)));
        let result = prepared(&with(|o| o.delay = Some(delay)), &delayed);
        let cut = (delay.abs() / TS - 1e-9).ceil() as usize;
        assert_eq!(result.len(), n - cut);
        let end = 15;
        assert_close(inner(result.y(), end), inner(result.u(), end), 0.0, 1e-4);
        let way = if delay > 0.0 { "earlier" } else { "later" };
        assert!(result.history()[0].starts_with(&format!("output shifted {way} by")), "{:?}", result.history());
    }
    // Whole samples are moved, not filtered.
    let steps = record((0..50).map(f64::from).collect(), (0..50).map(|k| f64::from(k % 7)).collect());
    let result = prepared(&with(|o| o.delay = Some(3.0 * TS)), &steps);
    assert_eq!((result.u(), result.y()), (&steps.u()[..47], &steps.y()[3..]));
    assert!(result.history()[0].ends_with("(3 samples); the last 3 samples, without output, cut"));
    let result = prepared(&with(|o| o.delay = Some(-TS)), &steps);
    assert_eq!((result.u(), result.y()), (&steps.u()[1..], &steps.y()[..49]));
}

#[test]
fn the_mean_of_periods_has_the_noise_that_statistics_expect() {
    let (p, periods, rms) = (200, 100, 0.7);
    let signal = |t: f64| 10.0 * (TAU * t / (p as f64 * TS)).sin();
    let u = series(p * periods + 30, signal);
    let y = series(u.len(), signal).iter().zip(noise(3, u.len())).map(|(y, e)| 3.0 * y + rms * e).collect();
    let result = prepared(&with(|o| o.average = true), &record(u.clone(), y));
    assert_eq!(result.len(), p);
    // The last 100 periods: the record has 30 samples more, and they are the first.
    assert_close(result.u(), &u[30..30 + p], 0.0, 1e-9);
    let errors: Vec<f64> = result.y().iter().zip(result.u()).map(|(y, u)| y - 3.0 * u).collect();
    let scatter = (errors.iter().map(|e| e * e).sum::<f64>() / p as f64).sqrt();
    // Of 200 samples, the standard deviation is known to 5 %.
    assert!((scatter / (rms / 10.0) - 1.0).abs() < 0.15, "{scatter}");
    let message = &result.history()[0];
    let figures: Vec<f64> = message.split(' ').filter_map(|word| word.parse().ok()).collect();
    assert_eq!(figures[..2], [100.0, 0.02], "{message}");
    // Of 19800 degrees of freedom, to 0.5 %.
    assert!((figures[2] / rms - 1.0).abs() < 0.02 && (figures[3] / (0.1 * rms) - 1.0).abs() < 0.02, "{message}");
    assert!(!message.contains("transient"));
}

#[test]
fn one_period_continues_itself_through_the_filters() {
    let p = 240;
    let wave = |t: f64| {
        let x = TAU * t / (p as f64 * TS);
        x.sin() + 0.4 * (3.0 * x + 1.0).cos()
    };
    let three = record(series(3 * p, wave), series(3 * p, |t| wave(t - 0.4e-4)));
    let options = with(|o| (o.average, o.delay, o.decimate) = (true, Some(0.4e-4), Some(6)));
    let result = prepared(&options, &three);
    let expected: Vec<f64> = series(p, wave).into_iter().step_by(6).collect();
    assert_close(result.u(), &expected, 0.0, 2e-4);
    assert_close(result.y(), &expected, 0.0, 2e-4);
    assert_eq!(result.history().len(), 3);
    let result = prepared(&with(|o| (o.average, o.resample) = (true, Some(1.6e-4))), &three);
    assert_close(result.u(), &(0..150).map(|k| wave(f64::from(k) * 1.6e-4)).collect::<Vec<_>>(), 0.0, 2e-4);
}

#[test]
fn a_transient_and_a_wrong_period_are_told() {
    let p = 100;
    let wave = |t: f64| (TAU * t / (p as f64 * TS)).sin();
    let settling = record(series(8 * p, wave), series(8 * p, |t| wave(t) - (-t / 3e-3).exp()));
    let message = prepared(&with(|o| o.average = true), &settling).history()[0].clone();
    assert!(message.contains("; the first of them differs from the others, like a transient, by"), "{message}");
    let later = prepared(&with(|o| o.average = true), &settling.part(0.02, 1.0).unwrap());
    assert!(!later.history()[1].contains("transient"), "{:?}", later.history());
    let input = |period: f64| with(|o| (o.average, o.period) = (true, Some(period)));
    assert_eq!(prepared(&input(0.02), &settling).len(), 200, "two periods as one");
    assert!(refused(input(0.013), &settling).contains("does not repeat with this period: its periods differ by"));
    assert!(refused(input(0.05), &settling).contains("no two periods"));
    assert!(refused(input(1.05e-3), &settling).contains("must be a multiple of the sampling period of 0.0001 s"));
    let ramp = record(series(500, |t| t), series(500, |t| t));
    assert!(refused(with(|o| o.average = true), &ramp).ends_with("apart from noise, give `period`"));
}

#[test]
fn exactly_the_spikes_that_were_put_in_are_replaced() {
    let n = 4000;
    let clean = record(series(n, |t| 30.0 * sine(5.0)(t)), series(n, |t| 20.0 * sine(5.0)(t - 1e-3)));
    let spikes = [(150, 3.0), (151 + 40, -1.5), (900, 0.8), (2500, -8.0), (3900, 100.0)];
    let mut y: Vec<f64> = clean.y().iter().zip(noise(3, n)).map(|(y, e)| y + 1e-3 * e).collect();
    let before = y.clone();
    spikes.iter().for_each(|(t, size)| y[*t] += size);
    let options = with(|o| o.outliers = true);
    let result = prepared(&options, &record(clean.u().to_vec(), y.clone()));
    let changed: Vec<usize> = (0..n).filter(|t| result.y()[*t] != y[*t]).collect();
    assert_eq!(changed, spikes.map(|(t, _)| t));
    assert_close(result.y(), &before, 0.0, 5e-3);
    let message = &result.history()[0];
    assert!(
        message.starts_with("outliers of the output replaced by interpolation: 5 samples in 5 places"),
        "{message}"
    );
    assert_eq!(prepared(&options, &clean).history(), ["no outliers were found in the output"]);
    assert!(
        refused(options, &record(vec![1.0; 50], series(50, |t| t))).starts_with("outliers cannot be found: the input")
    );
}

#[test]
fn trends_and_offsets_are_taken_from_their_channels() {
    let line = record(series(101, |t| t), series(101, |t| 5.0 + 40.0 * t));
    let result = prepared(&with(|o| o.detrend = Some(Trend::Line)), &line);
    assert_close(result.y(), &[0.0; 101], 0.0, 1e-12);
    assert_eq!(
        (result.u(), &*result.history()[0]),
        (line.u(), "line removed from the output: 5.200 um in its middle, 40.00 um/s")
    );
    let result = prepared(&with(|o| o.detrend = Some(Trend::Mean)), &line);
    assert_close(&[result.y()[0], result.y()[100]], &[-0.2, 0.2], 1e-9, 0.0);
    let result = prepared(&with(|o| (o.input_offset, o.output_offset) = (50.0, -5.0)), &line);
    assert_close(&[result.u()[0], result.y()[0]], &[50.0, 0.0], 0.0, 1e-12);
    assert_eq!(result.history(), ["50 V added to the input", "-5 um added to the output"]);
}

#[test]
fn values_that_do_not_suit_the_record_are_refused_with_what_to_do() {
    let wave = record(series(100, sine(400.0)), series(100, sine(400.0)));
    let messages = [
        (with(|o| o.decimate = Some(0)), "decimate = 0: must be a whole number, 1 or more"),
        (with(|o| o.decimate = Some(100)), "decimate = 100: the record has only 100 samples: choose a smaller factor"),
        (
            with(|o| o.resample = Some(0.5)),
            "resample = 0.5 s: fewer than two samples would remain of the record of 0.01 s",
        ),
        (with(|o| o.resample = Some(1e-13)), "choose 1e-10 s or more"),
        (with(|o| o.resample = Some(-1.0)), "resample = -1: must be a positive number of seconds"),
        (with(|o| o.delay = Some(0.0099)), "delay = 0.0099 s: the record is only 0.01 s long"),
        (with(|o| o.delay = Some(f64::NAN)), "delay = NaN s"),
        (with(|o| o.output_offset = f64::INFINITY), "y[0] is inf"),
        (with(|o| (o.decimate, o.resample) = (Some(2), Some(1.0))), "resample = 1 s: give either decimate or resample"),
        (with(|o| o.period = Some(0.01)), "period = 0.01 s: is needed only for an average: give `average` = true"),
        (
            with(|o| (o.average, o.decimate) = (true, Some(3))),
            "decimate = 3: the period of 25 samples is no multiple of it",
        ),
        (
            with(|o| (o.average, o.resample) = (true, Some(3e-4))),
            "resample = 0.0003 s: the period of 0.0025 s is no multiple",
        ),
    ];
    for (options, expected) in messages {
        let message = refused(options, &wave);
        assert!(message.contains(expected), "{message} is not {expected}");
    }
}

#[test]
fn no_record_is_too_short_or_too_odd_to_be_answered() {
    let records = [
        record(vec![1.0], vec![2.0]),
        record(vec![1.0, 2.0], vec![2.0, 2.0]),
        record(vec![0.0; 3], vec![1e308, -1e308, 1e308]),
        Record::new(f64::MAX / 4.0, vec![1.0, 2.0, 3.0], vec![2.0, 2.0, 1.0]).unwrap(),
        Record::new(f64::MIN_POSITIVE, vec![1.0, 2.0, 1.0, 2.0], vec![2.0, 2.0, 1.0, 2.0]).unwrap(),
    ];
    let changes: [fn(&mut PrepareOptions); 9] = [
        |o| o.decimate = Some(2),
        |o| o.decimate = Some(usize::MAX),
        |o| o.resample = Some(3e-5),
        |o| o.resample = Some(f64::MAX),
        |o| o.delay = Some(-1e-5),
        |o| o.delay = Some(f64::MIN_POSITIVE),
        |o| o.average = true,
        |o| o.outliers = true,
        |o| o.detrend = Some(Trend::Line),
    ];
    for record in &records {
        for change in changes {
            match with(change).run(record) {
                Ok(result) => {
                    assert!(result.ts() > 0.0 && result.ts().is_finite() && result.len() > 0);
                    assert!(result.u().iter().chain(result.y()).all(|v| v.is_finite()));
                }
                Err(error) => assert!(!error.to_string().is_empty()),
            }
        }
    }
}

/// The steps against scipy; `golden/preparation.py` writes the numbers.
mod golden {
    use super::*;
    use piezoid_testing::golden::{file, numbers};

    #[test]
    fn the_anti_alias_filter_is_the_one_that_scipy_designs() {
        let golden = file("preparation");
        for row in golden["taps"].as_array().unwrap() {
            let factor = row["factor"].as_u64().unwrap() as usize;
            assert_close(&Kernel::anti_alias().taps(factor), &numbers(row, "taps"), 0.0, 1e-9);
        }
        assert_close(&Kernel::between().taps(4), &numbers(&golden, "between"), 0.0, 1e-9);
    }

    #[test]
    fn trends_decimation_and_a_resampled_period_are_scipys() {
        let golden = file("preparation");
        let [u, y] = ["u", "y"].map(|name| numbers(&golden, name));
        let record = record(u, y);
        let check = |options: PrepareOptions, name: &str, ends: usize, atol: f64| {
            let (result, expected) = (prepared(&options, &record), numbers(&golden, name));
            assert_close(inner(result.y(), ends), inner(&expected, ends), 0.0, atol);
        };
        check(with(|o| o.detrend = Some(Trend::Line)), "line", 0, 1e-11);
        check(with(|o| o.detrend = Some(Trend::Mean)), "mean", 0, 1e-11);
        check(with(|o| o.decimate = Some(4)), "decimated", 30, 1e-9);
        check(with(|o| (o.average, o.resample) = (true, Some(1.6e-4))), "resampled", 0, 3e-4);
    }
}
