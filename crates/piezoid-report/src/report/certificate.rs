//! The certificate as a page: result, budget, records, conditions and range, and how it was computed.

use crate::each::Each;
use crate::page::{Cell, Fact, Page, PageTable, Section, Text, sentence};
use crate::plot::{Axes, Axis, Figure, Role, Series};
use piezoid_numerics::number::{round, short};
use piezoid_verbs::{Budget, Certificate, CertifiedBand, CertifiedRecord, Contribution, Evaluation, share};

/// What a certificate is not.
pub(crate) const STATEMENT: &str = "This certificate is a statement by its issuer. It was not issued by an accredited \
    laboratory, and nobody has examined what the issuer states. Its numbers were computed from the records and from \
    these statements.";

/// How it was computed.
pub(crate) const METHOD: &str = "Evaluated after JCGM 100:2008 (GUM). Standard uncertainties are added in squares with \
    their sensitivity coefficients (5.1.2), the coverage factor is the quantile of Student's t-distribution (G.3) for \
    the effective degrees of freedom of Welch and Satterthwaite (G.4.1), and the expanded uncertainty is rounded up to \
    two digits (7.2.6). The error of the model and the noise are measured on the records (4.2); what is stated is \
    evaluated after 4.3. The degrees of freedom of the error of the model count independent errors: successive errors \
    depend on each other.";

/// The page: one self-contained file.
pub fn certificate(certificate: &Certificate) -> Page {
    let options = &certificate.options;
    let title = match &options.item {
        Some(item) => format!("Calibration certificate: {item}"),
        None => "Calibration certificate".into(),
    };
    Page::new(title)
        .subtitle(format!("of a displacement that a model predicts: {}", certificate.model))
        .section(result(certificate))
        .section(budget(certificate))
        .section(records(certificate))
        .each((!certificate.bands.is_empty()).then(|| bands(certificate)), Page::section)
        .section(range(certificate))
        .section(names(certificate))
}

fn result(certificate: &Certificate) -> Section {
    let (worst, budget) = certificate.worst();
    let y = &certificate.units.y;
    let Certificate { digit, expanded, options, .. } = certificate;
    let correction = certificate
        .correction
        .map(|value| Fact::new(digit.text(value), y.clone(), "correction: add it to every prediction"));
    let probability = format!("coverage factor, for a coverage probability of {} %", options.coverage);
    let facts = [
        Fact::new(
            format!("±{}", digit.text(*expanded)),
            y.clone(),
            "expanded uncertainty of the predicted displacement",
        ),
        Fact::new(format!("{:.2}", budget.k), "", probability),
        Fact::new(share(certificate.within_percent()), "%", "of all samples of the records are within"),
    ];
    Section::new("Result")
        .facts(facts.into_iter().chain(correction))
        .text(sentence(&format!("measurand: {}", certificate.measurand())))
        .text(format!(
            "The uncertainty is the largest of all records and bands: that of {worst}. Predictions are given to the \
             same digit. It holds within the ranges of voltage, frequency and displacement below."
        ))
        .warning("A statement by its issuer", STATEMENT)
        .each(not_stated(certificate), |section, text| section.warning("Not stated, not included", text))
        .each((!certificate.remarks.is_empty()).then_some(()), |section, ()| {
            section.heading("Remarks").list(certificate.remarks.iter().map(|remark| format!("{remark}.")))
        })
}

fn not_stated(certificate: &Certificate) -> Option<String> {
    let all = certificate.not_stated.join(", ");
    (!all.is_empty()).then(|| format!("No uncertainty is stated for these sources, and none is in the budget: {all}."))
}

fn degrees(nu: Option<f64>) -> String {
    nu.map_or("∞".into(), short)
}

fn budget(certificate: &Certificate) -> Section {
    let (worst, budget) = certificate.worst();
    let y = &certificate.units.y;
    let table = PageTable::new(format!("Uncertainty budget of {worst}")).text("source").number("value x").text("type");
    let table = table.number("divisor").number("u(x)").number("c").number(format!("c u(x) [{y}]"));
    let table = table.number("ν").number("share [%]");
    let row = |row: &Contribution| {
        let kind = if row.evaluation == Evaluation::A { "A" } else { "B" };
        let per = if row.unit == *y { String::new() } else { format!(" {y}/{}", row.unit) };
        let cells = [
            row.source.into(),
            format!("{} {}", short(row.value), row.unit),
            format!("{kind}, {}", row.distribution),
            short(row.divisor),
            format!("{} {}", short(row.standard), row.unit),
            format!("{}{per}", round(row.sensitivity)),
            short(row.contribution),
            degrees(row.degrees_of_freedom),
            format!("{:.1}", row.share_percent),
        ];
        cells.map(|text| if row.contribution == 0.0 { Cell::from(text).muted() } else { text.into() })
    };
    let total = |what: &str, value: String, nu: String, share: &str| {
        let empty = String::new;
        [what.into(), empty(), empty(), empty(), empty(), empty(), value, nu, share.into()].map(Cell::from)
    };
    let Budget { standard, degrees_of_freedom, k, expanded, .. } = budget;
    let sources = budget.rows.iter().map(|row| format!("{}: {}", row.source, row.because));
    let table = table.rows(budget.rows.iter().map(row));
    let table = table
        .row(total("combined", short(*standard), degrees(*degrees_of_freedom), "100"))
        .row(total(&format!("expanded, k = {k:.3}"), short(*expanded), String::new(), ""))
        .note(
            "Type A: evaluated by statistics; type B: by other means. u(x): standard uncertainty, c: sensitivity \
             coefficient (0: listed, but not counted), ν: degrees of freedom.",
        );
    Section::new("Uncertainty budget").table(table).list(sources)
}

