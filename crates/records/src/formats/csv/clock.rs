//! Times in words: `2024-03-05T14:07:09.0005+01:00`, `05.03.2024 14:07:09,5`, `11:59:59.95 AM`, `0 days 00:00:01.5`,
//! `0.5 sec`.
//!
//! Of a date, only the time of day is read. A clock that goes back by more than half a day has passed midnight. Dates
//! are not read, because `3/5/2024` is two days.

use crate::formats::units;

/// Seconds of a day.
pub(super) const DAY: f64 = 86_400.0;

/// The time in a cell [s]; `None` if it does not hold one.
pub(super) fn read(cell: &str) -> Option<f64> {
    let Some(first) = cell.find(':') else { return duration(cell) };
    if let Some((days, time)) = cell.split_once(" day") {
        return Some(days.trim().parse::<f64>().ok()? * DAY + of_day(time.trim_start_matches('s').trim())?);
    }
    // Digits of the hour stand right before the first colon, after a date or at the start.
    let before = cell[..first].trim_end_matches(|c: char| c.is_ascii_digit());
    if !(before.is_empty() || before.ends_with(['T', 't', ' '])) || !before.chars().all(in_a_date) {
        return None;
    }
    of_day(&cell[before.len()..])
}

/// A number with a unit of time after it.
fn duration(cell: &str) -> Option<f64> {
    let (number, unit) = cell.split_once(' ')?;
    let seconds = units::seconds(unit)?;
    Some(super::number::read(number)?.0 * seconds)
}

/// A time of day such as `14:07:09.5`, perhaps with a time zone, or `2:07:09.5 PM`.
fn of_day(time: &str) -> Option<f64> {
    let end = time.find(|c: char| !c.is_ascii_digit() && !":.,".contains(c)).unwrap_or(time.len());
    let (time, after) = time.split_at(end);
    // Minutes and seconds, which alone have a fraction.
    if let Some((minute, second)) = time.split_once(':')
        && second.find(['.', ',']) == Some(2)
        && (1..=2).contains(&minute.len())
        && after.is_empty()
    {
        let second: f64 = second.replace(',', ".").parse().ok()?;
        return Some(minute.parse::<f64>().ok()? * 60.0 + second).filter(|_| second < 60.0);
    }
    let mut parts = time.splitn(3, ':');
    let hour: f64 = parts.next().filter(|hour| (1..=2).contains(&hour.len()))?.parse().ok()?;
    let minute: f64 = parts.next().filter(|minute| minute.len() == 2)?.parse().ok()?;
    // Some programs write milliseconds after a colon.
    let second: f64 = parts.next().unwrap_or("0").replace([',', ':'], ".").parse().ok()?;
    let after = after.trim();
    let noon = match after.get(..2).map(str::to_ascii_lowercase).as_deref() {
        Some("pm") if hour < 12.0 => 12.0,
        Some("am") if hour == 12.0 => -12.0,
        Some("am" | "pm") => 0.0,
        _ => -zone(after)?,
    };
    (hour < 24.0 && minute < 60.0 && second < 61.0).then_some(((hour + noon) * 60.0 + minute) * 60.0 + second)
}

/// The hours of a time zone such as `+01:00`, `-0530` or `Z`.
fn zone(text: &str) -> Option<f64> {
    let sign = match text.chars().next() {
        None | Some('Z' | 'z') => return Some(0.0),
        Some('+') => 1.0,
        Some('-') => -1.0,
        _ => return None,
    };
    let digits: String = text[1..].chars().filter(|c| *c != ':').collect();
    let number = |range: std::ops::Range<usize>| digits.get(range)?.parse::<f64>().ok();
    Some(sign * (number(0..2)? + number(2..4).unwrap_or(0.0) / 60.0))
}

fn in_a_date(c: char) -> bool {
    c.is_ascii_digit() || "-/. Tt".contains(c)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_time_of_day_is_read_with_or_without_its_date() {
        for (cell, expected) in [
            ("14:07:09.0005", Some(50829.0005)),
            ("2024-03-05T14:07:09.0005+01:00", Some(47229.0005)),
            ("2024-03-05T14:07:09.0005-0130", Some(56229.0005)),
            ("2024-03-05 14:07:09", Some(50829.0)),
            ("07:09.5", Some(429.5)),
            ("05.03.2024 14:07:09,5", Some(50829.5)),
            ("3/5/2024 2:07:09 PM", Some(50829.0)),
            ("2:07:09 am", Some(7629.0)),
            ("12:07:09 pm", Some(43629.0)),
            ("12:00:01 AM", Some(1.0)),
            ("14:07:09+0530", Some(31029.0)),
            ("0:00:01Z", Some(1.0)),
            ("14:07", Some(50820.0)),
            ("11/30/2023 14:07:09:500", Some(50829.5)),
            ("1 days 00:00:01.5", Some(86401.5)),
            ("0 days 00:00:01", Some(1.0)),
            ("0.5 sec", Some(0.5)),
            ("20 ms", Some(0.02)),
            ("20 V", None),
            ("days:", None),
            ("25:00:00", None),
            ("1:2:3", None),
            ("run 12:30:01", None),
            ("x12:30", None),
            ("12:30 V", None),
            (":", None),
            ("\u{b5}:00", None),
        ] {
            assert_eq!(read(cell), expected, "{cell}");
        }
    }
}
