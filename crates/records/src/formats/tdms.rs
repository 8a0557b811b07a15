//! TDMS, as LabVIEW and NI's programs write it: groups of channels in segments.
//!
//! ```text
//! segment   "TDSm", flags, version, length, length of the metadata; metadata; raw data
//! metadata  objects: path, place of the raw data, properties
//! scale     NI_Scale[0]_Scale_Type = Linear: value = slope x stored + intercept
//! period    wf_increment [s]
//! ```
//! A segment repeats the objects of the one before it unless its flag says that the list is new; raw data without new
//! metadata are more chunks of the same. Not supported: data in the layout of a DAQ card, other scales than linear
//! ones.

use super::bytes::{NumberFormat, NumberKind, Unpacking, damaged, length, part, whole};
use super::tree::{self, Node};
use super::{Channel, Format, Table};
use piezoid_numerics::error::Error;
use piezoid_numerics::number::power;
use std::collections::HashMap;

/// The row of TDMS.
pub(super) const ROW: Format = Format {
    name: "tdms",
    extensions: &["tdms", "tdms_index"],
    summary: "channels of LabVIEW",
    reference: "NI, TDMS File Format Internal Structure, \
                https://www.ni.com/en/support/documentation/supplemental/07/tdms-file-format-internal-structure.html",
    matches: |bytes| bytes.starts_with(DATA) || bytes.starts_with(INDEX),
    read,
    in_pieces: false,
    write: None,
};

const DATA: &[u8] = b"TDSm";
const INDEX: &[u8] = b"TDSh";
/// Length of the head of a segment.
const HEAD: usize = 28;
/// Flags of a segment.
const METADATA: u64 = 1 << 1;
const NEW_LIST: u64 = 1 << 2;
const INTERLEAVED: u64 = 1 << 5;
const BIG: u64 = 1 << 6;
const DAQMX: u64 = 1 << 7;
/// Place of the raw data of an object: none, or as in the segment before.
const NO_DATA: u64 = 0xffff_ffff;
const AS_BEFORE: u64 = 0;
/// Types of values.
const TEXT: u64 = 0x20;
const BOOLEAN: u64 = 0x21;
const INSTANT: u64 = 0x44;

fn read(bytes: &[u8]) -> Result<Table, Error> {
    if bytes.starts_with(INDEX) {
        return Err(Error::Content("this is the index of a TDMS file: give the .tdms file beside it".into()));
    }
    let mut reading = Reading {
        bytes,
        unpacking: Unpacking::of(bytes),
        objects: Vec::new(),
        paths: HashMap::new(),
        list: Vec::new(),
    };
    let mut at = 0;
    while at < bytes.len() {
        at = reading.segment(at)?;
    }
    let mut groups: Vec<(String, Node)> = Vec::new();
    for channel in reading.objects {
        let [group, name] = &channel.path[..] else { continue };
        let unit = channel.text("unit_string").filter(|unit| !unit.is_empty());
        let ts = channel.number("wf_increment").filter(|step| *step > 0.0);
        let series = Channel { name: name.clone(), unit, ts, samples: channel.samples() };
        let node = (name.clone(), Node::Series(series));
        match groups.iter_mut().find(|(known, _)| known == group) {
            Some((_, Node::Fields(channels))) => channels.push(node),
            _ => groups.push((group.clone(), Node::Fields(vec![node]))),
        }
    }
    Ok(tree::table(groups))
}

/// A channel, a group or the file itself.
#[derive(Debug, Clone)]
struct Object {
    /// Names of the group and of the channel; none for the file.
    path: Vec<String>,
    texts: HashMap<String, String>,
    numbers: HashMap<String, f64>,
    /// The stored numbers, or a description if they are none.
    stored: Result<Vec<f64>, String>,
    /// The first point in time, in ticks, from which the others count: it would leave few digits for their fractions.
    first: Option<i128>,
    place: Option<Place>,
    /// True if it is in the list of the segment.
    is_listed: bool,
}

/// Type and number of the values in a chunk.
#[derive(Debug, Clone, Copy)]
struct Place {
    kind: u64,
    count: usize,
    /// Bytes of all values, if they are text.
    text: usize,
}

struct Reading<'a> {
    bytes: &'a [u8],
    unpacking: Unpacking,
    objects: Vec<Object>,
    /// Their places by their paths.
    paths: HashMap<Vec<String>, usize>,
    /// The channels with raw data in a segment, in the order of their data.
    list: Vec<usize>,
}

