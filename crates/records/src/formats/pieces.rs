//! The input in a file, or input and output, piece by piece.
//!
//! A first pass over a text shows its sampling period, as that of the whole, and whether it can be read in pieces:
//! every row has a number, and the times are even. What needs a closer look is read as a whole, with the same result or
//! error.

use super::column::Column;
use super::csv::{PIECE, Rows};
use super::read::{Begun, broken, recognised};
use super::roles::Role;
use super::time::EvenStamps;
use super::{ColumnSelection, Signal, Table};
use piezoid_numerics::error::{Error, finite};
use piezoid_numerics::series::ends;
use std::io::{self, Read};
use std::sync::Arc;

/// Number of cells of a piece.
const CELLS: usize = 1 << 20;

/// The input in a file, in pieces that follow each other. Of text with columns, only a piece is held; a file of another
/// format, and one of which a part is selected, is one piece.
///
/// ```
/// use piezoid_records::formats::{ColumnSelection, InputPieces};
/// use std::io::{Cursor, Read};
/// let file = || Ok(Box::new(Cursor::new(b"t_s,u_V\n0,1\n0.1,2\n0.2,3\n")) as Box<dyn Read>);
/// let mut samples = Vec::new();
/// for piece in InputPieces::new("u.csv", &file, &ColumnSelection::default())? {
///     samples.extend(piece?.samples);
/// }
/// assert_eq!(samples, [1.0, 2.0, 3.0]);
/// # Ok::<(), piezoid_numerics::error::Error>(())
/// ```
pub struct InputPieces(Pieces);

enum Pieces {
    /// One piece, until it is taken.
    Whole(Option<Signal>),
    Rows(Box<RowPieces>),
}

/// Opens a file at its start.
pub type Open<'a> = &'a dyn Fn() -> io::Result<Box<dyn Read>>;

type Source = Begun<Box<dyn Read>>;

/// The rows of a text from its start.
pub(super) fn rows(open: Open, bytes: usize) -> Result<Rows<Source>, Error> {
    Rows::in_pieces(recognised(open().map_err(broken)?)?.1, bytes)
}

pub(super) struct RowPieces {
    rows: Rows<Source>,
    /// What the first pass found.
    found: Arc<Found>,
    /// Number of rows in the pieces so far.
    taken: usize,
    /// Number of cells of a piece.
    cells: usize,
}

/// What the first pass over a text found.
#[derive(Debug)]
pub(super) struct Found {
    /// The columns that are read.
    pub(super) signals: Vec<Place>,
    /// Sampling period [s].
    pub(super) ts: f64,
    /// Number of rows.
    pub(super) count: usize,
    /// For each column of the file, its numbers, and what is wrong with it.
    pub(super) columns: Vec<Content>,
    /// The steps that the file states, and lines that were left out.
    pub(super) steps: Vec<String>,
}

/// Place of a signal among the columns, its unit, and the factor that brings it there.
#[derive(Debug)]
pub(super) struct Place {
    pub(super) column: usize,
    pub(super) unit: String,
    pub(super) factor: f64,
}

/// The numbers of a column.
#[derive(Debug, Clone)]
pub(super) struct Content {
    pub(super) count: usize,
    pub(super) ends: (f64, f64),
    pub(super) flaw: Option<String>,
}

impl Content {
    /// Adds the numbers after the first `known` ones.
    fn add(&mut self, column: &Column, known: usize) {
        let numbers = || column.samples.iter().skip(known).copied().filter(|sample| sample.is_finite());
        let (low, high) = ends(numbers());
        self.count += numbers().count();
        self.ends = (self.ends.0.min(low), self.ends.1.max(high));
    }
}

impl InputPieces {
    /// The input in a file of this name, which is opened for each pass. Only errors use the name.
    ///
    /// # Errors
    /// The errors of [`Table::read_from`] and [`Table::input`].
    pub fn new(name: &str, open: Open, selection: &ColumnSelection) -> Result<Self, Error> {
        InputPieces::of(name, open, selection, (PIECE, CELLS)).map(InputPieces)
    }

