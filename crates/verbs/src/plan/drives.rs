//! The drives of a plan: a shape between -1 and 1 about the middle, with the amplitude that the limits allow.

use super::{MAX_SAMPLES, PlannedDrive, Rig};
use libm::{cos, sin};
use piezoid_numerics::error::Error;
use piezoid_numerics::number::{quantity, round};
use piezoid_records::excitation::{DecayingSine, Multisine, RisingSine, minimum_jerk};
use std::f64::consts::TAU;

/// Part of the slew and current limits that is used: the rest is for capacitance at large signals and for ripple.
const PART: f64 = 0.9;

/// Amplitude of the small signal, as a share of the range: its peak-to-peak is 2 %, where loops are still thin.
const SMALL_SIGNAL_RANGE_SHARE: f64 = 0.01;

/// Amplitudes of the large signals, as shares of half the range. The path stays inside the sines: it validates the
/// model, not an extrapolation.
const RISE: f64 = 0.95;
const STEP: f64 = 0.8;
const PATH: f64 = 0.9;

/// Smallest amplitude that is still useful, as a share of the wanted one.
const LEAST: f64 = 0.05;

/// Longest creep record [s], and its fewest samples.
const CREEP: f64 = 60.0;
const POINTS: usize = 240;

/// Longest time of the moves of the creep record that dynamics need, as a share of it.
const MOVES: f64 = 1.0 / 24.0;

/// Time over which a driver warms up [s]: its continuous current is a mean over it.
const WARM: f64 = 1.0;

/// Periods in which the rising sines grow, from the slowest to the fastest. Fast ones are short, so they may have more.
const PERIODS: [usize; 3] = [12, 20, 40];

/// Fewest periods with which a sine still grows slowly enough.
const FEWEST: usize = 4;

/// Fewest samples of a period that is sampled less often than the others.
const SMOOTH: f64 = 50.0;

/// Periods of a demagnetisation: its steps are a 25th of the amplitude.
const DECAY: f64 = 25.0;

/// Periods in which a rising sine falls again.
const FALL: f64 = 2.0;

/// All drives in the order of measurement: the small signal first, before large ones and the creep that they leave.
pub(super) fn all(rig: &Rig, notes: &mut Vec<String>) -> Result<Vec<PlannedDrive>, Error> {
    let b = rig.bandwidth;
    let (slow, middle) = (slowest(b), two_digits(b / 3.0));
    Ok(vec![
        small(rig, notes)?,
        rise(rig, 0, slow, notes)?,
        rise(rig, 1, middle, notes)?,
        rise(rig, 2, b, notes)?,
        creep(rig, notes)?,
        path(rig, notes)?,
    ])
}

/// A multisine up to nine tenths of the Nyquist frequency. Its lowest line is a tenth of the bandwidth or less.
fn small(rig: &Rig, notes: &mut Vec<String>) -> Result<PlannedDrive, Error> {
    let mut period = ((10.0 / (rig.bandwidth * rig.ts)).max(2048.0) as usize).next_power_of_two();
    while 9 * period > 4 * rig.points && period > 64 {
        period /= 2;
    }
    let (lead, ts) = (period / 8, rig.ts);
    let whole = Multisine {
        frequency_low: 0.99 / (period as f64 * ts),
        frequency_high: 0.45 / ts,
        period: period as f64 * ts,
        ..Multisine::default()
    };
    let sines = whole.samples(ts, period)?;
    let n = 2 * period + 2 * lead;
    let shape: Vec<f64> = (0..n).map(|t| sines[(t + period - lead) % period] * faded(t, n, lead)).collect();
    rig.drive(
        ("small", "linear dynamics"),
        (ts, &shape),
        2.0 * SMALL_SIGNAL_RANGE_SHARE * rig.half(),
        "a small signal",
        notes,
    )
}

/// The frequency of the slowest sine.
pub(super) fn slowest(bandwidth: f64) -> f64 {
    two_digits(0.1 * bandwidth)
}

/// The shortest sampling period with which a sine of this frequency has its fewest periods in so many samples [s].
pub(super) fn shortest_period(hz: f64, points: usize) -> f64 {
    (FEWEST as f64 + FALL) / (hz * points as f64)
}

