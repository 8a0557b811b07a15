//! What an NV200 reports about itself.

use super::codes::fault;
use super::line::Line;
use super::run::{BY_WAVE, POSITION, VOLTAGE};
use super::session::{CYCLE, Nv200, RECORDER, WAVE};
use crate::gcs::{Axis, Controller};
use crate::watch::Watch;
use crate::{ConnectOptions, Rest};
use piezoid::Error;
use piezoid::progress::Progress;

/// Name of the only axis, in messages.
pub(crate) const AXIS: &str = "1";

impl Nv200<'_> {
    /// What a controller reports. Nothing moves, and nothing is set.
    pub(crate) fn look(options: &ConnectOptions, progress: &mut Progress) -> Result<Controller, Error> {
        connect(options, progress).map(|(_, controller)| controller)
    }
}

/// A connection, and what the controller reports.
pub(crate) fn connect<'a>(
    options: &ConnectOptions,
    progress: &'a mut Progress<'_>,
) -> Result<(Line<'a>, Controller), Error> {
    let (mut line, name) = Line::open((&options.host, options.port), options.patience(), Watch::new(progress))?;
    let (actuator, serial) = (line.query("desc")?.join(","), line.query("acserno")?.join(","));
    let unit = line.query("unitcl")?.concat().to_lowercase().replace('\u{b5}', "u");
    let axis = Axis {
        name: AXIS.into(),
        unit: if unit.is_empty() { "um".into() } else { unit },
        servo: Some(line.number("cl")? != 0.0),
        position: Some(line.number("meas")?),
        // Only the recorder measures it, and its settings stay as they are.
        voltage: None,
        range: Some((line.number("avmin")?, line.number("avmax")?)),
    };
    let is_running = line.number("grun")? != 0.0;
    let controller = Controller {
        identity: format!("{name}, {actuator} #{serial}"),
        error: 0,
        is_moving: false,
        generators: if is_running { vec![1] } else { Vec::new() },
        cycle: Some(CYCLE),
        table: Some(WAVE),
        recorder: Some(RECORDER),
        axes: vec![axis],
    };
    Ok((line, controller))
}

/// Returns an error if the controller is not ready for a drive in open loop.
pub(crate) fn check(line: &mut Line, controller: &Controller) -> Result<(), Error> {
    let unready =
        |what: &str, advice: &str| Err(Error::Content(format!("{what}; nothing has moved: {advice}, then try again")));
    if let Some(signs) = controller.in_use() {
        return unready(&format!("the controller is in use: {signs}"), "end the program that uses it");
    }
    let records = line.number("recrun")? != 0.0;
    if records && !is_left(line)? {
        return unready("the controller is in use: its recorder runs", "end the program that uses it");
    }
    if let Some(what) = fault(line.number("stat")? as u16) {
        return unready(&format!("the controller reports that {what} (`stat`)"), "correct that");
    }
    if line.number("cl")? != 0.0 {
        // Its manual does not say what the voltage then does.
        return unready("the axis is in closed loop, which this program does not open on an NV200", "open it (`cl,0`)");
    }
    if line.number("ctrlmode")? != 0.0 {
        return unready("the controller is in a mode of ILC", "leave it (`ctrlmode,0`)");
    }
    if !matches!(line.number("modsrc")? as u8, SET | GENERATOR) {
        return unready("the setpoint comes from an analogue input or SPI", "choose another source (`modsrc,0`)");
    }
    if records {
        line.choose("recrun", 0)?;
    }
    Ok(())
}

/// True if the recorder waits for a generator at rest, as a measurement leaves it that was killed before its drive: it
/// would wait for ever.
fn is_left(line: &mut Line) -> Result<bool, Error> {
    let settings = [("recast", BY_WAVE), ("recsrc,0", VOLTAGE), ("recsrc,1", POSITION)];
    for (name, own) in settings {
        if line.number(name)? != own as f64 {
            return Ok(false);
        }
    }
    Ok(line.number("grun")? == 0.0)
}

/// Values of `modsrc`.
pub(crate) const SET: u8 = 0;
pub(crate) const GENERATOR: u8 = 3;

/// The voltage of rest, if the axis moves [V].
pub(crate) fn target(rest: Rest, start: f64) -> Option<f64> {
    match rest {
        Rest::Start => Some(start),
        Rest::Zero => Some(0.0),
        Rest::Stay => None,
    }
}
