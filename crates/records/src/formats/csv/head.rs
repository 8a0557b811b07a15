//! What stands above the rows: names, units and the sampling period, in the layouts of spreadsheets, oscilloscopes and
//! loggers.
//!
//! ```text
//! names     the line above the rows, or above a line of units; `Label,CH1,CH2`, `name;u;y`, `NAME0 = u`; the line
//!           below `channel names:`
//! units     a line of units only, `s,V,um` or `[ms];[V]`; or a line `Vertical Units,V,V`
//! period    `Sample Interval,5e-4`, `# sample rate: 2 kHz`, `tInc = 5e-4`, or `dt:` with the number on the next line
//! ```
//! All other lines are remarks.

use super::cells::{SPACES, cells};
use super::dialect::Dialect;
use super::{REMARKS, number};
use crate::formats::time::agreed;
use crate::formats::units;

/// Lines that set off a head from its rows and hold nothing: `data:`, `***End_of_Header***`.
const MARKERS: usize = 1;
/// First cells of a line of names, as letters.
const NAMES: &str = "\
    name names signal signals tracename channelname channelnames label labels source";
/// First cells of a line of units, as letters.
const UNITS: &str = "\
    unit units vunit vertunits verticalunits yunitlabel yunit yunits channelunits";
/// Names of a sampling period, as letters.
const PERIODS: &str = "\
    sampleinterval samplinginterval sampletime samplingtime samplingperiod sampleperiod timestep timeincrement dt \
    deltat deltax hresolution interval increment tinc xincrement ts wfincrement timeinterval tinterval \
    abtastintervall abtastzeit";
/// Names of a sampling rate, as letters.
const RATES: &str = "\
    samplerate samplingrate samplefrequency samplingfrequency acquisitionrate datarate fs samplespersecond scanrate \
    rate abtastrate abtastfrequenz messrate messfrequenz";

/// The head of a file.
#[derive(Debug, Default, PartialEq)]
pub(super) struct Head {
    /// Line of the names; that of the first row if there are none.
    pub(super) line: u64,
    /// One per column; empty if a column has no name.
    pub(super) names: Vec<String>,
    /// Units that stand apart from the names; empty if a column has none.
    pub(super) units: Vec<String>,
    /// The sampling period [s] that the head states.
    pub(super) ts: Option<f64>,
    /// Number of rows that the head states, as PI's controllers do: fewer are a file that was cut.
    pub(super) rows: Option<usize>,
}

