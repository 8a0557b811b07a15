//! The inverse as a program: the same searches in operations that every target language has, with bit-identical
//! results.

use super::TRIALS;
use crate::program::Program;
use piezoid_numerics::error::Error;

/// Adds `hysteresis_inverse(x: hysteresis, z, low, high)`, bit-identical to
/// [`Hysteresis::invert`](crate::hysteresis::Hysteresis::invert), and the functions it needs to a program that has
/// `hysteresis`.
pub(crate) fn inverse(program: &mut Program) -> Result<(), Error> {
    if program.function("hysteresis_inverse").is_some() {
        return Ok(());
    }
    if program.function("hysteresis_ahead").is_none() {
        program.slope("hysteresis")?;
        program.extend(AHEAD)?;
    }
    program.extend(&BY_SLOPES.replace("TRIALS", &TRIALS.to_string()))?;
    program.extend(&BY_TRIALS.replace("TRIALS", &TRIALS.to_string()))?;
    let closed = program.function("hysteresis_closed").is_some();
    program.extend(if closed { CLOSED_INVERSE } else { INVERSE })
}

/// Adds `hidden_inverse(x: hysteresis, d: driver, z, low, high)`, the inverse behind a driver by bracketing, to a
/// program that has `hidden`; without `x` if the operator has no memory.
pub(crate) fn inverse_behind_a_driver(program: &mut Program, remembers: bool) -> Result<(), Error> {
    let text = BY_TRIALS.replace("TRIALS", &TRIALS.to_string());
    let text = text.replace("hysteresis_by_trials(x: hysteresis,", "hidden_inverse(x: hysteresis, d: driver,");
    let text = text.replace("hysteresis(tried, u)", "hidden(tried, behind, u)");
    let text = text.replace("let tried = copy(x);", "let tried = copy(x);\n        let behind = copy(d);");
    let text = text.replace(
        "// The same by trials between the ends:",
        "// The input between low and high that the next sample answers with z, by trials between the ends:",
    );
    program.extend(&if remembers {
        text
    } else {
        text.replace("x: hysteresis, ", "").replace("let tried = copy(x);", "").replace("(tried, ", "(")
    })
}

const AHEAD: &str = "
// What the next step would give, and the slope.
fn hysteresis_ahead(x: hysteresis, u) {
    let trial = copy(x);
    let slopes = zero(x);
    let z, slope = hysteresis_slope(trial, slopes, u, 1.0);
    return z, slope;
}
";

/// [`super::by_slopes`].
const BY_SLOPES: &str = "
// The input between low and high for which the next step returns z, by Newton's method from the last input, bracketed by inputs below and above the requested z. The second value is 1, or 0 if z falls with the input or jumps over the requested value.
fn hysteresis_by_slopes(x: hysteresis, z, low, high) {
    let found = 0.0;
    let close = magnitude(low);
    if magnitude(high) > close { close = magnitude(high); }
    close = 2.0 * epsilon * close;
    let u = clamp(x.last, low, high);
    let toward = -1.0;
    let limit = low;
    let same = 0.0;
    // What lies before the wanted z: an input, what it gives and how steeply, and how far z still has to go.
    let start = u;
    let start_z = z;
    let start_slope = 0.0;
    let start_left = 0.0;
    // What does not, once there is such an input.
    let stop = u;
    let stop_left = 0.0;
    let bounded = 0;
    let before = most;
    let trial = 0;
    let searching = 1;
    while searching > 0 at most TRIALS + 1 {
        let reached, slope = hysteresis_ahead(x, u);
        if trial == 0 {
            if reached < z {
                toward = 1.0;
                limit = high;
            }
            same = magnitude(reached);
            if magnitude(z) > same { same = magnitude(z); }
            if same > most { same = most; }
            same = 4.0 * epsilon * same;
        }
        let left = toward * (z - reached);
        // On a flat piece a difference within rounding counts as 0.
        if slope == 0.0 && magnitude(left) <= same { left = 0.0; }
        if trial == 0 && left == 0.0 {
            found = 1.0;
            searching = 0;
        } else if trial > 0 && bounded == 0 && u == limit && left > 0.0 && slope >= 0.0 {
            // Beyond what the end gives.
            found = 1.0;
            searching = 0;
        } else if slope >= 0.0 && magnitude(left) <= most && trial < TRIALS {
            if left > 0.0 {
                start = u;
                start_z = reached;
                start_slope = slope;
                start_left = left;
            } else {
                stop = u;
                stop_left = left;
                bounded = 1;
                limit = u;
            }
            // If a whole flat piece has the requested z, the slope before it is used to find where the piece begins.
            let from_u = u;
            let from_z = reached;
            let from_slope = slope;
            if left == 0.0 && slope == 0.0 {
                from_u = start;
                from_z = start_z;
                from_slope = start_slope;
            }
            let newton = limit;
            let step = most;
            if from_slope > 0.0 {
                newton = from_u + (z - from_z) / from_slope;
                step = magnitude(newton - u);
            }
            if step <= close || magnitude(limit - start) <= close {
                u = start;
                let off = start_left;
                if bounded > 0 && magnitude(stop_left) <= start_left {
                    u = stop;
                    off = stop_left;
                }
                // A difference larger than rounding means that z jumps here.
                if magnitude(off) <= 10000.0 * same { found = 1.0; }
                searching = 0;
            } else if (newton - start) * toward > 0.0 && (limit - newton) * toward > 0.0 && magnitude(left) <= 0.5 * before {
                before = magnitude(left);
                u = newton;
            } else {
                before = most;
                u = limit;
                if bounded > 0 { u = 0.5 * (start + limit); }
            }
        } else {
            searching = 0;
        }
        trial += 1;
    }
    return u, found;
}
";

