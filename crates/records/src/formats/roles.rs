//! Which column is the time, the input and the output.
//!
//! ```text
//! the user says so                  --input-col "CH1"
//! names of piezoid's own files      t_s, u_V, u_*, y_*
//! the unit                          s; V; um, urad, ...
//! words of the name                 Zeit, Drive voltage, Position sensor, ...
//! ```
//! An earlier line of this list counts more. Two columns that are equally likely are an error, which names the options
//! that choose between them; a guess is written into the record's history.
//!
//! Why: docs/decisions/data-and-records.md, "Columns are guessed, and the guess is reported".

use super::column::Column;
use super::quote::{listed, quoted, shortened};
use super::selection::ColumnSelection;
use super::table::Table;
use super::units::Quantity;
use super::words::{INPUT, OTHER, OUTPUT, REQUESTED, TIME};
use piezoid_numerics::error::Error;
use serde_json::Value;

/// Number of rows from which on the course of a column shows what it may be.
const ROWS: usize = 10;

/// The role of a column.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Role {
    Time,
    Input,
    Output,
    /// A requested output.
    Reference,
}

impl Role {
    /// Its name, the option that chooses its column, and the prefix of names.
    fn texts(self) -> [&'static str; 3] {
        match self {
            Role::Time => ["time", "time_col", "t_"],
            Role::Input => ["input", "input_col", "u_"],
            Role::Output => ["output", "output_col", "y_"],
            Role::Reference => ["reference", "output_col", "r_"],
        }
    }