impl Head {
    /// The head in the lines above the rows. Rows that are `numbered` may have one cell more than there are names.
    pub(super) fn read(lines: &[(u64, &str)], dialect: &Dialect, numbered: bool) -> Head {
        let mut head = Head::default();
        let width = dialect.width();
        let mut above = true;
        for (at, &(number, line)) in lines.iter().enumerate().rev() {
            let text = uncommented(line);
            if text.split_once('=').is_some_and(|(key, value)| head.assigned(key.trim(), value.trim(), number)) {
                above = false;
                continue;
            }
            let cells = fitting(text, dialect);
            let filled = cells.iter().filter(|cell| !cell.is_empty()).count();
            if filled == 0 {
                continue;
            }
            let below = at > 0 && is_one_of(NAMES, uncommented(lines[at - 1].1));
            if cells.len() > 1 && is_one_of(UNITS, &cells[0]) {
                head.units = or_else(head.units, values(&cells, width));
            } else if cells.len() > 1
                && is_one_of(NAMES, &cells[0])
                && values(&cells, width).iter().any(|v| !v.is_empty())
            {
                // A label says more than the name of a socket, `CH1`.
                head.names = or_else(values(&cells, width), head.names);
                head.line = if head.line == 0 { number } else { head.line };
                above = false;
            } else if below && cells.len() == width {
                (head.line, head.names) = (number, or_else(cells, head.names));
                above = false;
            } else if above && filled > MARKERS.min(width - 1) && !text.contains('=') {
                // Twice as many cells as names: decimal commas between commas, which is an error of the rows.
                let halved = dialect.separator == ',' && 2 * cells.len() == width;
                let fits = cells.len() >= width || numbered && cells.len() + 1 == width || halved;
                // Keysight's scopes name channels by numbers: `x-axis,1,2` above `second,Volt,Volt`.
                let numbers = !head.units.is_empty() && are_channels(&cells[..width.min(cells.len())]);
                let words =
                    numbers || cells.iter().take(width).all(|cell| cell.is_empty() || !number::looks_numeric(cell));
                // The last columns may have no unit.
                let short = filled > 1 && cells.len() < width;
                if (fits || short) && head.units.is_empty() && are_units(&cells[..width.min(cells.len())]) {
                    // Words between the units and the rows are remarks on the columns.
                    head.names = Vec::new();
                    head.units = cells.iter().map(|cell| unbracketed(cell).into()).collect();
                } else if head.names.is_empty() && fits && words {
                    (head.line, head.names) = (number, cells);
                    above = head.units.is_empty();
                } else {
                    above = false;
                }
            }
        }
        let texts: Vec<&str> = lines.iter().map(|(_, line)| uncommented(line)).collect();
        head.ts = period(&texts, dialect).or_else(|| head.increment());
        // Rigol's scopes state `Start,Increment` beside the channels, with numbers in place of units and rows.
        while head.names.len() > width
            && head.units.get(head.names.len() - 1).is_some_and(|u| number::read(u).is_some())
        {
            head.names.pop();
        }
        head.units.truncate(head.names.len().max(width));
        // Above the numbers of rows nothing stands, not even a separator.
        if head.names.len() + 1 == width {
            head.names.insert(0, String::new());
        }
        head
    }

    /// Takes a value as PI's controllers write it: `NAME0 = Voltage`, `NDATA = 1024`.
    fn assigned(&mut self, key: &str, value: &str, line: u64) -> bool {
        if key == "NDATA" {
            self.rows = value.parse().ok();
        }
        let number = key.strip_prefix("NAME").and_then(|number| number.parse::<usize>().ok());
        let Some(at) = number.filter(|at| *at < super::MAX_COLUMNS) else { return key == "NDATA" };
        self.names.resize(self.names.len().max(at + 1), String::new());
        self.names[at] = value.into();
        self.line = line;
        true
    }

    /// The period that stands in place of a unit, below a name such as `Increment`.
    fn increment(&self) -> Option<f64> {
        let at = self.names.iter().position(|name| is_one_of(PERIODS, name))?;
        quantity(self.units.get(at)?, "", false)
    }
}

/// The first of two lists that is not empty, with what it lacks from the second.
fn or_else(first: Vec<String>, second: Vec<String>) -> Vec<String> {
    let len = first.len().max(second.len());
    let at = |list: &[String], k: usize| list.get(k).filter(|text| !text.is_empty()).cloned();
    (0..len).map(|k| at(&first, k).or_else(|| at(&second, k)).unwrap_or_default()).collect()
}

/// The text of a line without the sign of a comment.
fn uncommented(line: &str) -> &str {
    let line = line.trim_end_matches(['\r', '\n']);
    let text = line.trim_start();
    let text = REMARKS.iter().find_map(|sign| text.strip_prefix(sign)).unwrap_or(line);
    text.trim_start_matches(['#', '%'])
}

/// The cells of a line of the head, without empty ones at the end. A line whose cells do not fit the rows may have
/// another separator.
fn fitting(text: &str, dialect: &Dialect) -> Vec<String> {
    let own = split(text, dialect.separator);
    let others = || [',', ';', '\t', SPACES].into_iter().map(|separator| split(text, separator));
    if own.len() >= dialect.width() {
        return own;
    }
    others().find(|cells| cells.len() == dialect.width()).unwrap_or(own)
}

