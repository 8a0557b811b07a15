//! HDF5, as MATLAB (`save -v7.3`), h5py and NetCDF-4 write it: data sets, also those in groups, and their units and
//! rates in attributes.
//!
//! MATLAB states in attributes what an array is: text, logical, empty, sparse, an object. A data set that cannot be
//! read is left out and named in errors; a filter that only its own library knows (LZF, Blosc) is one reason.
//!
//! Why: docs/decisions/data-and-records.md, "HDF5 is read by a crate, other binary formats by piezoid".

use super::bytes::{self, DEEPEST, NumberFormat, NumberKind, Unpacking, damaged};
use super::csv::stated_period;
use super::tree::{self, Node};
use super::{Format, Table};
use hdf5_reader::group::Group;
use hdf5_reader::messages::datatype::CompoundField;
use hdf5_reader::{Attribute, ByteOrder, Dataset, Datatype, Hdf5File, OpenOptions};
use piezoid_numerics::error::Error;

/// The row of HDF5.
pub(super) const ROW: Format = Format {
    name: "hdf5",
    extensions: &["h5", "hdf5", "nc"],
    summary: "data sets of HDF5, such as MATLAB files of version 7.3",
    reference: "HDF5 File Format Specification 3.0, https://support.hdfgroup.org/documentation/hdf5/latest/_f_m_t3.html",
    matches,
    read,
    in_pieces: false,
    write: None,
};

/// The classes of MATLAB that are numbers.
const NUMBERS: [&str; 11] =
    ["double", "single", "logical", "int8", "uint8", "int16", "uint16", "int32", "uint32", "int64", "uint64"];
/// Maximum number of groups and data sets.
const MAX_NODES: usize = 10_000;

/// True if the signature stands at the start, or after a block of the user: that of MATLAB has 512 bytes.
fn matches(bytes: &[u8]) -> bool {
    let at = |at: &usize| bytes.get(*at..).is_some_and(|rest| rest.starts_with(b"\x89HDF\r\n\x1a\n"));
    [0, 512, 1024, 2048, 4096].iter().any(at)
}

fn read(bytes: &[u8]) -> Result<Table, Error> {
    let (table, failed) = content(bytes)?;
    match failed.then(|| older(bytes)).flatten() {
        Some(bytes) => Ok(content(&bytes)?.0),
        None => Ok(table),
    }
}

/// A copy in which the layouts of version 2 say that they are of version 1, which has the same bytes; `None` without
/// them. MATLAB before 2008 wrote version 2, of which hdf5-reader 0.12.1 skips three reserved bytes in place of five.
fn older(bytes: &[u8]) -> Option<Vec<u8>> {
    // The type of the message, its length, a flag, the version, the rank, the class, reserved bytes.
    let is_layout = |at: &usize| match bytes.get(*at..at + 16) {
        Some([8, 0, len, 0, _, 0, 0, 0, 2, rank, class, 0, 0, 0, 0, 0]) => *len >= 16 && *rank <= 33 && *class <= 2,
        _ => false,
    };
    let found: Vec<usize> = (0..bytes.len()).step_by(8).filter(is_layout).collect();
    let mut copy = bytes.to_vec();
    found.iter().for_each(|at| copy[at + 8] = 1);
    (!found.is_empty()).then_some(copy)
}

/// The table in a file, and whether a data set could not be read.
fn content(bytes: &[u8]) -> Result<(Table, bool), Error> {
    let mut reading = Reading { unpacking: Unpacking::of(bytes), objects: 0, failed: false };
    let limit = reading.unpacking.left();
    let options = OpenOptions::default().with_max_read_bytes(limit).with_max_chunk_bytes(limit);
    let file = Hdf5File::from_bytes_with_options(bytes, options).map_err(refused)?;
    let end = file.superblock().eof_address;
    if end > bytes.len() as u64 {
        return Err(damaged(format!("it should have {end} bytes, but has {}", bytes.len())));
    }
    let root = file.root_group().map_err(refused)?;
    let table = tree::table(reading.group(&root, 0)?);
    Ok((table, reading.failed))
}

/// The error of the reader.
fn refused(error: hdf5_reader::error::Error) -> Error {
    damaged(format!("{error}; if other programs read it, save it as MATLAB -v7 or CSV"))
}

/// The limits of reading a file.
struct Reading {
    unpacking: Unpacking,
    /// Groups and data sets so far: links of a damaged file may be cyclic.
    objects: usize,
    /// True if a data set could not be read.
    failed: bool,
}

impl Reading {
    fn count(&mut self) -> Result<(), Error> {
        self.objects += 1;
        if self.objects > MAX_NODES {
            return Err(damaged(format!("more than {MAX_NODES} groups and data sets")));
        }
        Ok(())
    }