    pub(super) fn what(self) -> &'static str {
        self.texts()[0]
    }

    /// The option that chooses the column.
    fn option(self) -> &'static str {
        self.texts()[1]
    }

    /// What the user says about it.
    pub(super) fn requested(self, selection: &ColumnSelection) -> Option<&String> {
        match self {
            Role::Time => selection.time_col.as_ref(),
            Role::Input => selection.input_col.as_ref(),
            Role::Output | Role::Reference => selection.output_col.as_ref(),
        }
    }

    /// True if the name is one of piezoid's own files. A name such as `u_out [V]` is none: its unit stands apart.
    pub(super) fn owns(self, column: &Column) -> bool {
        match self {
            Role::Time => column.name == "t_s",
            Role::Output if column.has_word(REQUESTED) => false,
            _ => column.name.starts_with(self.prefix()) && !column.has_unit_apart(),
        }
    }

    /// The prefix of its names in piezoid's own files.
    pub(super) fn prefix(self) -> &'static str {
        self.texts()[2]
    }

    /// The names that are expected, for messages.
    fn expected(self) -> String {
        match self {
            Role::Time => "`t_s`".into(),
            Role::Input => "`u_V` or exactly one `u_*`".into(),
            Role::Output | Role::Reference => format!("exactly one `{}*`", self.prefix()),
        }
    }

    /// The candidates of the most certain kind; more than one is an ambiguity.
    fn candidates<'a>(self, free: &[&'a Column]) -> Vec<&'a Column> {
        let those = |test: &dyn Fn(&Column) -> bool| -> Vec<&'a Column> {
            free.iter().copied().filter(|column| test(column)).collect()
        };
        let certain =
            [those(&|column| self == Role::Input && column.name == "u_V"), those(&|column| self.owns(column))];
        let is = |column: &Column, words: &str| column.has_word(words);
        let kinds: Vec<Vec<&Column>> = match self {
            Role::Time => vec![
                those(&|c| matches!(c.quantity(), Some(Quantity::Time(_))) && is(c, TIME)),
                those(&|c| c.quantity().is_none() && is(c, TIME) && !is(c, OTHER)),
                those(&|c| matches!(c.quantity(), Some(Quantity::Time(_)))),
                those(&|c| c.name.is_empty() && c.is_uniform_time()),
            ],
            Role::Input => {
                let voltage = those(&|c| c.quantity() == Some(Quantity::Voltage) && !is(c, OUTPUT) && !is(c, OTHER));
                vec![
                    preferred(voltage, INPUT),
                    those(&|c| c.quantity().is_none() && is(c, INPUT) && !is(c, OUTPUT) && !is(c, OTHER)),
                ]
            }
            Role::Output => {
                let length =
                    those(&|c| c.quantity() == Some(Quantity::Displacement) && !is(c, REQUESTED) && !is(c, OTHER));
                let unclear = |c: &Column| matches!(c.quantity(), None | Some(Quantity::Voltage)) || c.is_raw();
                // A length beside a sensor that counts is perhaps a setting.
                let counts = those(&|c| c.is_raw() && is(c, OUTPUT) && !is(c, REQUESTED) && !is(c, OTHER));
                let named = length.iter().any(|c| is(c, OUTPUT));
                vec![
                    if named || length.is_empty() { preferred(length, OUTPUT) } else { [length, counts].concat() },
                    those(&|c| unclear(c) && is(c, OUTPUT) && !is(c, INPUT) && !is(c, REQUESTED) && !is(c, OTHER)),
                ]
            }
            Role::Reference => vec![
                those(&|c| c.quantity() == Some(Quantity::Displacement) && is(c, REQUESTED)),
                Role::Output.candidates(free),
            ],
        };
        certain.into_iter().chain(kinds).find(|kind| !kind.is_empty()).unwrap_or_default()
    }

    /// True if it makes no difference which of two columns is taken.
    fn is_same(self, a: &Column, b: &Column) -> bool {
        let linked = a.name != b.name && a.leaf() == b.leaf() && a.stated() == b.stated() && a.has_numbers();
        // A gap is no number, which equals nothing.
        let equal = |(a, b): (&f64, &f64)| a == b || a.is_nan() && b.is_nan();
        a.samples.len() == b.samples.len()
            && a.samples.iter().zip(&b.samples).all(equal)
            && (self == Role::Time || linked)
    }

    /// The column of the table with this role.
    pub(super) fn find<'a>(self, table: &'a Table, selection: &ColumnSelection) -> Result<&'a Column, Missing<'a>> {
        if let Some(name) = self.requested(selection) {
            return table.named(name).map_err(Missing::Wrong);
        }
        let chosen = |role: &Role| table.named(role.requested(selection)?).ok();
        let requested: Vec<&Column> = [Role::Time, Role::Input, Role::Output].iter().filter_map(chosen).collect();
        let mut free: Vec<&Column> =
            table.columns.iter().filter(|c| !requested.iter().any(|other| std::ptr::eq(*other, *c))).collect();
        if self != Role::Time && self != Role::Reference {
            let time = Role::Time.candidates(&free);
            free.retain(|c| !time.iter().any(|other| std::ptr::eq(*other, *c)));
        }
        if self == Role::Time && table.ts.is_some() {
            free.retain(|column| !column.samples.is_empty());
        }
        let mut candidates = self.candidates(&free);
        // A clock beside the time since the start says less.
        if candidates.iter().any(|column| column.clock.is_none()) {
            candidates.retain(|column| column.clock.is_none());
        }
        // The same channel of another run is as likely, whatever its length.
        let twin =
            |column: &Column| table.others.iter().find(|other| self != Role::Time && other.leaf() == column.leaf());
        match candidates[..] {
            [column] => match twin(column) {
                Some(twin) => Err(Missing::Several(self, vec![column, twin])),
                None => Ok(column),
            },
            [] => Err(Missing::None(self, free)),
            // Some programs write the same time before every channel, or link to a channel from several groups.
            [column, ref others @ ..] if others.iter().all(|c| self.is_same(c, column)) => Ok(column),
            ref several => Err(Missing::Several(self, several.to_vec())),
        }
    }
}

/// Those with these words, if there are any; else all.
fn preferred<'a>(columns: Vec<&'a Column>, words: &str) -> Vec<&'a Column> {
    let with: Vec<&Column> = columns.iter().copied().filter(|column| column.has_word(words)).collect();
    if with.is_empty() { columns } else { with }
}

