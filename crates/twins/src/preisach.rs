//! Preisach hysteresis with a continuous density of relays, in closed form.
//!
//! ```text
//! w = d u + f,   f on a branch = f at its reversal +- E(reversal, u)
//! ```
//! with the Everett function E of [`super::everett`]. The memory of the ceramic is the list of dominant reversals:
//! alternating maxima and minima, each loop inside the one before. An input that reaches an older reversal wipes out
//! the loop that it closes, and continues bit-identically on the older branch, because f is stored with each reversal.
//! The mirror image of the first reversal counts as the reversal before it; from there the virgin curve continues.
//!
//! Rate-independent; exact for any division of a path into steps.
//!
//! State: number of reversals; current voltage u [V] and irreversible displacement f [m]; then 64 pairs (u, f), the
//! reversals, oldest first. If the list is full, the two neighbouring reversals are forgotten that change the fewest
//! relays: for a ring-down of a thousand cycles this is less than 2e-3 of the displacement.

use super::everett::ExponentialEverett;
use super::spec::require;
use piezoid_numerics::error::{Error, positive};

/// Number of stored reversals.
const CAPACITY: usize = 64;
const COUNT: usize = 0;
const U: usize = 1;
const F: usize = 2;
const REVERSALS: usize = 3;

/// A continuous density of relays and a reversible slope.
#[derive(Debug, Clone)]
pub(super) struct PreisachStage {
    /// Reversible displacement per volt [m/V].
    d: f64,
    everett: ExponentialEverett,
}

impl PreisachStage {
    pub(super) const ORDER: usize = REVERSALS + 2 * CAPACITY;

    /// The law with a major loop between +-`range` [V] of height `2 displacement` [m], and of width `width` at 0 V,
    /// relative to the height; `rho` is the spread of the density [V] and `c` its asymmetry.
    ///
    /// The asymmetry cancels in both: height = 2 d U + K J1(U) and width height = K (J1(U) - 2 J1(U/2)).
    pub(crate) fn new(range: f64, displacement: f64, width: f64, rho: f64, c: f64) -> Result<Self, Error> {
        positive("hysteresis.range_v", range, "volts")?;
        positive("hysteresis.displacement_m", displacement, "metres")?;
        positive("hysteresis.half_width_v", rho, "volts")?;
        require(c.abs() <= 1.0, "hysteresis.asymmetry", c, "must be from -1 to 1")?;
        let unit = ExponentialEverett { k: 1.0, rho, lean: c / range };
        let (full, bulge) = (unit.j1(range), unit.j1(range) - 2.0 * unit.j1(0.5 * range));
        let most = bulge / full;
        let rule =
            format!("must be at least 0 and below {most:.4}, because at that value no reversible slope would remain");
        require(width >= 0.0 && width < most, "hysteresis.width", width, &rule)?;
        let height = 2.0 * displacement;
        let k = width * height / bulge;
        Ok(PreisachStage { d: (height - k * full) / (2.0 * range), everett: ExponentialEverett { k, ..unit } })
    }

    /// Moves to the voltage `u` and returns the static displacement w [m].
    pub(super) fn displacement(&self, x: &mut [f64], u: f64) -> f64 {
        if u != x[U] {
            store_reversal(x, u);
            wipe_out(x, u);
            let n = count(x);
            x[F] = match n {
                0 => self.everett.virgin(u),
                _ => x[REVERSALS + 2 * n - 1] + self.everett.branch(reversal(x, n - 1), u),
            };
            x[U] = u;
        }
        self.d * u + x[F]
    }
}

/// Stores the current input if moving to `u` reverses its direction.
fn store_reversal(x: &mut [f64], u: f64) {
    let n = count(x);
    let origin = if n == 0 { 0.0 } else { reversal(x, n - 1) };
    let excursion = x[U] - origin;
    if excursion == 0.0 || (excursion > 0.0) == (u > x[U]) {
        return;
    }
    if n == CAPACITY {
        forget(x);
    }
    let n = count(x);
    x.copy_within(U..=F, REVERSALS + 2 * n);
    x[COUNT] = (n + 1) as f64;
}