fn records(certificate: &Certificate) -> Section {
    let y = &certificate.units.y;
    let table = PageTable::new("Uncertainty of each record").text("record").number("samples");
    let table = table.number(format!("mean error [{y}]")).number(format!("noise [{y}]"));
    let table = table.number(format!("u [{y}]")).number("ν").number("k");
    let table = table.number(format!("U [{y}]")).number("within its U [%]").number("within U [%]");
    let row = |record: &CertifiedRecord| {
        let Budget { standard, degrees_of_freedom, k, expanded, .. } = &record.budget;
        [
            record.compared.short().to_string(),
            record.n.to_string(),
            short(record.mean_error),
            record.noise.map_or("-".into(), short),
            short(*standard),
            degrees(*degrees_of_freedom),
            format!("{k:.2}"),
            short(*expanded),
            share(record.own_within_percent),
            share(record.within_percent),
        ]
    };
    let table = table.rows(certificate.records.iter().map(row)).note(
        "Mean error: measured less predicted; u: standard uncertainty; ν: degrees of freedom. The last columns are \
         the shares of the samples whose measured error is within the expanded uncertainty of the record, and within \
         that of the certificate.",
    );
    Section::new("Records").table(table).figure(errors(certificate))
}

/// The errors of the records over their times, with the expanded uncertainty.
fn errors(certificate: &Certificate) -> Figure {
    let y = &certificate.units.y;
    let (expanded, offset) = (certificate.expanded, certificate.correction.unwrap_or(0.0));
    let panel = |record: &CertifiedRecord| {
        let compared = &record.compared;
        let errors: Vec<f64> = record.errors().iter().map(|e| e - offset).collect();
        let first = compared.validation.start;
        let t: Vec<f64> = (0..errors.len()).map(|k| (first + k) as f64 * compared.record.ts()).collect();
        Axes::new(Axis::new("t [s]").tight(), Axis::new(format!("error [{y}]")))
            .titled(compared.short())
            .height(0.4)
            .with(Series::line(&t, &errors).role(Role::Residual))
            .at_y(expanded, "U")
            .at_y(-expanded, "")
    };
    let caption = "Measured less predicted displacement, and the expanded uncertainty of the certificate.";
    let figure = Figure::new("Errors", caption);
    certificate.records.iter().map(panel).fold(figure, Figure::panel).stacked()
}

fn bands(certificate: &Certificate) -> Section {
    let y = &certificate.units.y;
    let table = PageTable::new("Uncertainty by frequency").number("from [Hz]").number("to [Hz]").number("cycles");
    let table = table.number(format!("rms error [{y}]")).number(format!("u [{y}]"));
    let table = table.number("ν").number("k").number(format!("U [{y}]"));
    let row = |band: &CertifiedBand| {
        let Budget { standard, degrees_of_freedom, k, expanded, .. } = &band.budget;
        [
            short(band.hz[0]),
            short(band.hz[1]),
            band.cycles.to_string(),
            short(band.rmse),
            short(*standard),
            degrees(*degrees_of_freedom),
            format!("{k:.2}"),
            short(*expanded),
        ]
    };
    let table = table.rows(certificate.bands.iter().map(row));
    Section::new("Bands of frequencies").table(
        table.note("Of the cycles of the inputs of all records. The error of a band contains its mean and its drift."),
    )
}

