//! What C has no operators for: rounding and saturation, without anything that C99 leaves open.

use piezoid::program::{Expr, Program};

/// What C has no operators for.
pub(crate) fn helpers(name: &str, program: &Program) -> String {
    let mut called: Vec<String> = Vec::new();
    for function in &program.functions {
        function.expressions(&mut |expr| {
            if let Expr::Call(name, _) = expr {
                called.push(name.clone());
            }
        });
    }
    if called.iter().any(|c| c == "product") {
        called.push("shift".into());
    }
    let needed = HELPERS.iter().filter(|(helper, _)| called.iter().any(|c| c == helper));
    needed.map(|(_, text)| text.replace("NAME", name)).collect()
}

const HELPERS: &[(&str, &str)] = &[
    (
        "narrow",
        "/* v in 32 bits, held at the ends. */
static int32_t NAME_narrow(int64_t v)
{
    int64_t held = v;
    if (held > INT32_MAX) {
        held = INT32_MAX;
    }
    if (held < -INT32_MAX) {
        held = -INT32_MAX;
    }
    return (int32_t)held;
}

",
    ),
    (
        "keep",
        "/* v in 52 bits, held at the ends, which leaves room for a sum. */
static int64_t NAME_keep(int64_t v)
{
    const int64_t end = (int64_t)1 << 51;
    int64_t held = v;
    if (held > end) {
        held = end;
    }
    if (held < -end) {
        held = -end;
    }
    return held;
}

",
    ),
    (
        "shift",
        "/* v / 2^n to the nearest, halves away from zero. C99 leaves open what shifts do to negative numbers: none is shifted here. */
static int64_t NAME_shift(int64_t v, int n)
{
    const uint64_t size = (uint64_t)((v < 0) ? -v : v);
    const int64_t nearest = (int64_t)((size + ((uint64_t)1 << (n - 1))) >> n);
    return (v < 0) ? -nearest : nearest;
}

",
    ),
    (
        "product",
        "/* a b / 2^n to the nearest. */
static int64_t NAME_product(int32_t a, int32_t b, int n)
{
    return NAME_shift((int64_t)a * b, n);
}

",
    ),
    (
        "quotient",
        "/* 2^n a / b to the nearest, n < 32, in 32 bits; what is divided by nothing is as far as can be. */
static int32_t NAME_quotient(int32_t a, int32_t b, int n)
{
    const uint64_t size = (uint64_t)((a < 0) ? -(int64_t)a : (int64_t)a) << n;
    const uint64_t by = (uint64_t)((b < 0) ? -(int64_t)b : (int64_t)b);
    uint64_t nearest = (size == 0U) ? 0U : (uint64_t)INT32_MAX;
    if (by > 0U) {
        nearest = (size + (by / 2U)) / by;
        if (nearest > (uint64_t)INT32_MAX) {
            nearest = (uint64_t)INT32_MAX;
        }
    }
    return ((a < 0) == (b < 0)) ? (int32_t)nearest : -(int32_t)nearest;
}

",
    ),
];