/// Shortens the full list: forgets the reversals i and i + 1 that change the fewest relays, those in a rectangle
/// between their neighbours. Each reversal keeps its f, so the displacement does not jump.
fn forget(x: &mut [f64]) {
    let at = |i: usize| if i < CAPACITY { reversal(x, i) } else { x[U] };
    let relays = |i: usize| ((at(i) - at(i + 2)) * (at(i + 1) - at(i - 1))).abs();
    let least = (1..CAPACITY - 1).min_by(|&i, &j| relays(i).total_cmp(&relays(j))).unwrap_or(1);
    x.copy_within(REVERSALS + 2 * (least + 2).., REVERSALS + 2 * least);
    x[COUNT] = (CAPACITY - 2) as f64;
}

/// Forgets the loops that are closed by moving to `u`.
fn wipe_out(x: &mut [f64], u: f64) {
    let up = u > x[U];
    let mut n = count(x);
    while n > 0 {
        let end = if n == 1 { -reversal(x, 0) } else { reversal(x, n - 2) };
        let closed = if up { u >= end } else { u <= end };
        if !closed {
            break;
        }
        n = n.saturating_sub(2);
    }
    x[COUNT] = n as f64;
}

fn count(x: &[f64]) -> usize {
    (x[COUNT] as usize).min(CAPACITY)
}

