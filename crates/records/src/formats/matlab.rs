//! MATLAB's files of versions 4, 5 and 7 (`save -v4`, `-v6`, `-v7`): variables and structures (see `tree`).
//!
//! Matrices, complex and sparse arrays, and objects are left out and named in errors. Version 7.3 is HDF5 (see `hdf5`).

mod v4;
mod v5;
mod write;

use super::{Format, Table, tree};
use piezoid_numerics::error::Error;

/// The row of MATLAB.
pub(super) const ROW: Format = Format {
    name: "matlab",
    extensions: &["mat"],
    summary: "variables of MATLAB",
    reference: "MathWorks, MAT-File Format, R2024b, https://www.mathworks.com/help/pdf_doc/matlab/matfile_format.pdf",
    matches: |bytes| v5::begins(bytes) || v4::begins(bytes) || bytes.starts_with(OCTAVE),
    read,
    in_pieces: false,
    write: Some(write::write),
};

/// Signature of Octave's text format, which has the extension .mat too.
const OCTAVE: &[u8] = b"# Created by Octave";

fn read(file: &[u8]) -> Result<Table, Error> {
    if file.starts_with(OCTAVE) {
        return Err(Error::Content("this is Octave's text format: save it with `save -v7`, or as CSV".into()));
    }
    Ok(tree::table(if v5::begins(file) { v5::variables(file)? } else { v4::variables(file)? }))
}