fn split(text: &str, separator: char) -> Vec<String> {
    let mut found: Vec<String> = if separator == SPACES {
        words(text)
    } else {
        cells(text, separator).map(|cell| cell.unwrap_or_default().replace("\"\"", "\"")).collect()
    };
    let len = found.iter().rposition(|cell| !cell.is_empty()).map_or(0, |last| last + 1);
    found.truncate(len);
    found
}

/// Names between spaces: two or more set names apart if there are any; else a bracket belongs to the name before it.
fn words(text: &str) -> Vec<String> {
    let text = text.trim();
    if text.contains("  ") || text.contains('\t') {
        let parts = text.split("  ").flat_map(|part| part.split('\t')).map(str::trim);
        return parts.filter(|part| !part.is_empty()).map(String::from).collect();
    }
    let mut words: Vec<String> = Vec::new();
    for word in text.split(' ') {
        match words.last_mut() {
            Some(last) if word.starts_with(['[', '(']) && !last.ends_with([']', ')']) => {
                last.push(' ');
                last.push_str(word);
            }
            _ => words.push(word.into()),
        }
    }
    words
}

/// The values of a line after its key, one per column: the key stands in place of the time, or before all columns.
fn values(cells: &[String], width: usize) -> Vec<String> {
    let value = |cell: &String| cell.rsplit_once(':').map_or(cell.as_str(), |(_, value)| value).trim().to_string();
    let rest = cells[1..].iter().map(value);
    if cells.len() == width { std::iter::once(String::new()).chain(rest).collect() } else { rest.collect() }
}

/// True if these cells are units: at least one is known, and the others are empty, known or in brackets.
fn are_units(cells: &[String]) -> bool {
    let known = |cell: &String| units::known(unbracketed(cell)).is_some();
    let unit = |cell: &String| cell.is_empty() || known(cell) || unbracketed(cell) != cell.as_str();
    cells.iter().any(known) && cells.iter().all(unit)
}

/// True if these cells are the word of the time and the numbers of channels.
fn are_channels(cells: &[String]) -> bool {
    let numbered = |cell: &String| cell.parse::<u16>().is_ok_and(|number| number > 0);
    matches!(cells, [time, rest @ ..] if !time.is_empty() && !number::looks_numeric(time) && rest.iter().all(numbered))
}

/// The sampling period [s] that a number of this name states, such as `fs`, `Ts` or `sampling_rate_kHz`.
pub(in crate::formats) fn stated_period(name: &str, value: f64) -> Option<f64> {
    let (name, unit) = units::split(name);
    quantity(&value.to_string(), unit.unwrap_or_default(), is_rate(name)?)
}

/// A unit without the brackets around it.
fn unbracketed(cell: &str) -> &str {
    let cell = cell.trim();
    let inner = |open, close| cell.strip_prefix(open).and_then(|rest: &str| rest.strip_suffix(close));
    inner('[', ']').or_else(|| inner('(', ')')).unwrap_or(cell).trim()
}

/// True if a name is that of a sampling rate, false if it is that of a sampling period; `None` for another.
fn is_rate(name: &str) -> Option<bool> {
    let rate = is_one_of(RATES, name);
    (rate || is_one_of(PERIODS, name)).then_some(rate)
}

/// True if the letters of a text are one of these words.
fn is_one_of(words: &str, text: &str) -> bool {
    let letters: String = text.chars().filter(|c| c.is_alphabetic()).flat_map(char::to_lowercase).collect();
    words.split_whitespace().any(|word| word == letters)
}

