//! Functional mock-up units for co-simulation, which every system simulator imports.
//!
//! An FMU is a zip file: a description of its variables in XML, C sources, and a shared library if there is a compiler.
//! Each entry of the program is one FMU: by FMI 2.0 the model `NAME_fmi2.fmu`, its feed-forward `NAME_ff_fmi2.fmu`, its
//! controller `NAME_control_fmi2.fmu`; by FMI 3.0 the same with `fmi3`. The name of the file is also that of the model,
//! of the library, and the identifier of the model, because some importers take one for the other.
//!
//! ```text
//! modelDescription.xml      units, start values, causality, structure
//! documentation/index.html  the same as a page
//! sources/                  NAME.h, NAME.c as for the target `c`, and the wrapper
//! binaries/                 the shared library
//! ```
//! The bytes are reproducible. The compiler is an argument ([`Compiler`](super::Compiler)).
//!
//! A step is a whole number of samples with a held input. An input set at t_k gives, after the step to t_k + Ts, the
//! sample that `simulate` computes at t_k. States can be set before the run, saved, serialised and restored. There are
//! no derivatives, no events, no interpolation of inputs, and no model exchange, because the model is a difference
//! equation.
//!
//! Reference: Functional Mock-up Interface 2.0.5 and 3.0.2, Modelica Association, <https://fmi-standard.org>.
//!
//! Why: docs/decisions/export.md, "The export crate returns an FMU as bytes".

mod variables;

use super::c::{C, checked};
use super::exported::{Entry, ExportedProgram};
use super::template::{Template, context, render, template, template_context};
use super::{CODE, ExportRequest, ExportTarget, Exported, File, named};
use piezoid::error::Error;

pub(super) const FMI2: ExportTarget = ExportTarget {
    name: "fmu2",
    summary: "FMUs for co-simulation (FMI 2.0), with C sources and, if a C compiler is found, a shared library",
    reference: "Functional Mock-up Interface 2.0.5, https://fmi-standard.org",
    stands_alone: true,
    make: |request| make(request, &VERSION_2),
    ..CODE
};

pub(super) const FMI3: ExportTarget = ExportTarget {
    name: "fmu3",
    summary: "FMUs for co-simulation (FMI 3.0), with C sources and, if a C compiler is found, a shared library",
    reference: "Functional Mock-up Interface 3.0.2, https://fmi-standard.org",
    stands_alone: true,
    make: |request| make(request, &VERSION_3),
    ..CODE
};

/// The differences between the versions of the standard.
struct Version {
    /// The version number.
    number: &'static str,
    /// The end of names, so that FMUs of both versions fit into one folder, and into one importer.
    ending: &'static str,
    /// Its types and functions in C.
    functions: &'static str,
    /// modelDescription.xml.
    description: Template,
    /// sources/buildDescription.xml, if any.
    build: Option<Template>,
    /// The folder of binaries for a machine such as `x86_64-linux`.
    folder: fn(platform: &str) -> &str,
}

const VERSION_2: Version = Version {
    number: "2.0",
    ending: "_fmi2",
    functions: include_str!("fmi2.c"),
    description: template!("fmu/fmi2.xml.j2"),
    build: None,
    folder: |platform| match platform {
        "x86_64-linux" => "linux64",
        "x86_64-windows" => "win64",
        "x86_64-darwin" => "darwin64",
        // This version defines no others.
        platform => platform,
    },
};

const VERSION_3: Version = Version {
    number: "3.0",
    ending: "_fmi3",
    functions: include_str!("fmi3.c"),
    description: template!("fmu/fmi3.xml.j2"),
    build: Some(template!("fmu/build.xml.j2")),
    folder: |platform| platform,
};

/// One FMU.
struct Fmu<'f> {
    request: &'f ExportRequest<'f>,
    version: &'f Version,
    /// The program with one entry.
    whole: ExportedProgram,
    /// Name of file, library and model.
    name: String,
}

/// Headers of C that a header of the same name would hide.
const HEADERS: &str = "float stdbool stddef stdint stdio stdlib string";

fn make(request: &ExportRequest, version: &Version) -> Result<Exported, Error> {
    named(request.name(), HEADERS)?;
    let whole = checked(request)?;
    let mut result = Exported { files: Vec::new(), functions: whole.functions(), notes: whole.notes.clone() };
    for entry in &whole.entries {
        let fmu = Fmu::new(request, version, &whole, entry);
        let mut files = fmu.files()?;
        match fmu.library(&files) {
            Ok(library) => files.push(library),
            Err(why) => result.notes.push(format!("{}.fmu contains sources only: {why}", fmu.name)),
        }
        result.files.push(File { name: format!("{}.fmu", fmu.name), bytes: File::archive(&files)? });
    }
    Ok(result)
}

/// The generating tool.
const TOOL: &str = concat!("piezoid ", env!("CARGO_PKG_VERSION"));

/// The folder of the sources.
const SOURCES: &str = "sources/";

