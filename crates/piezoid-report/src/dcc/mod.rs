//! A certificate as Digital Calibration Certificate: XML after the schema DCC 3.3.0 of the PTB, with the units of D-SI
//! 2.2.1. One result is the expanded uncertainty, the others are those of the records and bands, and the contributions
//! of the budget.
//!
//! The schema asks for a date and a country; a name that is not stated is written as such. A signature is left to its
//! issuer.
//!
//! Reference: Hackel et al. 2017, doi:10.7795/310.20170403; <https://www.ptb.de/dcc/v3.3.0/>.

use crate::plot::{allowed, escape};
use crate::report::{METHOD, STATEMENT};
use piezoid_numerics::error::Error;
use piezoid_numerics::number::exact;
use piezoid_verbs::{Budget, Certificate, Contribution};
use serde_json::Value;

/// The version of the schema.
const SCHEMA: &str = "3.3.0";

/// What stands for a name that is not stated.
const NOT_STATED: &str = "not stated";

/// The document of a certificate.
///
/// # Errors
/// Returns an error without a date and a country, and for a displacement that is in no unit of length.
pub fn dcc(certificate: &Certificate) -> Result<String, Error> {
    let options = &certificate.options;
    let missing: Vec<(&'static str, Value)> = [("date", &options.date), ("country", &options.country)]
        .into_iter()
        .filter(|(_, value)| value.is_none())
        .map(|(name, _)| (name, Value::Null))
        .collect();
    let (Some(date), Some(country)) = (&options.date, &options.country) else {
        let error = Error::Content("a Digital Calibration Certificate has a date and a country: ".into());
        return Err(error.needing(missing));
    };
    let unit = length(&certificate.units.y)?;
    let k = certificate.worst().1.k;
    if k < 1.0 {
        let rule = format!("gives the coverage factor {k:.3}: D-SI asks for 1 or more, and thus for 68.27 % or more");
        return Err(Error::parameter("coverage", options.coverage, rule));
    }
    let root = Element::new("dcc:digitalCalibrationCertificate")
        .with("xmlns:dcc", "https://ptb.de/dcc")
        .with("xmlns:si", "https://ptb.de/si")
        .with("xmlns:xsi", "http://www.w3.org/2001/XMLSchema-instance")
        .with("xsi:schemaLocation", format!("https://ptb.de/dcc https://ptb.de/dcc/v{SCHEMA}/dcc.xsd"))
        .with("schemaVersion", SCHEMA)
        .child(administrative(certificate, date, country))
        .child(Element::new("dcc:measurementResults").child(results(certificate, unit)));
    let mut text = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    root.write(&mut text, 0);
    Ok(text)
}

fn administrative(certificate: &Certificate, date: &str, country: &str) -> Element {
    let options = &certificate.options;
    let stated = |name: &Option<String>| name.as_deref().map(collapsed).unwrap_or_else(|| NOT_STATED.into());
    let issuer = stated(&options.issuer);
    let core = Element::new("dcc:coreData")
        .text("dcc:countryCodeISO3166_1", country)
        .text("dcc:usedLangCodeISO639_1", "en")
        .text("dcc:mandatoryLangCodeISO639_1", "en")
        .text("dcc:uniqueIdentifier", collapsed(&certificate.number()))
        .text("dcc:beginPerformanceDate", options.measured.as_deref().unwrap_or(date))
        .text("dcc:endPerformanceDate", options.measured.as_deref().unwrap_or(date))
        .text("dcc:performanceLocation", "other")
        .text("dcc:issueDate", date);
    let identification = |issuer: &str, value: String, name: &str| {
        let value = Element::new("dcc:identification").text("dcc:issuer", issuer).text("dcc:value", value);
        value.child(named("dcc:name", name))
    };
    let model = identification("other", certificate.model_sha256.clone(), "SHA-256 of the file of the model");
    let serial = identification("manufacturer", stated(&options.serial), "serial number");
    let records = certificate.records.iter().map(|record| {
        let hash = &record.origin.sha256;
        let hash = if hash.is_empty() { "in no file".into() } else { hash.clone() };
        identification("other", hash, &format!("SHA-256 of the record {}", record.compared.short()))
    });
    let identifications = Element::new("dcc:identifications").child(serial).child(model).children(records);
    let item = Element::new("dcc:item")
        .child(named("dcc:name", &stated(&options.item)))
        .child(named("dcc:description", &format!("piezo actuator with a model of it: {}", certificate.model)))
        .child(identifications);
    // Names of people and firms are in no language.
    let contact = |element: &str, name: String, location: Element| {
        let name = Element::new("dcc:name").text("dcc:content", name);
        Element::new(element).child(name).child(Element::new("dcc:location").child(location))
    };
    let country = Element::leaf("dcc:countryCode", country);
    let unknown = Element::new("dcc:further").text("dcc:content", NOT_STATED);
    let person = options.person.as_deref().map(collapsed).unwrap_or_else(|| issuer.clone());
    let person = Element::new("dcc:person").child(Element::new("dcc:name").text("dcc:content", person));
    let statement = |name: &str, text: &str| {
        let declaration = named("dcc:declaration", text);
        Element::new("dcc:statement").child(named("dcc:name", name)).child(declaration)
    };
    let not_stated = (!certificate.not_stated.is_empty()).then(|| {
        let all = certificate.not_stated.join(", ");
        statement("not stated, not included", &format!("No uncertainty is stated for: {all}."))
    });
    let remarks = certificate.remarks.iter().map(|remark| statement("remark", remark));
    Element::new("dcc:administrativeData")
        .child(Element::new("dcc:dccSoftware").child(software()))
        .child(core)
        .child(Element::new("dcc:items").child(item))
        .child(Element::new("dcc:calibrationLaboratory").child(contact("dcc:contact", issuer, country)))
        .child(
            Element::new("dcc:respPersons")
                .child(Element::new("dcc:respPerson").child(person).text("dcc:mainSigner", "true")),
        )
        .child(contact("dcc:customer", stated(&options.customer), unknown))
        .child(
            Element::new("dcc:statements")
                .child(statement("statement by its issuer", STATEMENT))
                .children(not_stated)
                .children(remarks),
        )
}

fn software() -> Element {
    let version = format!("v{}", env!("CARGO_PKG_VERSION"));
    let name = Element::new("dcc:name").text("dcc:content", "piezoid");
    Element::new("dcc:software").child(name).text("dcc:release", version).text("dcc:type", "application")
}

fn results(certificate: &Certificate, unit: &str) -> Element {
    let (options, domain) = (&certificate.options, certificate.domain());
    let method = Element::new("dcc:usedMethod")
        .child(named("dcc:name", "free run of the model against the records"))
        .child(named("dcc:description", METHOD))
        .text("dcc:norm", "JCGM 100:2008");
    let sensor = options.sensor.as_deref().map(|sensor| {
        let sensor = Element::new("dcc:measuringEquipment").child(named("dcc:name", &collapsed(sensor)));
        Element::new("dcc:measuringEquipments").child(sensor)
    });
    let condition = |name: &str, quantities: Vec<Element>| {
        let data = Element::new("dcc:data").children(quantities);
        Element::new("dcc:influenceCondition").child(named("dcc:name", name)).child(data)
    };
    let ends = |name: &str, ends: Option<[f64; 2]>, unit: &str| {
        let [low, high] = ends?;
        let both = vec![quantity("lowest", real(low, unit)), quantity("highest", real(high, unit))];
        Some(condition(name, both))
    };
    let temperature = options.temperature.map(|t| {
        let half_width = options.temperature_half_width.map(|k| quantity("half-width", real(k, "\\kelvin")));
        let both = std::iter::once(quantity("temperature", real(t, "\\degreecelsius"))).chain(half_width);
        condition("temperature", both.collect())
    });
    let conditions = [
        match electric(&certificate.units.u) {
            Some(volt) => ends("range of the voltage", domain.map(|d| d.u), volt),
            // D-SI has no such unit.
            None => domain.map(|d| {
                let text = format!("{} to {} {}", exact(d.u[0]), exact(d.u[1]), certificate.units.u);
                let both = quantity("lowest and highest", named("dcc:noQuantity", &text));
                condition("range of the voltage", vec![both])
            }),
        },
        ends("range of the frequency", domain.and_then(|d| d.hz), "\\hertz"),
        ends("range of the displacement", Some(certificate.stroke()), unit),
        temperature,
    ];
    let digit = |x: f64| certificate.digit.text(x);
    let (worst, budget) = certificate.worst();
    let factor = (budget.k, options.coverage);
    let correction = certificate.correction.unwrap_or(0.0);
    // The correction of a prediction, 0 if there is none, with the uncertainty of the corrected displacement.
    let certified = expanded(digit(correction), unit, digit(certificate.expanded), factor);
    let main = result("correction of the predicted displacement", certificate.measurand())
        .child(Element::new("dcc:data").child(quantity("correction of the predicted displacement", certified)));
    let part = |name: String, value: f64, budget: &Budget| {
        let uncertainty = short(budget.expanded);
        quantity(&name, expanded(short(value), unit, uncertainty, (budget.k, options.coverage)))
    };
    let records = certificate.records.iter().map(|r| part(r.compared.short().into(), r.mean_error, &r.budget));
    let records = result("mean error of each record", "Measured less predicted displacement.")
        .child(Element::new("dcc:data").child(Element::new("dcc:list").children(records)));
    let bands = certificate.bands.iter().map(|band| part(band.name(), 0.0, &band.budget));
    let bands = (!certificate.bands.is_empty()).then(|| {
        let text = "Correction of the predicted displacement, by the frequency of the voltage.";
        result("bands of frequencies", text)
            .child(Element::new("dcc:data").child(Element::new("dcc:list").children(bands)))
    });
    let row = |row: &Contribution| {
        let nu = row.degrees_of_freedom.map_or("infinitely many".into(), short);
        let about = format!(
            "{}; type {:?}, {}, {nu} degrees of freedom, {:.1} % of the variance",
            row.because, row.evaluation, row.distribution, row.share_percent
        );
        let value = real_of(short(row.contribution), unit);
        Element::new("dcc:quantity")
            .child(named("dcc:name", row.source))
            .child(named("dcc:description", &about))
            .child(value)
    };
    let contributions = result(&format!("uncertainty budget of {worst}"), "Contributions to the standard uncertainty.")
        .child(Element::new("dcc:data").child(Element::new("dcc:list").children(budget.rows.iter().map(row))));
    let within = result("share of the samples within", "Share of the samples of the records within the uncertainty.")
        .child(Element::new("dcc:data").child(quantity("share", real(0.01 * certificate.within_percent(), "\\one"))));
    let results = Element::new("dcc:results").child(main).child(records).children(bands);
    Element::new("dcc:measurementResult")
        .child(named("dcc:name", "displacement predicted by the model"))
        .child(Element::new("dcc:usedMethods").child(method))
        .child(Element::new("dcc:usedSoftware").child(software()))
        .children(sensor)
        .child(Element::new("dcc:influenceConditions").children(conditions.into_iter().flatten()))
        .child(results.child(contributions).child(within))
}

fn result(name: &str, about: &str) -> Element {
    Element::new("dcc:result").child(named("dcc:name", name)).child(named("dcc:description", about))
}

fn quantity(name: &str, value: Element) -> Element {
    Element::new("dcc:quantity").child(named("dcc:name", name)).child(value)
}

fn real(value: f64, unit: &str) -> Element {
    real_of(exact(value), unit)
}

fn real_of(value: String, unit: &str) -> Element {
    Element::new("si:real").text("si:value", value).text("si:unit", unit)
}

fn expanded(value: String, unit: &str, uncertainty: String, (k, coverage): (f64, f64)) -> Element {
    let expanded = Element::new("si:expandedMU")
        .text("si:valueExpandedMU", uncertainty)
        .text("si:coverageFactor", format!("{k:.4}"))
        .text("si:coverageProbability", exact(coverage / 100.0));
    real_of(value, unit).child(Element::new("si:measurementUncertaintyUnivariate").child(expanded))
}

/// A number with four digits, as XML Schema writes decimals.
fn short(x: f64) -> String {
    piezoid_numerics::number::short(x)
}

/// A text in English.
fn named(element: &str, text: &str) -> Element {
    Element::new(element).child(Element::leaf("dcc:content", text).with("lang", "en"))
}

/// A text without spaces at its ends and without several in a row, as the schema asks for; never empty. Characters that
/// [`escape`] removes count as spaces: left in, they would leave the text empty, or with a space at an end.
fn collapsed(text: &str) -> String {
    let words = text.split(|c: char| c.is_whitespace() || !allowed(c)).filter(|word| !word.is_empty());
    let text = words.collect::<Vec<_>>().join(" ");
    if text.is_empty() { NOT_STATED.into() } else { text }
}

/// The D-SI unit of a length.
fn length(unit: &str) -> Result<&'static str, Error> {
    match unit {
        "um" => Ok("\\micro\\metre"),
        "nm" => Ok("\\nano\\metre"),
        "mm" => Ok("\\milli\\metre"),
        "m" => Ok("\\metre"),
        _ => Err(Error::units("the displacement of the certificate", unit, "um, nm, mm or m")),
    }
}

