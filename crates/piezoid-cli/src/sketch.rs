//! A signal as a few lines of text: its range in each column, in dots of Braille characters.

use piezoid_numerics::series::ends;

/// Lines of a sketch, of four dots each.
const LINES: usize = 4;

/// The signal over time, `width` characters wide, with its name and range on the left.
pub(crate) fn sketch(name: &str, samples: &[f64], width: usize) -> String {
    let mut sketch = Sketch::new(name, ends(samples.iter().copied()), samples.len(), width);
    sketch.add(samples);
    sketch.text()
}

/// A sketch of a signal whose range and length are known, piece by piece.
pub(crate) struct Sketch<'a> {
    name: &'a str,
    low: f64,
    high: f64,
    /// Number of samples in all, and so far.
    n: usize,
    taken: usize,
    /// The range of the samples of each column of dots.
    columns: Vec<(f64, f64)>,
}

impl<'a> Sketch<'a> {
    pub(crate) fn new(name: &'a str, (low, high): (f64, f64), n: usize, width: usize) -> Self {
        let margin = margin(name, &labels(low, high));
        let columns = vec![ends([]); 2 * width.saturating_sub(margin + 2).max(1)];
        Sketch { name, low, high, n, taken: 0, columns }
    }

    /// The next samples.
    pub(crate) fn add(&mut self, samples: &[f64]) {
        let (first, count) = (self.taken, self.columns.len());
        self.taken += samples.len();
        for (column, range) in self.columns.iter_mut().enumerate() {
            let from = column * self.n / count;
            let to = ((column + 1) * self.n / count).max(from + 1);
            let part = from.max(first)..to.min(self.taken);
            let new = if part.is_empty() { &[][..] } else { &samples[part.start - first..part.end - first] };
            let (low, high) = ends(new.iter().copied());
            *range = (range.0.min(low), range.1.max(high));
        }
    }

    pub(crate) fn text(&self) -> String {
        lines(self.name, (self.low, self.high), &self.columns)
    }
}

/// The largest and the smallest number.
fn labels(low: f64, high: f64) -> [String; 2] {
    [high, low].map(piezoid_numerics::number::short)
}

/// Characters on the left.
fn margin(name: &str, labels: &[String]) -> usize {
    labels.iter().map(String::len).max().unwrap_or(0).max(name.len())
}

fn lines(name: &str, (low, high): (f64, f64), columns: &[(f64, f64)]) -> String {
    let labels = labels(low, high);
    let margin = margin(name, &labels);
    let rows = 4 * LINES;
    let level = |v: f64| ((v - low) / (high - low).max(f64::MIN_POSITIVE) * (rows - 1) as f64).round() as usize;
    let mut cells = vec![[0u8; LINES]; columns.len() / 2];
    for (column, &(bottom, top)) in columns.iter().enumerate().filter(|(_, (bottom, top))| bottom <= top) {
        for dot in level(bottom)..=level(top).min(rows - 1) {
            let down = rows - 1 - dot;
            if let Some(cell) = cells.get_mut(column / 2) {
                cell[down / 4] |= DOTS[column % 2][down % 4];
            }
        }
    }
    let line = |k: usize| {
        let label = match k {
            0 => &labels[0],
            k if k == LINES - 1 => &labels[1],
            1 => name,
            _ => "",
        };
        let dots: String =
            cells.iter().map(|cell| char::from_u32(0x2800 + u32::from(cell[k])).unwrap_or(' ')).collect();
        format!("{label:>margin$}  {}\n", dots.trim_end_matches('\u{2800}'))
    };
    (0..LINES).map(line).collect()
}

/// Bits of the dots of a Braille character: left and right column, from the top.
const DOTS: [[u8; 4]; 2] = [[0x01, 0x02, 0x04, 0x40], [0x08, 0x10, 0x20, 0x80]];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ramp_goes_from_the_lower_left_to_the_upper_right() {
        let ramp: Vec<f64> = (0..64).map(f64::from).collect();
        let text = sketch("u", &ramp, 20);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), LINES);
        assert!(
            lines[0].starts_with("63.00  ") && lines[1].starts_with("    u  ") && lines[3].starts_with("    0  "),
            "{text}"
        );
        assert!(lines.iter().all(|line| line.chars().count() <= 20), "{text}");
        assert!(lines[3].chars().nth(7).is_some_and(|c| c > '\u{2800}'), "{text}");
        assert!(lines[0].chars().last().is_some_and(|c| c > '\u{2800}'), "{text}");
    }

    #[test]
    fn any_signal_has_a_sketch() {
        for samples in [vec![], vec![1.0], vec![2.0; 5], vec![-1e300, 1e300], vec![0.0, f64::MIN_POSITIVE]] {
            assert_eq!(sketch("y", &samples, 10).lines().count(), LINES, "{samples:?}");
        }
    }
}