    fn of(
        name: &str,
        open: Open,
        selection: &ColumnSelection,
        (bytes, cells): (usize, usize),
    ) -> Result<Pieces, Error> {
        let source = || recognised(open().map_err(broken)?);
        let text = || rows(open, bytes);
        let in_text = || {
            let mut rows = text()?;
            if !rows.fill(cells)? {
                return rows.end()?.input(selection).map(|signal| Some(Pieces::Whole(Some(signal))));
            }
            let Some(found) = Found::in_text(rows, &text, &[Role::Input], selection, cells)? else { return Ok(None) };
            Ok(Some(Pieces::Rows(Box::new(RowPieces::new(text()?, Arc::new(found), cells)))))
        };
        let is_cut = selection.from.is_some() || selection.to.is_some();
        // An error is found again in the whole, with all that it concerns.
        if !is_cut
            && source()?.0.in_pieces
            && let Ok::<_, Error>(Some(pieces)) = in_text()
        {
            return Ok(pieces);
        }
        let (table, _) = Table::read_from(name, open().map_err(broken)?)?;
        table.input(selection).map(|signal| Pieces::Whole(Some(signal)))
    }
}

/// The time column in the first pass.
struct Times {
    place: usize,
    stamps: EvenStamps,
}

impl Found {
    /// What a pass over the rows of a text shows, of which the first piece was read, or another one if the first is not
    /// sufficient; `None` for a text that must be read as a whole.
    pub(super) fn in_text(
        mut rows: Rows<Source>,
        text: &dyn Fn() -> Result<Rows<Source>, Error>,
        roles: &[Role],
        selection: &ColumnSelection,
        cells: usize,
    ) -> Result<Option<Found>, Error> {
        let Some((mut found, time)) = Found::columns(&rows.table, roles, selection)? else { return Ok(None) };
        found.columns.iter_mut().zip(&rows.table.columns).for_each(|(content, column)| content.add(column, 0));
        let mut times = time.map(|place| Times::new(place, &rows.table.columns[place]));
        let mut goes_on = true;
        while goes_on {
            // Without times, another record may begin where the names stand again.
            if times.is_none() && !rows.table.again.is_empty() {
                return Ok(None);
            }
            rows.drop_rows();
            goes_on = rows.fill(cells)?;
            // The first row is the last one of the rows before.
            found.columns.iter_mut().zip(&rows.table.columns).for_each(|(content, column)| content.add(column, 1));
            if let Some(times) = &mut times {
                times.add(&rows.table.columns[times.place]);
            }
        }
        let (count, table) = (rows.count(), rows.end()?);
        let places = found.signals.iter().map(|signal| signal.column).chain(times.as_ref().map(|times| times.place));
        let columns: Vec<&Column> = places.map(|place| &table.columns[place]).collect();
        let is_clear = |column: &&Column| column.flaw.is_none() && column.doubt.is_none();
        let signs: Vec<char> = columns.iter().filter_map(|column| column.decimal).map(|(sign, _)| sign).collect();
        let differ = signs.windows(2).any(|pair| pair[0] != pair[1]);
        if !columns.iter().all(is_clear) || differ || times.is_none() && !table.again.is_empty() {
            return Ok(None);
        }
        if let Some(times) = times {
            if !times.stamps.are_even() {
                return Ok(None);
            }
            let period = match times.stamps.period() {
                Some(period) => period,
                None => times.stamps.period_of(times.roughness(text()?, cells)?),
            };
            found.ts = table.seconds_of(&table.columns[times.place], selection, period)?;
        }
        for (content, column) in found.columns.iter_mut().zip(&table.columns) {
            content.flaw = column.doubt.as_ref().or(column.flaw.as_ref()).map(ToString::to_string);
        }
        (found.count, found.steps) = (count, table.steps);
        Ok(Some(found))
    }

    /// The columns of a table: those of the roles, and the place of the time if its stamps give the period. `None` if
    /// the period is stated in several ways.
    fn columns(
        table: &Table,
        roles: &[Role],
        selection: &ColumnSelection,
    ) -> Result<Option<(Found, Option<usize>)>, Error> {
        let place = |role: Role| {
            let column = role.find(table, selection).ok()?;
            table.columns.iter().position(|other| std::ptr::eq(other, column))
        };
        let mut signals: Vec<Place> = Vec::new();
        for role in roles {
            let Some(column) = place(*role) else { return Ok(None) };
            if signals.iter().any(|other| other.column == column) {
                return Ok(None);
            }
            let (unit, factor) = table.columns[column].unit_and_factor(*role, selection)?;
            signals.push(Place { column, unit, factor });
        }
        let is_signal = |time: usize| signals.iter().any(|signal| signal.column == time);
        let (ts, time) = match (selection.period()?, table.ts, place(Role::Time)) {
            (Some(ts), _, _) => (ts, None),
            (None, None, Some(time)) if !is_signal(time) => (0.0, Some(time)),
            (None, Some(ts), None) if selection.time_col.is_none() => (ts, None),
            _ => return Ok(None),
        };
        let none = Content { count: 0, ends: (f64::INFINITY, f64::NEG_INFINITY), flaw: None };
        let columns = vec![none; table.columns.len()];
        Ok(Some((Found { signals, ts, count: 0, columns, steps: Vec::new() }, time)))
    }
}