/// Why no column has a role.
pub(super) enum Missing<'a> {
    /// The user asked for what is not there.
    Wrong(Error),
    /// No column is likely; these are free.
    None(Role, Vec<&'a Column>),
    /// These are equally likely.
    Several(Role, Vec<&'a Column>),
}

impl Missing<'_> {
    /// One error about all that is missing, with the options that say it.
    pub(super) fn error(mut all: Vec<Missing<'_>>, table: &Table, selection: &ColumnSelection) -> Error {
        if let Some(at) = all.iter().position(|missing| matches!(missing, Missing::Wrong(_)))
            && let Missing::Wrong(error) = all.swap_remove(at)
        {
            return error;
        }
        // What has a role is not proposed for another.
        let roles = [Role::Time, Role::Input, Role::Output];
        let has_role: Vec<&Column> = roles.iter().filter_map(|role| role.find(table, selection).ok()).collect();
        let likely = |column: &Column| {
            let free = !has_role.iter().any(|other| std::ptr::eq(*other, column));
            free && !column.has_word(TIME) && !column.has_word(OTHER) && column.is_signal()
        };
        let time = table.columns.iter().find(|column| column.is_uniform_time()).map(|column| table.title(column));
        match &all[..] {
            // A name that stands twice cannot be chosen by name.
            [Missing::Several(role, several)] if several.windows(2).all(|pair| pair[0].name == pair[1].name) => {
                match table.named(&several[0].name) {
                    Err(error) => error.advised(vec![(role.option(), table.number(several[0]).into())]),
                    Ok(_) => table.about_names("a name stands twice", ""),
                }
            }
            [Missing::Several(role, several)] => {
                let names = listed(several.iter().map(|column| &*column.name));
                let problem = format!("{names} could each be the {}; choose one: ", role.what());
                let first = several.iter().find(|column| *role == Role::Time || likely(column));
                let name = first.map_or(Value::Null, |c| c.name.clone().into());
                Error::line(table.header, problem).advised(vec![(role.option(), name)])
            }
            [Missing::None(Role::Time, _)] => {
                let wrong = format!("there is no time column: expected {}", Role::Time.expected());
                let unknown = vec![("ts", Value::Null), ("fs", Value::Null), ("time_col", Value::Null)];
                let options = time.map_or(unknown, |time| vec![("time_col", time.into())]);
                table.about_names(&wrong, "; ").advised(options)
            }
            [Missing::None(role, free)] => {
                let wrong = format!("there is no {} column: expected {}", role.what(), role.expected());
                // The other of two roles takes one of them.
                let taken = |column: &&&Column| {
                    let other = if *role == Role::Input { Role::Output } else { Role::Input };
                    other.candidates(free).iter().any(|taken| std::ptr::eq(*taken, **column))
                };
                let mut likely = free.iter().filter(|column| likely(column) && !taken(column));
                let name = likely.next().map_or(Value::Null, |column| table.title(column).into());
                table.about_names(&wrong, "; ").advised(vec![(role.option(), name)])
            }
            several => {
                let expected = several.iter().filter_map(|missing| match missing {
                    Missing::None(role, _) | Missing::Several(role, _) => Some(*role),
                    Missing::Wrong(_) => None,
                });
                let roles: Vec<Role> = expected.collect();
                let whats: Vec<&str> = roles.iter().map(|role| role.what()).collect();
                let problem = format!("it cannot be decided which column is the {}", whats.join(", and which the "));
                // The example takes the columns in their order, which the user corrects.
                let likely: Vec<String> = table.columns.iter().filter(|c| likely(c)).map(|c| table.title(c)).collect();
                let expected = roles.iter().filter(|role| **role != Role::Time).count();
                let mut names = if likely.len() < expected { [].iter() } else { likely.iter() };
                let mut option = |role: &Role| match (role, &time) {
                    (Role::Time, Some(time)) => (role.option(), time.clone().into()),
                    (Role::Time, None) => ("ts", Value::Null),
                    _ => (role.option(), names.next().map_or(Value::Null, |name| name.clone().into())),
                };
                let options = roles.iter().map(&mut option).collect();
                let remedy = if likely.len() >= expected && expected > 1 { "; if this is their order, " } else { "; " };
                let error = match &likely[..] {
                    [one, other] if expected == 2 => {
                        let either = format!("{} and {} could be either{remedy}", quoted(one), quoted(other));
                        if table.header > 0 {
                            Error::line(table.header, format!("{problem}: {either}"))
                        } else {
                            table.about_names(&problem, &format!("; {either}"))
                        }
                    }
                    _ => table.about_names(&problem, remedy),
                };
                error.needing(options)
            }
        }
    }
}

