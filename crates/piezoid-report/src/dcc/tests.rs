//! The document against the rules of the schema, as far as the certificate uses them. The Schematron of dcclib, and its
//! schema where it can be fetched, are tried in the tests of the command line.

use super::*;
use crate::report::example_certificate as example;
use piezoid_verbs::{CertificateOptions, MeanError};

/// The children of an element in DCC 3.3.0 and D-SI 2.2.1, in their order; `?` may be missing, `+` may repeat, `*`
/// both.
/// Those that a certificate does not use are left out, unless they must be there.
const CHILDREN: [(&str, &str); 33] = [
    ("digitalCalibrationCertificate", "administrativeData measurementResults"),
    ("administrativeData", "dccSoftware coreData items calibrationLaboratory respPersons customer statements?"),
    ("dccSoftware", "software+"),
    ("usedSoftware", "software+"),
    ("software", "name release type?"),
    (
        "coreData",
        "countryCodeISO3166_1 usedLangCodeISO639_1+ mandatoryLangCodeISO639_1+ uniqueIdentifier beginPerformanceDate \
         endPerformanceDate performanceLocation issueDate?",
    ),
    ("items", "item+"),
    ("item", "name description? identifications"),
    ("identifications", "identification+"),
    ("identification", "issuer value name?"),
    ("calibrationLaboratory", "contact"),
    ("contact", "name location"),
    ("customer", "name location"),
    ("location", "countryCode* further*"),
    ("respPersons", "respPerson+"),
    ("respPerson", "person mainSigner?"),
    ("person", "name"),
    ("statements", "statement+"),
    ("statement", "name? declaration?"),
    ("measurementResults", "measurementResult+"),
    ("measurementResult", "name usedMethods? usedSoftware? measuringEquipments? influenceConditions? results"),
    ("usedMethods", "usedMethod+"),
    ("usedMethod", "name description? norm*"),
    ("measuringEquipments", "measuringEquipment+"),
    ("measuringEquipment", "name"),
    ("influenceConditions", "influenceCondition+"),
    ("influenceCondition", "name data"),
    ("results", "result+"),
    ("result", "name description? data"),
    ("quantity", "name? description? noQuantity? real?"),
    ("real", "value unit measurementUncertaintyUnivariate?"),
    ("measurementUncertaintyUnivariate", "expandedMU"),
    ("expandedMU", "valueExpandedMU coverageFactor coverageProbability"),
];

/// Elements with any number of these.
const CONTAINERS: [(&str, &str); 7] = [
    ("data", "quantity list"),
    ("list", "quantity"),
    ("name", "content"),
    ("description", "content"),
    ("declaration", "content"),
    ("further", "content"),
    ("noQuantity", "content"),
];

/// What is wrong with an element and with those in it.
fn faults(node: roxmltree::Node, found: &mut Vec<String>) {
    let name = node.tag_name().name();
    let children: Vec<&str> = node.children().filter(|n| n.is_element()).map(|n| n.tag_name().name()).collect();
    let expected = CHILDREN.iter().find(|(known, _)| *known == name).map(|(_, list)| *list);
    let container = CONTAINERS.iter().find(|(known, _)| *known == name).map(|(_, list)| *list);
    let mut left = children.as_slice();
    match (expected, container) {
        (Some(list), _) => {
            for one in list.split_whitespace() {
                let child = one.trim_end_matches(['?', '+', '*']);
                let count = left.iter().take_while(|name| **name == child).count();
                let taken = if one.ends_with(['+', '*']) { count } else { count.min(1) };
                if taken == 0 && !one.ends_with(['?', '*']) {
                    found.push(format!("{name} has no {child}"));
                }
                left = &left[taken..];
            }
            found.extend(left.first().map(|child| format!("{name} has {child} where the schema has none")));
        }
        (None, Some(list)) => {
            let known: Vec<&str> = list.split_whitespace().collect();
            found.extend(children.iter().find(|c| !known.contains(c)).map(|c| format!("{name} has {c}")));
            if children.is_empty() {
                found.push(format!("{name} is empty"));
            }
        }
        (None, None) if !children.is_empty() => found.push(format!("{name} is unknown")),
        // Texts that must not be empty, and must not begin or end with a space.
        (None, None) => {
            let text = node.text().unwrap_or_default();
            if text.is_empty() || text.trim() != text {
                found.push(format!("{name} is {text:?}"));
            }
        }
    }
    let namespace = if ["real", "expandedMU", "measurementUncertaintyUnivariate"].contains(&name)
        || node.parent().is_some_and(|p| ["real", "expandedMU"].contains(&p.tag_name().name()))
    {
        "https://ptb.de/si"
    } else {
        "https://ptb.de/dcc"
    };
    if node.tag_name().namespace() != Some(namespace) {
        found.push(format!("{name} is not of {namespace}"));
    }
    node.children().filter(|n| n.is_element()).for_each(|child| faults(child, found));
}