impl Times {
    fn new(place: usize, column: &Column) -> Self {
        let stamps = EvenStamps::new(column.samples[0], column.samples[1]);
        let mut times = Times { place, stamps };
        column.samples.iter().skip(2).for_each(|stamp| times.stamps.add(*stamp));
        times
    }

    /// Adds the stamps of a table that begins with the last one of the table before.
    fn add(&mut self, column: &Column) {
        column.samples.iter().skip(1).for_each(|stamp| self.stamps.add(*stamp));
    }

    /// The largest deviation of the stamps from even steps.
    fn roughness(&self, mut rows: Rows<Source>, cells: usize) -> Result<f64, Error> {
        let (mut roughness, mut first): (f64, usize) = (0.0, 0);
        loop {
            let goes_on = rows.fill(cells)?;
            let stamps = &rows.table.columns[self.place].samples;
            roughness =
                (first..).zip(stamps).map(|(k, stamp)| self.stamps.deviation(*stamp, k)).fold(roughness, f64::max);
            first += stamps.len().saturating_sub(1);
            if !goes_on {
                return Ok(roughness);
            }
            rows.drop_rows();
        }
    }
}

impl RowPieces {
    pub(super) fn new(rows: Rows<Source>, found: Arc<Found>, cells: usize) -> Self {
        RowPieces { rows, found, taken: 0, cells }
    }

    /// The next samples of each signal.
    pub(super) fn next(&mut self) -> Result<Option<Vec<Vec<f64>>>, Error> {
        if self.rows.fill(self.cells)? {
            return self.piece().map(Some);
        }
        let last = if self.taken < self.found.count { Some(self.piece()?) } else { None };
        if self.taken == self.found.count { Ok(last) } else { Err(changed()) }
    }

    fn piece(&mut self) -> Result<Vec<Vec<f64>>, Error> {
        let mut signals = Vec::with_capacity(self.found.signals.len());
        for Place { column, factor, .. } in &self.found.signals {
            let samples = &self.rows.table.columns[*column].samples;
            // All pieces but the first begin with the last row of the one before.
            let new = samples.iter().skip(usize::from(self.taken > 0));
            let samples: Vec<f64> = new.map(|sample| if *factor == 1.0 { *sample } else { sample * factor }).collect();
            finite("u", &samples).map_err(|_| changed())?;
            signals.push(samples);
        }
        self.taken += signals.first().map_or(0, Vec::len);
        self.rows.drop_rows();
        Ok(signals)
    }
}

/// The error for a file that has other rows than in the first pass.
fn changed() -> Error {
    Error::Content("the file was changed while it was read: repeat the command".into())
}

impl Iterator for InputPieces {
    type Item = Result<Signal, Error>;

