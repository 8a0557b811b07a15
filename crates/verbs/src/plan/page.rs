//! The page of a plan: what to measure, why, within which limits, and what to run afterwards.

use super::{Plan, PlannedDrive};
use piezoid_numerics::number::{quantity, round};
use piezoid_records::excitation::Peak;

/// Why each record is measured.
const WHY: [(&str, &str); 6] = [
    (
        "small",
        "a multisine of 2 % of the range: two periods, with a fade-in before and a fade-out after them. Loops this \
      small are thin, so it shows the linear dynamics alone: modes, lags and delay.",
    ),
    (
        "rise1",
        "a sine that grows from zero. It contains loops of every amplitude, slow enough to show the hysteresis \
      without dynamics.",
    ),
    (
        "rise2",
        "the same at a third of the bandwidth. With its neighbours it shows whether loops change with frequency, \
      and each of the three can be held out and predicted from the others.",
    ),
    ("rise3", "the same at the bandwidth: hysteresis and dynamics as the application sees them."),
    ("creep", "a step up and a step down, each held: slow creep, which fast records do not separate from hysteresis."),
    (
        "path",
        "a random path up to the bandwidth, of small and large amplitudes. Its signal is of another kind than the \
      training signals, so the error on it is the error to expect in the application.",
    ),
];

impl Plan {
    /// The page in Markdown.
    pub fn page(&self) -> String {
        let rig = &self.rig;
        let mut page = String::from("# Records for the identification of an actuator\n\n");
        let driver = rig.driver.as_ref().map_or(String::new(), |name| format!(", driver `{name}`"));
        let actuator = rig.actuator.map_or(String::new(), |a| format!(", actuator {}", a.description()));
        let ([low, high, hz], ts) = ([rig.low, rig.high, rig.bandwidth].map(round), self.ts);
        page += &format!("Range {low} to {high} V, up to {hz} Hz, sampling period {ts} s{driver}{actuator}.\n\n");
        page += "| drive | record | purpose | duration [s] | voltage [V] | slew [V/s] | current [A] |\n";
        page += "|---|---|---|---|---|---|---|\n";
        for drive in &self.drives {
            page += &self.row(drive);
        }
        page += "\n";
        for (name, reason) in WHY {
            page += &format!("- **{name}**: {reason}\n");
        }
        page += "\nPercentages are shares of the limits; those of voltages are measured from the middle of the allowed \
                 range. Currents are means over a sampling period: where a converter holds each voltage, the jump to the \
                 next one draws more for an instant.\n\n## How to measure\n\n";
        let middle = round(rig.middle());
        let first = match rig.middle() {
            0.0 => "Every drive starts and ends at 0 V.".to_string(),
            _ => format!(
                "Every drive starts and ends at {middle} V, the middle of the range. Bring the driver there slowly, and \
                 back to 0 V only after the last record: a jump exceeds the current limit."
            ),
        };
        let creep = "Play `demagnetisation_u.csv` before each record, which need not be recorded, then wait ten seconds: the \
                     hysteresis is in the middle of its loop then, and creep of the record before has decayed.";
        let mut record = format!(
            "Play each drive sample by sample, every {} s, and record the voltage at the actuator and the displacement \
             at the same instants.",
            self.ts
        );
        let rare = self.drives.iter().filter(|drive| drive.ts > self.ts);
        for PlannedDrive { name, ts, .. } in rare {
            record += &format!(
                " `{name}_u.csv` has {ts} s between its samples; straight lines join them (`piezoid acquire --join`)."
            );
        }
        let small = "Measure in the order of the table: the small signal before any large one.";
        let path = "`path.csv` takes no part in the identification: only then does it test the model.";
        for line in [&*first, creep, &record, small, path] {
            page += &format!("- {line}\n");
        }
        page += &format!("\n## What to run\n\n```text\n{}\n```\n", self.commands().join("\n"));
        if let Some(rehearsal) = &self.rehearsal {
            let header = rehearsal.header().join(" | ");
            page += &format!("\n## Rehearsal\n\n{}\n\n| drive | {header} |\n|---|---|---|---|\n", rehearsal.text());
            for drive in &rehearsal.drives {
                page += &format!("| `{}_u.csv` | {} |\n", drive.name, rehearsal.cells(drive).join(" | "));
            }
        }
        if let Some(advice) = &self.advice {
            page += &format!("\n## What would help most\n\n{advice}\n");
        }
        if !self.notes.is_empty() {
            page += "\n## Notes\n\n";
            for note in &self.notes {
                page += &format!("- {note}.\n");
            }
        }
        page
    }

    /// The commands for the measured records.
    pub fn commands(&self) -> [String; 2] {
        let large = self.drives.iter().filter(|drive| !["small", "path"].contains(&drive.name));
        let large: Vec<String> = large.map(|drive| format!("{}.csv", drive.name)).collect();
        [
            format!("piezoid identify {} --small-signal small.csv -o model.json", large.join(" ")),
            "piezoid validate path.csv --model model.json".into(),
        ]
    }

    fn row(&self, drive: &PlannedDrive) -> String {
        let share = |peak: &Peak| {
            let percent = |share: f64| format!(" ({} %)", round((1e3 * share).round() / 10.0));
            peak.share.map_or(String::new(), percent)
        };
        let value = |peak: &Peak| format!("{}{}", round(peak.value), share(peak));
        let PlannedDrive { name, purpose, usage, .. } = drive;
        let [low, high, slew] = [&usage.lowest, &usage.highest, &usage.slew].map(value);
        let amperes = |peak: &Peak| format!("{}{}", quantity(peak.value, "A"), share(peak));
        let current = usage.current.as_ref().map_or("-".into(), amperes);
        let (file, duration) = (drive.file(), round(self.duration(drive)));
        format!("| `{file}` | `{name}.csv` | {purpose} | {duration} | {low} to {high} | {slew} | {current} |\n")
    }
}