impl Reading<'_> {
    /// Reads the segment at a position; returns the position of the next.
    fn segment(&mut self, at: usize) -> Result<usize, Error> {
        let bytes = self.bytes;
        if part(bytes, at, HEAD)?.get(..4) != Some(DATA) {
            return Err(damaged(format!("no segment stands at byte {at}")));
        }
        let flags = whole(bytes, at + 4, 4, false)?;
        let big = flags & BIG > 0;
        if flags & DAQMX > 0 {
            let advice = "this TDMS file holds raw data in the layout of a DAQ card: convert it in LabVIEW or with \
                          npTDMS, or export it as CSV";
            return Err(Error::Content(advice.into()));
        }
        // A segment that was not closed has the length 2^64 - 1: its data go on to the end of the file.
        let next = length(bytes, at + 12, 8, big).map_or(bytes.len(), |len| at + HEAD + len).min(bytes.len());
        let raw = at + HEAD + length(bytes, at + 20, 8, big)?;
        if flags & METADATA > 0 {
            if flags & NEW_LIST > 0 {
                self.list.drain(..).for_each(|index| self.objects[index].is_listed = false);
            }
            let mut cursor = Cursor { bytes, at: at + HEAD, big };
            for _ in 0..cursor.count()? {
                self.object(&mut cursor)?;
            }
        }
        let data = bytes.get(raw.min(next)..next).unwrap_or_default();
        self.chunks(data, big, flags & INTERLEAVED > 0)?;
        Ok(next)
    }

    /// Reads the metadata of one object.
    fn object(&mut self, cursor: &mut Cursor<'_>) -> Result<(), Error> {
        let path = names(&cursor.text()?);
        let index = *self.paths.entry(path.clone()).or_insert(self.objects.len());
        if index == self.objects.len() {
            self.objects.push(Object {
                path,
                texts: HashMap::new(),
                numbers: HashMap::new(),
                stored: Ok(Vec::new()),
                first: None,
                place: None,
                is_listed: false,
            });
        }
        let channel = &mut self.objects[index];
        let place = cursor.number(4)?;
        if place != NO_DATA && place != AS_BEFORE {
            let (kind, _, count) = (cursor.number(4)?, cursor.number(4)?, cursor.number(8)?);
            let many = |_| damaged("a chunk of too many values");
            let text = if kind == TEXT { usize::try_from(cursor.number(8)?).map_err(many)? } else { 0 };
            channel.place = Some(Place { kind, count: usize::try_from(count).map_err(many)?, text });
        }
        match (std::mem::replace(&mut channel.is_listed, place != NO_DATA), place != NO_DATA) {
            (false, true) => self.list.push(index),
            (true, false) => self.list.retain(|listed| *listed != index),
            _ => {}
        }
        for _ in 0..cursor.count()? {
            let (name, kind) = (cursor.text()?, cursor.number(4)?);
            channel.texts.remove(&name);
            channel.numbers.remove(&name);
            match kind {
                TEXT => drop(channel.texts.insert(name, cursor.text()?)),
                _ => drop(channel.numbers.insert(name, cursor.value(kind)?)),
            }
        }
        Ok(())
    }

    /// Reads the raw data of a segment: chunk after chunk, in which the values of a channel stand together or, if
    /// interleaved, one of each channel in turn.
    fn chunks(&mut self, data: &[u8], big: bool, interleaved: bool) -> Result<(), Error> {
        let mut places = Vec::new();
        let mut chunk = 0usize;
        for &index in &self.list {
            let Some(place) = self.objects[index].place else { continue };
            let (size, bytes) = match size(place.kind) {
                _ if place.kind == TEXT => {
                    self.objects[index].stored = Err("text".into());
                    (1, Some(place.text))
                }
                Some(size) => (size, place.count.checked_mul(size)),
                None => {
                    // The place of the data behind it is unknown.
                    for &index in &self.list {
                        self.objects[index].stored = Err("beside values of an unknown type".into());
                    }
                    return Ok(());
                }
            };
            let end = bytes.and_then(|bytes| chunk.checked_add(bytes));
            chunk = end.ok_or_else(|| damaged("a chunk of too many values"))?;
            places.push((index, place, size, bytes.unwrap_or_default()));
        }
        if chunk == 0 {
            return Ok(());
        }
        // Channels without values in a chunk would cost a pass each.
        places.retain(|(_, _, _, bytes)| interleaved || *bytes > 0);
        let row: usize = places.iter().map(|(_, _, size, _)| size).sum();
        for chunk in data.chunks(chunk) {
            let mut at = 0;
            for &(index, place, size, bytes) in &places {
                let (from, stride) = if interleaved { (at, row) } else { (at, size) };
                at += if interleaved { size } else { bytes };
                let values = chunk.get(from..).unwrap_or_default();
                // The last chunk of a file that was not closed may be shorter.
                let last = values.len().checked_sub(size).and_then(|last| last.checked_div(stride));
                let count = place.count.min(last.map_or(0, |last| last + 1));
                self.unpacking.count(count.saturating_mul(8))?;
                let object = &mut self.objects[index];
                let read = match numbers(place.kind, big) {
                    Some(format) => {
                        let end = if count == 0 { 0 } else { (count - 1) * stride + size };
                        format.read(values.get(..end).unwrap_or_default(), stride)
                    }
                    None if place.kind == INSTANT => {
                        let each = |k| object.since_first(values.get(k * stride..).unwrap_or_default(), big);
                        (0..count).map(each).collect()
                    }
                    None => None,
                };
                if let (Ok(stored), Some(read)) = (&mut object.stored, read) {
                    stored.extend(read);
                }
            }
        }
        Ok(())
    }
}

