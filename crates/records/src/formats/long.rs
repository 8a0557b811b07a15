//! A record that is too long to be held: it is read from its file as often as needed, piece by piece.
//!
//! It does not do: other files than text with columns, cuts, times that are uneven, and numbers that are in doubt. What
//! needs this is held.

use super::csv::PIECE;
use super::pieces::{Found, Open, RowPieces, rows};
use super::read::{broken, recognised};
use super::roles::Role;
use super::{ColumnSelection, Format, Table};
use crate::record::{Record, Units};
use piezoid_numerics::error::{Error, positive};
use piezoid_numerics::number::ascii_unit;
use piezoid_numerics::series::ends;
use serde_json::{Value, json};
use std::sync::Arc;

/// Number of samples up to which a record is held.
pub const MAX_HELD_SAMPLES: usize = 1 << 21;

/// Number of cells of a piece.
const CELLS: usize = 1 << 19;

/// The samples of a record in a text, which are read in pieces.
///
/// ```
/// use piezoid_records::formats::{ColumnSelection, LongRecord, Opened};
/// use std::io::{Cursor, Read};
/// let file = || Ok(Box::new(Cursor::new(b"t_s,u_V,y_um\n0,1,0\n0.1,2,9\n0.2,3,18\n")) as Box<dyn Read>);
/// // It has more than one sample, which is the most to be held here.
/// let opened = LongRecord::open("r.csv", &file, &ColumnSelection::default(), 1)?;
/// let Opened::Long(record) = opened else { panic!("held") };
/// let mut sum = 0.0;
/// record.read(&mut |_, y| {
///     sum += y.iter().sum::<f64>();
///     Ok(())
/// })?;
/// assert_eq!((record.len(), record.ts(), sum), (3, 0.1, 27.0));
/// # Ok::<(), piezoid_numerics::error::Error>(())
/// ```
pub struct LongRecord<'a> {
    open: Open<'a>,
    found: Arc<Found>,
    units: Units,
    /// Factor of the output after that of its column.
    factor: f64,
    history: Vec<String>,
    channels: Vec<Value>,
    layout: String,
    profile: ColumnSelection,
    format: &'static Format,
    /// Number of samples up to which its sections are held.
    held: usize,
    /// Number of bytes and of cells of a piece.
    piece: (usize, usize),
}

/// Takes the input and the output of a piece.
pub type Take<'a> = &'a mut dyn FnMut(&[f64], &[f64]) -> Result<(), Error>;

