//! An axis: its label, ticks and range.

use super::scale::Scale;
use super::ticks::{self, Tick};

/// A horizontal or vertical axis.
///
/// ```
/// use piezoid_report::plot::Axis;
/// let frequency = Axis::log("f [Hz]").ticks(&[5.0, 20.0, 40.0, 80.0, 250.0]);
/// let error = Axis::new("rms error [% of p-p]").from(0.0);
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Axis {
    pub(super) label: String,
    log: bool,
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

    /// Labels exactly these values.
    pub fn ticks(self, at: &[f64]) -> Self {
        Axis { ticks: at.to_vec(), ..self }
    }

    /// Starts and ends with the data instead of at round numbers.
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
        let shown = |v: &f64| v.is_finite() && (!self.log || *v > 0.0);
        let range = self.range.filter(|(low, high)| low < high && shown(low) && shown(high));
        let (mut low, mut high) = range.unwrap_or_else(|| {
            let all = data.chain(self.include.iter().copied()).chain(self.ticks.iter().copied());
            let ends = all.filter(shown).fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)));
            self.opened(ends)
        });
        let given = !self.ticks.is_empty();
        let free = range.is_none() && !self.tight && !given;
        let step = ticks::TickStep::nice((high - low) / count.max(1) as f64);
        match (free, self.log) {
            (true, true) => (low, high) = (ticks::log_floor(low), ticks::log_ceil(high)),
            (true, false) => (low, high) = step.enclose(low, high),
            (false, false) if self.tight => high = step.complete(low, high),
            _ => {}
        }
        let found = match (given, self.log) {
            (true, _) => self.ticks.iter().map(|&at| Tick::plain(at)).collect(),
            (false, true) => ticks::log(low, high, count),
            (false, false) => ticks::linear(low, high, step),
        };
        // Given ticks are slightly inside the ends, so that the frame does not cut the marks there.
        let margin = if given && range.is_none() { 0.03 } else { 0.0 };
        let scale = if self.log {
            let factor = (high / low).powf(margin);
            Scale::log(low / factor, high * factor)
        } else {
            let more = margin * (high - low);
            Scale::linear(low - more, high + more)
        };
        (scale, found)
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

    fn ends(axis: &Axis, data: &[f64]) -> (f64, f64) {
        let (scale, ticks) = axis.resolve(data.iter().copied(), 6);
        assert!(ticks.len() >= 2 && ticks.len() < 60, "{data:?}: {ticks:?}");
        assert!(ticks.iter().any(|t| !t.label.is_empty()));
        (scale.low, scale.high)
    }

    #[test]
    fn an_axis_ends_on_round_numbers_that_enclose_the_data() {
        assert_eq!(ends(&Axis::new("y"), &[0.0, 117.0]), (0.0, 120.0));
        assert_eq!(ends(&Axis::new("y"), &[-0.016, 0.029]), (-0.02, 0.03));
        assert_eq!(ends(&Axis::log("f"), &[7.0, 180.0]), (5.0, 200.0));
        assert_eq!(ends(&Axis::new("y").from(0.0), &[40.0, 50.0]), (0.0, 50.0));
        assert_eq!(ends(&Axis::new("t").tight(), &[0.0, 0.73]), (0.0, 0.73));
        assert_eq!(ends(&Axis::new("t").tight(), &[0.0, 1.9995]), (0.0, 2.0), "the last sample of two seconds");
    }

    #[test]
    fn data_slightly_below_zero_do_not_cost_a_whole_step() {
        assert_eq!(ends(&Axis::new("z"), &[-12.0, 1630.0]), (-100.0, 1700.0));
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
    fn given_ticks_are_labelled_exactly() {
        let axis = Axis::log("f").ticks(&[5.0, 20.0, 2.5]);
        let labels: Vec<String> = axis.resolve([6.0].into_iter(), 6).1.into_iter().map(|t| t.label).collect();
        assert_eq!(labels, ["5", "20", "2.5"]);
    }
}