impl Object {
    fn number(&self, name: &str) -> Option<f64> {
        self.numbers.get(name).copied()
    }

    fn text(&self, name: &str) -> Option<String> {
        self.texts.get(name).cloned()
    }

    /// The values: the stored numbers, scaled.
    fn samples(&self) -> Result<Vec<f64>, String> {
        let mut samples = self.stored.clone()?;
        if samples.is_empty() {
            return Err("empty".into());
        }
        let scaled = self.text("NI_Scaling_Status").is_some_and(|status| status == "scaled");
        let scales = self.number("NI_Number_Of_Scales").filter(|_| !scaled).unwrap_or(0.0) as usize;
        for k in 0..scales.min(16) {
            let value = |name: &str| self.number(&format!("NI_Scale[{k}]_{name}"));
            match self.text(&format!("NI_Scale[{k}]_Scale_Type")).as_deref() {
                // A scale of another input than the values of the scale before it.
                Some(_)
                    if value("Linear_Input_Source").is_some_and(|from| k > 0 && from != f64::from(k as u32 - 1)) =>
                {
                    return Err("with scales that branch".into());
                }
                Some("Linear") => {
                    let slope = value("Linear_Slope").unwrap_or(1.0);
                    let intercept = value("Linear_Y_Intercept").unwrap_or(0.0);
                    samples.iter_mut().for_each(|v| *v = *v * slope + intercept);
                }
                Some(kind) => return Err(format!("in counts with a scale of the kind {kind}")),
                None => {}
            }
        }
        Ok(samples)
    }

    /// The time [s] since the first point in time.
    fn since_first(&mut self, bytes: &[u8], big: bool) -> Option<f64> {
        let ticks = ticks(bytes, big)?;
        Some(ticks.saturating_sub(*self.first.get_or_insert(ticks)) as f64 / power(2.0, 64))
    }
}

/// A position in metadata.
struct Cursor<'a> {
    bytes: &'a [u8],
    at: usize,
    big: bool,
}

impl Cursor<'_> {
    fn number(&mut self, size: usize) -> Result<u64, Error> {
        let number = whole(self.bytes, self.at, size, self.big)?;
        self.at += size;
        Ok(number)
    }

    /// A number of entries, of which each takes four bytes at least.
    fn count(&mut self) -> Result<usize, Error> {
        let count = self.number(4)? as usize;
        part(self.bytes, self.at, count.saturating_mul(4))?;
        Ok(count)
    }

    fn text(&mut self) -> Result<String, Error> {
        let len = self.number(4)? as usize;
        let text = String::from_utf8_lossy(part(self.bytes, self.at, len)?).into_owned();
        self.at += len;
        Ok(text)
    }

    /// The value of a property that is no text.
    fn value(&mut self, kind: u64) -> Result<f64, Error> {
        let size = size(kind).ok_or_else(|| damaged(format!("a property of the unknown type {kind}")))?;
        let value = part(self.bytes, self.at, size)?;
        self.at += size;
        let number = numbers(kind, self.big).and_then(|format| format.read(value, size)?.first().copied());
        Ok(number.unwrap_or(f64::NAN))
    }
}

/// Bytes of a value of this type.
fn size(kind: u64) -> Option<usize> {
    if kind == INSTANT { Some(16) } else { Some(numbers(kind, false)?.size) }
}

/// The format of numbers of this type; `None` for others.
fn numbers(kind: u64, big: bool) -> Option<NumberFormat> {
    let (kind, size) = match kind {
        1..=4 => (NumberKind::Signed, 1 << (kind - 1)),
        5..=8 => (NumberKind::Unsigned, 1 << (kind - 5)),
        BOOLEAN => (NumberKind::Unsigned, 1),
        9 | 0x19 => (NumberKind::Float, 4),
        10 | 0x1a => (NumberKind::Float, 8),
        _ => return None,
    };
    Some(NumberFormat { kind, size, big })
}

