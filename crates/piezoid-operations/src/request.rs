//! A request: the operation, its options, how columns are read, and the names of files by their roles.

use crate::Role;
use piezoid::Error;
use piezoid::formats::ColumnSelection;
use piezoid_numerics::options::Options;
use piezoid_verbs::{DataFile, File, Origin, Source, Step};
use serde::Deserialize;
use serde_json::{Map, Value};
use std::collections::BTreeMap;

/// A request.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Request {
    /// Name of the operation.
    pub call: String,
    /// Its options by name.
    #[serde(default)]
    pub options: Map<String, Value>,
    /// Options of the columns of data files: a [`ColumnSelection`] by the names of its fields.
    #[serde(default)]
    pub columns: Map<String, Value>,
    /// How the records of files are read and prepared, by the names of the files. For a file that is not named here,
    /// `columns` applies.
    #[serde(default)]
    pub records: BTreeMap<String, Reading>,
    /// Names of files, by their roles.
    #[serde(default)]
    pub files: BTreeMap<String, Vec<String>>,
}

/// How the record of a file is read and prepared.
#[derive(Debug, Clone, PartialEq, Default, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Reading {
    /// A [`ColumnSelection`] by the names of its fields.
    pub columns: Map<String, Value>,
    /// Steps of its preparation, in their order.
    pub preparation: Vec<Step>,
    /// Origin of the record, if the file was derived from another one.
    pub origin: Option<Origin>,
}

impl Request {
    /// The request in a document.
    ///
    /// # Errors
    /// Returns an error if the document is not a request.
    pub fn of(document: Value) -> Result<Request, Error> {
        let example = "{\"call\": \"inspect\", \"files\": {\"data\": [\"log.csv\"]}}";
        let refused = |e| Error::Content(format!("this is not a request: {e}; a request is such as {example}"));
        serde_json::from_value(document).map_err(refused)
    }

    /// Returns an error if a role has too few or too many files, or is unknown.
    pub(crate) fn fit(&self, roles: &[Role]) -> Result<(), Error> {
        let names = || roles.iter().map(|role| role.name);
        if let Some(name) = self.files.keys().find(|name| names().all(|known| known != **name)) {
            return Err(Error::unknown("role of files", name, names()));
        }
        for Role { name, least, many } in roles {
            let count = self.files.get(*name).map_or(0, Vec::len);
            if count < *least || count > 1 && !many {
                let expected = match (least, many) {
                    (1, false) => "exactly 1".into(),
                    (least, true) => format!("{least} or more"),
                    (_, false) => "0 to 1".to_string(),
                };
                let call = &self.call;
                return Err(Error::Content(format!(
                    "{call} takes {expected} of the files `{name}`, but {count} are given"
                )));
            }
        }
        Ok(())
    }
}

/// The input of an operation: a request with its files.
#[derive(Debug)]
pub struct Inputs<'a> {
    pub(crate) request: &'a Request,
    pub(crate) files: &'a [File],
}

impl Inputs<'_> {
    /// The options of the operation.
    pub(crate) fn options<O: Options>(&self) -> Result<O, Error> {
        O::from_json(Value::Object(self.request.options.clone()))
    }

    /// What is said of the columns of data files.
    pub(crate) fn columns(&self) -> Result<ColumnSelection, Error> {
        ColumnSelection::from_json(Value::Object(self.request.columns.clone()))
    }

    /// The files with a role.
    pub(crate) fn all(&self, role: &str) -> Result<Vec<File>, Error> {
        let names = self.request.files.get(role).into_iter().flatten();
        let file = |name: &String| {
            let known = || Error::unknown("file", name, self.files.iter().map(|file| &*file.name));
            self.files.iter().find(|file| file.name == *name).cloned().ok_or_else(known)
        };
        names.map(file).collect()
    }

    /// The files with a role, and how their records are made.
    pub(crate) fn sources(&self, role: &str) -> Result<Vec<Source>, Error> {
        let source = |file: File| {
            let Some(Reading { columns, preparation, origin }) = self.request.records.get(&file.name).cloned() else {
                return Ok(Source::new(file, self.columns()?, Vec::new()));
            };
            let columns = ColumnSelection::from_json(Value::Object(columns)).map_err(|error| error.of(&file.name))?;
            Ok(Source { origin, ..Source::new(file, columns, preparation) })
        };
        self.all(role)?.into_iter().map(source).collect()
    }

    /// The first file with a role, if there is one.
    pub(crate) fn some(&self, role: &str) -> Result<Option<File>, Error> {
        Ok(self.all(role)?.into_iter().next())
    }

    /// The only file of samples with a role.
    pub(crate) fn data(&self, role: &str) -> Result<DataFile, Error> {
        Ok(self.one(role)?.into())
    }

    /// The only file with a role.
    pub(crate) fn one(&self, role: &str) -> Result<File, Error> {
        let none = || Error::Content(format!("{} needs a file `{role}`", self.request.call));
        self.some(role)?.ok_or_else(none)
    }
}