    /// The content of a group.
    fn group(&mut self, group: &Group, depth: usize) -> Result<Vec<(String, Node)>, Error> {
        self.count()?;
        if depth > DEEPEST {
            return Err(damaged(format!("groups {depth} deep")));
        }
        let attributes = group.attributes().map_err(refused)?;
        let stated = |(name, value, _): (&str, f64, f64)| (name.to_string(), Node::series(Ok(vec![value]), None));
        let mut content: Vec<_> = periods(&attributes).map(stated).collect();
        let (groups, data) = group.members().map_err(refused)?;
        for data in &data {
            self.count()?;
            let attributes = data.attributes();
            let own = periods(&attributes).next().map(|(.., ts)| ts);
            content.extend(self.data(data, &attributes)?.map(|node| (data.name().to_string(), node.every(own))));
        }
        for group in &groups {
            let name = group.name().to_string();
            // Groups of MATLAB itself, to which cells refer.
            if name.starts_with('#') {
                continue;
            }
            let sparse = group.attribute("MATLAB_sparse").is_ok();
            let node =
                if sparse { Node::other("a sparse matrix") } else { Node::Fields(self.group(group, depth + 1)?) };
            content.push((name, node));
        }
        Ok(content)
    }

    /// The content of a data set; `None` for information of MATLAB itself.
    fn data(&mut self, data: &Dataset, attributes: &[Attribute]) -> Result<Option<Node>, Error> {
        let attribute = |name: &str| attributes.iter().find(|attribute| attribute.name == name);
        let dims: Vec<usize> = data.shape().iter().map(|dim| usize::try_from(*dim).unwrap_or(usize::MAX)).collect();
        // The last dimension is the first one of MATLAB: a line of text has one row.
        let rows = dims.last().copied().unwrap_or(1);
        let class = attribute("MATLAB_class").and_then(|class| class.read_string().ok());
        match class.as_deref() {
            _ if attribute("MATLAB_empty").is_some_and(|empty| empty.read_as_f64().is_ok_and(|v| v > 0.0)) => {
                return Ok(Some(Node::other("empty")));
            }
            Some("char") if rows == 1 => return Ok(self.letters(data, &dims)?.map(Node::Text)),
            Some(class) if !NUMBERS.contains(&class) => return Ok(Some(Node::other(format!("of class {class}")))),
            _ => {}
        }
        let unit = ["units", "unit", "Units", "Unit"].iter().find_map(|name| attribute(name)?.read_string().ok());
        let size = bytes::size(&dims)?;
        let text = matches!(data.dtype(), Datatype::String { .. } | Datatype::VarLen { .. });
        if text && size == 1 {
            return Ok(data.read_string().ok().map(Node::Text));
        }
        if let Datatype::Compound { size, fields } = data.dtype() {
            let complex = fields.len() == 2 && fields[0].name == "r" && fields[1].name == "i";
            return Ok(Some(match bytes::vector(&dims)? {
                _ if complex => Node::other("complex numbers"),
                Err(what) => Node::other(what),
                Ok(n) => {
                    let raw = self.raw(data, n, *size as usize)?;
                    let field = |field: &CompoundField| {
                        let samples = numbers(&field.datatype).map_err(String::from).and_then(|numbers| {
                            let raw = raw.as_ref().map_err(Clone::clone)?;
                            let raw = raw.get(field.byte_offset as usize..).unwrap_or_default();
                            numbers.read(raw, *size as usize).ok_or_else(|| "of an unknown type".into())
                        });
                        (field.name.clone(), Node::series(samples, None))
                    };
                    Node::Fields(fields.iter().map(field).collect())
                }
            }));
        }
        Ok(Some(match (numbers(data.dtype()), bytes::vector(&dims)?) {
            // A single value that is no number is information on the record.
            (Err(_), _) if size == 1 => return Ok(None),
            (Err(what), _) => Node::other(what),
            (_, Err(what)) => Node::other(what),
            (Ok(numbers), Ok(n)) => {
                self.unpacking.count(n.saturating_mul(8))?;
                let raw = self.raw(data, n, numbers.size)?;
                let read = |raw: Vec<u8>| numbers.read(&raw, numbers.size).ok_or_else(|| "of an unknown type".into());
                Node::series(raw.and_then(read).map(|values| unpacked(values, attributes)), unit)
            }
        }))
    }

    /// The bytes of a vector, or the reason why they cannot be read.
    fn raw(&mut self, data: &Dataset, n: usize, size: usize) -> Result<Result<Vec<u8>, String>, Error> {
        self.unpacking.count(n.saturating_mul(size))?;
        let raw = data.read_raw_bytes();
        self.failed |= raw.is_err();
        Ok(raw.map_err(|error| error.to_string()))
    }

    /// A line of text as MATLAB stores it: code units of 16 bits.
    fn letters(&mut self, data: &Dataset, dims: &[usize]) -> Result<Option<String>, Error> {
        let Ok(n) = bytes::vector(dims)? else { return Ok(None) };
        let raw = self.raw(data, n, 2)?.unwrap_or_default();
        let units: Vec<u16> = raw.chunks_exact(2).map(|unit| u16::from_le_bytes([unit[0], unit[1]])).collect();
        Ok(Some(String::from_utf16_lossy(&units)))
    }
}