/// A sine that rises to its amplitude, and falls to zero in its last periods.
fn rise(rig: &Rig, k: usize, hz: f64, notes: &mut Vec<String>) -> Result<PlannedDrive, Error> {
    let ts = rig.rare((PERIODS[k] as f64 + FALL) / hz, hz) * rig.ts;
    let (period, most) = (1.0 / (hz * ts), rig.points as f64);
    let room = (most.min(rig.longest() / ts) / period - FALL) as usize;
    if room < FEWEST {
        let least = shortest_period(hz, rig.points);
        let rule = format!(
            "{FEWEST} periods of {} Hz, the slowest sine, would have more than {most} samples: take {} s or more, or \
             raise the bandwidth",
            round(hz),
            round(least)
        );
        return Err(Error::parameter("ts", format!("{} s", rig.ts), rule));
    }
    let n = (PERIODS[k].min(room) as f64 * period).round() as usize;
    let fall = (FALL * period).round() as usize;
    let mut shape = RisingSine { amplitude: 1.0, frequency: hz, offset: 0.0 }.samples(ts, n)?;
    shape.extend((n..=n + fall).map(|t| {
        let left = 1.0 - eased((t - n) as f64 / fall as f64);
        left * sin(TAU * (hz * ts * t as f64).fract())
    }));
    let (name, purpose) = [
        ("rise1", "hysteresis, slow"),
        ("rise2", "hysteresis, middle of the band"),
        ("rise3", "hysteresis, highest frequency"),
    ][k];
    if let Some(f0) = rig.resonance.filter(|f0| hz > 0.3 * f0) {
        let (hz, f0, ratio) = (quantity(hz, "Hz"), quantity(f0, "Hz"), hz / f0);
        let larger = match (1.0 - ratio * ratio).abs() {
            gap if gap > 0.3 => format!("{} times the static one", round((100.0 / gap).round() / 100.0)),
            _ => "several times the static one: lower the bandwidth unless the actuator bears it".into(),
        };
        notes.push(format!(
            "{name}_u.csv: at {hz}, near the resonance of {f0}, the displacement is {larger}; check the range of the \
             sensor"
        ));
    }
    let what = format!("a sine of {} Hz", round(hz));
    rig.drive((name, purpose), (ts, &shape), RISE * rig.half(), &what, notes)
}

/// A step up and a step down, each held. Nothing rings: the moves take two periods of the bandwidth, or
/// a 24th of the record if that is shorter.
fn creep(rig: &Rig, notes: &mut Vec<String>) -> Result<PlannedDrive, Error> {
    const STEEPEST: f64 = 1.875; // slope of `moved`
    let a = STEP * rig.half();
    let longest = CREEP.min(rig.longest());
    let ts = rig.rare(longest, 0.0) * rig.ts;
    let n = ((longest / ts) as usize).clamp(POINTS, rig.points.max(POINTS));
    let unhurried = (2.0 / rig.bandwidth).min(MOVES * n as f64 * ts);
    let fastest = PART * rig.limits.fastest();
    let move_of = |volts: f64| ((STEEPEST * volts / fastest).max(unhurried) / ts).ceil() as usize + 1;
    let (single, double) = (move_of(a), move_of(2.0 * a));
    let moves = 2 * single + double;
    if 4 * moves > n {
        let [took, most] = [moves as f64, n as f64 / 4.0].map(|n| round(n * ts));
        let rule = format!(
            "is too large for the creep record: its moves take {took} s, but must take less than {most} s; take a \
             smaller range or a driver with more current"
        );
        return Err(Error::parameter("range", format!("{} {}", round(rig.low), round(rig.high)), rule));
    }
    let hold = (n - moves) / 2;
    let mut shape = Vec::with_capacity(n);
    for (from, to, samples, held) in [(0.0, 1.0, single, hold), (1.0, -1.0, double, hold), (-1.0, 0.0, single, 0)] {
        shape.extend((0..samples).map(|t| from + (to - from) * minimum_jerk(t as f64 / (samples - 1) as f64)));
        shape.extend(std::iter::repeat_n(to, held));
    }
    if (n as f64) * ts < 0.99 * CREEP {
        let (whole, each) = (round(n as f64 * ts), round(hold as f64 * ts));
        let most = if n == rig.points { n } else { MAX_SAMPLES };
        notes.push(format!(
            "creep_u.csv: shortened from {CREEP} s to {whole} s, because it has at most {most} samples; it shows creep up \
             to {each} s. A longer sampling period shows slower creep"
        ));
    }
    rig.drive(("creep", "creep"), (ts, &shape), a, "the steps", notes)
}

/// Sines up to the bandwidth with random phases, whose amplitude swells twice.
fn path(rig: &Rig, notes: &mut Vec<String>) -> Result<PlannedDrive, Error> {
    let (ts, b) = (rig.ts, rig.bandwidth);
    let n = (((60.0 / b).max(1.0) / ts).round() as usize).min(rig.points);
    let sines = Multisine { frequency_low: b / 20.0, frequency_high: b, seed: 1, ..Multisine::default() };
    let sines = sines.samples(ts, n)?;
    let lead = ((2.0 / (b * ts)) as usize).clamp(1, n / 4);
    let swell = |t: usize| 1.0 - 0.375 * (1.0 + cos(2.0 * TAU * t as f64 / n as f64));
    let shape: Vec<f64> = (0..n).map(|t| sines[t] * swell(t) * faded(t, n, lead)).collect();
    rig.drive(("path", "validation only"), (ts, &shape), PATH * rig.half(), "the path", notes)
}

