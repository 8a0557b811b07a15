//! Text of Igor Pro (`.itx`): waves, and the commands that scale them.
//!
//! ```text
//! IGOR
//! WAVES/D u, y
//! BEGIN
//! 20.0 1.93
//! END
//! X SetScale/P x 0,5e-05,"s", u, y; SetScale y 0,0,"V", u
//! ```
//! Not supported: text, complex numbers, several dimensions.

use super::bytes::damaged;
use super::csv::{decode, lines};
use super::quote::{quoted, shortened};
use super::units::seconds;
use super::{Channel, Format, Table, time};
use piezoid_numerics::error::Error;

/// The row of Igor's text.
pub(super) const ROW: Format = Format {
    name: "igor",
    extensions: &["itx"],
    summary: "waves of Igor Pro, as text",
    reference: "WaveMetrics, Igor Pro Manual, chapter Importing and Exporting Data, Igor Text Files",
    matches: |bytes| bytes.starts_with(b"IGOR\r") || bytes.starts_with(b"IGOR\n"),
    read,
    in_pieces: false,
    write: None,
};

fn read(bytes: &[u8]) -> Result<Table, Error> {
    let text = decode(bytes)?;
    let mut waves = Vec::new();
    let mut lines = lines(&text).map(|(line, text)| (line, text.trim()));
    while let Some((_, text)) = lines.next() {
        if let Some(head) = after("WAVES", text) {
            waves.extend(block(head, &mut lines)?);
        } else if let Some(commands) = after("X ", text) {
            commands.split(';').for_each(|command| scale(command.trim(), &mut waves));
        }
    }
    Ok(Table::of(waves))
}

/// The rest of a text after a word, in any case.
fn after<'a>(word: &str, text: &'a str) -> Option<&'a str> {
    let (head, rest) = text.split_at_checked(word.len())?;
    head.eq_ignore_ascii_case(word).then_some(rest)
}

/// Names between spaces and commas; a name in quotes may contain both.
fn names(text: &str) -> impl Iterator<Item = &str> {
    let mut inside = false;
    let apart = move |c: char| {
        inside ^= c == '\'';
        !inside && (c == ',' || c.is_whitespace())
    };
    text.split(apart).filter(|name| !name.is_empty()).map(|name| name.trim_matches('\''))
}

/// The waves of a block; its head is `/D u, y`.
fn block<'a>(head: &str, lines: &mut impl Iterator<Item = (u64, &'a str)>) -> Result<Vec<Channel>, Error> {
    let head = head.trim_start();
    let flags = if head.starts_with('/') { head.split(char::is_whitespace).next().unwrap_or(head) } else { "" };
    let mut waves: Vec<Channel> = names(&head[flags.len()..]).map(|name| Channel::new(name, Vec::new())).collect();
    let flags = flags.to_ascii_uppercase();
    let other = flags.split('/').find_map(|flag| match flag {
        "T" => Some("text"),
        "C" => Some("complex numbers"),
        _ if flag.starts_with("N=") && flag.contains(',') => Some("of several dimensions"),
        _ => None,
    });
    for (line, text) in lines {
        match text {
            _ if text.eq_ignore_ascii_case("END") => {
                let named = |wave: Channel| match other {
                    Some(what) => Channel::other(wave.name, what),
                    None => wave,
                };
                return Ok(waves.into_iter().map(named).collect());
            }
            _ if other.is_some() || text.is_empty() || text.eq_ignore_ascii_case("BEGIN") => {}
            _ => row(line, text, &mut waves)?,
        }
    }
    Err(damaged("a block of waves has no END"))
}

/// Appends a row of numbers to the waves.
fn row(line: u64, text: &str, waves: &mut [Channel]) -> Result<(), Error> {
    let refused = |column, problem| Err(Error::Line { line, column, problem });
    let mut cells = text.split([',', ' ', '\t']).filter(|cell| !cell.is_empty());
    let count = cells.clone().count();
    if count != waves.len() {
        return refused(None, format!("{count} numbers, but {} waves: complete the row, or delete it", waves.len()));
    }
    for (Channel { name, samples, .. }, cell) in waves.iter_mut().zip(&mut cells) {
        match (samples, cell.parse()) {
            (Ok(samples), Ok(value)) => samples.push(value),
            _ => return refused(Some(shortened(name)), format!("{} is not a number", quoted(cell))),
        }
    }
    Ok(())
}