impl Table {
    /// The column of this name, or else of this number, counted from 1.
    pub(in crate::formats) fn named(&self, name: &str) -> Result<&Column, Error> {
        let name = name.trim();
        let all = (1..).zip(self.columns.iter().chain(&self.others));
        let mut named = all.filter(|(_, column)| !name.is_empty() && column.name == name);
        match (named.next(), named.next()) {
            (Some((_, column)), None) => return Ok(column),
            (Some((first, _)), Some((second, _))) => {
                let name = quoted(name);
                let problem = format!("{name} is also the name of column {first}: choose one by its number; ");
                return Err(Error::Line { line: self.header, column: Some(second.to_string()), problem });
            }
            _ => {}
        }
        let number = name.parse::<usize>().ok().and_then(|number| self.columns.get(number.checked_sub(1)?));
        number.ok_or_else(|| {
            let known: Vec<String> = self.columns.iter().take(100).map(|column| self.title(column)).collect();
            Error::unknown("column", name, known.iter().map(String::as_str))
        })
    }

    /// The name of a column, or its number if it has none.
    pub(super) fn title(&self, column: &Column) -> String {
        if column.name.is_empty() { self.number(column) } else { shortened(&column.name) }
    }

    fn number(&self, column: &Column) -> String {
        (1 + self.columns.iter().position(|other| std::ptr::eq(other, column)).unwrap_or(0)).to_string()
    }
}

impl Column {
    /// Its name without those of the groups around it.
    fn leaf(&self) -> &str {
        self.name.rsplit('/').next().unwrap_or(&self.name)
    }

    fn has_numbers(&self) -> bool {
        let numbers = self.samples.iter().filter(|sample| sample.is_finite()).count();
        // Remarks may hold some numbers too.
        self.doubt.is_none() && numbers > 0 && 2 * numbers >= self.samples.len()
    }

    /// True if this may be a voltage or a displacement: it measures nothing else, does not increase evenly as times and
    /// numbers of rows do, and has more than the two levels of a trigger. A few rows tell nothing.
    fn is_signal(&self) -> bool {
        let other = matches!(self.quantity(), Some(Quantity::Time(_) | Quantity::Other)) && !self.is_raw();
        let numbers: Vec<f64> = self.samples.iter().copied().filter(|sample| sample.is_finite()).collect();
        let second = numbers.iter().find(|sample| **sample != numbers[0]);
        let levels = numbers.iter().any(|sample| *sample != numbers[0] && Some(sample) != second);
        self.has_numbers() && !other && (numbers.len() < ROWS || levels && !is_even(&numbers))
    }

    /// True if these are the stamps of a time: they increase evenly, and not by a whole number as numbers of rows do.
    fn is_uniform_time(&self) -> bool {
        let step = self.samples.windows(2).map(|pair| pair[1] - pair[0]).next();
        step.is_some_and(|step| step.fract() != 0.0) && is_even(&self.samples)
    }
}

