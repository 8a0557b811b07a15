//! Generalised Prandtl-Ishlinskii: plays between two envelope functions, and dead zones, for asymmetric loops.
//!
//! ```text
//! p_k <- max(g_a(u) - r_k, min(g_d(u) + r_k, p_k))                 ascending and descending envelope g_a, g_d
//! g(u) = u + half (quadratic (1 - v^2) + cubic (v - v^3)) - g_0    v = (u - middle) / half, from -1 to 1
//! d_j(u) = max(u - d_j, 0) for d_j > 0, min(u - d_j, 0) for d_j < 0
//! z = w_0 u + sum_k w_k p_k + sum_j v_j d_j(u)                     w_k >= 0
//! ```
//! `middle` and `half` describe the input range; g_0 is such that g(0) = 0. Outside the range an envelope has the
//! slope 1. A positive `cubic` saturates, a `quadratic` bends to one side. Where the envelopes cross by more than the
//! thresholds, the ascending one applies. Without bends and dead zones the operator is `prandtl-ishlinskii`.
//!
//! References: M. Al Janaideh, S. Rakheja & C.-Y. Su, IEEE/ASME Trans. Mechatronics 16 (2011), DOI
//! 10.1109/TMECH.2010.2052366 (envelopes); K. Kuhnen, Eur. J. Control 9 (2003), DOI 10.3166/ejc.9.407-418 (dead zones;
//! there in series with the plays, here in parallel, so that z is linear in all weights). It does not do: rate.
//!
//! Inverse: Newton's method on the cubic piece of the requested z. Outside the range z is linear.

use super::basis::{BasisDesign, ShapeParameter};
use super::law::{Input, Law, Weighted, require};
use super::real::Real;
use super::thresholds;
use super::{Class, Operator};
use crate::program::Block;
use piezoid_numerics::error::{Error, finite};
use serde::{Deserialize, Serialize};

/// Weights: w_0 of the input, then one per threshold, then one per dead zone.
///
/// State: the plays p_k.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub(super) struct GeneralisedPlay {
    /// r_1 < r_2 < ... [input unit]
    thresholds: Vec<f64>,
    /// d_j [input unit], not 0.
    dead_zones: Vec<f64>,
    ascending_quadratic: f64,
    ascending_cubic: f64,
    descending_quadratic: f64,
    descending_cubic: f64,
}

/// Bends for which an envelope increases over the whole range.
const QUADRATIC: (f64, f64) = (-0.25, 0.25);
const CUBIC: (f64, f64) = (-0.5, 0.25);

/// Pieces of the range between dead zones.
const PIECES: u32 = 8;

pub(super) static OPERATOR: Operator = Operator {
    name: "generalised-prandtl-ishlinskii",
    aliases: &["GPI", "generalized-prandtl-ishlinskii"],
    summary: "play operators with two nonlinear envelope functions, and dead zones: asymmetric loops",
    reference: "Al Janaideh, Rakheja & Su 2011, doi:10.1109/TMECH.2010.2052366",
    minor_loops: true,
    needs_minor_loops: false,
    rate_independent: true,
    wipes_out: true,
    class: Class::Plays,
    load: Weighted::<GeneralisedPlay>::load,
    basis: |design| {
        let law = GeneralisedPlay::new(thresholds::even(design), dead_zones(design), [0.0; 4]);
        Weighted::basis(design.ts, design.range, law)
    },
    example: |ts| {
        let law = GeneralisedPlay::new(thresholds::example(), vec![-15.0, 15.0], [0.1, 0.05, -0.05, 0.1]);
        let weights = [&thresholds::example_weights(0.6)[..], &[0.1, -0.1]].concat();
        Weighted::example(ts, law, weights)
    },
};

/// Equidistant dead zones over the range, except at 0.
fn dead_zones(design: &BasisDesign) -> Vec<f64> {
    let step = 2.0 * design.half() / f64::from(PIECES);
    let all = (1..PIECES).map(|k| design.range.0 + step * f64::from(k));
    all.filter(|d| d.abs() > 1e-6 * step).collect()
}

