//! Actuators by name: the voltages that they allow, their stroke, and their load on the driver, from data sheets.
//!
//! All figures are those that the data sheets call nominal or typical; their tolerances are 10 to 20 %. A figure that
//! is not known is `None`, not an estimate. Not stated: hysteresis, creep, damping.

use piezoid_numerics::error::{Error, row};
use piezoid_numerics::number::{quantity, round};
use serde::{Serialize, Serializer};

/// An actuator by name.
///
/// ```
/// use piezoid::excitation::{Actuator, Amplifier};
///
/// let stack = Actuator::find("p-885.51")?;
/// assert_eq!(stack.description(), "PI P-885.51, stack: 15 um from 0 to 100 V (allowed: -20 to 120 V), 1.5 uF, \
///                                  70 kHz, 50 N/um, 900 N");
/// let limits = Amplifier::find("e-610")?.loaded(stack.capacitance)?;
/// assert_eq!(limits.fastest().round(), 120_000.0); // V/s
/// # Ok::<(), piezoid::Error>(())
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[serde(remote = "Self")]
pub struct Actuator {
    /// Name in every front end: the order number in lower case.
    pub name: &'static str,
    /// Maker.
    pub maker: &'static str,
    /// Type, as the maker writes it.
    pub model: &'static str,
    /// `bender`, `stack`, `amplified` (a stack in a frame that enlarges its stroke), `stage` or `tube`.
    pub kind: &'static str,
    /// Lowest voltage that it allows; that of a bender is relative to the middle of its supply [V].
    pub low: f64,
    /// Highest voltage that it allows, likewise [V].
    pub high: f64,
    /// Free stroke, peak to peak, between the voltages `stroke_at` [`unit`].
    pub stroke: f64,
    /// Unit of the stroke.
    pub unit: &'static str,
    /// Voltages between which the stroke is stated [V].
    pub stroke_at: [f64; 2],
    /// Capacitance that the driver charges, at small signals; large signals see up to twice as much [F].
    pub capacitance: Option<f64>,
    /// Resonance without load: of stacks with both ends free (half of it with one end fixed), of the others fixed [Hz].
    pub resonance: Option<f64>,
    /// Stiffness in the direction of the stroke [N/m].
    pub stiffness: Option<f64>,
    /// Blocking force [N].
    pub blocking_force: Option<f64>,
    /// Source of the figures.
    pub reference: &'static str,
}

/// Its figures by name; the summary is the description.
impl Serialize for Actuator {
    fn serialize<S: Serializer>(&self, to: S) -> Result<S::Ok, S::Error> {
        #[derive(Serialize)]
        struct Row {
            #[serde(flatten, serialize_with = "Actuator::serialize")]
            figures: Actuator,
            summary: String,
        }
        Row { figures: *self, summary: self.description() }.serialize(to)
    }
}

/// A row without figures, for those that follow.
const NONE: Actuator = Actuator {
    name: "",
    maker: "",
    model: "",
    kind: "",
    low: 0.0,
    high: 0.0,
    stroke: 0.0,
    unit: "um",
    stroke_at: [0.0; 2],
    capacitance: None,
    resonance: None,
    stiffness: None,
    blocking_force: None,
    reference: "",
};

/// The actuators of a series, with their range [V], at whose ends the stroke is stated.
const fn series(maker: &'static str, kind: &'static str, range: [f64; 2], reference: &'static str) -> Actuator {
    Actuator { maker, kind, low: range[0], high: range[1], stroke_at: range, reference, ..NONE }
}

/// PI's benders between outer electrodes at 0 and 60 V; the capacitance is that of both halves.
const PL: Actuator = series("PI", "bender", [-30.0, 30.0], "PI, data sheet PL112-PL140, PICMA Bender, 31.07.2020");

/// The benders of CTS between outer electrodes at 0 and 200 V; the capacitance is that of both halves.
const NAC: Actuator = series("CTS (Noliac)", "bender", [-100.0, 100.0], NAC_SHEET);
const NAC_SHEET: &str = "CTS, data sheet Bending Actuators - Plate Benders, RevC_0524";

