//! Integer arithmetic of fixed-point programs, equal to 64-bit integers where these do not overflow. It has 128 bits,
//! because programs are run before it is known whether their numbers exceed their formats.

/// The operation with this name on integers of at most 53 bits, if there is one.
///
/// `wide(v)` is v; `narrow(v)` and `keep(v)` are clamped to 31 and 51 bits; `shift(v, n)` is v / 2^n; `product(a, b,
/// n)` is a b / 2^n; `quotient(a, b, n)` is 2^n a / b, clamped to 31 bits. Results are rounded to nearest, halves away
/// from zero.
pub(super) fn operation(name: &str) -> Option<fn(&[f64]) -> f64> {
    Some(match name {
        "wide" => |v| v[0],
        "narrow" => |v| v[0].clamp(-NARROW, NARROW),
        "keep" => |v| v[0].clamp(-KEPT, KEPT),
        "shift" => |v| shifted((v[0] as i64).into(), v[1]),
        "product" => |v| shifted(i128::from(v[0] as i64) * i128::from(v[1] as i64), v[2]),
        "quotient" => |v| quotient(v[0] as i64, v[1] as i64, v[2]).clamp(-NARROW, NARROW),
        _ => return None,
    })
}

/// Range of 32 bits, symmetric about zero.
const NARROW: f64 = 2_147_483_647.0;

/// Range of a state in 64 bits, with a margin for a sum.
pub(crate) const KEPT: f64 = 2_251_799_813_685_248.0;

fn shifted(v: i128, n: f64) -> f64 {
    let n = n as u32;
    let nearest = (v.unsigned_abs() + ((1 << n) >> 1)) >> n;
    if v < 0 { -(nearest as f64) } else { nearest as f64 }
}

fn quotient(a: i64, b: i64, n: f64) -> f64 {
    let (size, by) = (u128::from(a.unsigned_abs()) << n as u32, u128::from(b.unsigned_abs()));
    let nearest = (size + by / 2).checked_div(by).map_or(if a == 0 { 0.0 } else { NARROW }, |q| q as f64);
    if (a < 0) == (b < 0) { nearest } else { -nearest }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(name: &str, counts: &[f64]) -> f64 {
        operation(name).unwrap()(counts)
    }

    #[test]
    fn halves_are_rounded_away_from_zero() {
        assert_eq!([5.0, -5.0, 6.0, -7.0].map(|v| of("shift", &[v, 1.0])), [3.0, -3.0, 3.0, -4.0]);
        assert_eq!([7.0, -7.0].map(|v| of("quotient", &[v, 2.0, 0.0])), [4.0, -4.0]);
        assert_eq!(of("product", &[NARROW, -NARROW, 31.0]), -2_147_483_646.0);
    }

    #[test]
    fn numbers_that_left_their_formats_do_not_overflow() {
        assert_eq!(of("product", &[f64::INFINITY, KEPT, 1.0]), i64::MAX as f64 * KEPT / 2.0);
        assert_eq!(of("shift", &[f64::NAN, 3.0]), 0.0);
        assert_eq!(of("quotient", &[f64::INFINITY, 1.0, 60.0]), NARROW);
    }

    #[test]
    fn a_division_by_zero_gives_the_limit() {
        assert_eq!([1.0, -1.0, 0.0].map(|v| of("quotient", &[v, 0.0, 3.0])), [NARROW, -NARROW, 0.0]);
    }
}
