//! The memory of a Preisach operator: the dominant reversals of its input.
//!
//! The list has alternating maxima and minima, each loop inside the previous one. An input that reaches an older
//! reversal wipes out the loop that it closes and continues on the older branch. The mirror image of the first reversal
//! precedes it: outside, the relays are in the demagnetised state, up where alpha + beta < 0.
//!
//! State: number of reversals; the input; the present value; then (input, value) of each reversal, oldest first. The
//! caller chooses how many numbers a value has. When the list is full, the two neighbours with the fewest relays
//! between them are deleted. Values do not change, so there is no jump.

use crate::hysteresis::real::Real;
use crate::program::Block;

/// Maximum number of reversals. If each is at least 1/100 of the range inside the previous one, there are never more.
pub(super) const CAPACITY: usize = 64;

/// Start of the present branch.
pub(super) enum BranchStart<R = f64> {
    /// At rest: there is no reversal.
    Rest,
    /// At the last reversal, with this input.
    From(R),
}

/// State layout, given by the length of a value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Memory {
    pub(super) value: usize,
}

impl Memory {
    pub(super) fn order(self) -> usize {
        1 + (1 + self.value) * (1 + CAPACITY)
    }

    /// The present input.
    pub(super) fn input<R: Real>(self, x: &[R]) -> f64 {
        x[1].value()
    }

    /// The present value.
    pub(super) fn value<R>(self, x: &[R]) -> &[R] {
        &x[2..2 + self.value]
    }

    /// Moves the input to `u`, which differs from the present input. Returns the new branch, the value at its start
    /// (empty at rest), and the present value, which the caller updates.
    pub(super) fn travel<R: Real>(self, x: &mut [R], u: R) -> (BranchStart<R>, &[R], &mut [R]) {
        self.remember(x, u.value());
        // Deletes the loops that the movement closes.
        x[0] = (kept(|i| self.reversal(x, i), count(x), x[1].value(), u.value()) as f64).into();
        x[1] = u;
        let n = count(x);
        let (now, past) = x[2..].split_at_mut(self.value);
        match n.checked_sub(1) {
            None => (BranchStart::Rest, &[], now),
            Some(last) => {
                let reversal = &past[last * (1 + self.value)..(last + 1) * (1 + self.value)];
                (BranchStart::From(reversal[0]), &reversal[1..], now)
            }
        }
    }

    /// The branch after a movement to `u` and the value at its start (empty at rest), without changing the state.
    /// `None` if a reversal would have to be deleted first.
    pub(super) fn ahead(self, x: &[f64], u: f64) -> Option<(BranchStart, &[f64])> {
        let (stored, reverses) = (count(x), self.reverses(x, u));
        if reverses && stored == CAPACITY {
            return None;
        }
        let reversal = |i: usize| if i < stored { self.reversal(x, i) } else { x[1] };
        Some(match kept(reversal, stored + usize::from(reverses), x[1], u).checked_sub(1) {
            None => (BranchStart::Rest, &[]),
            Some(i) => {
                let at = if i < stored { self.place(i) } else { 1 };
                (BranchStart::From(x[at]), &x[at + 1..at + 1 + self.value])
            }
        })
    }

    /// True if a movement to `u` is a reversal.
    fn reverses<R: Real>(self, x: &[R], u: f64) -> bool {
        let n = count(x);
        let so_far = x[1].value() - if n == 0 { 0.0 } else { self.reversal(x, n - 1) };
        so_far != 0.0 && (so_far > 0.0) != (u > x[1].value())
    }

    /// Stores the present input and value if a movement to `u` is a reversal.
    fn remember<R: Real>(self, x: &mut [R], u: f64) {
        if !self.reverses(x, u) {
            return;
        }
        if count(x) == CAPACITY {
            self.forget(x);
        }
        let at = self.place(count(x));
        x.copy_within(1..2 + self.value, at);
        x[0] = x[0] + 1.0.into();
    }

