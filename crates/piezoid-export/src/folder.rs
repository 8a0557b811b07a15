//! Exports in a folder: what is written, what is removed, and what is refused, so that no export is mixed with another
//! by mistake.
//!
//! The file [`EXPORT_LIST_FILE`] in the folder names each export with its files. The same export again replaces its
//! files and removes those that it no longer has, so that the folder is as after a first export. Another export is
//! refused unless every file of both stands for itself, as FMUs do. An existing file that is not in the list is
//! replaced only with `force`. It does not do: compare contents, so files changed by hand are replaced by the same
//! export again.

use super::{ExportTarget, Exported, File, TARGETS};
use piezoid::error::Error;
use serde::{Deserialize, Serialize};
use serde_json::Value;

/// The file that lists the exports of a folder.
pub const EXPORT_LIST_FILE: &str = "piezoid-export.json";

/// How the list begins, and the number of its layout.
#[derive(Serialize, Deserialize)]
struct Listing {
    piezoid_export: u32,
    exports: Vec<Row>,
}

/// An export and its files.
#[derive(Serialize, Deserialize)]
struct Row {
    target: String,
    name: String,
    files: Vec<String>,
}

/// What changes in a folder.
#[derive(Debug, PartialEq)]
pub struct Placement {
    /// Files to write, the list first.
    pub write: Vec<File>,
    /// Files of the same export that it no longer has.
    pub remove: Vec<String>,
}

impl Exported {
    /// The changes that place this export of a target in a folder, under a name. `list` is the content of
    /// [`EXPORT_LIST_FILE`] in the folder; `exists` is true for the name of an existing file.
    ///
    /// # Errors
    /// If the folder holds another export, or files of the same names, unless `force` is given.
    pub fn placed(
        &self,
        (target, name): (&ExportTarget, &str),
        list: Option<&[u8]>,
        exists: &dyn Fn(&str) -> bool,
        force: bool,
    ) -> Result<Placement, Error> {
        let mut rows = match list.map(read) {
            Some(Err(_)) if force => Vec::new(),
            Some(rows) => rows?,
            None => Vec::new(),
        };
        // Files may have been deleted or moved since. None is outside of the folder, and none is the list.
        let is_name = |file: &str| !file.contains(['/', '\\']) && ![".", "..", EXPORT_LIST_FILE].contains(&file);
        rows.iter_mut().for_each(|row| row.files.retain(|file| is_name(file) && exists(file)));
        rows.retain(|row| !row.files.is_empty());
        let own = rows.iter().position(|row| row.target == target.name && row.name == name).map(|k| rows.remove(k));
        let is_own = |file: &String| own.as_ref().is_some_and(|own| own.files.contains(file));
        let files: Vec<String> = self.files.iter().map(|file| file.name.clone()).collect();
        let taken: Vec<&str> = files.iter().filter(|file| exists(file) && !is_own(file)).map(String::as_str).collect();
        // What has been put beside each other once may be exported again.
        let mixed = rows.iter().find(|row| own.is_none() && !(target.stands_alone && stands_alone(row)));
        if let (false, true) = (force, mixed.is_some() || !taken.is_empty()) {
            return Err(refused(mixed, &taken));
        }
        rows.iter_mut().for_each(|row| row.files.retain(|file| !files.contains(file)));
        let remove = own.map_or(Vec::new(), |own| own.files.into_iter().filter(|f| !files.contains(f)).collect());
        rows.push(Row { target: target.name.into(), name: name.into(), files });
        rows.retain(|row| !row.files.is_empty());
        rows.sort_by(|a, b| (&a.name, &a.target).cmp(&(&b.name, &b.target)));
        let listing = serde_json::to_string_pretty(&Listing { piezoid_export: 1, exports: rows });
        let listing = listing.map_err(|error| Error::Content(error.to_string()))? + "\n";
        // The list is the first, so that what follows it is known to belong here.
        Ok(Placement { write: [&[File::new(EXPORT_LIST_FILE, listing)], &self.files[..]].concat(), remove })
    }
}

fn read(list: &[u8]) -> Result<Vec<Row>, Error> {
    match serde_json::from_slice(list) {
        Ok(Listing { piezoid_export: 1, exports }) => Ok(exports),
        Ok(Listing { piezoid_export: other, .. }) => {
            Err(occupied(format!("{EXPORT_LIST_FILE} has layout {other}, but only 1 is known")))
        }
        Err(error) => Err(occupied(format!("{EXPORT_LIST_FILE} is no list of exports ({error})"))),
    }
}

/// The error of a folder in which nothing is exported without `force`.
fn occupied(why: String) -> Error {
    Error::Content(why + ": name another folder, or ").advised(vec![("force", Value::Bool(true))])
}

fn stands_alone(row: &Row) -> bool {
    TARGETS.iter().any(|target| target.name == row.target && target.stands_alone)
}

