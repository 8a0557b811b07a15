//! Compact path data: relative moves in tenths of a unit, without accumulated rounding.

use super::text::{in_tenths, tenths};

/// A point in the coordinates of the drawing.
pub(super) type Point = [f64; 2];

/// The `d` attribute of a path.
#[derive(Debug, Default)]
pub(super) struct PathData {
    d: String,
    /// Positions of the pen and of the start of the outline [tenths].
    at: [i64; 2],
    from: [i64; 2],
    command: char,
}

impl PathData {
    /// Moves the pen to `p`.
    pub(super) fn start(&mut self, p: Point) {
        self.step('m', p);
    }

    /// Draws to `p`, unless the pen is there already.
    pub(super) fn line(&mut self, p: Point) {
        if p.map(in_tenths) != self.at || self.command == 'm' {
            self.step('l', p);
        }
    }

    /// The polyline through `points`; a single point becomes a dot with the width of the stroke.
    pub(super) fn polyline(&mut self, points: &[Point]) {
        let Some((first, rest)) = points.split_first() else { return };
        if rest.is_empty() {
            return self.dot(*first);
        }
        self.start(*first);
        rest.iter().for_each(|p| self.line(*p));
    }

    /// A dot with the width of the stroke, for round line ends.
    pub(super) fn dot(&mut self, p: Point) {
        self.step('m', p);
        self.raw("h0");
    }

    /// Closes the outline; the pen returns to its start.
    pub(super) fn close(&mut self) {
        self.raw("z");
        self.at = self.from;
    }

    /// Commands that do not move the pen.
    pub(super) fn raw(&mut self, commands: &str) {
        self.d.push_str(commands);
        self.command = ' ';
    }

    /// The path data.
    pub(super) fn finish(self) -> String {
        self.d
    }

    fn step(&mut self, command: char, p: Point) {
        let to = p.map(in_tenths);
        let [dx, dy] = [to[0] - self.at[0], to[1] - self.at[1]];
        // After a move, further pairs are lines without a letter.
        let implied = command == 'l' && matches!(self.command, 'l' | 'm');
        if !implied {
            self.d.push(command);
        } else if dx >= 0 {
            self.d.push(' ');
        }
        self.d.push_str(&tenths(dx));
        if dy >= 0 {
            self.d.push(' ');
        }
        self.d.push_str(&tenths(dy));
        (self.at, self.command) = (to, command);
        if command == 'm' {
            self.from = to;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polyline_is_written_in_relative_steps() {
        let mut path = PathData::default();
        path.polyline(&[[1.0, 2.0], [2.5, 1.0], [2.0, 3.0]]);
        path.polyline(&[[9.0, 9.0]]);
        assert_eq!(path.finish(), "m1 2 1.5-1-0.5 2m7 6h0");
    }

    #[test]
    fn the_outline_after_a_closed_one_starts_at_the_right_place() {
        let mut path = PathData::default();
        for x in [0.0, 10.0] {
            path.polyline(&[[x, 0.0], [x + 5.0, 0.0], [x + 5.0, 5.0]]);
            path.close();
        }
        assert_eq!(path.finish(), "m0 0 5 0 0 5zm10 0 5 0 0 5z");
    }

    #[test]
    fn rounding_does_not_accumulate() {
        let mut path = PathData::default();
        let points: Vec<Point> = (0..1000).map(|i| [f64::from(i) * 0.149, 0.0]).collect();
        path.polyline(&points);
        assert_eq!(path.at, [in_tenths(999.0 * 0.149), 0]);
    }
}