const PICMA: Actuator = Actuator { stroke_at: [0.0, 100.0], ..series("PI", "stack", [-20.0, 120.0], PICMA_SHEET) };
const PICMA_SHEET: &str = "PI Ceramic, data sheet P-882 - P-888, PICMA Stack multilayer piezo actuators";

/// The range of the stacks of PiezoDrive is that from -30 to 150 V; from 0 to 150 V it is three quarters.
const PIEZO_DRIVE: Actuator = series("PiezoDrive", "stack", [-30.0, 150.0], "");

const KEMET: Actuator = series("KEMET (NEC Tokin)", "stack", [0.0, 150.0], AE_SHEET);
const AE_SHEET: &str = "NEC Tokin, Multilayer Piezoelectric Actuators, AE series; mechano-transformer.com, products";

/// PI's flexure stages, with the travel in open loop.
const STAGE: Actuator = series("PI", "stage", [-20.0, 120.0], "");

/// The lateral deflection of PI's tubes, with opposite voltages on opposite quarters; the capacitance is that of one.
const PT230: Actuator = series("PI", "tube", [-250.0, 250.0], TUBE_SHEET);
const TUBE_SHEET: &str = "PI Ceramic, data sheet PT120 - PT140 Piezo Tube Actuators, scanner tubes";

/// The lateral deflection of PiezoDrive's tubes, likewise.
const TB: Actuator = Actuator {
    maker: "PiezoDrive",
    kind: "tube",
    reference: "PiezoDrive, Piezoelectric Tube Scanners, table of specifications, mmech.com",
    ..NONE
};