/// The D-SI unit of a voltage, if it is one.
fn electric(unit: &str) -> Option<&'static str> {
    match unit {
        "V" => Some("\\volt"),
        "mV" => Some("\\milli\\volt"),
        "uV" => Some("\\micro\\volt"),
        "kV" => Some("\\kilo\\volt"),
        _ => None,
    }
}

/// An element with attributes, and either text or elements.
#[derive(Debug, Clone, PartialEq, Default)]
struct Element {
    name: String,
    attributes: Vec<(&'static str, String)>,
    text: String,
    children: Vec<Element>,
}

impl Element {
    fn new(name: &str) -> Self {
        Element { name: name.into(), ..Element::default() }
    }

    fn leaf(name: &str, text: impl Into<String>) -> Self {
        Element { text: text.into(), ..Element::new(name) }
    }

    fn with(mut self, name: &'static str, value: impl Into<String>) -> Self {
        self.attributes.push((name, value.into()));
        self
    }

    fn child(mut self, child: Element) -> Self {
        self.children.push(child);
        self
    }

    fn children(mut self, children: impl IntoIterator<Item = Element>) -> Self {
        self.children.extend(children);
        self
    }

    fn text(self, name: &str, text: impl Into<String>) -> Self {
        self.child(Element::leaf(name, text))
    }

    fn write(&self, out: &mut String, depth: usize) {
        let (indent, name) = ("  ".repeat(depth), &self.name);
        let attributes: String =
            self.attributes.iter().map(|(name, value)| format!(" {name}=\"{}\"", escape(value))).collect();
        if self.children.is_empty() {
            *out += &format!("{indent}<{name}{attributes}>{}</{name}>\n", escape(&self.text));
            return;
        }
        *out += &format!("{indent}<{name}{attributes}>\n");
        self.children.iter().for_each(|child| child.write(out, depth + 1));
        *out += &format!("{indent}</{name}>\n");
    }
}

#[cfg(test)]
mod tests;