/// A point in time in ticks of 2^-64 s: the fraction of a second, then whole seconds.
fn ticks(bytes: &[u8], big: bool) -> Option<i128> {
    let (fraction, seconds) = if big { (8, 0) } else { (0, 8) };
    let half = |at| whole(bytes, at, 8, big).ok();
    Some(i128::from(half(seconds)? as i64) << 64 | i128::from(half(fraction)?))
}

/// The names in a path such as `/'group'/'channel'`, in which a quote is doubled.
fn names(path: &str) -> Vec<String> {
    let mut names: Vec<String> = Vec::new();
    let mut inside = false;
    let mut chars = path.chars().peekable();
    while let Some(c) = chars.next() {
        let is_doubled = inside && c == '\'' && chars.next_if_eq(&'\'').is_some();
        if c == '\'' && !is_doubled {
            inside = !inside;
            names.extend(inside.then(String::new));
        } else if let Some(name) = names.last_mut().filter(|_| inside) {
            name.push(c);
        }
    }
    names
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_path_holds_the_names_of_group_and_channel() {
        assert_eq!(names("/"), Vec::<String>::new());
        assert_eq!(names("/'Log'/'Voltage'"), ["Log", "Voltage"]);
        assert_eq!(names("/'it''s'/'a/b'"), ["it's", "a/b"]);
        assert_eq!(names("/'open"), ["open"]);
    }

    #[test]
    fn a_point_in_time_is_a_fraction_and_whole_seconds() {
        for seconds in [3_700_000_000i64, -1] {
            let bytes = [(1u64 << 63).to_le_bytes(), seconds.to_le_bytes()].concat();
            let turned: Vec<u8> = bytes.iter().rev().copied().collect();
            let expected = Some((i128::from(seconds) << 64) + (1 << 63));
            assert_eq!((ticks(&bytes, false), ticks(&turned, true)), (expected, expected));
        }
    }

    fn words(numbers: &[u32], big: bool) -> Vec<u8> {
        numbers.iter().flat_map(|number| if big { number.to_be_bytes() } else { number.to_le_bytes() }).collect()
    }

    fn long(number: u64, big: bool) -> [u8; 8] {
        if big { number.to_be_bytes() } else { number.to_le_bytes() }
    }

    /// A channel, the place of its data, and its property `wf_increment`.
    fn channel(name: &str, place: &[u8], step: f64, big: bool) -> Vec<u8> {
        let text = |text: &str| [words(&[text.len() as u32], big), text.into()].concat();
        let property = [text("wf_increment"), words(&[10], big), long(step.to_bits(), big).into()].concat();
        [text(&format!("/'log'/'{name}'")), place.into(), words(&[1], big), property].concat()
    }

    /// A place of so many values of a type; if they are text, of so many bytes.
    fn place(kind: u32, count: u64, text: u64, big: bool) -> Vec<u8> {
        let text = if u64::from(kind) == TEXT { long(text, big).to_vec() } else { Vec::new() };
        [words(&[20, kind, 1], big), long(count, big).into(), text].concat()
    }

    fn segment(flags: u64, channels: &[Vec<u8>], data: &[u8], big: bool) -> Vec<u8> {
        let flags = if big { flags | BIG } else { flags };
        let count = if flags & METADATA > 0 { words(&[channels.len() as u32], big) } else { Vec::new() };
        let metadata = [count, channels.concat()].concat();
        let lens = [metadata.len() + data.len(), metadata.len()].map(|len| long(len as u64, big));
        let head = [DATA, &(flags as u32).to_le_bytes(), &words(&[4713], big), &lens.concat()].concat();
        [&head[..], &metadata, data].concat()
    }

    /// The numbers of all channels that were read, in the order of the channels.
    fn stored(file: &[u8]) -> Vec<Vec<f64>> {
        let (unpacking, objects, paths, list) = (Unpacking::of(file), Vec::new(), HashMap::new(), Vec::new());
        let mut reading = Reading { bytes: file, unpacking, objects, paths, list };
        let mut at = 0;
        while at < file.len() {
            at = reading.segment(at).unwrap();
        }
        reading.objects.into_iter().map(|object| object.stored.unwrap()).collect()
    }

    #[test]
    fn every_whole_number_before_the_end_of_the_file_is_read() {
        for (flags, order, big) in [(0, "uuyy", false), (0, "uuyy", true), (INTERLEAVED, "uyuy", false)] {
            let channels = [("u", 2), ("y", 10)].map(|(name, kind)| channel(name, &place(kind, 2, 0, big), 0.5, big));
            // Three chunks of two numbers of two bytes and two of eight, and the end of each number.
            let (mut data, mut ends) = (Vec::new(), Vec::new());
            for (k, name) in (0i16..).zip(order.repeat(3).chars()) {
                let long = f64::from(-k).to_be_bytes();
                let mut bytes = if name == 'u' { (-k).to_be_bytes().to_vec() } else { long.into() };
                if !big {
                    bytes.reverse();
                }
                data.extend(bytes);
                ends.push((name, data.len(), f64::from(-k)));
            }
            for len in 0..=data.len() {
                let expected = ['u', 'y'].map(|name| {
                    let here = ends.iter().filter(|(own, end, _)| *own == name && *end <= len);
                    here.map(|(.., number)| *number).collect::<Vec<f64>>()
                });
                let mut file = segment(METADATA | NEW_LIST | flags, &channels, &data[..len], big);
                assert_eq!(stored(&file), expected, "{order} {big} {len}");
                // As it is written while the file is open.
                file[12..20].fill(0xff);
                assert_eq!(stored(&file), expected, "{order} {big} {len}, not closed");
            }
        }
    }

    #[test]
    fn a_segment_says_only_what_differs_from_the_one_before_it() {
        let (before, none) = (words(&[0], false), words(&[NO_DATA as u32], false));
        let part = |flags: u64, channels: &[(&str, &[u8], f64)], data: &[&[f64]]| {
            let one = |(name, place, step): &(&str, &[u8], f64)| channel(name, place, *step, false);
            let channels: Vec<_> = channels.iter().map(one).collect();
            let data: Vec<u8> = data.concat().iter().flat_map(|number| number.to_le_bytes()).collect();
            segment(flags, &channels, &data, false)
        };
        let two = place(10, 2, 0, false);
        let file = [
            part(METADATA | NEW_LIST, &[("u", &two, 0.0), ("data", &two, 0.5)], &[&[1.0, 2.0], &[11.0, 12.0]]),
            // The same again, twice.
            part(0, &[], &[&[3.0, 4.0], &[13.0, 14.0], &[5.0, 6.0], &[15.0, 16.0]]),
            part(METADATA, &[("u", &before, 0.0), ("data", &none, 0.5)], &[&[7.0, 8.0]]),
            part(METADATA | NEW_LIST, &[("data", &before, 0.5)], &[&[17.0, 18.0]]),
            part(METADATA, &[("u", &before, 0.0)], &[&[19.0, 20.0], &[9.0, 10.0]]),
        ];
        let table = read(&file.concat()).unwrap();
        let counted = |first: i32| (first..first + 10).map(f64::from).collect::<Vec<_>>();
        let found: Vec<_> = table.columns.into_iter().map(|column| (column.name, column.samples, column.ts)).collect();
        assert_eq!(found, [("u".to_string(), counted(1), None), ("data".to_string(), counted(11), Some(0.5))]);
    }

    #[test]
    fn numbers_behind_text_are_read_and_those_beside_an_unknown_type_are_not() {
        let numbers = |kind: u32, text: &[u8]| {
            let channels = [("note", place(kind, 2, text.len() as u64, false)), ("u", place(2, 2, 0, false))];
            let channels = channels.map(|(name, place)| channel(name, &place, 0.5, false));
            read(&segment(METADATA | NEW_LIST, &channels, &[text, &[1, 0, 2, 0]].concat(), false)).unwrap()
        };
        // The ends of two texts, and the texts.
        let table = numbers(TEXT as u32, b"\x04\0\0\0\x06\0\0\0bender");
        assert_eq!((&table.columns[0].samples[..], &*table.left), (&[1.0, 2.0][..], "note (text)"));
        let unknown = numbers(11, b"");
        let left = "note (beside values of an unknown type), u (beside values of an unknown type)";
        assert_eq!((unknown.columns.len(), &*unknown.left), (0, left));
        let card = read(&segment(DAQMX, &[], &[], false)).unwrap_err().to_string();
        assert!(card.contains("the layout of a DAQ card"), "{card}");
    }

    #[test]
    fn a_type_has_its_size() {
        assert_eq!([1, 2, 3, 4, 5, 6, 7, 8].map(size), [1, 2, 4, 8, 1, 2, 4, 8].map(Some));
        assert_eq!([BOOLEAN, 9, 0x19, 10, 0x1a, INSTANT].map(size), [1, 4, 4, 8, 8, 16].map(Some));
        assert_eq!([0, 11, TEXT].map(size), [None; 3]);
    }
}