    /// Deletes the two neighbours i and i + 1 with the fewest relays between them, in the rectangle of their own
    /// neighbours.
    fn forget<R: Real>(self, x: &mut [R]) {
        let at = |i: usize| if i < CAPACITY { self.reversal(x, i) } else { x[1].value() };
        let relays = |i: usize| ((at(i) - at(i + 2)) * (at(i + 1) - at(i - 1))).abs();
        let least = (1..CAPACITY - 1).min_by(|&i, &j| relays(i).total_cmp(&relays(j))).unwrap_or(1);
        x.copy_within(self.place(least + 2)..self.place(CAPACITY), self.place(least));
        x[0] = ((CAPACITY - 2) as f64).into();
    }

    fn reversal<R: Real>(self, x: &[R], i: usize) -> f64 {
        x[self.place(i)].value()
    }

    /// Position of reversal `i` in the state.
    fn place(self, i: usize) -> usize {
        1 + (1 + self.value) * (1 + i)
    }
}

/// Adds a memory with values of one number, and its functions, to a program `block`.
pub(super) fn block(block: Block) -> Block {
    let block = block.number("count", 0.0).number("last", 0.0).number("sum", 0.0);
    block.numbers("reversal", vec![0.0; 2 * CAPACITY]).count("capacity", CAPACITY).text(TEXT)
}

const TEXT: &str = "
// Number of stored reversals. Input and sum are stored alternately, the oldest first.
fn stored(x: hysteresis) {
    let n = 0.0;
    // A NaN counts as 0.
    if x.count > 0.0 { n = clamp(x.count, 0.0, real(capacity)); }
    return n;
}

// 1 if the move to u is a reversal, else 0.
fn turns(x: hysteresis, u) {
    let n = whole(stored(x));
    let so_far = x.last;
    if n > 0 { so_far = x.last - x.reversal[2 * (n - 1)]; }
    let round = 0.0;
    if (so_far > 0.0 && u < x.last) || (so_far < 0.0 && u > x.last) { round = 1.0; }
    return round;
}

// How many of n reversals remain after the input moves to u (wiping-out). Reversal n may be the present input, which is not stored.
fn kept(x: hysteresis, n: whole, u) {
    let left = n;
    let closes = 1;
    while left > 0 && closes > 0 at most capacity / 2 {
        let older = 0;
        if left > 1 { older = left - 2; }
        let limit = x.last;
        if older < whole(stored(x)) { limit = x.reversal[2 * older]; }
        // The first reversal is compared with its own value of the opposite sign.
        if left == 1 { limit = -limit; }
        if (u > x.last && u >= limit) || (u < x.last && u <= limit) { left = older; } else { closes = 0; }
    }
    return real(left);
}

// Makes room for two reversals: removes the two neighbouring reversals whose removal changes the smallest area of the Preisach plane.
fn forget(x: hysteresis) {
    let fewest = -1.0;
    let chosen = 1;
    for i in 1..capacity - 1 {
        let after = x.last;
        if i + 2 < capacity { after = x.reversal[2 * (i + 2)]; }
        let relays = magnitude((x.reversal[2 * i] - after) * (x.reversal[2 * (i + 1)] - x.reversal[2 * (i - 1)]));
        if relays < fewest || fewest < 0.0 {
            fewest = relays;
            chosen = i;
        }
    }
    for i in 2 * chosen..2 * (capacity - 2) at most 2 * (capacity - 3) { x.reversal[i] = x.reversal[i + 4]; }
    x.count = real(capacity - 2);
}

// Remembers where the input is.
fn remember(x: hysteresis) {
    if whole(stored(x)) == capacity { forget(x); }
    let i = 2 * whole(stored(x));
    x.reversal[i] = x.last;
    x.reversal[i + 1] = x.sum;
    x.count += 1.0;
}
";

/// Number of the `n` reversals that remain after a movement from `before` to `u`.
fn kept(reversal: impl Fn(usize) -> f64, mut n: usize, before: f64, u: f64) -> usize {
    let up = u > before;
    while n > 0 {
        let end = if n == 1 { -reversal(0) } else { reversal(n - 2) };
        if (up && u < end) || (!up && u > end) || end.is_nan() || u.is_nan() {
            break;
        }
        n = n.saturating_sub(2);
    }
    n
}

fn count<R: Real>(x: &[R]) -> usize {
    (x[0].value() as usize).min(CAPACITY)
}
