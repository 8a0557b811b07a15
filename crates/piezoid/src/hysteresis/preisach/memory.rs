//! What a Preisach operator remembers: the dominant reversals of its input.
//!
//! The list holds maxima and minima in turn, each loop inside the one before. An input that reaches an older reversal
//! wipes out the loop it closes and continues on the older branch. Before the first reversal stands its mirror image:
//! beyond that the relays are as demagnetisation about 0 left them, up where alpha + beta < 0.
//!
//! State: number of reversals; the input; the value now; then (input, value) of each reversal, oldest first. A value is
//! as many numbers as the caller likes. When the list is full, the two neighbours that hold the fewest relays between
//! them are forgotten; values stay, so nothing jumps.

use crate::program::Block;

/// Reversals remembered: with each at least a hundredth of the range inside the one before, more never happen.
pub(super) const CAPACITY: usize = 64;

/// Where the branch begins that the input is on.
pub(super) enum BranchStart {
    /// At rest: no reversal is remembered.
    Rest,
    /// At the last reversal, whose input this is.
    From(f64),
}

/// How states are laid out: the length of a value.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Memory {
    pub(super) value: usize,
}

impl Memory {
    pub(super) fn order(self) -> usize {
        1 + (1 + self.value) * (1 + CAPACITY)
    }

    /// The input now.
    pub(super) fn input(self, x: &[f64]) -> f64 {
        x[1]
    }

    /// The value now.
    pub(super) fn value(self, x: &[f64]) -> &[f64] {
        &x[2..2 + self.value]
    }

    /// Moves the input to `u`, which is not where it is. Returns the branch it is on then, the value where that branch
    /// began (none at rest), and the value now, which the caller brings up to date.
    pub(super) fn travel(self, x: &mut [f64], u: f64) -> (BranchStart, &[f64], &mut [f64]) {
        self.turn(x, u);
        self.wipe_out(x, u);
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

    /// Where the branch begins that moving to `u` would lead to, and the value there (none at rest); the state stays. None
    /// where something would have to be forgotten first.
    pub(super) fn ahead(self, x: &[f64], u: f64) -> Option<(BranchStart, &[f64])> {
        let (stored, turned) = (count(x), self.turns(x, u));
        if turned && stored == CAPACITY {
            return None;
        }
        let reversal = |i: usize| if i < stored { self.reversal(x, i) } else { x[1] };
        Some(match kept(reversal, stored + usize::from(turned), x[1], u).checked_sub(1) {
            None => (BranchStart::Rest, &[]),
            Some(i) => {
                let at = if i < stored { self.place(i) } else { 1 };
                (BranchStart::From(x[at]), &x[at + 1..at + 1 + self.value])
            }
        })
    }

    /// Whether moving to `u` turns the input round.
    fn turns(self, x: &[f64], u: f64) -> bool {
        let n = count(x);
        let so_far = x[1] - if n == 0 { 0.0 } else { self.reversal(x, n - 1) };
        so_far != 0.0 && (so_far > 0.0) != (u > x[1])
    }

    /// Remembers where the input is if moving to `u` turns it round.
    fn turn(self, x: &mut [f64], u: f64) {
        if !self.turns(x, u) {
            return;
        }
        if count(x) == CAPACITY {
            self.forget(x);
        }
        let at = self.place(count(x));
        x.copy_within(1..2 + self.value, at);
        x[0] += 1.0;
    }

    /// Forgets the loops that the way to `u` closes.
    fn wipe_out(self, x: &mut [f64], u: f64) {
        x[0] = kept(|i| self.reversal(x, i), count(x), x[1], u) as f64;
    }

    /// Makes room for two: forgets the neighbours i and i + 1 between which the fewest relays lie, in the rectangle that
    /// their own neighbours span.
    fn forget(self, x: &mut [f64]) {
        let at = |i: usize| if i < CAPACITY { self.reversal(x, i) } else { x[1] };
        let relays = |i: usize| ((at(i) - at(i + 2)) * (at(i + 1) - at(i - 1))).abs();
        let least = (1..CAPACITY - 1).min_by(|&i, &j| relays(i).total_cmp(&relays(j))).unwrap_or(1);
        x.copy_within(self.place(least + 2)..self.place(CAPACITY), self.place(least));
        x[0] = (CAPACITY - 2) as f64;
    }

    fn reversal(self, x: &[f64], i: usize) -> f64 {
        x[self.place(i)]
    }

    /// Where reversal `i` stands in the state.
    fn place(self, i: usize) -> usize {
        1 + (1 + self.value) * (1 + i)
    }
}

/// For programs: `block` with the memory of a value of one number, and what it does.
pub(super) fn block(block: Block) -> Block {
    let block = block.number("count", 0.0).number("last", 0.0).number("sum", 0.0);
    block.numbers("reversal", vec![0.0; 2 * CAPACITY]).count("capacity", CAPACITY).text(TEXT)
}

const TEXT: &str = "
// How many reversals are remembered: inputs and sums by turns, the oldest first.
fn stored(x: hysteresis) {
    let n = 0.0;
    // Not so of what is no number.
    if x.count > 0.0 { n = clamp(x.count, 0.0, real(capacity)); }
    return n;
}

// 1 where moving to u turns the input round, else 0.
fn turns(x: hysteresis, u) {
    let n = whole(stored(x));
    let so_far = x.last;
    if n > 0 { so_far = x.last - x.reversal[2 * (n - 1)]; }
    let round = 0.0;
    if (so_far > 0.0 && u < x.last) || (so_far < 0.0 && u > x.last) { round = 1.0; }
    return round;
}

// How many of n reversals are left when the input has gone to u; the one after those that are stored is where the input is.
fn kept(x: hysteresis, n: whole, u) {
    let left = n;
    let closes = 1;
    while left > 0 && closes > 0 {
        let older = 0;
        if left > 1 { older = left - 2; }
        let limit = x.last;
        if older < whole(stored(x)) { limit = x.reversal[2 * older]; }
        // Before the first reversal stands its mirror image.
        if left == 1 { limit = -limit; }
        if (u > x.last && u >= limit) || (u < x.last && u <= limit) { left = older; } else { closes = 0; }
    }
    return real(left);
}

// Makes room for two: forgets the neighbours between which the fewest relays lie, in the rectangle that their own neighbours span.
fn forget(x: hysteresis) {
    let fewest = most;
    let chosen = 1;
    for i in 1..capacity - 1 {
        let after = x.last;
        if i + 2 < capacity { after = x.reversal[2 * (i + 2)]; }
        let relays = magnitude((x.reversal[2 * i] - after) * (x.reversal[2 * (i + 1)] - x.reversal[2 * (i - 1)]));
        if relays < fewest {
            fewest = relays;
            chosen = i;
        }
    }
    for i in 2 * chosen..2 * (capacity - 2) { x.reversal[i] = x.reversal[i + 4]; }
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

/// How many of `n` reversals are left when the input has gone from `before` to `u`.
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

fn count(x: &[f64]) -> usize {
    (x[0] as usize).min(CAPACITY)
}