fn reversal(x: &[f64], i: usize) -> f64 {
    x[REVERSALS + 2 * i]
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;
    use proptest::prelude::*;

    fn pl140() -> PreisachStage {
        PreisachStage::new(30.0, 1e-3, 0.13, 20.0, 0.3).unwrap()
    }

    fn drive(law: &PreisachStage, x: &mut [f64], path: &[f64]) -> Vec<f64> {
        path.iter().map(|&u| law.displacement(x, u)).collect()
    }

    fn rest() -> Vec<f64> {
        vec![0.0; PreisachStage::ORDER]
    }

    #[test]
    fn the_major_loop_has_the_specified_height_and_width() {
        for c in [0.0, 0.3, -1.0] {
            let law = PreisachStage::new(30.0, 1e-3, 0.13, 20.0, c).unwrap();
            let w = drive(&law, &mut rest(), &[30.0, -30.0, 0.0, 30.0, 0.0]);
            assert_close(&[w[3] - w[1], (w[4] - w[2]) / (w[3] - w[1])], &[2e-3, 0.13], 1e-12, 0.0);
        }
    }

    /// The same law as a grid of relays in (r, v), each up or down.
    #[test]
    fn a_grid_of_relays_agrees() {
        let law = pl140();
        let (n, step) = (400_i32, 30.0 / 400.0);
        let mut relays: Vec<(f64, f64, f64, f64)> = (0..n)
            .flat_map(|i| (-n..n).map(move |j| ((f64::from(i) + 0.5) * step, (f64::from(j) + 0.5) * step)))
            .filter(|(r, v)| v.abs() + r < 30.0)
            .map(|(r, v)| {
                let ExponentialEverett { k, rho, lean } = law.everett;
                let weight = 0.25 * k * (-r / rho).exp() * (1.0 + lean * v) * step * step;
                (v + r, v - r, weight, if v < 0.0 { 1.0 } else { -1.0 })
            })
            .collect();
        let start: f64 = relays.iter().map(|r| r.2 * r.3).sum();
        let mut x = rest();
        for u in [9.0, -4.0, 6.0, -12.0, 30.0, -20.0, 10.0, -10.0, 5.0, 2.0, 3.0, -15.0, 28.0, -30.0, 0.0, 7.0] {
            relays.iter_mut().for_each(|relay| match u {
                u if u >= relay.0 => relay.3 = 1.0,
                u if u <= relay.1 => relay.3 = -1.0,
                _ => {}
            });
            let sum: f64 = relays.iter().map(|r| r.2 * r.3).sum();
            let w = law.displacement(&mut x, u);
            assert_close(&[w - law.d * u], &[sum - start], 0.0, 2e-6); // 1e-3 of the displacement
        }
    }

    proptest! {
        #[test]
        fn the_state_is_bit_identical_after_a_closed_minor_loop(
            path in prop::collection::vec(-30.0..30.0f64, 1..20), inner in 0.0..1.0f64, deeper in 0.0..1.0f64) {
            let (law, mut x) = (pl140(), rest());
            drive(&law, &mut x, &path);
            let (before, last) = (x.clone(), x[U]);
            // A reversal inside the innermost loop, another one inside that, and back.
            let n = count(&x);
            let origin = if n == 0 { -last } else { reversal(&x, n - 1) };
            let turn = last + (origin - last) * inner;
            drive(&law, &mut x, &[turn, turn + (last - turn) * deeper, turn, last]);
            prop_assert_eq!(count(&x), count(&before));
            let live = REVERSALS + 2 * count(&x);
            prop_assert_eq!(&x[..live], &before[..live]);
        }

        #[test]
        fn the_division_of_a_path_does_not_matter(path in prop::collection::vec(-30.0..30.0f64, 1..20)) {
            let law = pl140();
            let (mut coarse, mut fine) = (rest(), rest());
            for &u in &path {
                let from = fine[U];
                (1..7).for_each(|i| { law.displacement(&mut fine, from + (u - from) * f64::from(i) / 7.0); });
                let w = law.displacement(&mut fine, u);
                assert_close(&[w], &[law.displacement(&mut coarse, u)], 0.0, 1e-15);
            }
        }
    }

    #[test]
    fn minor_loops_between_the_same_ends_are_congruent() {
        let law = pl140();
        let loop_height = |history: &[f64]| {
            let mut x = rest();
            drive(&law, &mut x, history);
            let w = drive(&law, &mut x, &[-5.0, 0.0, 8.0, 0.0, -5.0]);
            [w[1] - w[0], w[2] - w[0], w[3] - w[0], w[4] - w[0]]
        };
        assert_close(&loop_height(&[30.0, -5.0, 8.0]), &loop_height(&[-30.0, 20.0, -10.0, 8.0]), 1e-12, 1e-18);
    }

    #[test]
    fn the_ascending_branch_is_below_the_descending_one() {
        let (law, mut x) = (pl140(), rest());
        let w = drive(&law, &mut x, &[30.0, 10.0, -30.0, 10.0]);
        assert!(w[3] < w[1]);
    }

    #[test]
    fn a_ring_down_longer_than_the_list_has_a_small_error() {
        let (law, mut x) = (pl140(), rest());
        let cycles = 1000;
        let extreme =
            |i: i32| 30.0 * (1.0 - f64::from(i) / f64::from(2 * cycles)) * if i % 2 == 0 { 1.0 } else { -1.0 };
        (0..2 * cycles).for_each(|i| {
            law.displacement(&mut x, extreme(i));
        });
        // Demagnetised: if it rises again, the true law is on its virgin curve (in steps of 0.03 V).
        for u in [0.5, 3.0, 11.0, 25.0, 30.0] {
            let (w, virgin) = (law.displacement(&mut x, u), law.displacement(&mut rest(), u));
            assert_close(&[w], &[virgin], 0.0, 2e-6);
        }
    }

    #[test]
    fn a_width_without_reversible_slope_is_an_error() {
        let message = PreisachStage::new(30.0, 1e-3, 0.6, 20.0, 0.3).unwrap_err().to_string();
        assert!(message.starts_with("hysteresis.width = 0.6: must be at least 0 and below 0.385"), "{message}");
        assert!(PreisachStage::new(30.0, 1e-3, 0.1, 20.0, f64::NAN).is_err());
    }

    #[test]
    fn a_nan_ends_in_nan_without_a_panic() {
        let (law, mut x) = (pl140(), rest());
        let w = drive(&law, &mut x, &[3.0, f64::NAN, 1.0, -2.0]);
        assert!(w[1].is_nan());
        (0..500).for_each(|i| {
            law.displacement(&mut x, if i % 2 == 0 { f64::NAN } else { f64::from(i % 7) });
        });
    }
}