/// All actuators.
#[rustfmt::skip]
pub static ACTUATORS: &[Actuator] = &[
    Actuator { name: "pl112", model: "PL112.10", stroke: 200.0, capacitance: Some(2.2e-6), resonance: Some(1800.0),
        blocking_force: Some(2.1), ..PL },
    Actuator { name: "pl122", model: "PL122.10", stroke: 620.0, capacitance: Some(5e-6), resonance: Some(600.0),
        blocking_force: Some(1.25), ..PL },
    Actuator { name: "pl127", model: "PL127.10", stroke: 900.0, capacitance: Some(6.8e-6), resonance: Some(420.0),
        blocking_force: Some(1.1), ..PL },
    Actuator { name: "pl128", model: "PL128.10", stroke: 900.0, capacitance: Some(2.4e-6), resonance: Some(360.0),
        blocking_force: Some(0.55), ..PL },
    Actuator { name: "pl140", model: "PL140.10", stroke: 2000.0, capacitance: Some(8.2e-6), resonance: Some(160.0),
        blocking_force: Some(0.5), ..PL },
    Actuator { name: "nac2224", model: "NAC2224", stroke: 1060.0, capacitance: Some(340e-9), resonance: Some(340.0),
        stiffness: Some(1.7e3), blocking_force: Some(0.92), ..NAC },
    Actuator { name: "nac2225", model: "NAC2225", stroke: 730.0, capacitance: Some(700e-9), resonance: Some(620.0),
        stiffness: Some(9.3e3), blocking_force: Some(3.4), ..NAC },
    Actuator { name: "p-885.11", model: "P-885.11", stroke: 6.5, capacitance: Some(0.6e-6), resonance: Some(135e3),
        stiffness: Some(100e6), blocking_force: Some(800.0), ..PICMA },
    Actuator { name: "p-885.51", model: "P-885.51", stroke: 15.0, capacitance: Some(1.5e-6), resonance: Some(70e3),
        stiffness: Some(50e6), blocking_force: Some(900.0), ..PICMA },
    Actuator { name: "p-885.91", model: "P-885.91", stroke: 32.0, capacitance: Some(3.1e-6), resonance: Some(40e3),
        stiffness: Some(25e6), blocking_force: Some(950.0), ..PICMA },
    Actuator { name: "p-010.80", model: "P-010.80", low: 0.0, high: 1000.0, stroke: 120.0, stroke_at: [0.0, 1000.0],
        resonance: Some(10e3), stiffness: Some(20e6), blocking_force: Some(2400.0),
        reference: "PI Ceramic, catalogue, PICA Stack piezo actuators", ..PICMA },
    Actuator { name: "sa050510", model: "SA050510", stroke: 14.0, capacitance: Some(0.63e-6), resonance: Some(150e3),
        stiffness: Some(108e6), blocking_force: Some(900.0),
        reference: "PiezoDrive, SA Stack Actuators, table of specifications, mmech.com", ..PIEZO_DRIVE },
    Actuator { name: "sr080418", model: "SR080418", stroke: 28.0, capacitance: Some(1.6e-6), resonance: Some(83e3),
        stiffness: Some(65e6), blocking_force: Some(1300.0),
        reference: "PiezoDrive, 150V Piezo Ring Stack Actuators, table of specifications", ..PIEZO_DRIVE },
    Actuator { name: "ae0505d08df", model: "AE0505D08DF", stroke: 9.1, capacitance: Some(0.75e-6),
        resonance: Some(138e3), ..KEMET },
    Actuator { name: "ae0505d16df", model: "AE0505D16DF", stroke: 17.4, resonance: Some(69e3), ..KEMET },
    Actuator { name: "nac2023", maker: "CTS (Noliac)", model: "NAC2023", kind: "stack", high: 200.0, stroke: 3.1,
        stroke_at: [0.0, 200.0], capacitance: Some(970e-9), resonance: Some(486e3), stiffness: Some(3050e6),
        blocking_force: Some(9450.0), reference: "Noliac, data sheet NAC2023", ..NONE },
    Actuator { name: "pk4fyc2", maker: "Thorlabs", model: "PK4FYC2", kind: "stack", high: 150.0, stroke: 38.5,
        stroke_at: [0.0, 150.0], reference: "Thorlabs, Piezoelectric Actuators with Attached Strain Gauges", ..NONE },
    Actuator { name: "apa120s", maker: "Cedrat Technologies", model: "APA120S", kind: "amplified", low: -20.0,
        high: 150.0, stroke: 140.0, stroke_at: [-20.0, 150.0], resonance: Some(1300.0), stiffness: Some(0.33e6),
        blocking_force: Some(46.0), reference: "Cedrat Technologies, data sheet APA120S", ..NONE },
    Actuator { name: "pk2fsf1", maker: "Thorlabs", model: "PK2FSF1", kind: "amplified", high: 75.0, stroke: 220.0,
        stroke_at: [0.0, 75.0], reference: "Thorlabs, Amplified Piezoelectric Actuators", ..NONE },
    Actuator { name: "p-611.1s", model: "P-611.1S", stroke: 120.0, capacitance: Some(1.5e-6), resonance: Some(400.0),
        stiffness: Some(0.2e6), reference: "PI, data sheet P-611.1", ..STAGE },
    Actuator { name: "p-621.1cd", model: "P-621.1CD", stroke: 120.0, resonance: Some(800.0), stiffness: Some(0.35e6),
        reference: "PI, data sheet P-620.1 - P-629.1 PIHera", ..STAGE },
    Actuator { name: "p-622.1cd", model: "P-622.1CD", stroke: 300.0, resonance: Some(400.0), stiffness: Some(0.2e6),
        reference: "PI, data sheet P-620.1 - P-629.1 PIHera", ..STAGE },
    Actuator { name: "p-753.1cd", model: "P-753.1CD", stroke: 15.0, resonance: Some(5600.0), stiffness: Some(45e6),
        reference: "PI, data sheet P-753 LISA", ..STAGE },
    Actuator { name: "pt230.94", model: "PT230.94", stroke: 70.0, capacitance: Some(2.1e-9), ..PT230 },
    Actuator { name: "pt230.14", model: "PT230.14", stroke: 32.0, capacitance: Some(4.5e-9), ..PT230 },
    Actuator { name: "pt230.24", model: "PT230.24", stroke: 20.0, capacitance: Some(6.9e-9), ..PT230 },
    Actuator { name: "tb3507", model: "TB3507", low: -264.0, high: 264.0, stroke: 39.0, stroke_at: [-264.0, 264.0],
        capacitance: Some(10e-9), resonance: Some(3000.0), ..TB },
    Actuator { name: "tb6006", model: "TB6006", low: -260.0, high: 260.0, stroke: 114.0, stroke_at: [-260.0, 260.0],
        capacitance: Some(12e-9), resonance: Some(850.0), ..TB },
];

