//! FMI 2.0.

use super::super::{CODE, Target};
use super::variables::{Role, Variable, units};
use super::xml::Element;
use super::{Fmu, Version, make};
use piezoid::system::System;

pub(in super::super) const TARGET: Target = Target {
    name: "fmu2",
    summary: "co-simulation units of FMI 2.0, with C sources and, where there is a compiler, a shared library",
    reference: "Functional Mock-up Interface 2.0.5, https://fmi-standard.org",
    heeds: CODE,
    make: |wanted| make(wanted, &VERSION),
};

const VERSION: Version = Version {
    number: "2.0",
    functions: include_str!("fmi2.c"),
    description,
    build: None,
    folder: |platform| match platform {
        "x86_64-linux" => "linux64",
        "x86_64-windows" => "win64",
        "x86_64-darwin" => "darwin64",
        // This version names no others.
        platform => platform,
    },
};

fn description(fmu: &Fmu, token: &str) -> String {
    let [_, code, wrapper] = fmu.names();
    let file = |name: String| Element::new("File").with("name", name);
    let simulation = Element::new("CoSimulation")
        .with("modelIdentifier", &fmu.name)
        .with("canHandleVariableCommunicationStepSize", false)
        .with("canNotUseMemoryManagementFunctions", true)
        .with("canGetAndSetFMUstate", true)
        .with("canSerializeFMUstate", true)
        .hold([Element::new("SourceFiles").hold([file(code), file(wrapper)])]);
    let scalar = |(reference, v): (usize, &Variable)| {
        let (causality, variability, initial) = v.role.words();
        let real = Element::new("Real")
            .maybe("unit", Some(&v.unit).filter(|unit| !unit.is_empty()))
            .maybe("start", v.start.map(|start| format!("{start:?}")));
        Element::new("ScalarVariable")
            .with("name", &v.name)
            .with("valueReference", reference)
            .with("description", &v.about)
            .with("causality", causality)
            .with("variability", variability)
            .maybe("initial", initial)
            .hold([real])
    };
    // The time need not be among the variables, and importers that are built on FMI Library want a start value of it.
    let listed = || fmu.variables.iter().enumerate().filter(|(_, v)| v.role != Role::Time);
    // Places in the list are counted from 1. What is set at a communication point shows after the next step only.
    let outputs = || listed().zip(1..).filter(|((_, v), _)| v.role == Role::Output).map(|(_, index)| index);
    let unknown = |index: usize| Element::new("Unknown").with("index", index);
    let structure = Element::new("ModelStructure").hold([
        Element::new("Outputs").hold(outputs().map(|index| unknown(index).with("dependencies", ""))),
        Element::new("InitialUnknowns").hold(outputs().map(unknown)),
    ]);
    let category =
        |(name, about): &(&str, &str)| Element::new("Category").with("name", name).with("description", about);
    Element::new("fmiModelDescription")
        .with("fmiVersion", fmu.version.number)
        .with("modelName", &fmu.name)
        .with("guid", token)
        .with("description", &fmu.entry().about)
        .with("generationTool", super::TOOL)
        .with("variableNamingConvention", "structured")
        .with("numberOfEventIndicators", 0)
        .hold([
            simulation,
            Element::new("UnitDefinitions").hold(units(&fmu.variables)),
            Element::new("LogCategories").hold(super::CATEGORIES.iter().map(category)),
            Element::new("DefaultExperiment")
                .with("startTime", 0)
                .with("stepSize", format!("{:?}", fmu.wanted.model.ts())),
            Element::new("ModelVariables").hold(listed().map(scalar)),
            structure,
        ])
        .document()
}