fn options() -> CertificateOptions {
    let text = |text: &str| Some(text.to_string());
    CertificateOptions {
        date: text("2026-11-30"),
        country: text("CZ"),
        temperature: Some(22.5),
        temperature_coefficient: text("0.01"),
        temperature_half_width: Some(2.0),
        sensor: text("capacitive <no. 7>"),
        issuer: text("  Our   institute "),
        mean_error: MeanError::Corrected,
        ..CertificateOptions::default()
    }
}

#[test]
fn the_document_keeps_the_order_and_the_names_of_the_schema() {
    for options in
        [options(), CertificateOptions { date: options().date, country: options().country, ..Default::default() }]
    {
        let found = example(options);
        let text = dcc(&found).unwrap();
        assert_eq!(text, dcc(&found).unwrap());
        let document = roxmltree::Document::parse(&text).unwrap();
        let mut wrong = Vec::new();
        faults(document.root_element(), &mut wrong);
        assert!(wrong.is_empty(), "{wrong:?}");
        assert_eq!(document.root_element().attribute("schemaVersion"), Some("3.3.0"));
    }
}

#[test]
fn a_range_in_a_unit_that_is_no_voltage_is_a_text() {
    let mut found = example(options());
    found.units.u = "counts".into();
    let text = dcc(&found).unwrap();
    let mut wrong = Vec::new();
    faults(roxmltree::Document::parse(&text).unwrap().root_element(), &mut wrong);
    assert!(wrong.is_empty() && text.contains(" counts<"), "{wrong:?} {text}");
}

#[test]
fn characters_that_xml_forbids_leave_no_text_empty_or_with_a_space_at_an_end() {
    let text = |text: &str| Some(text.to_string());
    let number = text("\u{2} 17\u{ffff}");
    let found = example(CertificateOptions { number, serial: text("\u{1}"), person: text(" \u{7f} "), ..options() });
    let text = dcc(&found).unwrap();
    let document = roxmltree::Document::parse(&text).unwrap();
    let mut wrong = Vec::new();
    faults(document.root_element(), &mut wrong);
    assert!(wrong.is_empty() && text.contains(">17<"), "{wrong:?} {text}");
}

#[test]
fn the_document_has_the_numbers_of_the_certificate() {
    let found = example(options());
    let text = dcc(&found).unwrap();
    let document = roxmltree::Document::parse(&text).unwrap();
    let all = |name: &str| -> Vec<String> {
        document
            .descendants()
            .filter(|n| n.has_tag_name(("https://ptb.de/si", name)))
            .filter_map(|n| n.text())
            .map(String::from)
            .collect()
    };
    assert_eq!(all("valueExpandedMU")[0], found.digit.text(found.expanded));
    assert_eq!(all("coverageProbability")[0], "0.9545");
    assert!((all("coverageFactor")[0].parse::<f64>().unwrap() - found.worst().1.k).abs() < 1e-4);
    let units = all("unit");
    assert!(
        ["\\micro\\metre", "\\volt", "\\hertz", "\\degreecelsius", "\\kelvin", "\\one"]
            .iter()
            .all(|u| units.iter().any(|v| v == u))
    );
    let correction = document.descendants().find(|n| n.has_tag_name(("https://ptb.de/dcc", "result"))).unwrap();
    let value = correction.descendants().find(|n| n.has_tag_name(("https://ptb.de/si", "value"))).unwrap();
    assert_eq!(value.text(), Some(&*found.digit.text(found.correction.unwrap())));
    assert!(text.contains("capacitive &lt;no. 7&gt;") && text.contains(">Our institute<"));
    assert!(text.contains("not issued by an accredited laboratory") && text.contains("No uncertainty is stated for: "));
}

#[test]
fn a_document_without_date_or_country_and_with_a_small_coverage_is_refused() {
    let refused = |options| dcc(&example(options)).unwrap_err().to_string();
    let none = refused(CertificateOptions::default());
    assert!(none.ends_with("has a date and a country: give `date`, `country`"), "{none}");
    assert!(refused(CertificateOptions { country: None, ..options() }).ends_with("give `country`"));
    let small = refused(CertificateOptions { coverage: 20.0, ..options() });
    assert!(small.starts_with("coverage = 20: gives the coverage factor 0."), "{small}");
}
