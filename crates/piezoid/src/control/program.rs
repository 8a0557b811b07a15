//! The common parts of controllers as programs.

use crate::program::Block;

/// The block of a controller's state, with the functions that all controllers share: error and limits.
pub(super) fn block(about: &str, limits: (f64, f64)) -> Block {
    Block::new("control_state", about).constant("low", limits.0).constant("high", limits.1).text(SHARED)
}

const SHARED: &str = "
// What is missing; nothing where the reading is no number, so that it leaves the state alone.
fn missing(r, y) {
    let off = r - y;
    let answered = 0.0;
    if magnitude(off) <= most { answered = off; }
    return answered;
}

// The feed-forward within the limits; of what is no number, as of 0.
fn fed(feed) {
    let given = 0.0;
    if magnitude(feed) <= most { given = feed; }
    return clamp(given, low, high);
}
";

/// The same as [`super::integrating`], for a state with an `integral`.
pub(super) const INTEGRATING: &str = "
// w on top of the feed-forward within the limits. The integral takes its gain, but where that would drive the input further beyond a limit.
fn integrating(s: control_state, feed, w, gain) {
    let v = fed(feed) + w;
    let u = clamp(v, low, high);
    if u == v || (v - u) * gain < 0.0 { s.integral += gain; }
    return u;
}
";
