//! An axis: its label, ticks and range.

use super::scale::Scale;
use super::ticks::{self, Tick, TickStep};

/// Room beside the outermost data, as a share of the range.
const ROOM: f64 = 0.04;

/// A horizontal or vertical axis. Its range is that of the data with a little room; its ticks are round numbers inside.
///
/// ```
/// use piezoid_report::plot::Axis;
/// let frequency = Axis::log("f [Hz]").ticks(&[5.0, 20.0, 40.0, 80.0, 250.0]);
/// let error = Axis::new("rms error [% of p-p]").from(0.0);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    pub(super) label: String,
    pub(super) log: bool,
    tight: bool,
    ticks: Vec<f64>,
    include: Vec<f64>,
    range: Option<(f64, f64)>,
}

impl Axis {
    /// A linear axis. The label ends with its unit in brackets.
    pub fn new(label: impl Into<String>) -> Self {
        let label = label.into();
        Axis { label, log: false, tight: false, ticks: Vec::new(), include: Vec::new(), range: None }
    }

    /// A logarithmic axis to base 10, which shows positive values only.
    pub fn log(label: impl Into<String>) -> Self {
        Axis { log: true, ..Axis::new(label) }
    }

    /// Labels exactly the values in the range, if there are at least two of them.
    pub fn ticks(self, at: &[f64]) -> Self {
        Axis { ticks: at.to_vec(), ..self }
    }

    /// Starts and ends with the data, without room.
    pub fn tight(self) -> Self {
        Axis { tight: true, ..self }
    }

    /// Includes this value: `from(0.0)` starts an axis of positive data at zero.
    pub fn from(mut self, value: f64) -> Self {
        self.include.push(value);
        self
    }

    /// Shows exactly this range; data outside is clipped.
    pub fn range(self, low: f64, high: f64) -> Self {
        Axis { range: Some((low, high)), ..self }
    }

    /// True if data may lie outside the range.
    pub(super) fn cuts(&self) -> bool {
        self.range.is_some()
    }

    /// The scale for the data, and its ticks with about `count` labels.
    pub(super) fn resolve(&self, data: impl Iterator<Item = f64>, count: usize) -> (Scale, Vec<Tick>) {
        let drawn = |v: &f64| v.is_finite() && (!self.log || *v > 0.0);
        let range = self.range.filter(|(low, high)| low < high && drawn(low) && drawn(high));
        let (low, high) = range.unwrap_or_else(|| {
            let all = data.chain(self.include.iter().copied());
            let ends = all.filter(drawn).fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)));
            self.padded(self.opened(ends), count)
        });
        let inside = |v: &&f64| drawn(v) && (low..=high).contains(*v);
        let arguments: Vec<Tick> = self.ticks.iter().filter(inside).map(|&at| Tick::plain(at)).collect();
        let found = match self.log {
            _ if arguments.len() > 1 => arguments,
            true => ticks::log(low, high, count),
            false => ticks::linear(low, high, TickStep::within(low, high, count)),
        };
        (if self.log { Scale::log(low, high) } else { Scale::linear(low, high) }, found)
    }

    /// The ends with some room, so that the frame does not cut the outermost data. An end stays where it is if the
    /// axis is to start there, or is tight.
    fn padded(&self, (low, high): (f64, f64), count: usize) -> (f64, f64) {
        if self.tight {
            let step = TickStep::nice((high - low) / count.max(1) as f64);
            return (low, if self.log { high } else { step.complete(low, high) });
        }
        let share = |end: f64| if self.include.contains(&end) { 0.0 } else { ROOM };
        let (below, above) = (share(low), share(high));
        if self.log {
            let span = high.ln() - low.ln();
            let [low, high] = [low.ln() - below * span, high.ln() + above * span].map(f64::exp);
            (low.max(f64::MIN_POSITIVE), high.min(f64::MAX))
        } else {
            let span = high - low;
            (low - below * span, high + above * span)
        }
    }

    /// Ends that enclose a range even for empty or constant data.
    fn opened(&self, (low, high): (f64, f64)) -> (f64, f64) {
        match (low > high, self.log) {
            (true, true) => (1.0, 10.0),
            (true, false) => (0.0, 1.0),
            (false, true) => {
                let (low, high) = (low.clamp(1e-300, 1e300), high.clamp(1e-300, 1e300));
                if high / low > 1.0 + 1e-9 { (low, high) } else { (low / 3.0, high * 3.0) }
            }
            (false, false) => {
                let (low, high) = (low.clamp(-1e300, 1e300), high.clamp(-1e300, 1e300));
                let size = low.abs().max(high.abs());
                let around = if size > 1e-300 { 0.1 * size } else { 1.0 };
                if high - low > 1e-9 * size { (low, high) } else { (low - around, high + around) }
            }
        }
    }
}