impl GeneralisedPlay {
    fn new(thresholds: Vec<f64>, dead_zones: Vec<f64>, bends: [f64; 4]) -> Self {
        let [ascending_quadratic, ascending_cubic, descending_quadratic, descending_cubic] = bends;
        GeneralisedPlay {
            thresholds,
            dead_zones,
            ascending_quadratic,
            ascending_cubic,
            descending_quadratic,
            descending_cubic,
        }
    }

    fn bends(&self) -> [(&'static str, f64, (f64, f64)); 4] {
        [
            ("ascending_quadratic", self.ascending_quadratic, QUADRATIC),
            ("ascending_cubic", self.ascending_cubic, CUBIC),
            ("descending_quadratic", self.descending_quadratic, QUADRATIC),
            ("descending_cubic", self.descending_cubic, CUBIC),
        ]
    }
}

impl Law for GeneralisedPlay {
    const ROW: &'static Operator = &OPERATOR;

    fn check(&self) -> Result<(), Error> {
        thresholds::check(&self.thresholds)?;
        finite("dead_zones", &self.dead_zones)?;
        if let Some(j) = self.dead_zones.iter().position(|d| *d == 0.0) {
            let rule = "must not be 0: a dead zone must end at a positive or at a negative input";
            return Err(Error::parameter(format!("dead_zones[{j}]"), 0.0, rule));
        }
        self.bends().into_iter().try_for_each(|(name, value, (low, high))| {
            let rule = format!("must be from {low} to {high}, so that the envelope increases everywhere");
            require((low..=high).contains(&value), name, value, &rule)
        })
    }

    fn thresholds(&self) -> &[f64] {
        &self.thresholds
    }

    fn responses(&self) -> usize {
        1 + self.thresholds.len() + self.dead_zones.len()
    }

    fn step<R: Real>(&self, shape: &[R], x: &mut [R], input: Input<R>, mut phi: impl FnMut(usize, R)) {
        let u = input.u;
        let (square, cube) = bulges(&input);
        let envelope = |k: usize| u + square * shape[k] + cube * shape[k + 1];
        let (ascending, descending) = (envelope(0), envelope(2));
        phi(0, u);
        for (k, (p, &r)) in x.iter_mut().zip(&self.thresholds).enumerate() {
            *p = p.clamp(ascending - r.into(), descending + r.into());
            phi(k + 1, *p);
        }
        for (j, &d) in self.dead_zones.iter().enumerate() {
            let (beyond, none) = (u - d.into(), R::from(0.0));
            let beyond = if (beyond > none) == (d > 0.0) { beyond } else { none };
            phi(1 + self.thresholds.len() + j, beyond);
        }
    }

    fn block(&self, block: Block, input: Input) -> Block {
        let (half, middle) = (input.half(), input.middle());
        let (square, cube) = bent(0.0, half, middle);
        let block = block.constant("half", half).constant("middle", middle);
        let block = block.constant("square_at_rest", square).constant("cube_at_rest", cube);
        let (n, zones) = (self.thresholds.len(), self.dead_zones.len());
        let block = block.numbers("play", vec![0.0; n]).table("r", &self.thresholds).count("n", n);
        let block = block.table("d", &self.dead_zones).count("zones", zones).text(PLAYS);
        block.text(if zones > 0 { DEAD_ZONES } else { "" }).text("    return z;\n}\n")
    }

    fn non_negative(&self, k: usize) -> bool {
        k <= self.thresholds.len()
    }

