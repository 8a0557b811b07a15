//! The address of a project, for a link in its reports.

use piezoid::Error;
use std::str::FromStr;

/// An address of the web.
///
/// ```
/// use piezoid_report::page::Address;
/// assert!("http://127.0.0.1:7440/#workbench".parse::<Address>().is_ok());
/// assert!("javascript:alert(1)".parse::<Address>().is_err());
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct Address(String);

impl FromStr for Address {
    type Err = Error;

    /// # Errors
    /// [`Error::Parameter`] unless the text begins with http:// or https:// and has no spaces.
    fn from_str(text: &str) -> Result<Self, Error> {
        let is_web = ["http://", "https://"].iter().any(|start| text.starts_with(start));
        if !is_web || text.contains(|c: char| c.is_whitespace() || c.is_control()) {
            return Err(Error::parameter("project", text, "must begin with http:// or https://, without spaces"));
        }
        Ok(Address(text.into()))
    }
}

impl AsRef<str> for Address {
    fn as_ref(&self) -> &str {
        &self.0
    }
}
