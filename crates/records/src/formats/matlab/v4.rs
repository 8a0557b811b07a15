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

#[cfg(test)]
mod tests {
    use super::*;

    /// A matrix whose data take eight bytes a number.
    fn matrix(code: u32, dims: [u32; 2], complex: u32, name: &[u8], data: &[f64]) -> Vec<u8> {
        let head = [code, dims[0], dims[1], complex, name.len() as u32].map(u32::to_le_bytes).concat();
        let data: Vec<u8> = data.iter().flat_map(|number| number.to_le_bytes()).collect();
        [&head[..], name, &data].concat()
    }

    #[test]
    fn a_file_begins_with_a_matrix_only_if_each_number_of_its_head_fits() {
        let begins = |code, complex, name: &[u8]| begins(&matrix(code, [2, 1], complex, name, &[1.0, 2.0]));
        let longest = [&[b'u'; 1023][..], &[0]].concat();
        assert!(begins(0, 0, b"u\0") && begins(2, 1, &longest));
        // Another machine, a digit that is 0, an unknown type, an unknown kind.
        assert!([1000, 100, 60, 3].iter().all(|code| !begins(*code, 0, b"u\0")));
        assert!(!begins(0, 2, b"u\0") && !begins(0, 0, b"u") && !begins(0, 0, b""));
        assert!(!begins(0, 0, &[&b"u"[..], &longest].concat()));
        let formats = [0, 10, 20, 30, 40, 50].map(|code| {
            let NumberFormat { kind, size, big } = head(&matrix(code, [0, 0], 0, b"u\0", &[]), 0).unwrap().numbers;
            (kind, size, big)
        });
        let [float, signed, unsigned] = [NumberKind::Float, NumberKind::Signed, NumberKind::Unsigned];
        let expected = [(float, 8), (float, 4), (signed, 4), (signed, 2), (unsigned, 2), (unsigned, 1)];
        assert_eq!(formats, expected.map(|(kind, size)| (kind, size, false)));
    }

    #[test]
    fn matrices_follow_each_other_whatever_they_hold() {
        let file = [
            matrix(0, [2, 1], 1, b"u\0", &[1.0, 2.0, 3.0, 4.0]),
            matrix(51, [1, 8], 0, b"remark\0", &[0.0]),
            matrix(51, [2, 4], 0, b"lines\0", &[0.0]),
            matrix(2, [1, 1], 0, b"sparse\0", &[0.0]),
            matrix(0, [2, 1], 0, b"y\0", &[5.0, 6.0]),
        ];
        let named = |name: &str, node| (name.to_string(), node);
        let expected = [
            named("u", Node::other("complex numbers")),
            named("lines", Node::other("text")),
            named("sparse", Node::other("a sparse matrix")),
            named("y", Node::series(Ok(vec![5.0, 6.0]), None)),
        ];
        assert_eq!(variables(&file.concat()).unwrap(), expected);
    }
}
