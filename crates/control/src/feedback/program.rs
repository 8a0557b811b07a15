//! The common parts of controllers as programs.

use super::apart;
use piezoid_models::program::Block;

/// The block of a controller's state, with the functions that all controllers share: error and limits.
pub(super) fn block(about: &str, limits: (f64, f64)) -> Block {
    Block::new("control_state", about)
        .constant("low", limits.0)
        .constant("high", limits.1)
        .constant("span", apart(limits))
        .text(SHARED)
}

const SHARED: &str = "
// The tracking error r - y; 0 if it is not measurable, so that the state does not change.
fn missing(r, y) {
    let off = r - y;
    let answered = 0.0;
    if magnitude(off) <= measurable { answered = off; }
    return answered;
}

// The feed-forward, clipped to the limits; 0 if it is not measurable.
fn fed(feed_forward) {
    let applied = 0.0;
    if magnitude(feed_forward) <= measurable { applied = feed_forward; }
    return clamp(applied, low, high);
}
";

/// The same as [`super::integrating`], for a state with an `integral`.
pub(super) const INTEGRATING: &str = "
// The feed-forward plus w, clipped to the limits. The integral changes by gain, but not further beyond a limit, and by no more than the limits are apart.
fn integrating(s: control_state, feed_forward, w, gain) {
    let v = fed(feed_forward) + w;
    let u = clamp(v, low, high);
    if u == v || (v - u) * gain < 0.0 { s.integral += clamp(gain, -span, span); }
    return u;
}
";