impl<'f> Fmu<'f> {
    fn new(request: &'f ExportRequest<'f>, version: &'f Version, all: &ExportedProgram, entry: &Entry) -> Self {
        let mut whole = ExportedProgram { entries: vec![entry.clone()], notes: Vec::new(), ..all.clone() };
        whole.program.keep(&[entry.step]);
        Fmu { request, version, whole, name: entry.named(request.name()) + version.ending }
    }

    /// All files except the library.
    fn files(&self) -> Result<Vec<File>, Error> {
        let (request, version, model) = (self.request, self.version, self.request.model);
        let own = context! {
            fmu => &self.name, version => version.number, tool => TOOL, known => model.identified().map(|known| known.u),
        };
        let variables = variables::template_context(request, &self.whole.program, &self.whole.entries[0]);
        let all = context! { ..own, ..variables, ..template_context(request, &self.whole, &|_| String::new()) };
        let text = |template, token: &str| render(template, context! { token, ..all.clone() });
        // The part of this FMU, the common part, and the functions of the version.
        let wrapper = |token: &str| {
            let head = text(template!("fmu/wrapper.c.j2"), token)?;
            Ok([&head, include_str!("instance.c"), include_str!("kept.c"), version.functions].join("\n"))
        };
        let c = C::of(&self.whole, request);
        let [header, source] = c.pair()?;
        let token = token(&(text(version.description, "")? + &header + &source + &wrapper("")?));
        let mut files = vec![
            File::new("modelDescription.xml", text(version.description, &token)?),
            File::new("documentation/index.html", text(template!("fmu/index.html.j2"), &token)?),
            File::new(format!("{SOURCES}{}.h", request.name()), header),
            File::new(format!("{SOURCES}{}.c", request.name()), source),
            File::new(format!("{SOURCES}{}_fmu.c", self.name), wrapper(&token)?),
        ];
        if let Some(build) = version.build {
            files.push(File::new(format!("{SOURCES}buildDescription.xml"), text(build, &token)?));
        }
        Ok(files)
    }

    /// The library compiled from the sources among these files.
    fn library(&self, files: &[File]) -> Result<File, Error> {
        let none = "no C compiler was found; the importing tool must compile the sources";
        let compiler = self.request.compiler.ok_or_else(|| Error::Content(none.into()))?;
        let source = |file: &File| Some(File::new(file.name.strip_prefix(SOURCES)?, file.bytes.clone()));
        let bytes = (compiler.run)(&files.iter().filter_map(source).collect::<Vec<_>>())?;
        let extension = match compiler.platform.rsplit('-').next() {
            Some("windows") => "dll",
            Some("darwin") => "dylib",
            _ => "so",
        };
        let folder = (self.version.folder)(compiler.platform);
        Ok(File { name: format!("binaries/{folder}/{}.{extension}", self.name), bytes })
    }
}

/// The identifier shared by description and library: a hash of all they are made from (FNV-1a of 128 bits).
fn token(text: &str) -> String {
    let start: u128 = 0x6c62_272e_07bb_0142_62b8_2175_6295_c58d;
    let hash = text.bytes().fold(start, |hash, byte| (hash ^ u128::from(byte)).wrapping_mul((1 << 88) + 0x13b));
    let hex = format!("{hash:032x}");
    format!("{{{}-{}-{}-{}-{}}}", &hex[..8], &hex[8..12], &hex[12..16], &hex[16..20], &hex[20..])
}

#[cfg(test)]
mod tests {
    use super::super::Compiler;
    use super::*;
    use piezoid::hammerstein::Model;
    use piezoid::hysteresis::Operator;
    use piezoid::linear::Arx;
    use piezoid::record::Units;
    use roxmltree::Document;
    use std::io::{Cursor, Read};

    fn model(unit: &str) -> Model {
        let plays = (Operator::find("prandtl-ishlinskii").unwrap().example)(5e-4).unwrap();
        let model = Model::new(plays, Arx::new(5e-4, vec![1.6, -0.8], vec![0.1, 0.1]).unwrap(), 2.0).unwrap();
        model.with_units(Units { u: "V".into(), y: unit.into() })
    }

    fn result(version: &str, model: &Model, compiler: Option<Compiler>) -> Exported {
        (ExportTarget::find(version).unwrap().make)(&ExportRequest { compiler, ..ExportRequest::new(model, "bender") })
            .unwrap()
    }

    fn by(run: fn(&[File]) -> Result<Vec<u8>, Error>) -> Option<Compiler> {
        Some(Compiler { platform: "x86_64-linux", run })
    }

    fn text(file: &File, name: &str) -> String {
        let mut archive = zip::ZipArchive::new(Cursor::new(&file.bytes[..])).unwrap();
        let mut text = String::new();
        archive.by_name(name).unwrap().read_to_string(&mut text).unwrap();
        text
    }

    fn names(file: &File) -> Vec<String> {
        let archive = zip::ZipArchive::new(Cursor::new(&file.bytes[..])).unwrap();
        archive.file_names().map(|name| name.unwrap().into_owned()).collect()
    }