/// A file of a record.
pub enum Opened<'a> {
    /// What it contains.
    Held(Table, &'static Format),
    /// Its record is longer than what is held.
    Long(Box<LongRecord<'a>>),
}

impl<'a> LongRecord<'a> {
    /// The record in a file of this name, which is opened for each pass; the table in it, if that has at most `held`
    /// rows, or needs to be known as a whole. Only errors use the name.
    ///
    /// # Errors
    /// The errors of [`Table::read_from`].
    pub fn open(name: &str, open: Open<'a>, selection: &ColumnSelection, held: usize) -> Result<Opened<'a>, Error> {
        let (format, _) = recognised(open().map_err(broken)?)?;
        let piece = (PIECE.min(held.saturating_mul(64).max(256)), CELLS.min(held.saturating_mul(2).max(4)));
        let is_cut = selection.from.is_some() || selection.to.is_some();
        // An error is found again in the whole, with all that it concerns.
        if format.in_pieces
            && !is_cut
            && let Ok(Some(opened)) = LongRecord::in_text(open, format, selection, (held, piece))
        {
            return Ok(opened);
        }
        Table::read_from(name, open().map_err(broken)?).map(|(table, format)| Opened::Held(table, format))
    }

    fn in_text(
        open: Open<'a>,
        format: &'static Format,
        selection: &ColumnSelection,
        (held, piece): (usize, (usize, usize)),
    ) -> Result<Option<Opened<'a>>, Error> {
        let text = || rows(open, piece.0);
        let mut head = text()?;
        if !head.fill(held.saturating_mul(head.table.columns.len()))? {
            return head.end().map(|table| Some(Opened::Held(table, format)));
        }
        let (history, channels) = (head.table.history(selection), head.table.described(selection));
        let (profile, layout) = (head.table.profile(selection), head.table.layout(format.name));
        let Some(found) = Found::in_text(head, &text, &[Role::Input, Role::Output], selection, piece.1)? else {
            return Ok(None);
        };
        positive("ts", found.ts, "seconds")?;
        let unit = |k: usize| found.signals.get(k).map(|signal| ascii_unit(&signal.unit)).unwrap_or_default();
        let units = Units { u: unit(0), y: unit(1) };
        let history = found.steps.iter().cloned().chain(history).collect();
        let described = |(mut channel, content): (Value, &super::pieces::Content)| {
            channel["samples"] = json!(content.count);
            (channel["low"], channel["high"]) = (json!(content.ends.0), json!(content.ends.1));
            channel["flaw"] = json!(content.flaw);
            channel
        };
        let channels = channels.into_iter().zip(&found.columns).map(described).collect();
        let found = Arc::new(found);
        let record =
            LongRecord { open, found, units, factor: 1.0, history, channels, layout, profile, format, held, piece };
        Ok(Some(Opened::Long(Box::new(record))))
    }

    /// Reads all samples: `take` gets input and output of each piece.
    ///
    /// # Errors
    /// The errors of reading and of `take`, and an error if the file was changed.
    pub fn read(&self, take: Take) -> Result<(), Error> {
        let mut pieces = RowPieces::new(rows(self.open, self.piece.0)?, self.found.clone(), self.piece.1);
        while let Some(mut signals) = pieces.next()? {
            let (Some(mut y), Some(u)) = (signals.pop(), signals.pop()) else { continue };
            if self.factor != 1.0 {
                y.iter_mut().for_each(|y| *y *= self.factor);
            }
            take(&u, &y)?;
        }
        Ok(())
    }

    /// Reads all samples in sections of equal length, of which each is held: `take` gets the place of its first sample,
    /// and the section.
    ///
    /// # Errors
    /// The errors of [`read`](LongRecord::read).
    pub fn sections(&self, take: &mut dyn FnMut(usize, &Record)) -> Result<(), Error> {
        let (mut start, mut ends) = (0, self.section_ends(self.len()).peekable());
        let mut held = [Vec::new(), Vec::new()];
        self.read(&mut |u, y| {
            let mut from = 0;
            while let Some(&end) = ends.peek().filter(|_| from < u.len()) {
                let to = u.len().min(from + end - start - held[0].len());
                held.iter_mut().zip([u, y]).for_each(|(held, new)| held.extend(&new[from..to]));
                from = to;
                if start + held[0].len() == end {
                    let [u, y] = std::mem::take(&mut held);
                    take(start, &Record::new(self.ts(), u, y)?.with_units(self.units.clone()));
                    start = end;
                    ends.next();
                }
            }
            Ok(())
        })
    }

    /// The smallest and the largest number of input and output.
    pub fn ends(&self) -> [(f64, f64); 2] {
        let of = |k: usize| {
            let signal = self.found.signals.get(k)?;
            let (low, high) = self.found.columns.get(signal.column)?.ends;
            let factor = if k == 1 { self.factor } else { 1.0 };
            Some(ends([low, high].map(|x| x * signal.factor * factor)))
        };
        [0, 1].map(|k| of(k).unwrap_or_default())
    }

    /// The same record with its output in another length unit.
    ///
    /// # Errors
    /// Returns an error if the conversion is unknown (see [`Units::factor`]).
    pub fn output_in(self, unit: &str) -> Result<Self, Error> {
        let unit = ascii_unit(unit);
        let unknown = || Error::units("the output of the record", &self.units.y, &unit);
        let factor = Units::factor(&self.units.y, &unit).ok_or_else(unknown)?;
        Ok(LongRecord { units: Units { y: unit, ..self.units }, factor, ..self })
    }

    /// Sampling period [s].
    pub fn ts(&self) -> f64 {
        self.found.ts
    }

    /// Number of samples.
    #[allow(clippy::len_without_is_empty)] // never empty
    pub fn len(&self) -> usize {
        self.found.count
    }

    /// Length in time [s].
    pub fn duration(&self) -> f64 {
        self.len() as f64 * self.ts()
    }

    /// Units of the samples.
    pub fn units(&self) -> &Units {
        &self.units
    }

    /// How the record was made, step by step.
    pub fn history(&self) -> &[String] {
        &self.history
    }

    /// Name of the format of its file.
    pub fn format(&self) -> &'static str {
        self.format.name
    }

    /// The columns of its file: see [`Table::described`].
    pub fn channels(&self) -> &[Value] {
        &self.channels
    }

    /// What files like its own have in common: see [`Table::layout`].
    pub fn layout(&self) -> &str {
        &self.layout
    }

    /// The selection that reads it: see [`Table::profile`].
    pub fn profile(&self) -> &ColumnSelection {
        &self.profile
    }

    /// Ends of the sections, of equal length, in which `n` samples are analysed one after the other: each is at most
    /// half of what may be held, because a spectrum needs as much again.
    pub fn section_ends(&self, n: usize) -> impl Iterator<Item = usize> + use<> {
        let count = n.div_ceil((self.held / 2).max(1)).max(1);
        (1..=count).map(move |k| (k as u128 * n as u128 / count as u128) as usize)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::{Cursor, Read};

    /// Most samples that are held.
    const HELD: usize = 64;

    /// A time in ms, an input, and an output that is stated in mm.
    fn text(n: usize) -> String {
        let row = |k: usize| format!("{},{}.5,{}e-3\n", 0.5 * k as f64, k % 7, (3 * k) % 11);
        std::iter::once("# rig 3\nt (ms),Drive (V),Sensor (mm)\n".to_string()).chain((0..n).map(row)).collect()
    }

    /// What is done with an open text.
    fn opened<T>(text: &str, selection: &ColumnSelection, with: impl FnOnce(Result<Opened, Error>) -> T) -> T {
        let bytes: Arc<[u8]> = text.as_bytes().into();
        let open = move || Ok(Box::new(Cursor::new(bytes.clone())) as Box<dyn Read>);
        with(LongRecord::open("r.csv", &open, selection, HELD))
    }

    /// The same with its record, which is too long to be held.
    fn long<T>(text: &str, selection: &ColumnSelection, with: impl FnOnce(LongRecord) -> T) -> T {
        opened(text, selection, |opened| match opened.unwrap() {
            Opened::Long(record) => with(*record),
            Opened::Held(..) => panic!("it is held"),
        })
    }

    #[test]
    fn a_record_that_is_read_in_pieces_is_the_one_that_is_read_as_a_whole() {
        let selection = ColumnSelection { input_scale: Some("-2".into()), ..ColumnSelection::default() };
        let text = text(1000);
        let table = Table::read("r.csv", text.as_bytes()).unwrap();
        let whole = table.record(&selection).unwrap();
        long(&text, &selection, |record| {
            let (mut u, mut y, mut pieces) = (Vec::new(), Vec::new(), 0);
            let add = &mut |more_u: &[f64], more_y: &[f64]| {
                u.extend_from_slice(more_u);
                y.extend_from_slice(more_y);
                pieces += 1;
                Ok(())
            };
            record.read(add).unwrap();
            assert!(pieces > 2, "{pieces} pieces");
            assert_eq!((&u[..], &y[..]), (whole.u(), whole.y()));
            assert_eq!(record.ends(), [&u, &y].map(|x| ends(x.iter().copied())));
            assert_eq!((record.len(), record.ts(), record.duration()), (1000, whole.ts(), 0.5));
            assert_eq!((record.units(), record.history()), (whole.units(), &table.history(&selection)[..]));
            assert_eq!((record.format(), record.layout()), ("csv", &*table.layout("csv")));
            assert_eq!(
                (record.profile(), record.channels()),
                (&table.profile(&selection), &table.described(&selection)[..])
            );
        });
    }

    #[test]
    fn sections_follow_each_other_and_are_of_equal_length() {
        let text = text(1000);
        let whole = Table::read("r.csv", text.as_bytes()).unwrap().record(&ColumnSelection::default()).unwrap();
        long(&text, &ColumnSelection::default(), |record| {
            let mut sections = Vec::new();
            record.sections(&mut |start, section| sections.push((start, section.clone()))).unwrap();
            for (start, section) in &sections {
                // A whole number of sections of at most 32 samples: 31 or 32 each.
                assert!(section.len().abs_diff(31) <= 1 && section.len() <= HELD / 2, "{}", section.len());
                let same = whole.slice(*start..start + section.len()).unwrap();
                assert_eq!((section.u(), section.y(), section.units()), (same.u(), same.y(), same.units()));
            }
            assert_eq!(sections.iter().map(|(_, section)| section.len()).sum::<usize>(), 1000);
            assert!(sections.windows(2).all(|pair| pair[1].0 == pair[0].0 + pair[0].1.len()));
            assert_eq!(sections.len(), record.section_ends(1000).count());
        });
    }

    #[test]
    fn the_output_of_a_long_record_can_be_in_another_unit_of_length() {
        long(&text(200), &ColumnSelection::default(), |record| {
            assert_eq!(record.units().y, "mm");
            let [input, _] = record.ends();
            let record = record.output_in("um").unwrap();
            assert_eq!((record.units().y.as_str(), record.units().u.as_str()), ("um", "V"));
            assert_eq!(record.ends(), [input, (0.0, 10.0)]);
            let mut first = Vec::new();
            let take = &mut |_: &[f64], y: &[f64]| {
                first.extend_from_slice(y);
                Ok(())
            };
            record.read(take).unwrap();
            piezoid_testing::assert_close(&first[..4], &[0.0, 3.0, 6.0, 9.0], 1e-12, 0.0);
            let refused = record.output_in("V").err().expect("a voltage is no length").to_string();
            assert!(refused.contains("um") && refused.contains('V'), "{refused}");
        });
    }

    #[test]
    fn what_is_short_cut_uneven_or_in_doubt_is_held() {
        let whole = text(200);
        let cut = ColumnSelection { from: Some(0.01), ..ColumnSelection::default() };
        let any = ColumnSelection::default();
        for (text, selection) in [
            (text(HELD), &any),
            (whole.clone(), &cut),
            (whole.replace("\n20,", "\n20.1,"), &any),
            (whole.replace("\n20,5.5,", "\n20,x,"), &any),
        ] {
            let held = opened(
                &text,
                selection,
                |opened| matches!(opened, Ok(Opened::Held(_, format)) if format.name == "csv"),
            );
            assert!(held, "{} bytes", text.len());
        }
        let other = ColumnSelection { output_col: Some("no such".into()), ..any };
        assert!(
            opened(&whole, &other, |opened| matches!(opened, Ok(Opened::Held(..)))),
            "its error is found by the table"
        );
    }
}