    fn shape(&self, _: f64, _: f64) -> Vec<ShapeParameter> {
        self.bends().map(|(name, value, (low, high))| ShapeParameter { name, value, low, high }).into()
    }
}

/// The quadratic and the cubic term of an envelope at `u`; 0 at u = 0, constant outside the range [input unit].
fn bulges<R: Real>(input: &Input<R>) -> (R, R) {
    let at = |u: R| bent(u, input.half(), input.middle());
    let (here, rest) = (at(input.u), at(0.0.into()));
    (here.0 - rest.0, here.1 - rest.1)
}

/// The same terms, but 0 at the ends of the range and outside it.
fn bent<R: Real>(u: R, half: f64, middle: f64) -> (R, R) {
    let (one, half) = (R::from(1.0), R::from(half));
    let v = ((u - middle.into()) / half).clamp(-one, one);
    (half * (one - v * v), half * (v - v * v * v))
}

/// [`Law::step`], weighted, without dead zones.
const PLAYS: &str = "
fn hysteresis(x: hysteresis, u) {
    // What bends the envelopes, constant beyond the range.
    let v = clamp((u - middle) / half, -1.0, 1.0);
    let square = half * (1.0 - v * v) - square_at_rest;
    let cube = half * (v - v * v * v) - cube_at_rest;
    let ascending = u + square * ascending_quadratic + cube * ascending_cubic;
    let descending = u + square * descending_quadratic + cube * descending_cubic;
    let z = w[0] * u;
    for k in 0..n {
        x.play[k] = clamp(x.play[k], ascending - r[k], descending + r[k]);
        z += w[k + 1] * x.play[k];
    }
    x.last = u;
";

/// The dead zones of [`Law::step`].
const DEAD_ZONES: &str = "
    // How far the input is beyond each dead zone.
    for j in 0..zones {
        let beyond = u - d[j];
        if d[j] > 0.0 {
            if beyond <= 0.0 { beyond = 0.0; }
        } else if beyond > 0.0 {
            beyond = 0.0;
        }
        z += w[n + 1 + j] * beyond;
    }
";

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;

    #[test]
    fn without_bends_and_dead_zones_it_is_prandtl_ishlinskii() {
        let document = |name: &str, more: &str| {
            format!(
                r#"{{"operator": "{name}", "range": [-30, 30], "thresholds": [2, 9], "weights": [1, 0.2, 0.3]{more}}}"#
            )
        };
        let bends: String = GeneralisedPlay::new(vec![1.0], vec![], [0.0; 4])
            .bends()
            .iter()
            .map(|(name, ..)| format!(r#", "{name}": 0"#))
            .collect();
        let load = |text: String| super::super::load(&serde_json::from_str(&text).unwrap(), 5e-4).unwrap();
        let plain = load(document("prandtl-ishlinskii", ""));
        let general = load(document(OPERATOR.name, &(bends + r#", "dead_zones": []"#)));
        let u: Vec<f64> = (0..400).map(|t| 28.0 * (f64::from(t) * 0.1).sin() * (f64::from(t) * 0.013).cos()).collect();
        assert_close(&general.simulate(&u), &plain.simulate(&u), 1e-14, 1e-14);
    }

    #[test]
    fn envelopes_increase_for_all_allowed_bends() {
        for a in [QUADRATIC.0, 0.1, QUADRATIC.1] {
            for b in [CUBIC.0, -0.1, CUBIC.1] {
                let g = |k: i32| {
                    let input = Input { u: f64::from(k), before: 0.0, ts: 1.0, range: (-20.0, 100.0) };
                    let (square, cube) = bulges(&input);
                    input.u + a * square + b * cube
                };
                assert!((-40..120).all(|k| g(k + 1) > g(k)), "{a} {b}");
                assert_eq!(g(0), 0.0);
            }
        }
    }

    #[test]
    fn dead_zones_end_at_eighths_of_the_range_but_not_at_rest() {
        let zones = |range| dead_zones(&BasisDesign { ts: 1.0, range, elements: None, frequencies: Vec::new() });
        assert_eq!(zones((-4.0, 4.0)), [-3.0, -2.0, -1.0, 1.0, 2.0, 3.0]);
        // One that is 0 except for rounding; all that are small.
        assert_eq!((zones((-0.3, 0.1)).len(), zones((0.0, 1e-3)).len()), (6, 7));
    }
}
