//! Minor loops of an input: reversals that are nested within a branch.
//!
//! As in counting by rainflow (ASTM E1049), a movement is nested if the movements before and after it are larger. A few
//! equal cycles between larger movements are nested too. More of them are cycles of their own: a record may change
//! between amplitudes.

/// A movement is larger than another from this ratio on; nearer ones are equal.
const LARGER: f64 = 1.2;

/// Largest number of equal cycles one after the other that are minor loops.
const MAX_LOOPS: usize = 3;

/// The reversals of an input without those of minor loops, and the minor loops.
pub(super) struct Nested {
    /// The samples of the other reversals.
    pub(super) reversals: Vec<usize>,
    /// The minor loops: a reversal, the next one, and the sample at which the input is back at the value of the first.
    pub(super) loops: Vec<[usize; 3]>,
    /// Number of minor loops that contain others.
    pub(super) containing: usize,
}

impl Nested {
    /// Of `u` with these reversals.
    pub(super) fn of(u: &[f64], reversals: &[usize]) -> Self {
        let mut found = Nested { reversals: Vec::new(), loops: Vec::new(), containing: 0 };
        for at in reversals {
            found.reversals.push(*at);
            while let Some(first) = found.nested(u) {
                found.separate(u, first);
            }
        }
        found.loops.sort_unstable_by_key(|minor| minor[0]);
        found
    }

    /// The place of the first reversal of nested cycles before the last movement.
    fn nested(&self, u: &[f64]) -> Option<usize> {
        let kept = &self.reversals;
        let movement = |k: usize| (u[kept[k + 1]] - u[kept[k]]).abs();
        let last = kept.len().checked_sub(2)?;
        let equal = |k: &usize| movement(k - 1) <= LARGER * movement(*k) && movement(*k) <= LARGER * movement(k - 1);
        // A movement that others equal is the first of the nested ones if the one before is larger.
        let mut first = last.checked_sub(1)?;
        if movement(last) <= LARGER * movement(first) {
            return None;
        }
        while first > 0 && equal(&first) && last - first <= 2 * MAX_LOOPS {
            first -= 1;
        }
        (first > 0 && last - first <= 2 * MAX_LOOPS && movement(first - 1) > LARGER * movement(first)).then_some(first)
    }

    /// Takes the reversals from this place on, but the last one, or two, which belong to the branch.
    fn separate(&mut self, u: &[f64], first: usize) {
        // With an odd number of movements the branch goes on; with an even one it turns back at the last of these.
        let movements = self.reversals.len() - 2 - first;
        let taken: Vec<usize> = self.reversals.drain(first..first + movements.next_multiple_of(2)).collect();
        let end = self.reversals[first];
        for pair in taken.chunks_exact(2) {
            let (start, turn) = (pair[0], pair[1]);
            let up = (u[start] - u[turn]).signum();
            let back = (turn..=end).find(|t| (u[*t] - u[start]) * up >= 0.0).unwrap_or(end);
            self.containing += usize::from(self.loops.last().is_some_and(|inner| (start..back).contains(&inner[0])));
            self.loops.push([start, turn, back]);
        }
    }
}