/// True if these numbers increase evenly.
fn is_even(numbers: &[f64]) -> bool {
    let steps = || numbers.windows(2).map(|pair| pair[1] - pair[0]);
    steps().next().is_some_and(|first| first > 0.0 && steps().all(|step| (step - first).abs() <= 0.01 * first))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The refusal of a file with this head, whose 50 rows `row` writes.
    fn refusal(head: &str, row: impl Fn(f64) -> String) -> String {
        let rows: String = (0..50).map(|k| row(f64::from(k)) + "\n").collect();
        let table = Table::parse(format!("{head}{rows}").as_bytes()).unwrap();
        table.record(&ColumnSelection::default()).unwrap_err().to_string()
    }

    /// A time, a trigger, a voltage and a displacement.
    fn cells(k: f64) -> [String; 4] {
        let trigger = if k % 10.0 < 3.0 { 5.0 } else { 0.0 };
        [
            format!("{:.4}", k * 5e-4),
            format!("{trigger}"),
            format!("{}", (0.3 * k).sin()),
            format!("{}", (0.3 * k).cos()),
        ]
    }

    #[test]
    fn neither_time_nor_row_numbers_nor_triggers_are_proposed() {
        let unnamed = refusal("", |k| [0, 2, 3].map(|c| cells(k)[c].clone()).join(" "));
        assert_eq!(
            unnamed,
            "line 1: it cannot be decided which column is the input, and which the output: the columns have no \
             names, but numbers \
             from 1 to 3; `2` and `3` could be either; if this is their order, give `input_col` = \"2\", `output_col` \
             = \"3\""
        );
        let trigger = refusal("time,CH1,CH2,CH3\n", |k| cells(k).join(","));
        assert!(trigger.contains("`CH2` and `CH3` could be either"), "{trigger}");
        assert!(trigger.ends_with("give `input_col` = \"CH2\", `output_col` = \"CH3\""), "{trigger}");
        let rows = refusal("time,no,CH1,CH2\n", |k| format!("{},{k},{},{}", cells(k)[0], cells(k)[2], cells(k)[3]));
        assert!(rows.ends_with("give `input_col` = \"CH1\", `output_col` = \"CH2\""), "{rows}");
        let rigol = refusal("X,CH1,CH2,Start,Increment,\nSequence,VOLT,VOLT,-5e-1,1e-4\n", |k| {
            format!("{k},{},{},,", cells(k)[2], cells(k)[3])
        });
        assert!(rigol.contains("`CH1` and `CH2` could be either"), "{rigol}");
        let volts = refusal("t_s,A (V),B (V),y_um\n", |k| cells(k).join(","));
        assert!(volts.ends_with("choose one: give `input_col` = \"B (V)\""), "{volts}");
    }

    #[test]
    fn fewer_signals_than_roles_are_not_proposed() {
        let one = refusal("", |k| [0, 2].map(|c| cells(k)[c].clone()).join(" "));
        assert!(one.ends_with("numbers from 1 to 2; give `input_col`, `output_col`"), "{one}");
        let other = refusal("arr_0,piezo_hv,capsens\n", |k| [0, 2, 3].map(|c| cells(k)[c].clone()).join(","));
        assert!(other.ends_with("give `output_col` = \"capsens\", `time_col` = \"arr_0\""), "{other}");
    }

    fn column(name: &str, unit: &str, samples: &[f64]) -> Column {
        let unit = Some(unit.to_string()).filter(|unit| !unit.is_empty());
        Column { unit, samples: samples.to_vec(), ..Column::new(name.into()) }
    }

    #[test]
    fn a_channel_is_the_same_in_another_group_if_all_of_it_is() {
        let gap = f64::NAN;
        let one = column("a/drive", "V", &[1.0, 2.0, gap]);
        for (other, expected) in [
            (column("b/drive", "V", &[1.0, 2.0, gap]), true),
            (column("a/drive", "V", &[1.0, 2.0, gap]), false),
            (column("b/gate", "V", &[1.0, 2.0, gap]), false),
            (column("b/drive", "mV", &[1.0, 2.0, gap]), false),
            (column("b/drive", "V", &[1.0, 3.0, gap]), false),
            (column("b/drive", "V", &[1.0, 2.0, 3.0]), false),
            (column("b/drive", "V", &[1.0, 2.0]), false),
        ] {
            assert_eq!(Role::Input.is_same(&other, &one), expected, "{other:?}");
            // Times are the same by their numbers.
            let of_time = Role::Time.is_same(&other, &one);
            assert_eq!(of_time, format!("{:?}", other.samples) == format!("{:?}", one.samples), "{other:?}");
        }
        let empty = ["a/drive", "b/drive"].map(|name| column(name, "V", &[gap; 3]));
        assert!(!Role::Input.is_same(&empty[0], &empty[1]), "no numbers");
    }

    #[test]
    fn a_signal_has_numbers_of_several_levels_that_do_not_count_up() {
        let gap = f64::NAN;
        let numbers = [&[1.0, gap][..], &[1.0, 2.0, 3.0, gap, gap], &[1.0, gap, gap], &[gap], &[]];
        let has = numbers.map(|samples| column("", "", samples).has_numbers());
        assert_eq!(has, [true, true, false, false, false]);
        let signal = |unit: &str, n: u32, sample: fn(f64) -> f64| {
            column("", unit, &(0..n).map(|k| sample(f64::from(k))).collect::<Vec<_>>()).is_signal()
        };
        assert_eq!([9, 10].map(|n| signal("", n, |k| k)), [true, false], "a few rows tell nothing");
        assert!(!signal("", 10, |k| k % 2.0) && signal("", 10, |k| k % 3.0));
        let units = ["V", "um", "counts", "A", "s"].map(|unit| signal(unit, 9, |k| k));
        assert_eq!(units, [true, true, true, false, false]);
    }

    #[test]
    fn times_increase_evenly_and_not_by_whole_numbers() {
        for (samples, even, time) in [
            (&[0.5, 1.0, 1.5][..], true, true),
            (&[0.25, 1.25, 2.25], true, false),
            (&[0.0, 100.0, 201.0], true, false),
            (&[0.0, 100.0, 202.0], false, false),
            (&[0.0, 0.5, 2.0], false, false),
            (&[1.5, 1.0, 0.5], false, false),
            (&[1.0, 1.0, 1.0], false, false),
            (&[0.5], false, false),
        ] {
            assert_eq!((is_even(samples), column("", "", samples).is_uniform_time()), (even, time), "{samples:?}");
        }
    }

    #[test]
    fn a_name_of_another_meaning_does_not_stand_in_the_way() {
        let y = |head: &str, row: &str| {
            let table = Table::parse(format!("{head}\n0,{row}\n0.01,{row}\n0.02,{row}\n").as_bytes()).unwrap();
            table.record(&ColumnSelection::default()).map(|record| record.y()[0]).map_err(|error| error.to_string())
        };
        assert_eq!(y("t_s,u_V,y_um,y_ref_um", "1,2,3"), Ok(2.0));
        assert_eq!(y("time_of_drive,drive,sensor", "1,2"), Ok(2.0));
        assert_eq!(y("t_s,u_V,Sensor [counts]", "1,2"), Ok(2.0));
        assert_eq!(
            y("t_s,u_V,Offset (um),Gain [counts],Sensor [counts]", "1,2,3,4").unwrap_err(),
            "line 1: `Offset (um)`, `Sensor [counts]` could each be the output; choose one: give `output_col` = \
             \"Offset (um)\""
        );
        let times = y("t (s),Zeit (s),u_V,y_um", "1,2,3").unwrap_err();
        assert!(times.ends_with("could each be the time; choose one: give `time_col` = \"t (s)\""), "{times}");
    }

    #[test]
    fn a_time_in_words_is_used_only_if_nothing_else_states_the_period() {
        let read = |head: &str| {
            let table = Table::parse(format!("{head}Time,u_V,y_um\nnoon,1,2\nnoon,2,3\n").as_bytes()).unwrap();
            table.record(&ColumnSelection::default()).map(|record| record.ts()).map_err(|error| error.to_string())
        };
        assert_eq!(read("# dt: 0.01 s\n"), Ok(0.01));
        assert_eq!(read(""), Err("line 2, column Time: `noon` is not a number".into()));
    }

    #[test]
    fn what_is_proposed_is_neither_taken_nor_likely_for_another_role() {
        let parsed = |text: &str| Table::parse(text.as_bytes()).unwrap();
        let any = ColumnSelection::default();
        let both = parsed("foo,bar\n0,1\n3,7\n4,2\n").record(&any).unwrap_err().to_string();
        assert_eq!(
            both,
            "line 1: it cannot be decided which column is the input, and which the output, and which the time: `foo` \
             and `bar` could be either; if this is their order, give `input_col` = \"foo\", `output_col` = \"bar\", \
             `ts`"
        );
        let output = parsed("arr_0,piezo_hv,foo\n0,1,4\n3,7,4\n4,2,5\n").record(&any).unwrap_err().to_string();
        assert!(output.contains("the output, and which the time among the columns `arr_0`"), "{output}");
        assert!(!output.contains("if this is their order"), "{output}");
        let sensors = parsed("t_s,Sensor 1 (um),Sensor 2 (um),piezo\n0,1,4,2\n1,7,4,1\n2,2,5,1\n");
        let input = sensors.input(&any).unwrap_err().to_string();
        assert!(input.ends_with("give `input_col` = \"piezo\""), "{input}");
    }
}