/// The sampling periods and rates among attributes: names, values, and the periods [s] that they state.
fn periods(attributes: &[Attribute]) -> impl Iterator<Item = (&str, f64, f64)> {
    attributes.iter().filter_map(|attribute| {
        let (name, value) = (&*attribute.name, attribute.read_as_f64().ok()?);
        Some((name, value, stated_period(name, value)?))
    })
}

/// Values as NetCDF packs them: `scale_factor` and `add_offset`, NaN for `_FillValue`.
/// <https://docs.unidata.ucar.edu/nug/current/attribute_conventions.html>
fn unpacked(values: Vec<f64>, attributes: &[Attribute]) -> Vec<f64> {
    let stated = |name: &str| attributes.iter().find(|attribute| attribute.name == name)?.read_as_f64().ok();
    let fill = stated("_FillValue").or_else(|| stated("missing_value"));
    let (scale, offset) = (stated("scale_factor"), stated("add_offset"));
    if (fill, scale, offset) == (None, None, None) {
        return values;
    }
    let one = |value: f64| match Some(value) == fill {
        true => f64::NAN,
        false => value * scale.unwrap_or(1.0) + offset.unwrap_or(0.0),
    };
    values.into_iter().map(one).collect()
}

/// The format of numbers, or a description of a type that is not real numbers.
fn numbers(kind: &Datatype) -> Result<NumberFormat, &'static str> {
    let format = |kind, size: u8, order: ByteOrder| {
        Ok(NumberFormat { kind, size: size.into(), big: order == ByteOrder::BigEndian })
    };
    match kind {
        Datatype::FixedPoint { size, signed, byte_order } => {
            format(if *signed { NumberKind::Signed } else { NumberKind::Unsigned }, *size, *byte_order)
        }
        Datatype::FloatingPoint { size, byte_order } => format(NumberKind::Float, *size, *byte_order),
        // Booleans of h5py.
        Datatype::Enum { base, .. } => numbers(base),
        Datatype::String { .. } => Err("text"),
        Datatype::Compound { .. } => Err("several numbers in one"),
        Datatype::Reference { .. } => Err("references, as of cells and arrays of structures"),
        Datatype::VarLen { .. } => Err("text, or series of several lengths"),
        _ => Err("no numbers"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_layout_of_version_two_is_read_as_one_of_version_one() {
        let file = |before: usize, [len, rank, class]: [u8; 3]| {
            let message = [8, 0, len, 0, 7, 0, 0, 0, 2, rank, class, 0, 0, 0, 0, 0];
            [&vec![0; before][..], &message, &[9; 8]].concat()
        };
        for (before, last) in [(8, [16, 33, 2]), (24, [40, 1, 0])] {
            let mut expected = file(before, last);
            expected[before + 8] = 1;
            assert_eq!(older(&file(before, last)), Some(expected));
        }
        for (before, wrong) in [(4, [16, 33, 2]), (8, [15, 33, 2]), (8, [16, 34, 2]), (8, [16, 33, 3])] {
            assert_eq!(older(&file(before, wrong)), None, "{before} {wrong:?}");
        }
    }

    #[test]
    fn a_file_has_so_many_groups_and_data_sets_at_most_and_so_deep() {
        let bytes = include_bytes!("../../../testing/golden/formats/links.h5");
        let mut reading = Reading { unpacking: Unpacking::of(bytes), objects: MAX_NODES - 1, failed: false };
        assert!(reading.count().is_ok() && reading.count().is_err());
        // A group stands in the first one.
        let file = Hdf5File::from_bytes_with_options(bytes, OpenOptions::default()).unwrap();
        let root = file.root_group().unwrap();
        reading.objects = 0;
        assert!(reading.group(&root, DEEPEST - 1).is_ok());
        let error = reading.group(&root, DEEPEST).unwrap_err().to_string();
        assert!(error.ends_with("groups 33 deep"), "{error}");
    }

    #[test]
    fn an_attribute_states_a_period_by_its_name() {
        let attribute = |name: &str, value: f64| Attribute {
            name: name.into(),
            datatype: Datatype::FloatingPoint { size: 8, byte_order: ByteOrder::LittleEndian },
            shape: Vec::new(),
            raw_data: value.to_le_bytes().into(),
            decoded_strings: None,
        };
        let attributes = [attribute("gain", 3.0), attribute("fs", 2000.0), attribute("Ts_ms", 0.5)];
        let found: Vec<_> = periods(&attributes).collect();
        assert_eq!(found, [("fs", 2000.0, 5e-4), ("Ts_ms", 0.5, 5e-4)]);
    }

    #[test]
    fn what_follows_a_file_is_not_read() {
        let bytes = include_bytes!("../../../testing/golden/formats/fields.h5");
        assert_eq!(read(&[&bytes[..], &[0; 8]].concat()), read(bytes));
    }
}
