//! Numbers of errors that the controller answers to `ERR?`. What they mean: [`meaning`](crate::gcs::codes::meaning).

pub(super) const SYNTAX: i32 = 1;
pub(super) const UNKNOWN: i32 = 2;
pub(super) const TOO_LONG: i32 = 3;
pub(super) const SERVO_IS_OFF: i32 = 5;
pub(super) const POSITION: i32 = 7;
pub(super) const VELOCITY: i32 = 8;
pub(super) const STOPPED: i32 = 10;
pub(super) const AXIS: i32 = 15;
pub(super) const RANGE: i32 = 17;
pub(super) const TWICE: i32 = 22;
pub(super) const CHANNEL: i32 = 23;
pub(super) const COUNT: i32 = 24;
pub(super) const NUMBER: i32 = 25;
pub(super) const PARAMETER: i32 = 54;
pub(super) const PASSWORD: i32 = 56;
pub(super) const RECORDER_TABLE: i32 = 57;
pub(super) const RECORDER_OPTION: i32 = 58;
pub(super) const RECORDER_SOURCE: i32 = 59;
pub(super) const PROTECTED: i32 = 60;
pub(super) const READ_ONLY: i32 = 64;
pub(super) const VOLTAGE: i32 = 66;
pub(super) const WAVE_TOO_LARGE: i32 = 67;
pub(super) const LENGTHS: i32 = 70;
pub(super) const GENERATOR_RUNS: i32 = 73;
pub(super) const NO_WAVE: i32 = 75;
pub(super) const TOO_FEW_POINTS: i32 = 77;
pub(super) const SERVO_IS_ON: i32 = 79;

/// No error of the controller: points that are still to be recorded.
pub(super) const AWAITED: i32 = i32::MIN;

/// The first error of which the condition holds.
pub(super) fn refused(checks: &[(bool, i32)]) -> Result<(), i32> {
    checks.iter().find(|(refused, _)| *refused).map_or(Ok(()), |(_, error)| Err(*error))
}
