//! The page that goes with tables: what they are, what each costs, how each is loaded.

use super::super::{File, Wanted};
use super::drive::Drive;
use super::table::{Figures, Table};
use piezoid::hammerstein::Model;
use piezoid::number::{round, short};
use piezoid::series::ends;
use piezoid::system::System;

/// A table with what it costs.
pub(super) struct Shown {
    /// Whose it is.
    whose: &'static str,
    file: String,
    points: usize,
    /// How long a point is held [s].
    point: f64,
    cycles: usize,
    figures: Figures,
}

impl Shown {
    pub(super) fn of(whose: &'static str, file: &File, table: &Table, model: &Model, drive: &Drive) -> Self {
        Shown {
            whose,
            file: file.path.clone(),
            points: table.held.len(),
            point: table.point(),
            cycles: table.cycles,
            figures: table.figures(model, drive),
        }
    }

    /// What a terminal says of it.
    pub(super) fn sentence(&self) -> String {
        let Figures { y, period, .. } = self.figures;
        let off = if period == 0.0 { String::new() } else { format!(", period {} % off", short(100.0 * period)) };
        format!(
            "{}: {} points of {} s{off}; on the model {} % of the stroke off, rms, {} % at most",
            self.file,
            self.points,
            round(self.point),
            short(y.rms),
            short(y.largest)
        )
    }

    fn row(&self) -> String {
        let Figures { period, u, y, .. } = self.figures;
        let cells = [100.0 * period, u.rms, u.largest, y.rms, y.largest].map(short).join(" | ");
        format!("| `{}` | {} | {} | {} | {cells} |\n", self.file, self.whose, self.points, round(1e6 * self.point))
    }
}

pub(super) fn readme(wanted: &Wanted, drive: &Drive, shown: &[Shown]) -> String {
    let (model, name) = (wanted.model, wanted.name);
    let (unit, ts) = (&model.units().y, model.ts());
    let period = drive.u.len() as f64 * ts;
    let ((low, high), (bottom, top)) = (ends(drive.u.iter().copied()), ends(drive.r.iter().copied()));
    let mut out = format!(
        "# {name}\n\n\
         One period of the voltage that makes a piezo actuator follow a path again and again, made by piezoid from a \
         model of it: {} samples of {ts} s, {} s in all ({} Hz), from {} to {} V for {} to {} {unit}. It is for open loop: \
         the compensation is in the voltage.\n\n",
        drive.u.len(),
        round(period),
        short(1.0 / period),
        short(low),
        short(high),
        round(bottom),
        round(top),
    );
    out += "| file | for | points | each held [us] | period off [%] | u off, rms [%] | largest [%] | y off, rms [%] | \
            largest [%] |\n\
            |---|---|--:|--:|--:|--:|--:|--:|--:|\n";
    shown.iter().for_each(|table| out += &table.row());
    out += "\n\
            \"u off\" is the held voltage of the file, as written, beside the drive, which is held for a sample of \
            the model at a time, as a share of the stroke of the voltage: the steps of a coarser table are in it. \
            What matters is \"y off\": the answer of the model to the voltages of the file, beside what is wanted, as \
            a share of the stroke of that. Where points do not last whole samples of the model, it is given their \
            mean over each sample. A period that is off changes the frequency, and is not in the other figures. What \
            the model does not know of the actuator comes on top of all.\n\n";
    out += &format!(
        "The drive is that of the steady state, in which two periods of the answer differ by {} % of the stroke at \
         most. From standing still at its first voltage the model is {} % of the stroke off at most in the first \
         period{}.\n\n",
        short(100.0 * shown.iter().map(|table| table.figures.differs).fold(0.0, f64::max)),
        short(beginning(model, drive)),
        slowest(model),
    );
    out += &format!(
        "## `{name}.csv`\n\n\
         Columns: time, voltage, wanted, and what the model answers. Voltages are rounded to 0.1 mV, displacements to \
         a millionth of the stroke or finer.\n\n"
    );
    let cycle = round(1e6 * wanted.playback.servo_cycle);
    let cycles = shown.get(1).map_or(0, |gcs| gcs.cycles);
    out += &format!(
        "## `{name}_gcs.txt`\n\n\
         Commands of PI's General Command Set 2.0 for axis, wave generator and wave table 1; send each line with a \
         line feed, for example with PITerminal, and ask `ERR?` now and then. They switch the servo off (`SVO 1 0`), \
         define the table by points (`WAV 1 X PNT`, appended with `&`), hold each point for {cycles} servo cycles \
         without interpolation (`WTR 1 {cycles} 0`), repeat without end (`WGC 1 0`), go to the first point (`SVA`) \
         and start (`WGO 1 1`); `WGO 1 0` stops.\n\n\
         - A servo cycle of {cycle} us is taken, that of an E-727 being 50 us. Ask the controller (`SPA? 1 \
         0x0E000200`), and export anew with its own if it has another: the frequency goes with it.\n\
         - Values are volts of the model's input. In which unit the open-loop control value of a controller counts \
         (volts, or micrometres by a factor of its own) is in its manual: set one value with `SVA 1`, and compare \
         with `VOL?` before the first run.\n\
         - `WMS?` tells how many points its tables hold, `GWD?` reads them back. If a line is too long for it, send fewer \
         points a line.\n\n"
    );
    if let Some((low, high)) = wanted.playback.range {
        out += &format!(
            "## `{name}_nv200.txt`\n\n\
             Commands for an NV200 amplifier of piezosystem jena; send each line with a carriage return. They open \
             the loop (`cl,0`), set how long a point lasts (`gtarb`, in 50 us), write the buffer in percent \
             (`gbarb`), repeat it without end (`gsarb`, `gearb`, `goarb`, `gcarb,0`), make the generator the setpoint \
             (`modsrc,3`) and start (`grun,1`); `grun,0` stops.\n\n\
             - 0 % is taken for {low} V and 100 % for {high} V of the model's input. Ask the amplifier for the ends \
             of its range with the actuator plugged in (`avmin`, `avmax`), and export anew if they are others. Its \
             manual does not say that these are the ends of the percentage: write one value, start, and compare with \
             `meas` on an actuator without sensor before the first run.\n\
             - Setpoint low-pass and slew rate limit are in the way of the waveform: switch them off (`setlpon,0`, in \
             older firmware `lpon,0`; `sr,2000`).\n\n"
        );
    }
    out += "## Before it runs\n\n\
            Each file steps to the first point at once: where that is too much for what the actuator carries, go near \
            it slowly first. Voltages count as the model's input does; where the controller counts from another zero, \
            as with a bender that is driven about the middle, shift them (`WOS` in GCS, the range for the NV200).\n";
    out
}

/// How far off the model is at most in the first period from standing still at the first voltage [% of the stroke].
fn beginning(model: &Model, drive: &Drive) -> f64 {
    let y = model.resume(&mut model.settled(drive.u.first().copied().unwrap_or(0.0)), &drive.u);
    let (low, high) = ends(drive.r.iter().copied());
    100.0 * y.iter().zip(&drive.r).map(|(y, r)| (y - r).abs()).fold(0.0, f64::max) / (high - low)
}

/// How long creep takes.
fn slowest(model: &Model) -> String {
    let slowest = model.creep().lags().iter().map(|lag| lag.tau_s).fold(0.0, f64::max);
    if slowest > 0.0 {
        format!("; its slowest creep settles within some {} s", round(3.0 * slowest))
    } else {
        String::new()
    }
}
