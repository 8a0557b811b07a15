//! Closed loop: the drive is positions, and the servo follows them. It must be on, and it stays on.
//!
//! ```text
//! PUN? 1, TMN? 1, TMX? 1   the unit and the travel
//! VEL? 1                   the largest velocity
//! MOV? 1                   the target, to which the axis returns
//! MOV 1 ...                slowly to the first position, and back to rest
//! SVO? 1, POS? 1           the servo is on, and holds its target: before the first move, the drive, and at rest
//! ```
//! Wave generator and recorder do the same as in open loop. It does not switch the servo on: a person tunes it and
//! closes the loop on an actuator, at the maker's program.

use super::controller::Axis;
use super::line::Line;
use super::run::Run;
use crate::moves::Moves;
use crate::{InstrumentOptions, Left, Rest};
use piezoid::Error;
use piezoid::excitation::{LimitOptions, Limits};
use std::time::{Duration, Instant};

/// Largest distance of a position from its target, and of a target at rest from the expected one, over the travel.
const NEAR: f64 = 0.01;

/// Time in which it must come so near.
const TIME: Duration = Duration::from_secs(3);

const PAUSE: Duration = Duration::from_millis(20);

/// The travel of an axis in closed loop [unit of the axis], and the limit of its velocity. Nothing moves.
pub(super) fn travel(line: &mut Line, axis: &Axis, options: &InstrumentOptions) -> Result<((f64, f64), Limits), Error> {
    let name = &axis.name;
    if axis.servo != Some(true) {
        let rule = format!(
            "needs the servo, but that of axis {name} is off: switch it on with the maker's program, once it is tuned"
        );
        return Err(Error::parameter("closed_loop", "true", rule));
    }
    if options.limits != LimitOptions::default() || options.gain.is_some() {
        let rule = "leaves the voltage to the servo: give no driver, limit or gain with it";
        return Err(Error::parameter("closed_loop", "true", rule));
    }
    if options.rest == Rest::Zero {
        return Err(Error::parameter("rest", "zero", "is a voltage: in closed loop the axis can return or stay"));
    }
    let unit = line.optional_query(&format!("PUN? {name}"))?.map_or_else(String::new, |lines| lines.concat());
    if unit.rsplit('=').next().is_none_or(|unit| unit.trim().is_empty()) {
        return Err(Error::Content(format!("the controller does not report the unit of axis {name} (`PUN?`)")));
    }
    let range = (line.needed(&format!("TMN? {name}"))?, line.needed(&format!("TMX? {name}"))?);
    let slew = line.value(&format!("VEL? {name}"))?.filter(|velocity| *velocity > 0.0);
    Ok((range, Limits { slew, ..Limits::default() }))
}

impl Run<'_> {
    /// The target of the servo.
    pub(super) fn target(&mut self) -> Result<f64, Error> {
        self.line.needed(&format!("MOV? {}", self.axis.name))
    }

    /// Returns an error if the servo is off: positions would be played as voltages.
    pub(super) fn check_servo(&mut self) -> Result<(), Error> {
        let name = &self.axis.name;
        if self.line.needed(&format!("SVO? {name}"))? != 0.0 {
            return Ok(());
        }
        Err(Error::Content(format!("the servo of axis {name} has been switched off")))
    }

    /// Waits until the servo holds its target, which it returns.
    pub(super) fn arrive(&mut self) -> Result<f64, Error> {
        let (begin, near) = (Instant::now(), NEAR * (self.range.1 - self.range.0));
        loop {
            self.check_servo()?;
            let target = self.target()?;
            let (name, unit) = (&self.axis.name, &self.axis.unit);
            let position = self.line.needed(&format!("POS? {name}"))?;
            if (position - target).abs() <= near {
                return Ok(target);
            }
            if begin.elapsed() > TIME {
                return Err(Error::Content(format!(
                    "the servo of axis {name} does not hold its target: it is at {position} {unit} instead of {target} {unit}; \
                     tune it first"
                )));
            }
            self.line.watch.pause(PAUSE)?;
        }
    }

    /// Moves the axis from the last position of a drive to its rest in this time [s], and checks that it is there.
    pub(super) fn return_to(&mut self, rest: Rest, start: f64, last: f64, time: f64) -> Result<Left, Error> {
        let goal = if rest == Rest::Stay { last } else { start };
        if rest != Rest::Stay {
            self.ramp(last, start, time)?;
        }
        let target = self.arrive()?;
        if (target - goal).abs() > NEAR * (self.range.1 - self.range.0) {
            let unit = &self.axis.unit;
            return Err(Error::Content(format!("the target is {target} {unit} instead of {goal} {unit}")));
        }
        self.left()
    }
}

#[cfg(test)]
mod tests {
    use crate::gcs::tests::{at_rest, simulated};
    use crate::measuring::{self, but, refused, text};
    use crate::{AcquireOptions, ConnectOptions, InstrumentOptions, Rest, Simulation};
    use piezoid::Error;
    use piezoid::excitation::LimitOptions;
    use piezoid::formats::Table;
    use piezoid::progress::Stage;
    use piezoid_numerics::options::Options;
    use piezoid_testing::assert_close;
    use piezoid_verbs::{DataFile, File};
    use serde_json::json;
    use std::f64::consts::TAU;
    use std::ops::ControlFlow;