/// Demagnetisation about the middle: a decaying sine, as fast as the limits allow at most of the range.
pub(super) fn demagnetisation(rig: &Rig, notes: &mut Vec<String>) -> Result<PlannedDrive, Error> {
    let a = RISE * rig.half();
    let fastest = rig.limits.fastest().min(rig.continuous * std::f64::consts::SQRT_2);
    let hz = two_digits((rig.bandwidth / 3.0).min(0.95 * PART * fastest / (TAU * a)).max(0.1 * rig.bandwidth));
    let ts = rig.rare(DECAY / hz, hz) * rig.ts;
    let n = ((DECAY / (hz * ts)).round() as usize + 1).min(rig.points);
    let shape = DecayingSine { amplitude: 1.0, frequency: hz, offset: 0.0 }.samples(ts, n)?;
    rig.drive(("demagnetisation", "before each record"), (ts, &shape), a, "a decaying sine", notes)
}

impl Rig {
    /// The smallest multiple of the sampling period with which so long a drive [s] fits into the samples, or the
    /// largest with which a sine of this frequency is still smooth.
    fn rare(&self, duration: f64, hz: f64) -> f64 {
        if !self.joins {
            return 1.0;
        }
        let needed = (duration.min(self.longest()) / (self.ts * self.points as f64) - 1e-9).ceil();
        needed.min((1.0 / (SMOOTH * hz * self.ts)).floor()).max(1.0)
    }

    /// The longest drive [s].
    fn longest(&self) -> f64 {
        MAX_SAMPLES as f64 * self.ts
    }

    /// The drive of this shape, with the amplitude that is wanted [V], or the one that the limits allow.
    fn drive(
        &self,
        (name, purpose): (&'static str, &'static str),
        (ts, shape): (f64, &[f64]),
        expected: f64,
        what: &str,
        notes: &mut Vec<String>,
    ) -> Result<PlannedDrive, Error> {
        let peak = shape.iter().fold(0.0, |peak: f64, s| peak.max(s.abs()));
        let step = shape.windows(2).fold(0.0, |most: f64, w| most.max((w[1] - w[0]).abs()));
        // Of peak and rms, that which leaves less.
        let peaks = (self.limits.fastest(), step);
        let lasting = (self.continuous, busiest(shape, (WARM / ts) as usize));
        let left = |(limit, step): (f64, f64)| PART * limit * ts * peak / step;
        let ((fastest, step), kind) =
            if left(lasting) < left(peaks) { (lasting, " continuously") } else { (peaks, "") };
        let allowed = left((fastest, step));
        let amplitude = expected.min(allowed);
        let [wants, allows] = [expected, allowed].map(|volts| quantity((1e3 * volts).round() / 1e3, "V"));
        if amplitude < LEAST * expected {
            let (slew, limit) = (quantity(step / peak * expected / ts, "V/s"), quantity(fastest, "V/s"));
            let rule = format!(
                "{what} of {wants} needs {slew}{kind}, but driver and load allow {limit} (at most {allows}): lower \
                 the bandwidth or the range, or take a driver with more current"
            );
            return Err(Error::parameter("bandwidth", format!("{} Hz", self.bandwidth), rule));
        }
        if amplitude < expected {
            let percent = round((1e2 * amplitude / expected).round());
            notes.push(format!(
                "{name}_u.csv: amplitude reduced from {wants} to {allows} ({percent} %), which uses {} % of the slew or \
                 current{kind}",
                100.0 * PART
            ));
        }
        let middle = self.middle();
        let u: Vec<f64> = shape.iter().map(|s| middle + amplitude * (s / peak)).collect();
        let usage = self.limits.refuse(&u, ts)?;
        Ok(PlannedDrive { name, purpose, ts, u, usage })
    }
}

/// The largest rms step of a shape over so many samples.
fn busiest(shape: &[f64], samples: usize) -> f64 {
    let squares: Vec<f64> = shape.windows(2).map(|w| (w[1] - w[0]).powi(2)).collect();
    let window = samples.clamp(1, squares.len().max(1));
    let mut sum: f64 = squares.iter().take(window).sum();
    let mut most = sum;
    for (new, old) in squares.iter().skip(window).zip(&squares) {
        sum += new - old;
        most = most.max(sum);
    }
    (most / window as f64).sqrt()
}

/// From 0 to 1 without a corner.
fn eased(x: f64) -> f64 {
    x * x * (3.0 - 2.0 * x)
}

/// Rises from 0 to 1 in the first `lead` of `n` samples, and falls to 0 in the last.
fn faded(t: usize, n: usize, lead: usize) -> f64 {
    eased((t.min(n - 1 - t) as f64 / lead as f64).min(1.0))
}

/// A frequency with two significant digits.
fn two_digits(hz: f64) -> f64 {
    format!("{hz:.1e}").parse().unwrap_or(hz)
}
