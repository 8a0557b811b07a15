//! Version 4: matrices one after the other, each after a header of 20 bytes and its name.

use crate::formats::bytes::{NumberFormat, NumberKind, damaged, length, part, size, text, vector, whole};
use crate::formats::tree::Node;
use piezoid_numerics::error::Error;

/// The header of a matrix.
struct MatrixHead {
    numbers: NumberFormat,
    /// Numbers, text, or a sparse matrix.
    kind: u64,
    dims: [usize; 2],
    complex: bool,
    name: usize,
}

/// The header at this position, if it can be one. These files have no signature, but hardly any other file passes the
/// checks.
fn head(file: &[u8], at: usize) -> Option<MatrixHead> {
    let big = whole(file, at, 4, false).ok()? > 9999;
    let number = |k: usize| length(file, at + 4 * k, 4, big).ok();
    // Four decimal digits: machine, 0, type of number, kind of matrix.
    let code = whole(file, at, 4, big).ok()?;
    let (machine, zero, kind) = (code / 1000, code / 100 % 10, code % 10);
    let (number_kind, bytes) = match code / 10 % 10 {
        0 => (NumberKind::Float, 8),
        1 => (NumberKind::Float, 4),
        2 => (NumberKind::Signed, 4),
        3 => (NumberKind::Signed, 2),
        4 => (NumberKind::Unsigned, 2),
        5 => (NumberKind::Unsigned, 1),
        _ => return None,
    };
    let (complex, name) = (number(3)?, number(4)?);
    let fits = machine == u64::from(big) && zero == 0 && kind <= 2 && complex <= 1 && (1..=1024).contains(&name);
    let [.., 0] = part(file, at + 20, name).ok()? else { return None };
    let numbers = NumberFormat { kind: number_kind, size: bytes, big };
    fits.then_some(MatrixHead { numbers, kind, dims: [number(1)?, number(2)?], complex: complex == 1, name })
}

/// True if a file begins with a matrix.
pub(super) fn begins(file: &[u8]) -> bool {
    head(file, 0).is_some()
}

/// The variables.
pub(super) fn variables(file: &[u8]) -> Result<Vec<(String, Node)>, Error> {
    let mut channels = Vec::new();
    let mut at = 0;
    while at < file.len() {
        let MatrixHead { numbers, kind, dims, complex, name: len } =
            head(file, at).ok_or_else(|| damaged(format!("no matrix stands at byte {at}")))?;
        let name = text(part(file, at + 20, len)?);
        at += 20 + len;
        let mut shape = dims.to_vec();
        shape.push(numbers.size);
        let real = part(file, at, size(&shape)?)?;
        shape.push(1 + usize::from(complex));
        at += part(file, at, size(&shape)?)?.len();
        let what = match (kind, vector(&dims)?) {
            (1, _) if dims[0] <= 1 => continue,
            (1, _) => "text",
            (2, _) => "a sparse matrix",
            _ if complex => "complex numbers",
            (_, Err(what)) => &what.clone(),
            (_, Ok(_)) => {
                channels.push((name, Node::series(Ok(numbers.read(real, numbers.size).unwrap_or_default()), None)));
                continue;
            }
        };
        channels.push((name, Node::other(what.to_string())));
    }
    Ok(channels)
}