/// Gives waves the period of `SetScale/P x 0,5e-05,"s", u` or the unit of `SetScale y 0,0,"V", u`; ignores other
/// commands.
fn scale(command: &str, waves: &mut [Channel]) {
    let parts = after("SetScale", command).map(|rest| rest.trim_start().splitn(3, '"').collect::<Vec<_>>());
    let Some([axis, unit, targets]) = parts.as_deref() else { return };
    let step = || after("/P x ", axis)?.split(',').nth(1)?.trim().parse::<f64>().ok();
    // Without a unit of time, x counts samples, or is something else.
    let ts = seconds(unit).and_then(|seconds| Some(time::times(step()?, seconds)));
    let ts = ts.filter(|ts| ts.is_finite() && *ts > 0.0);
    let of_samples = !unit.is_empty() && ["y ", "d "].iter().any(|kind| after(kind, axis).is_some());
    for name in names(targets) {
        for wave in waves.iter_mut().filter(|wave| wave.name.eq_ignore_ascii_case(name)) {
            wave.ts = ts.or(wave.ts);
            wave.unit = if of_samples { Some(unit.to_string()) } else { wave.unit.take() };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::ColumnSelection;

    fn record(text: &str) -> Result<crate::record::Record, String> {
        read(text.as_bytes()).and_then(|table| table.record(&ColumnSelection::default())).map_err(|e| e.to_string())
    }

    #[test]
    fn waves_are_read_together_or_one_by_one_with_their_units() {
        let scales = "X SetScale/P x 0,0.5,\"ms\", u, 'y 1'; SetScale y 0,0,\"V\", U\nX SetScale d 0,0,\"um\", 'y 1'\n";
        let together = "IGOR\nWAVES/D/N=(2)\tu, 'y 1'\nBEGIN\n\t1\t2e1\n\t-3\t40\nEND\n";
        let apart =
            "IGOR\nWAVES u\nBEGIN\n 1\n-3\nEND\nX Note u, \"by night; E-503\"\nwaves/o 'y 1'\nbegin\n20\n40\nend\n";
        for waves in [together, apart] {
            for text in [format!("{waves}{scales}"), format!("{waves}{scales}").replace('\n', "\r")] {
                let record = record(&text).unwrap();
                assert_eq!((record.ts(), record.u(), record.y()), (5e-4, &[1.0, -3.0][..], &[20.0, 40.0][..]));
                assert_eq!((record.units().u.as_str(), record.units().y.as_str()), ("V", "um"));
            }
        }
        // Igor's scale of waves that have none is no period.
        assert!(record(&format!("{together}X SetScale/P x 0,1,\"\", u, 'y 1'\n")).unwrap_err().contains("time"));
    }

    #[test]
    fn what_is_no_wave_of_numbers_is_left_out_or_refused() {
        let head = "IGOR\nWAVES t_s u_V y_um\nBEGIN\n0 1 2\n";
        let message = |text: &str| record(&format!("{head}{text}")).unwrap_err();
        assert!(message("1 2\nEND\n").starts_with("line 5: 2 numbers, but 3 waves"));
        assert!(message("1 x 2\nEND\n").starts_with("line 5, column u_V: `x` is not a number"));
        assert!(message("1 nan 2\nEND\n").starts_with("row 1, u_V: the sample is NaN: repair it"));
        assert!(message("1 2 3\n").contains("no END"));
        let others = "1 2 3\nEND\nWAVES/T a\nBEGIN\n\"b c\"\nEND\nWAVES/C z\nBEGIN\n1 2\nEND\nWAVES/N=(2,2) m\nBEGIN\n1 2\nEND\n";
        assert_eq!(record(&format!("{head}{others}")).unwrap().y(), [2.0, 3.0]);
    }
}