/// [`super::by_trials`].
const BY_TRIALS: &str = "
// The same by trials between the ends: inverse quadratic interpolation where it stays well inside, else bisection.
fn hysteresis_by_trials(x: hysteresis, z, low, high) {
    // a is the newest input; b lies on the other side of the requested z.
    let a = low;
    let a_off = 0.0;
    let b = high;
    let b_off = 0.0;
    let u = low;
    let trial = 0;
    let searching = 1;
    while searching > 0 at most TRIALS + 2 {
        let tried = copy(x);
        let off = hysteresis(tried, u) - z;
        if trial == 0 {
            a_off = off;
            u = high;
        } else if trial == 1 {
            b_off = off;
            u = a + 0.5 * (b - a);
            // If z is out of reach between low and high, the nearer end is returned.
            if (a_off <= b_off && a_off >= 0.0) || (a_off > b_off && a_off <= 0.0) {
                u = low;
                searching = 0;
            } else if (a_off <= b_off && b_off <= 0.0) || (a_off > b_off && b_off >= 0.0) {
                u = high;
                searching = 0;
            }
        } else {
            // c is the one before.
            let c = a;
            let c_off = a_off;
            if (off < 0.0 && a_off >= 0.0) || (off >= 0.0 && a_off < 0.0) {
                c = b;
                c_off = b_off;
                b = a;
                b_off = a_off;
            }
            a = u;
            a_off = off;
            let nearest = b;
            let nearest_off = b_off;
            if magnitude(a_off) < magnitude(b_off) {
                nearest = a;
                nearest_off = a_off;
            }
            let close = (epsilon * magnitude(nearest) + least) / magnitude(b - a);
            if nearest_off == 0.0 || close > 0.25 {
                u = nearest;
                searching = 0;
            } else if trial > TRIALS {
                searching = 0;
            } else {
                let share = 0.5;
                if c_off != b_off {
                    let xi = (a - b) / (c - b);
                    let phi = (a_off - b_off) / (c_off - b_off);
                    if phi * phi < xi && (1.0 - phi) * (1.0 - phi) < 1.0 - xi {
                        share = a_off / (b_off - a_off) * c_off / (b_off - c_off)
                            + (c - a) / (b - a) * a_off / (c_off - a_off) * b_off / (c_off - b_off);
                    }
                }
                u = a + clamp(share, close, 1.0 - close) * (b - a);
            }
        }
        trial += 1;
    }
    return u;
}
";

const INVERSE: &str = "
// The input between low and high that the next step answers with z; of what lies beyond, the nearer end.
fn hysteresis_inverse(x: hysteresis, z, low, high) {
    let u, found = hysteresis_by_slopes(x, z, low, high);
    let best = u;
    if found < 1.0 { best = hysteresis_by_trials(x, z, low, high); }
    return best;
}
";

const CLOSED_INVERSE: &str = "
// The input between low and high that the next step answers with z; of what lies beyond, the nearer end.
fn hysteresis_inverse(x: hysteresis, z, low, high) {
    let best, closed = hysteresis_closed(x, z, low, high);
    if closed < 1.0 {
        let u, found = hysteresis_by_slopes(x, z, low, high);
        best = u;
        if found < 1.0 { best = hysteresis_by_trials(x, z, low, high); }
    }
    return best;
}
";