fn range(certificate: &Certificate) -> Section {
    let Certificate { units, options, .. } = certificate;
    let between = |ends: [f64; 2], unit: &str| match ends.map(round) {
        [low, high] if low == high => format!("{low} {unit}"),
        [low, high] => format!("{low} to {high} {unit}"),
    };
    let domain = certificate.domain();
    let sampling: Vec<String> = certificate.records.iter().map(|r| round(r.compared.record.ts())).collect();
    let all_the_same = sampling.iter().all(|ts| *ts == sampling[0]);
    let sampling = if all_the_same { sampling[0].clone() } else { sampling.join(", ") };
    let rows = [
        ("voltage", domain.map(|domain| between(domain.u, &units.u))),
        ("frequency", domain.and_then(|domain| domain.hz).map(|hz| between(hz, "Hz"))),
        ("displacement", Some(between(certificate.stroke(), &units.y))),
        ("sampling period", Some(format!("{sampling} s"))),
        ("temperature", options.temperature.map(|t| format!("{} °C", round(t)))),
        ("temperature, half-width", options.temperature_half_width.map(|t| format!("{} K", round(t)))),
        ("left out at the start of each record", Some(format!("{} s", round(options.validation.skip)))),
    ];
    let table = PageTable::new("Conditions and range").text("quantity").text("value");
    let section = Section::new("Conditions and range").table(table.rows(stated(rows)));
    section.each(&certificate.verdict, |section, verdict| section.text(sentence(verdict)))
}

/// What is stated, and that the rest is not.
fn stated<const N: usize>(rows: [(&'static str, Option<String>); N]) -> impl Iterator<Item = [Cell; 2]> {
    rows.into_iter().map(|(name, value)| {
        let value = value.map_or_else(|| Cell::from("not stated").muted(), Cell::from);
        [name.into(), value]
    })
}

fn names(certificate: &Certificate) -> Section {
    let options = &certificate.options;
    let rows = [
        ("number", Some(certificate.number())),
        ("date of issue", options.date.clone()),
        ("date of the records", options.measured.clone().or(options.date.clone())),
        ("issuer", options.issuer.clone()),
        ("responsible", options.person.clone().or(options.issuer.clone())),
        ("customer", options.customer.clone()),
        ("country", options.country.clone()),
        ("actuator", options.item.clone()),
        ("serial number", options.serial.clone()),
        ("sensor", options.sensor.clone()),
        ("program", Some(format!("piezoid {}", env!("CARGO_PKG_VERSION")))),
    ];
    let table = PageTable::new("Identification").text("what").text("value").rows(stated(rows));
    let file = |name: &str, hash: &str| {
        let hash = if hash.is_empty() { "in no file" } else { hash };
        [Cell::from(name), Cell::from(Text::new().code(hash))]
    };
    let records = certificate.records.iter().map(|r| file(r.compared.short(), &r.origin.sha256));
    let hashes = PageTable::new("Files").text("file").text("SHA-256").row(file("the model", &certificate.model_sha256));
    Section::new("Identification").table(table).table(hashes.rows(records)).text(METHOD)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;
    use piezoid::hysteresis::Proportional;
    use piezoid::linear::Arx;
    use piezoid::{Model, Record};
    use piezoid_verbs::{CertificateOptions, Origin};
    use std::sync::Arc;

    pub(crate) fn example(options: CertificateOptions) -> Certificate {
        let gain = Proportional::new(1e-3, 2.0).unwrap();
        let model = Model::new(Arc::new(gain), Arx::gain(1e-3, 1.0).unwrap(), 0.0).unwrap();
        let wave = |hz: f64| (0..3000).map(move |t| 9.0 * (std::f64::consts::TAU * hz * f64::from(t) * 1e-3).sin());
        let noise = piezoid_testing::noise(3, 3000);
        let record = |hz: f64, gain: f64| {
            let y = wave(hz).zip(&noise).map(|(u, e)| gain * u + 0.01 * e).collect();
            let record = Record::new(1e-3, wave(hz).collect(), y).unwrap();
            (format!("<{hz}>.csv"), record, Origin::of("a", format!("{hz:064}")))
        };
        options.on(&model, &"ab".repeat(32), vec![record(4.0, 2.01), record(40.0, 2.05)]).unwrap()
    }

    #[test]
    fn the_page_states_the_result_the_budget_and_what_is_not_stated() {
        let options = CertificateOptions {
            sensor_calibration: Some(0.5),
            item: Some("P-885 & co".into()),
            date: Some("2026-11-30".into()),
            ..CertificateOptions::default()
        };
        let found = example(options);
        let html = certificate(&found).html();
        assert_eq!(html, certificate(&found).html());
        for text in [
            "P-885 &amp; co",
            "not issued by an accredited laboratory",
            "linearity of the sensor, resolution, drift after the records, temperature",
            &format!("Uncertainty budget of {}", found.worst().0),
            "&lt;40&gt;.csv",
            "calibration of the sensor",
            "2026-11-30",
            &"ab".repeat(32),
            "<td class=\"txt muted\">not stated</td>",
            &format!("±{}", found.digit.text(found.expanded)),
        ] {
            assert!(html.contains(text), "{text}");
        }
        assert!(!html.split("<script>").next().unwrap().contains("NaN"));
    }
}