/// The sampling period [s] that the lines state; `None` if they contradict each other.
fn period(lines: &[&str], dialect: &Dialect) -> Option<f64> {
    // Between spaces, a line such as `rate: 2 kHz` is one cell.
    let separator = if dialect.separator == SPACES { '\t' } else { dialect.separator };
    let mut found = Vec::new();
    for (k, line) in lines.iter().enumerate() {
        let cells: Vec<&str> = cells(line, separator).map(Result::unwrap_or_default).collect();
        for (at, cell) in cells.iter().enumerate() {
            let (key, value) = cell.split_once([':', '=']).unwrap_or((cell, ""));
            let (key, unit) = units::split(key);
            let Some(rate) = is_rate(key) else { continue };
            let next = |k: usize| cells.get(k).copied().unwrap_or_default();
            let below = || lines.get(k + 1).and_then(|line| self::cells(line, separator).next()?.ok());
            let value = Some(value.trim()).filter(|value| !value.is_empty()).unwrap_or_else(|| next(at + 1));
            let value = if value.is_empty() { below().unwrap_or_default() } else { value };
            // 2.000 is 2 or 2000 among decimal commas.
            if dialect.commas && value.split_once('.').is_some_and(|(_, rest)| in_three(rest) && !value.contains(',')) {
                continue;
            }
            found.extend(quantity(value, unit.unwrap_or_else(|| next(at + 2)), rate));
        }
    }
    agreed(found)
}

/// True if a text begins with three digits and not four.
fn in_three(text: &str) -> bool {
    text.find(|c: char| !c.is_ascii_digit()).unwrap_or(text.len()) == 3
}

/// The factor of a unit of a rate or a period; `None` if it is none.
fn factor(unit: &str, rate: bool) -> Option<f64> {
    if rate {
        return Some(match unit.to_lowercase().as_str() {
            "hz" | "s/s" | "sa/s" | "sps" | "samples/s" | "1/s" | "hertz" => 1.0,
            "khz" | "ks/s" | "ksa/s" | "ksps" => 1e3,
            // Not mHz.
            "mhz" | "ms/s" | "msa/s" if unit.starts_with('M') => 1e6,
            _ => return None,
        });
    }
    units::seconds(unit)
}