/// A linear axis with this label.
impl From<&str> for Axis {
    fn from(label: &str) -> Self {
        Axis::new(label)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;

    fn ends(axis: &Axis, data: &[f64]) -> (f64, f64) {
        let (scale, ticks) = axis.resolve(data.iter().copied(), 6);
        assert!(ticks.len() >= 2 && ticks.len() < 60, "{data:?}: {ticks:?}");
        assert!(ticks.iter().any(|t| !t.label.is_empty()));
        (scale.low, scale.high)
    }

    #[test]
    fn an_axis_fits_its_data_with_four_percent_of_room() {
        let fits = |axis: Axis, data: [f64; 2], expected: [f64; 2]| {
            let (low, high) = ends(&axis, &data);
            assert_close(&[low, high], &expected, 1e-3, 1e-12);
        };
        fits(Axis::new("y"), [-25.0, 75.0], [-29.0, 79.0]);
        fits(Axis::new("z"), [-12.0, 1630.0], [-77.7, 1695.7]);
        fits(Axis::log("f"), [10.0, 1000.0], [8.318, 1202.0]);
        fits(Axis::new("y").from(0.0), [40.0, 50.0], [0.0, 52.0]);
        fits(Axis::new("y").ticks(&[-90.0, 0.0, 90.0, 180.0]), [0.0, 100.0], [-4.0, 104.0]);
        fits(Axis::new("t").tight(), [0.0, 0.73], [0.0, 0.73]);
        fits(Axis::new("t").tight(), [0.0, 1.9995], [0.0, 2.0]);
    }

    #[test]
    fn empty_constant_and_extreme_data_give_a_valid_axis() {
        let (tiny, max) = (f64::MIN_POSITIVE, f64::MAX);
        let hard: [&[f64]; 9] = [
            &[],
            &[f64::NAN, f64::INFINITY],
            &[0.0],
            &[5.0, 5.0],
            &[-1e-320],
            &[max, f64::MIN],
            &[1e300],
            &[1.0, 1.0 + 1e-15],
            &[tiny, max],
        ];
        for data in hard {
            for axis in [Axis::new("x"), Axis::log("x"), Axis::new("x").tight(), Axis::new("x").range(2.0, 1.0)] {
                let (low, high) = ends(&axis, data);
                assert!(low.is_finite() && high.is_finite() && low < high, "{data:?}: {low} {high}");
            }
        }
    }

    #[test]
    fn given_ticks_in_the_range_are_labelled_exactly() {
        let axis = Axis::log("f").ticks(&[5.0, 20.0, 2.5, 80.0]);
        let labels = |data: [f64; 2]| -> Vec<String> {
            axis.resolve(data.into_iter(), 6).1.into_iter().map(|t| t.label).filter(|l| !l.is_empty()).collect()
        };
        assert_eq!(labels([2.4, 40.0]), ["5", "20", "2.5"]);
        assert_eq!(labels([30.0, 100.0]), ["50", "100"], "one given tick is not an axis");
    }
}
