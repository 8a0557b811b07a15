//! HDF5, as MATLAB (`save -v7.3`) and h5py write it by default: data sets, also those in groups, by their own names.
//!
//! MATLAB states in attributes what an array is: text, logical, empty, sparse, an object. Not supported: features of
//! newer libraries (large groups in heaps, indices of chunks other than B-trees of version 1), files in several parts,
//! and filters other than deflate, shuffle and Fletcher's checksum. A data set that needs one of these is left out and
//! named in errors.

mod data;
mod group;
mod object;

use super::bytes::{Unpacking, damaged, length, part};
use super::{Channel, Format, Table};
use crate::Error;
use object::{Object, attribute};

/// The row of HDF5.
pub(super) const ROW: Format = Format {
    name: "hdf5",
    extensions: &["h5", "hdf5"],
    summary: "data sets of HDF5, as MATLAB's version 7.3 is",
    reference: "HDF5 File Format Specification 3.0, https://support.hdfgroup.org/documentation/hdf5/latest/_f_m_t3.html",
    matches: |bytes| start(bytes).is_some(),
    read: |bytes| Ok(Table::of(Hdf5File::open(bytes)?.channels()?)),
};

const MAGIC: &[u8] = b"\x89HDF\r\n\x1a\n";

/// Start of the data, after a block of the user: that of MATLAB has 512 bytes.
fn start(bytes: &[u8]) -> Option<usize> {
    let at = |at: &usize| bytes.get(*at..).is_some_and(|rest| rest.starts_with(MAGIC));
    [0, 512, 1024, 2048, 4096].into_iter().find(at)
}

/// A file, and the limits of reading it.
struct Hdf5File<'a> {
    /// The bytes to which addresses refer.
    bytes: &'a [u8],
    /// Address of the first group.
    root: usize,
    unpacking: Unpacking,
    /// Number of nodes and object headers that may still be visited: references of a damaged file may be cyclic.
    visits: usize,
}

impl<'a> Hdf5File<'a> {
    fn open(file: &'a [u8]) -> Result<Self, Error> {
        let bytes = file.get(start(file).unwrap_or(0)..).unwrap_or_default();
        let number = |at, size| length(bytes, at, size, false);
        // Positions of the sizes of addresses and lengths, of the base of addresses, of the end of the file, and of the
        // first group.
        let (sizes, base, end, root) = match number(8, 1)? {
            0 => (13, 24, 40, 64),
            1 => (13, 28, 44, 68),
            2 | 3 => (9, 12, 28, 36),
            version => return Err(newer(format!("superblock {version}"))),
        };
        if part(bytes, sizes, 2)? != [8, 8] {
            return Err(newer("addresses of other than 8 bytes"));
        }
        part(file, 0, number(end, 8)?)?;
        let bytes = file
            .get(number(base, 8)?..)
            .ok_or_else(|| damaged("the start of its data lies after the end of the file"))?;
        Ok(Hdf5File { bytes, root: number(root, 8)?, unpacking: Unpacking::of(file), visits: file.len() / 8 })
    }

    /// All data sets.
    fn channels(mut self) -> Result<Vec<Channel>, Error> {
        let mut channels = Vec::new();
        let root = self.object(self.root)?;
        self.group(&root, 0, &mut channels)?;
        Ok(channels)
    }

    /// Counts one more node or object header.
    fn visit(&mut self) -> Result<(), Error> {
        self.visits =
            self.visits.checked_sub(1).ok_or_else(|| damaged("its objects refer to each other cyclically"))?;
        Ok(())
    }

    fn number(&self, at: usize, size: usize) -> Result<usize, Error> {
        length(self.bytes, at, size, false)
    }

    /// The channels of a group and of the groups in it.
    fn group(&mut self, group: &Object<'a>, depth: usize, channels: &mut Vec<Channel>) -> Result<(), Error> {
        if depth > super::bytes::DEEPEST {
            return Err(damaged(format!("groups {depth} deep")));
        }
        for (name, at) in self.links(group)? {
            // Groups of MATLAB itself, to which cells refer.
            if name.starts_with('#') {
                continue;
            }
            let object = self.object(at)?;
            if attribute(&object, "MATLAB_sparse")?.is_some() {
                channels.push(Channel::other(name, "a sparse matrix"));
            } else if object.is_group() {
                self.group(&object, depth + 1, channels)?;
            } else if let Some(samples) = self.samples(&object)? {
                channels.push(Channel { name, unit: None, samples });
            }
        }
        Ok(())
    }
}

/// The error for an unsupported feature.
fn newer(what: impl std::fmt::Display) -> Error {
    Error::Content(format!(
        "this HDF5 file uses a feature that is not supported ({what}): save it as MATLAB -v7 or CSV"
    ))
}