    /// A controller whose axis is held at 100 um.
    fn held() -> (u16, AcquireOptions) {
        let port = simulated(&Simulation { plant: "paper".into(), ..Simulation::default() });
        text(port, &at_rest("SVO 1 1\nMOV 1 100\n"));
        let connection = ConnectOptions { port, ..ConnectOptions::default() };
        let instrument = InstrumentOptions { connection, ramp: 0.5, ..InstrumentOptions::default() };
        (port, AcquireOptions { instrument, settle: 0.5, closed_loop: true, ..AcquireOptions::default() })
    }

    fn positions(name: &str, factor: f64, amplitude: f64) -> DataFile {
        let r: Vec<f64> =
            (0..1000).map(|t| factor * (200.0 + amplitude * libm::sin(TAU * t as f64 / 1000.0))).collect();
        File::new("path.csv", Table::write("path.csv", 1e-3, &[(name, &r)]).unwrap()).into()
    }

    #[test]
    fn the_servo_follows_a_path_and_returns_to_its_target() {
        let (port, options) = held();
        let acquired = measuring::run(&options, &positions("r_nm", 1e3, 100.0), &mut Stage::ignore).0.unwrap();
        let record = &acquired.record;
        let r: Vec<f64> = (0..1000).map(|t| 200.0 + 100.0 * libm::sin(TAU * t as f64 / 1000.0)).collect();
        // A servo of 3 Hz lags behind a sine of 1 Hz, whose slope it knows but for hysteresis.
        assert_close(record.y(), &r, 0.0, 25.0);
        assert!(record.y()[250] > 280.0 && record.u()[250] > record.u()[750], "the voltage is measured");
        assert!(acquired.notes.concat().starts_with("the position differs from the drive by "), "{:?}", acquired.notes);
        assert_eq!(acquired.notes.len(), 1);
        assert_eq!((acquired.unfinished, acquired.servo), (None, Some(true)));
        assert_eq!(text(port, "MOV?\nSVO?\n"), "1=100.000000\n1=1\n");
        let stay = but(options, |instrument| instrument.rest = Rest::Stay);
        measuring::run(&stay, &positions("r_um", 1.0, 50.0), &mut Stage::ignore).0.unwrap();
        assert!(text(port, "MOV?\n").starts_with("1=199.6"));
    }

    #[test]
    fn what_the_servo_cannot_follow_is_refused_and_nothing_moves() {
        let (port, options) = held();
        let small = positions("r_um", 1.0, 50.0);
        let limits = |instrument: &mut InstrumentOptions| {
            instrument.limits = LimitOptions::from_json(json!({"slew": 50})).unwrap();
        };
        for (options, path, says) in [
            (but(options.clone(), limits), &small, "give no driver, limit or gain"),
            (but(options.clone(), |i| i.rest = Rest::Zero), &small, "rest = zero: is a voltage"),
            (options.clone(), &positions("r_um", 1.0, 2000.0), "outside -890 to 890 um: make it smaller"),
            (options.clone(), &positions("r_um", 1.0, 600.0), " um/s at "),
            (options.clone(), &positions("u_V", 1.0, 1.0), "r_"),
        ] {
            let message = refused(&options, path);
            assert!(message.contains(says), "{says}: {message}");
        }
        assert_eq!(text(port, "MOV?\nSVO?\n"), "1=100.000000\n1=1\n");
        text(port, "SVO 1 0\n");
        assert!(refused(&options, &small).contains("that of axis 1 is off: switch it on"));
        assert!(text(port, "SVO?\n").starts_with("1=0"), "it stays off");
    }

    #[test]
    fn a_servo_that_is_switched_off_or_does_not_hold_its_target_plays_nothing() {
        let (port, options) = held();
        let mut switch_off = |stage: Stage| {
            if stage.what.contains("settling") {
                text(port, "SVO 1 0\n");
            }
            ControlFlow::Continue(())
        };
        let (_, text_of, _) = measuring::run(&options, &positions("r_um", 1.0, 100.0), &mut switch_off);
        assert!(text_of.starts_with("the servo of axis 1 has been switched off; axis 1 is at "), "{text_of}");
        // Nothing was recorded, because the generator was not started.
        assert_eq!(text(port, "DRL? 1\n"), "1=0\n");
        // A servo that does not correct its error.
        let (port, options) = held();
        text(port, &at_rest("CCL 1 advanced\nSPA 1 0x07000301 1e-9 1 0x07000900 1000\nMOV 1 -700\n"));
        let message = refused(&options, &positions("r_um", 1.0, 100.0));
        assert!(message.contains("does not hold its target: it is at "), "{message}");
        assert_eq!(text(port, "MOV?\nDRL? 1\n"), "1=-700.000000\n1=0\n");
    }

    #[test]
    fn a_path_that_is_cancelled_stops_where_it_is_with_the_servo_on() {
        let (port, options) = held();
        let mut stop = |stage: Stage| match (stage.what.contains("the drive is played"), stage.done) {
            (true, done) if done > 200 => ControlFlow::Break(()),
            _ => ControlFlow::Continue(()),
        };
        let (outcome, text_of, _) = measuring::run(&options, &positions("r_um", 1.0, 100.0), &mut stop);
        assert!(matches!(outcome, Err(Error::Cancelled { .. })), "{text_of}");
        assert!(text_of.contains("in closed loop"), "{text_of}");
        assert_eq!(text(port, "\x09SVO?\n"), "0x0\n1=1\n");
        let target = text(port, "MOV?\n");
        assert!(target != "1=100.000000\n" && target == text(port, "MOV?\n"), "{target}");
    }
}
