//! FMI 3.0.

use super::super::{CODE, Target};
use super::variables::{Role, Variable, units};
use super::xml::Element;
use super::{Fmu, Version, make};
use piezoid::system::System;

pub(in super::super) const TARGET: Target = Target {
    name: "fmu3",
    summary: "co-simulation units of FMI 3.0, with C sources and, where there is a compiler, a shared library",
    reference: "Functional Mock-up Interface 3.0.2, https://fmi-standard.org",
    heeds: CODE,
    make: |wanted| make(wanted, &VERSION),
};

const VERSION: Version = Version {
    number: "3.0",
    functions: include_str!("fmi3.c"),
    description,
    build: Some(build),
    folder: |platform| platform,
};

fn description(fmu: &Fmu, token: &str) -> String {
    let ts = format!("{:?}", fmu.wanted.model.ts());
    let simulation = Element::new("CoSimulation")
        .with("modelIdentifier", &fmu.name)
        .with("canGetAndSetFMUState", true)
        .with("canSerializeFMUState", true)
        .with("canHandleVariableCommunicationStepSize", false)
        .with("fixedInternalStepSize", &ts);
    let float = |(reference, v): (usize, &Variable)| {
        let (causality, variability, initial) = v.role.words();
        Element::new("Float64")
            .with("name", &v.name)
            .with("valueReference", reference)
            .with("description", &v.about)
            .with("causality", causality)
            .with("variability", variability)
            .maybe("initial", initial)
            .maybe("unit", Some(&v.unit).filter(|unit| !unit.is_empty()))
            .maybe("start", v.start.map(|start| format!("{start:?}")))
    };
    // What is set at a communication point shows after the next step only.
    let outputs = || fmu.variables.iter().enumerate().filter(|(_, v)| v.role == Role::Output).map(|(k, _)| k);
    let unknown = |kind, reference: usize| Element::new(kind).with("valueReference", reference);
    let structure = Element::new("ModelStructure")
        .hold(outputs().map(|k| unknown("Output", k).with("dependencies", "")))
        .hold(outputs().map(|k| unknown("InitialUnknown", k)));
    let category =
        |(name, about): &(&str, &str)| Element::new("Category").with("name", name).with("description", about);
    Element::new("fmiModelDescription")
        .with("fmiVersion", fmu.version.number)
        .with("modelName", &fmu.name)
        .with("instantiationToken", token)
        .with("description", &fmu.entry().about)
        .with("generationTool", super::TOOL)
        .with("variableNamingConvention", "structured")
        .hold([
            simulation,
            Element::new("UnitDefinitions").hold(units(&fmu.variables)),
            Element::new("LogCategories").hold(super::CATEGORIES.iter().map(category)),
            Element::new("DefaultExperiment").with("startTime", 0).with("stepSize", &ts),
            Element::new("ModelVariables").hold(fmu.variables.iter().enumerate().map(float)),
            structure,
        ])
        .document()
}

fn build(fmu: &Fmu) -> String {
    let [_, code, wrapper] = fmu.names();
    let file = |name: String| Element::new("SourceFile").with("name", name);
    let set = Element::new("SourceFileSet").with("language", "C99").hold([file(code), file(wrapper)]);
    Element::new("fmiBuildDescription")
        .with("fmiVersion", fmu.version.number)
        .hold([Element::new("BuildConfiguration").with("modelIdentifier", &fmu.name).hold([set])])
        .document()
}
