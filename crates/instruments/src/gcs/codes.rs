//! Numbers of errors that controllers answer to `ERR?`.

/// What the number of an error means; PI's GCS manuals list all.
pub(crate) fn meaning(code: i32) -> &'static str {
    match code {
        1 => "an argument is not written as the command demands",
        2 => "it does not know this command",
        3 => "the command is too long",
        5 => "the axis is not referenced, or its servo is off",
        7 => "the position is outside its limits",
        8 => "the velocity is outside its limits",
        10 => "it was stopped by a command",
        15 | 23 => "it has no such axis",
        17 => "an argument is outside its range",
        24 | 26 => "the number of arguments is wrong",
        25 => "an argument is not a number",
        22 => "an axis is named twice",
        54 => "it has no such parameter",
        56 => "the password is wrong",
        57 => "its recorder has no such table",
        58 => "its recorder cannot record this quantity",
        59 => "its recorder cannot record this channel",
        60 => "this parameter is protected",
        64 => "this parameter cannot be changed",
        66 => "the voltage is outside its limits",
        67 => "the wave table is too long for its memory",
        70 => "the tables differ in length",
        72 => "the axis follows its analogue input",
        73 => "the wave generator runs",
        75 => "no wave table is selected",
        77 => "not so many points are recorded",
        79 => "the servo of the axis is on",
        _ => "see its manual",
    }
}
