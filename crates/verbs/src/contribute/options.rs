//! What the person states who contributes records: the licence, the equipment and a name.

use piezoid_numerics::error::Error;
use piezoid_numerics::options::{OptionKind, OptionRow, options};
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// A licence of contributed records. Both allow to show and to use them; one asks for the name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Licence {
    /// Creative Commons Attribution 4.0: the name must be stated.
    #[serde(rename = "CC-BY-4.0")]
    Attribution,
    /// Creative Commons Zero 1.0: no conditions.
    #[serde(rename = "CC0-1.0")]
    PublicDomain,
}

impl Licence {
    /// Its name for people, and its address.
    pub fn words(self) -> [&'static str; 2] {
        match self {
            Licence::Attribution => ["CC BY 4.0", "https://creativecommons.org/licenses/by/4.0/"],
            Licence::PublicDomain => ["CC0 1.0", "https://creativecommons.org/publicdomain/zero/1.0/"],
        }
    }
}

const LICENCES: OptionKind = OptionKind::Choice(&[
    ("CC-BY-4.0", "all may use the records, and must state who measured them"),
    ("CC0-1.0", "all may use the records, without conditions"),
]);

const TEXT: OptionKind = OptionKind::Text("TEXT");
const STATED: &str = "Statement";

options! {
    /// What is stated of contributed records. All but {conditions} is needed to pack them.
    pub struct ContributeOptions {
        /// Licence of the records.
        licence: Option<Licence> = None, OptionRow::new(LICENCES).group(STATED);
        /// The actuator: manufacturer, type, what it carries.
        actuator: Option<String> = None, OptionRow::new(TEXT).group(STATED);
        /// The driver: manufacturer, type, gain, and where the voltage was measured.
        driver: Option<String> = None, OptionRow::new(TEXT).group(STATED);
        /// The sensor: manufacturer, type, range, bandwidth.
        sensor: Option<String> = None, OptionRow::new(TEXT).group(STATED);
        /// Who measured the records, as it shall be stated.
        who: Option<String> = None, OptionRow::new(TEXT).group(STATED);
        /// Conditions: temperature, load, preload, age.
        conditions: Option<String> = None, OptionRow::new(TEXT).group(STATED);
    }
}

impl ContributeOptions {
    /// What is stated, by the names of options and in their order.
    pub(super) fn texts(&self) -> [(&'static str, &Option<String>); 5] {
        let Self { actuator, driver, sensor, who, conditions, .. } = self;
        [("actuator", actuator), ("driver", driver), ("sensor", sensor), ("who", who), ("conditions", conditions)]
    }

    /// The licence, if all is stated that must be.
    ///
    /// # Errors
    /// Returns an error that names what is missing, empty, or more than a line.
    pub fn stated(&self) -> Result<Licence, Error> {
        let is_stated = |text: &Option<String>| text.as_ref().is_some_and(|text| !text.trim().is_empty());
        if let Some((name, Some(text))) = self
            .texts()
            .into_iter()
            .find(|(_, text)| text.as_ref().is_some_and(|text| text.chars().any(char::is_control)))
        {
            return Err(Error::parameter(name, format!("{text:?}"), "must be one line of text"));
        }
        let missing = self.texts().into_iter().filter(|(name, text)| *name != "conditions" && !is_stated(text));
        let none = |name: &'static str| (name, Value::Null);
        let missing: Vec<_> = missing.map(|(name, _)| none(name)).collect();
        let Some(licence) = self.licence else {
            let why = "a contribution has a licence, without which nobody may use it: ";
            let known = ["CC-BY-4.0", "CC0-1.0"].map(|name| ("licence", Value::from(name)));
            return Err(Error::Content(why.into()).advised(known.into()));
        };
        if missing.is_empty() {
            return Ok(licence);
        }
        let why = "a contribution states the equipment and who measured it, in words and not empty: ";
        Err(Error::Content(why.into()).needing(missing))
    }
}