/// The period [s] in a text such as `2 kHz`, `0.5 ms` or `Analog:5e-4`; the unit may stand in the next cell.
fn quantity(text: &str, next: &str, rate: bool) -> Option<f64> {
    // A time of day is no period.
    if text.matches(':').count() > 1 {
        return None;
    }
    let text = text.rsplit_once(':').map_or(text, |(_, value)| value).trim();
    let end = text.find(|c: char| !(c.is_ascii_digit() || "+-.,eE".contains(c))).unwrap_or(text.len());
    let digits = text[..end].trim_end_matches([',', 'e', 'E']);
    // 2,000 is 2 or 2000.
    if digits.split_once(',').is_some_and(|(whole, rest)| rest.len() == 3 && !rest.contains('.') && whole != "0") {
        return None;
    }
    let (value, _) = number::read(digits)?;
    let own = text[end..].trim().split([' ', ',']).next().unwrap_or_default();
    // The next cell may hold the unit, or something else.
    let prefix = next.len() == 1 && next.chars().all(char::is_alphabetic);
    let next = if own.is_empty() { factor(next, rate).or((!prefix).then_some(1.0)) } else { None };
    let factor = next.or_else(|| factor(own, rate))?;
    let period = if rate { 1.0 / (value * factor) } else { value * factor };
    Some(period).filter(|period| period.is_finite() && *period > 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::formats::csv::encoding::lines;

    fn head(text: &str) -> Head {
        let dialect = Dialect::of(text).unwrap();
        Head::read(&super::super::rows::above(&mut lines(text).peekable(), &dialect), &dialect, text.contains("\"1\","))
    }

    fn names(text: &str) -> Vec<String> {
        head(text).names
    }

    const ROWS: &str = "0.0,20,1.5\n0.5,21,1.6\n1.0,22,1.7\n";

    #[test]
    fn names_stand_above_the_rows_or_above_their_units() {
        for above in [
            "t,u,y\n",
            "# t,u,y\n",
            "% rig 7, by night\n# gain 10\n# t u y\n",
            "Timer,Amplifier,Sensor\nt,u,y\ns,V,um\n",
            "Operator: N.N.\nRate: 2000 Hz, by hand\n\nt,u,y\n\n",
            "sep=,\nt,u,y,Comment\n",
            "t,u,y\ndata:\n",
            "t,u,y\ns,V,um\nrun 7,E-663,capacitive\n",
        ] {
            assert_eq!(names(&format!("{above}{ROWS}"))[..3], ["t", "u", "y"], "{above}");
        }
        assert_eq!(names("t [s]  Weg U [V]  y\n0.0 1 2\n0.5 2 3\n1.0 3 4\n"), ["t [s]", "Weg U [V]", "y"]);
        assert_eq!(names("% t [s] U [V] y (um)\n0.0 1 2\n0.5 2 3\n1.0 3 4\n"), ["t [s]", "U [V]", "y (um)"]);
        assert_eq!(names("\"t\",\"u\"\n\"1\",0,1\n\"2\",1,2\n"), ["", "t", "u"], "row numbers without a name");
        assert_eq!(names(ROWS), Vec::<String>::new());
        assert_eq!(names(&format!("Model,MSO\n{ROWS}")), Vec::<String>::new(), "a remark");
    }

    #[test]
    fn channels_of_oscilloscopes_are_called_as_on_the_scope() {
        let keysight = head(&format!("x-axis,1,2\nsecond,Volt,Volt\n{ROWS}"));
        assert_eq!((&keysight.names[..], keysight.line), (&["x-axis", "1", "2"].map(String::from)[..], 1));
        let rigol = head("X,CH1,CH2,Start,Increment,\nSequence,VOLT,VOLT,-5e-1,1e-4\n0,1,2,,\n1,2,4,,\n2,3,9,,\n");
        assert_eq!((&rigol.names[..], rigol.ts), (&["X", "CH1", "CH2"].map(String::from)[..], Some(1e-4)));
    }

    #[test]
    fn names_and_units_may_stand_in_lines_that_say_so() {
        for above in [
            "descr;export\nname;u;y\nunit;V;um\ntrace_values\n".replace(';', ","),
            "\"VERT_UNITS\", \"s\",\"V\", \"um\"\n\"SIGNAL\", \"\",\"u\", \"y\"\n\"DATA\"\n".into(),
            "channel units,V,um\n\nchannel names:\nt,u,y\nstart:\n1,2,3\ndata:\n".into(),
            "# NDATA = 3\n# NAME1 = u\n# NAME2 = y\n# UNITS,V,um\n# END_HEADER\n".into(),
            "Vertical Units,CH1:V,CH2:um\nLabel,u,y\nTIME,CH1,CH2\n".into(),
        ] {
            let head = head(&format!("{above}{ROWS}"));
            assert_eq!(
                (&head.names[1..], &head.units[1..]),
                (&["u", "y"].map(String::from)[..], &["V", "um"].map(String::from)[..]),
                "{above}"
            );
        }
        assert_eq!(head(&format!("Label,,\nTIME,CH1,CH2\n{ROWS}")).names, ["TIME", "CH1", "CH2"]);
        assert_eq!(head(&format!("t,u,y\n[ms],[V],[nm]\n{ROWS}")).units, ["ms", "V", "nm"]);
        let last = head(&format!("t,u,y\ns,V,\n{ROWS}"));
        assert_eq!((last.names, last.units), (["t", "u", "y"].map(String::from).into(), vec!["s".into(), "V".into()]));
    }

    #[test]
    fn the_sampling_period_is_found_wherever_it_stands() {
        for (above, expected) in [
            ("# sampling rate: 2000 Hz\n", 5e-4),
            ("#Sample rate: 100Hz\n", 0.01),
            ("\"SampleRate\", 2,\"kHz\"\n", 5e-4),
            ("% Acquisition rate: 2.0e+03 Hz, Precision mode\n", 5e-4),
            ("Sample Interval,Analog:5.0E-04,\n", 5e-4),
            ("# SAMPLE_TIME = 0.00005\n", 5e-5),
            ("Delta_X,0.0005,0.0005\n", 5e-4),
            ("dt:\n0.0005,0.0005,0.0005\ndata:\n", 5e-4),
            ("u,y,t0 = -5e-2, tInc = 5e-4,\n", 5e-4),
            ("X,CH1,CH2,Start,Increment,\nSequence,Volt,Volt,-3e-3,5e-4\n", 5e-4),
            ("# step: 0.5 ms\n# dt = 0.5 ms\n", 5e-4),
            ("Sample interval (us),250\n", 2.5e-4),
            ("Abtastrate: 2 kHz\n", 5e-4),
        ] {
            let ts = head(&format!("{above}{ROWS}")).ts;
            assert_eq!(ts, Some(expected), "{above}");
        }
        for unclear in ["Scan rate: 1 Hz\nSample rate: 2000 Hz\n", "# ts: 2024-03-05 14:07:09\n", "Sample rate,2,M\n"] {
            assert_eq!(head(&format!("{unclear}t,u,y\n{ROWS}")).ts, None, "{unclear}");
        }
        let commas = |rate: &str| head(&format!("{rate}\nt;u;y\n0;1,5;2\n1;2,5;3\n2;2,7;3\n")).ts;
        assert_eq!((commas("Rate: 2.000 Hz"), commas("Rate: 2.500,0 Hz")), (None, Some(4e-4)), "2 or 2000");
        assert_eq!(quantity("0,005 s", "", false), Some(5e-3));
        assert_eq!(quantity("2,000 Hz", "", true), None, "2 or 2000");
        assert_eq!(head(&format!("# sample rate: high\nt,u,y\n{ROWS}")).ts, None);
    }

    #[test]
    fn what_is_no_line_of_names_or_units_is_a_remark() {
        for (above, expected) in [
            ("t,u,y,Comment\n", &["t", "u", "y", "Comment"][..]),
            ("Channel names,t,u,y\n", &["t", "u", "y"]),
            ("t,u,y\n# gain = 10\n", &["t", "u", "y"]),
            // A unit that is a number is still a unit; units twice are names of units.
            ("t,u,y\n[s],[V],[1]\n", &["t", "u", "y"]),
            ("s,V,um\ns,V,um\n", &["s", "V", "um"]),
            ("s,u,y\n", &["s", "u", "y"]),
            // Above another remark stand no names, and channels have numbers only above their units, from 1.
            ("t,u,y\nModel,MSO\n", &[]),
            ("t,1,2\n", &[]),
            ("1,2,3\ns,V,um\n", &[]),
            ("x-axis,0,1\nsecond,Volt,Volt\n", &[]),
            ("# NAME10000 = x y z\n", &[]),
        ] {
            assert_eq!(names(&format!("{above}{ROWS}")), expected, "{above}");
        }
        assert_eq!(head(&format!("t,u,y\n[s],[V],[1]\n{ROWS}")).units, ["s", "V", "1"]);
        assert_eq!(names("unit\n1\n2\n3\n"), ["unit"]);
        let halves = "t,u,y\n0,0,1,5,2,5\n0,1,1,6,2,6\n0,2,1,7,2,7\n";
        assert_eq!(names(halves), ["t", "u", "y"], "decimal commas between commas");
    }

    #[test]
    fn the_line_of_the_names_is_the_lowest_that_has_some() {
        let line = |above: &str| head(&format!("{above}{ROWS}")).line;
        assert_eq!(line("descr,export\nname,u,y\nunit,V,um\n"), 2);
        assert_eq!(line("Label,u,y\nTIME,CH1,CH2\n"), 2);
    }

    #[test]
    fn a_period_is_positive_and_mega_is_not_milli() {
        for (text, rate, expected) in [
            ("2 MHz", true, Some(5e-7)),
            ("2 mHz", true, None),
            ("2,5 Hz", true, Some(0.4)),
            ("0 Hz", true, None),
            ("0 s", false, None),
            ("-5 ms", false, None),
        ] {
            assert_eq!(quantity(text, "", rate), expected, "{text}");
        }
        let ts = head("Rate: 2.5 Hz\nt;u;y\n0;1,5;2\n1;2,5;3\n2;2,7;3\n").ts;
        assert_eq!(ts, Some(0.4), "one digit after a point among decimal commas");
    }
}