    fn next(&mut self) -> Option<Self::Item> {
        match &mut self.0 {
            Pieces::Whole(signal) => signal.take().map(Ok),
            Pieces::Rows(rows) => {
                let found = rows.found.clone();
                let signal = |mut signals: Vec<Vec<f64>>| {
                    let unit = found.signals.first()?.unit.clone();
                    Some(Signal { ts: found.ts, samples: signals.pop()?, unit })
                };
                rows.next().map(|signals| signals.and_then(signal)).transpose()
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Cursor;

    /// The input of a text in pieces of a few rows, and the number of pieces.
    fn pieces(text: &str, selection: &ColumnSelection) -> Result<(Signal, usize), Error> {
        let bytes: std::sync::Arc<[u8]> = text.as_bytes().into();
        let open = move || Ok(Box::new(Cursor::new(bytes.clone())) as Box<dyn Read>);
        let mut all = Signal { ts: 0.0, samples: Vec::new(), unit: String::new() };
        let mut count = 0;
        for piece in InputPieces(InputPieces::of("u.csv", &open, selection, (200, 30))?) {
            let Signal { ts, samples, unit } = piece?;
            (all.ts, all.unit, count) = (ts, unit, count + 1);
            all.samples.extend(samples);
        }
        Ok((all, count))
    }

    fn whole(text: &str, selection: &ColumnSelection) -> Result<Signal, Error> {
        Table::read("u.csv", text.as_bytes())?.input(selection)
    }

    /// Rows of a time and an input.
    fn rows(n: usize, time: impl Fn(f64) -> String) -> String {
        (0..n).map(|k| format!("{},{}.5\n", time(k as f64), k % 7)).collect()
    }

    #[test]
    fn the_input_is_the_same_in_pieces() {
        let exact = |k: f64| format!("{:.4}", k * 5e-4);
        let any = ColumnSelection::default();
        let scaled = ColumnSelection { fs: Some(1e3), input_scale: Some("20".into()), ..any.clone() };
        for (text, selection) in [
            (format!("Time (s),Drive (V)\n{}", rows(300, exact)), &any),
            (format!("Time (s),Drive (V)\n{}", rows(301, exact)), &scaled),
            (format!("t_s,u_V\n{}Mean,3\n", rows(302, |k| format!("{:.6}", 17.123456 + k / 3000.0))), &any),
            (format!("t (ms),u_V\n{}", rows(303, |k| format!("{:.3}", 0.2 * k * (1.0 + 2e-6 * k)))), &any),
            (format!("t_s,u_V\n{}", rows(304, exact).replace("\n0.0500,", "\n# mark\nt_s,u_V\n0.0500,")), &any),
            (
                rows(305, |k| format!("{:.3}", 0.01 * k)).replace(',', "\t").replace('.', ","),
                &ColumnSelection {
                    input_col: Some("2".into()),
                    time_col: Some("1".into()),
                    time_unit: Some("s".into()),
                    ..any.clone()
                },
            ),
            (
                format!("Time (s),Drive (V),Time (s)\n{}", rows(300, exact).replace(".5\n", ".5,0\n")),
                &ColumnSelection { time_col: Some("1".into()), ..any.clone() },
            ),
        ] {
            let expected = whole(&text, selection).unwrap();
            let (found, count) = pieces(&text, selection).unwrap();
            assert_eq!((&found, count > 5), (&expected, true), "{count} pieces of {}", &text[..100]);
        }
    }

    #[test]
    fn what_needs_a_closer_look_is_read_as_a_whole() {
        let even = |k: f64| format!("{:.1}", 0.1 * k);
        let text = format!("t_s,u_V\n{}", rows(200, even));
        let any = ColumnSelection::default();
        for text in [
            text.replace("\n15.0,", "\n15.0,x"),
            text.replace("\n15.0,3.5\n", "\n"),
            format!("{text}20.0,1,2\n"),
            format!("t_s,u_V\n{}", rows(200, |k| format!("{:.9}", 1.0003f64.powf(k)))),
            format!("u_V\n{}u_V\n1\n2\n", "1\n2\n".repeat(100)),
            format!("t_s;u_V\n{}", "0;1,234\n".repeat(100)),
            format!("Sample Interval,0.01\nTime,u_V\n{}", rows(200, |_| "noon".into())),
            format!(
                "Sample Interval,0.005\nTime (s),u_V\n{}",
                rows(200, |k| format!("{:.2}", (0.5 * k).floor() / 100.0))
            ),
            "t_s,u_V\n0,1\n0.1,2\n".into(),
        ] {
            let expected = whole(&text, &any).map_err(|error| error.to_string());
            let found = pieces(&text, &any).map_err(|error| error.to_string());
            assert_eq!(found, expected.map(|signal| (signal, 1)), "{}", &text[..20]);
        }
        let cut = ColumnSelection { from: Some(1.0), ..any };
        assert_eq!(pieces(&text, &cut).unwrap().0.samples.len(), 190);
    }

    #[test]
    fn a_file_that_changes_while_it_is_read_is_an_error() {
        let opened = std::cell::Cell::new(0);
        let text = format!("t_s,u_V\n{}", rows(200, |k| format!("{:.1}", 0.1 * k)));
        let open = || {
            opened.set(opened.get() + 1);
            let end = if opened.get() > 2 { text.find("10.0,").unwrap() } else { text.len() };
            Ok(Box::new(Cursor::new(text.as_bytes()[..end].to_vec())) as Box<dyn Read>)
        };
        let pieces = InputPieces(InputPieces::of("u.csv", &open, &ColumnSelection::default(), (200, 30)).unwrap());
        let error = pieces.filter_map(Result::err).next().unwrap();
        assert!(error.to_string().starts_with("the file was changed while it was read"), "{error}");
    }
}
