//! The settings of an excitation: what they are called, what they mean, and what they were set to.
//!
//! The command line makes a flag of every parameter, Python a keyword and the web page a field; all of them from these
//! rows. Every setting is a number: whole ones are checked here, and a switch is 0 or 1.

use crate::error::Error;

/// One setting of an excitation.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Parameter {
    /// Lower case, words joined by dashes.
    pub name: &'static str,
    /// Unit in SI, empty for a plain number.
    pub unit: &'static str,
    /// What it is when it is not given; `None` when it must be given.
    pub default: Option<f64>,
    /// What it means, in one line.
    pub help: &'static str,
}

/// Half of peak to peak.
pub(super) const AMPLITUDE: Parameter = Parameter {
    name: "amplitude",
    unit: "V",
    default: None,
    help: "largest distance from the offset, half of peak to peak",
};

/// What everything is centred on.
pub(super) const OFFSET: Parameter =
    Parameter { name: "offset", unit: "V", default: Some(0.0), help: "voltage that the excitation is centred on" };

/// Periods a second.
pub(super) const FREQUENCY: Parameter =
    Parameter { name: "frequency", unit: "Hz", default: None, help: "periods a second, below half the sampling rate" };

/// The settings of one excitation, complete and finite.
pub(super) struct Values(Vec<(&'static str, f64)>);

impl Values {
    /// Completes what was `given` with the defaults of the `parameters` of the excitation `kind`. Of a name given
    /// twice the last one counts.
    ///
    /// # Errors
    /// Unknown names, values that are not finite, and required parameters that are missing.
    pub(super) fn new(kind: &str, parameters: &[Parameter], given: &[(&str, f64)]) -> Result<Self, Error> {
        for (name, value) in given {
            if !parameters.iter().any(|p| p.name == *name) {
                return Err(Error::unknown("parameter", name, parameters.iter().map(|p| p.name)));
            }
            if !value.is_finite() {
                return Err(Error::parameter(*name, value, "must be a finite number"));
            }
        }
        let complete = parameters.iter().map(|p| {
            let value = given.iter().rev().find(|(name, _)| *name == p.name).map(|(_, value)| *value);
            match value.or(p.default) {
                Some(value) => Ok((p.name, value)),
                None => {
                    let unit = if p.unit.is_empty() { String::new() } else { format!(" [{}]", p.unit) };
                    let rule = format!("{kind} needs it: {}{unit}", p.help);
                    Err(Error::parameter(p.name, "(not given)", rule))
                }
            }
        });
        complete.collect::<Result<_, _>>().map(Values)
    }

    /// The value of a parameter.
    pub(super) fn get(&self, parameter: &Parameter) -> Result<f64, Error> {
        let found = self.0.iter().find(|(name, _)| *name == parameter.name);
        found
            .map(|(_, value)| *value)
            .ok_or_else(|| Error::unknown("parameter", parameter.name, self.0.iter().map(|(name, _)| *name)))
    }

    /// The value of a parameter that counts something.
    pub(super) fn whole(&self, parameter: &Parameter) -> Result<u32, Error> {
        let value = self.get(parameter)?;
        if value.fract() == 0.0 && (0.0..=f64::from(u32::MAX)).contains(&value) {
            Ok(value as u32)
        } else {
            Err(Error::parameter(parameter.name, value, format!("must be a whole number from 0 to {}", u32::MAX)))
        }
    }

    /// The value of a switch.
    pub(super) fn switch(&self, parameter: &Parameter) -> Result<bool, Error> {
        match self.get(parameter)? {
            0.0 => Ok(false),
            1.0 => Ok(true),
            value => Err(Error::parameter(parameter.name, value, "must be 0 (no) or 1 (yes)")),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const KNOWN: [Parameter; 3] = [AMPLITUDE, FREQUENCY, OFFSET];

    fn refusal(given: &[(&str, f64)]) -> String {
        Values::new("sine", &KNOWN, given).err().map(|e| e.to_string()).unwrap_or_default()
    }

    #[test]
    fn what_is_not_given_takes_its_default_and_the_last_of_two_counts() {
        let values =
            Values::new("sine", &KNOWN, &[("amplitude", 3.0), ("frequency", 5.0), ("amplitude", 4.0)]).unwrap();
        assert_eq!(values.get(&AMPLITUDE).unwrap(), 4.0);
        assert_eq!(values.get(&OFFSET).unwrap(), 0.0);
    }

    #[test]
    fn unknown_missing_and_infinite_settings_are_refused_by_name() {
        assert_eq!(
            refusal(&[("amplitud", 1.0)]),
            "there is no parameter called `amplitud`: known are amplitude, frequency, offset; did you mean `amplitude`?"
        );
        assert_eq!(
            refusal(&[("amplitude", 1.0)]),
            "frequency = (not given): sine needs it: periods a second, below half the sampling rate [Hz]"
        );
        assert_eq!(refusal(&[("offset", f64::NAN)]), "offset = NaN: must be a finite number");
    }

    #[test]
    fn counts_are_whole_and_switches_are_0_or_1() {
        let values = Values::new("", &KNOWN, &[("amplitude", 1.0), ("frequency", 2.5), ("offset", -1.0)]).unwrap();
        assert_eq!(values.whole(&AMPLITUDE).unwrap(), 1);
        assert!(values.switch(&AMPLITUDE).unwrap());
        assert!(values.whole(&FREQUENCY).is_err() && values.whole(&OFFSET).is_err());
        assert!(values.switch(&FREQUENCY).is_err());
    }
}