    #[test]
    fn the_library_is_compiled_from_the_sources_and_has_the_name_of_file_and_model() {
        let listed = by(|files| Ok(files.iter().map(|file| file.name.clone() + ";").collect::<String>().into()));
        for (version, name, folder) in [("fmu2", "bender_fmi2", "linux64"), ("fmu3", "bender_fmi3", "x86_64-linux")] {
            let result = result(version, &model("um"), listed);
            assert_eq!(result.files[0].name, format!("{name}.fmu"));
            let sources = text(&result.files[0], &format!("binaries/{folder}/{name}.so"));
            assert!(sources.starts_with(&format!("bender.h;bender.c;{name}_fmu.c;")), "{sources}");
            let xml = text(&result.files[0], "modelDescription.xml");
            let document = Document::parse(&xml).unwrap();
            let simulated = document.descendants().find(|n| n.has_tag_name("CoSimulation")).unwrap();
            let names = [document.root_element().attribute("modelName"), simulated.attribute("modelIdentifier")];
            assert_eq!(names, [Some(name); 2]);
        }
    }

    #[test]
    fn without_a_library_a_note_gives_the_reason() {
        let none = result("fmu3", &model("um"), None);
        assert!(none.notes.iter().any(|note| note.contains("no C compiler")), "{:?}", none.notes);
        let failed = result("fmu3", &model("um"), by(|_| Err(Error::Content("the disk is full".into()))));
        assert!(failed.notes.iter().any(|note| note.contains("the disk is full")), "{:?}", failed.notes);
        assert_eq!(failed.files, none.files);
        assert!(!names(&none.files[0]).iter().any(|name| name.starts_with("binaries")));
    }

    #[test]
    fn the_token_depends_on_the_model_alone() {
        let token = |version: &str, model: &Model, single: bool| {
            let request = ExportRequest::new(model, "bender").single(single);
            let result = (ExportTarget::find(version).unwrap().make)(&request).unwrap();
            let xml = text(&result.files[0], "modelDescription.xml");
            let attribute = if version == "fmu2" { "guid" } else { "instantiationToken" };
            let document = Document::parse(&xml).unwrap();
            let token = document.root_element().attribute(attribute).unwrap().to_owned();
            let wrapper = format!("sources/bender_fmi{}_fmu.c", &version[3..]);
            assert!(text(&result.files[0], &wrapper).contains(&format!("#define TOKEN \"{token}\"")));
            token
        };
        for version in ["fmu2", "fmu3"] {
            assert_eq!(result(version, &model("um"), None), result(version, &model("um"), None));
            let first = token(version, &model("um"), false);
            assert_eq!(first, token(version, &model("um"), false));
            assert_ne!(first, token(version, &model("nm"), false));
            assert_ne!(first, token(version, &model("um"), true));
        }
    }

    #[test]
    fn value_references_match_those_of_the_wrapper() {
        let model = model("um");
        let result = result("fmu3", &model, None);
        let xml = text(&result.files[0], "modelDescription.xml");
        let document = Document::parse(&xml).unwrap();
        let variables: Vec<_> = document.descendants().filter(|n| n.has_tag_name("Float64")).collect();
        for (k, variable) in variables.iter().enumerate() {
            assert_eq!(variable.attribute("valueReference"), Some(k.to_string().as_str()));
        }
        let names: Vec<&str> = variables.iter().map(|v| v.attribute("name").unwrap()).collect();
        assert_eq!(names[..7], ["time", "u", "u_gain", "u_offset", "y", "ts", "state.hysteresis.last"]);
        // The last field is the input that was taken.
        let order = model.program().unwrap().order("state") + 1;
        assert_eq!(names.len(), 6 + order);
        let wrapper = text(&result.files[0], "sources/bender_fmi3_fmu.c");
        let variables = format!("VARIABLES = {},", 6 + order);
        for line in ["GAIN = 2,", "OFFSET = 3,", "OUTPUT = 4,", "PERIOD = 5,", "STATE = 6,", &variables] {
            assert!(wrapper.contains(line), "{line}");
        }
    }

    #[test]
    fn names_of_headers_are_errors() {
        let model = model("um");
        let error = (ExportTarget::find("fmu2").unwrap().make)(&ExportRequest::new(&model, "stdio")).unwrap_err();
        assert!(error.to_string().contains("reserved word"), "{error}");
    }

    #[test]
    fn known_units_are_related_to_si_units_and_units_are_escaped() {
        let units = |unit: &str| {
            let xml = text(&result("fmu2", &model(unit), None).files[0], "modelDescription.xml");
            let document = Document::parse(&xml).unwrap();
            let found = document.descendants().find(|n| n.has_tag_name("Unit") && n.attribute("name") == Some(unit));
            let base = found.unwrap().first_element_child();
            base.map(|base| (base.attribute("m").map(String::from), base.attribute("factor").map(String::from)))
        };
        assert_eq!(units("um"), Some((Some("1".into()), Some("1e-6".into()))));
        assert_eq!(units("m"), Some((Some("1".into()), None)));
        assert_eq!(units("<a> & \"b\""), None);
    }
}
