//! Numbers of errors that an NV200 answers.

/// What `error,N` means.
pub(crate) fn meaning(code: u32) -> &'static str {
    match code {
        2 => "it does not know this command",
        3 => "an argument is missing",
        4 => "an argument is outside its range",
        5 => "there are too many arguments",
        6 => "this value cannot be changed",
        7 => "underload",
        8 => "overload",
        9 => "the value is too low",
        10 => "the value is too high",
        _ => "see its manual",
    }
}

/// The bits of `stat` that forbid a drive.
const FAULTS: [(u16, &str); 4] = [
    (10, "it is too hot"),
    (11, "its actuator has an error"),
    (12, "its hardware has an error"),
    (13, "I2C has an error"),
];

/// Why `stat` forbids a drive, if it does.
pub(crate) fn fault(status: u16) -> Option<&'static str> {
    if status & 1 == 0 {
        return Some("no actuator is connected");
    }
    FAULTS.iter().find(|(bit, _)| status >> bit & 1 == 1).map(|(_, what)| *what)
}