impl Actuator {
    /// The actuator called `name`.
    ///
    /// # Errors
    /// [`Error::Unknown`] with all names.
    pub fn find(name: &str) -> Result<&'static Actuator, Error> {
        row("actuator", ACTUATORS.iter(), |row| row.name, name)
    }

    /// What it is, and its figures, in one line.
    pub fn description(&self) -> String {
        let [from, to] = self.stroke_at.map(round);
        let allowed = || format!(" (allowed: {} to {} V)", round(self.low), round(self.high));
        let allowed = (self.stroke_at != [self.low, self.high]).then(allowed).unwrap_or_default();
        let Actuator { maker, model, kind, unit, .. } = self;
        let stroke = format!("{maker} {model}, {kind}: {} {unit} from {from} to {to} V{allowed}", round(self.stroke));
        let figures = [
            self.capacitance.map(|c| quantity(c, "F")),
            self.resonance.map(|f| quantity(f, "Hz")),
            self.stiffness.map(|k| format!("{} N/um", round(1e-6 * k))),
            self.blocking_force.map(|f| quantity(f, "N")),
        ];
        [stroke].into_iter().chain(figures.into_iter().flatten()).collect::<Vec<_>>().join(", ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;
    use std::f64::consts::TAU;

    #[test]
    fn every_actuator_is_found_by_its_name_and_has_consistent_figures() {
        for (i, actuator) in ACTUATORS.iter().enumerate() {
            let Actuator { name, low, high, stroke_at: [from, to], .. } = *actuator;
            assert_eq!(Actuator::find(name).unwrap(), actuator);
            assert!(ACTUATORS[..i].iter().all(|other| other.name != name), "{name} twice");
            assert!(low <= from && from < to && to <= high && low <= 0.0, "{name}");
            let figures = [actuator.capacitance, actuator.resonance, actuator.stiffness, actuator.blocking_force];
            assert!(figures.into_iter().flatten().chain([actuator.stroke]).all(|x| x > 0.0 && x.is_finite()), "{name}");
            assert!(["bender", "stack", "amplified", "stage", "tube"].contains(&actuator.kind), "{name}");
            assert!(![actuator.maker, actuator.model, actuator.unit].contains(&"") && actuator.reference.len() > 10);
        }
        assert!(Actuator::find("p-885.15").unwrap_err().to_string().contains("did you mean `p-885.11`?"));
    }

    /// The blocking force of the highest voltage takes away the free stroke of this voltage.
    #[test]
    fn stroke_times_stiffness_is_the_blocking_force() {
        for actuator in ACTUATORS.iter().filter(|a| a.kind != "bender" && a.unit == "um") {
            let Actuator { stiffness: Some(k), blocking_force: Some(force), .. } = actuator else { continue };
            let per_volt = 1e-6 * actuator.stroke / (actuator.stroke_at[1] - actuator.stroke_at[0]);
            assert_close(&[k * per_volt * actuator.high / force], &[1.0], 0.5, 0.0);
        }
    }

    #[test]
    fn the_capacitance_of_a_tube_is_that_of_its_dimensions() {
        // Permittivity of PIC255: 1750. Outer diameter, wall [m].
        for (name, outer, wall) in
            [("pt230.94", 3.2e-3, 0.5e-3), ("pt230.14", 6.35e-3, 0.5e-3), ("pt230.24", 10e-3, 0.5e-3)]
        {
            let quarter = 1750.0 * 8.854e-12 * (0.125 * TAU * (outer - wall) * 30e-3) / wall;
            assert_close(&[Actuator::find(name).unwrap().capacitance.unwrap()], &[quarter], 0.1, 0.0);
        }
    }

    #[test]
    fn a_description_has_the_figures_that_are_known() {
        let message = |name| Actuator::find(name).unwrap().description();
        assert_eq!(message("pl140"), "PI PL140.10, bender: 2000 um from -30 to 30 V, 8.2 uF, 160 Hz, 500 mN");
        assert_eq!(message("pk2fsf1"), "Thorlabs PK2FSF1, amplified: 220 um from 0 to 75 V");
    }
}