fn refused(mixed: Option<&Row>, taken: &[&str]) -> Error {
    let files = taken.join(", ");
    let what = match mixed {
        Some(Row { target, name, .. }) => {
            let replaced = if taken.is_empty() { String::new() } else { format!("; {files} would be replaced") };
            format!("the export of another model or target: target {target}, name {name}{replaced}")
        }
        None => format!("{files}, not from this target under this name"),
    };
    occupied(format!("the folder holds {what}"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeMap;

    /// A folder in memory.
    #[derive(Default)]
    struct Folder(BTreeMap<String, Vec<u8>>);

    impl Folder {
        /// Exports files with this content.
        fn take(&mut self, target: &str, name: &str, files: &[&str], force: bool) -> Result<(), String> {
            let files = files.iter().map(|file| File::new(*file, format!("{target} {name}"))).collect();
            let result = Exported { files, ..Exported::default() };
            let target = ExportTarget::find(target).unwrap();
            let list = self.0.get(EXPORT_LIST_FILE).map(Vec::as_slice);
            let placed = result.placed((target, name), list, &|file| self.0.contains_key(file), force);
            let Placement { write, remove } = placed.map_err(|error| error.to_string())?;
            remove.iter().for_each(|file| drop(self.0.remove(file)));
            self.0.extend(write.into_iter().map(|file| (file.name, file.bytes)));
            Ok(())
        }

        fn names(&self) -> Vec<&str> {
            self.0.keys().map(String::as_str).filter(|name| *name != EXPORT_LIST_FILE).collect()
        }
    }

    #[test]
    fn the_same_export_again_leaves_what_a_first_one_leaves() {
        let (mut folder, mut fresh) = (Folder::default(), Folder::default());
        folder.take("simulink", "m", &["m.c", "m_control_sfun.c"], false).unwrap();
        folder.0.insert("notes.txt".into(), Vec::new());
        folder.take("simulink", "m", &["m.c"], false).unwrap();
        fresh.take("simulink", "m", &["m.c"], false).unwrap();
        assert_eq!(folder.names(), ["m.c", "notes.txt"]);
        assert_eq!(folder.0[EXPORT_LIST_FILE], fresh.0[EXPORT_LIST_FILE]);
    }

    #[test]
    fn another_export_is_refused_with_what_is_there_unless_forced() {
        let mut folder = Folder::default();
        folder.take("simulink", "m", &["m.c", "m.m"], false).unwrap();
        for (target, name, says) in [
            ("c", "m", "target simulink, name m; m.c would be replaced: name another folder, or give `force`"),
            ("c", "n", "target simulink, name m: name another folder"),
            ("fmu2", "m", "target simulink, name m"),
        ] {
            let error = folder.take(target, name, &[&format!("{name}.c")], false).unwrap_err();
            assert!(error.contains(says), "{error}");
        }
        folder.take("c", "m", &["m.c"], true).unwrap();
        assert_eq!(folder.names(), ["m.c", "m.m"]);
        // The file has another owner now.
        folder.take("c", "m", &["m.c"], false).unwrap();
        assert!(folder.take("simulink", "m", &["m.c", "m.m"], false).is_err());
    }

    #[test]
    fn two_models_put_beside_each_other_once_may_be_exported_again() {
        let mut folder = Folder::default();
        folder.take("c", "x", &["x.c"], false).unwrap();
        folder.take("c", "y", &["y.c"], true).unwrap();
        folder.take("c", "x", &["x.c"], false).unwrap();
        folder.take("c", "y", &["y.c"], false).unwrap();
        assert_eq!(folder.names(), ["x.c", "y.c"]);
    }

    #[test]
    fn fmus_of_any_version_and_name_share_a_folder() {
        let mut folder = Folder::default();
        for (target, name) in [("fmu2", "m"), ("fmu3", "m"), ("fmu2", "n"), ("fmu2", "m")] {
            folder.take(target, name, &[&format!("{name}_{target}.fmu")], false).unwrap();
        }
        assert_eq!(folder.names().len(), 3);
    }

    #[test]
    fn a_file_that_no_export_lists_is_not_replaced_unasked() {
        let mut folder = Folder::default();
        folder.0.insert("m.c".into(), b"by hand".into());
        let error = folder.take("c", "m", &["m.c", "m.h"], false).unwrap_err();
        assert!(error.contains("the folder holds m.c, not from this target under this name"), "{error}");
        folder.take("c", "m", &["m.c", "m.h"], true).unwrap();
        // Once its files are gone, an export is forgotten.
        folder.0.retain(|name, _| name == EXPORT_LIST_FILE);
        folder.take("rust", "n", &["n.rs"], false).unwrap();
    }

    #[test]
    fn a_list_that_is_none_is_refused_unless_forced() {
        let mut folder = Folder::default();
        for list in ["{}", "{\"piezoid_export\": 2, \"exports\": []}"] {
            folder.0.insert(EXPORT_LIST_FILE.into(), list.into());
            let error = folder.take("c", "m", &["m.c"], false).unwrap_err();
            assert!(error.contains(EXPORT_LIST_FILE) && error.ends_with("give `force` = true"), "{error}");
        }
        folder.take("c", "m", &["m.c"], true).unwrap();
    }
}
