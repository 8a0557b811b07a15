//! The plants by name: one row per plant, read by front ends, documentation and contract tests.

use super::actuators;
use super::catalogue::{Bender, DENSITY, PL112, PL122, PL127, PL128, PL140};
use super::spec::{BeamMode, BeamSpec, Cantilever, DriverSpec, HysteresisSpec, Logged, Oscillator, SensorSpec, Spec};
use piezoid_numerics::error::{Error, row};
use serde::Serialize;

/// A plant by name.
#[derive(Debug, Clone, Copy, Serialize)]
pub struct Preset {
    /// Its name in every front end.
    pub name: &'static str,
    /// Description in one line.
    pub summary: &'static str,
    /// Source of its numbers.
    pub reference: &'static str,
    /// Its parameters.
    #[serde(skip)]
    spec: fn() -> Spec,
}

const SHEET: &str = "PI datasheet PL112-PL140, 31.07.2020; Mayergoyz 1991, DOI 10.1007/978-1-4612-3028-1";
const SHEET_BOUC_WEN: &str = "PI datasheet PL112-PL140, 31.07.2020; Low & Guo 1995, DOI 10.1109/84.475550";

/// Every plant.
#[rustfmt::skip]
pub static PLANTS: &[Preset] = &[
    Preset {
        name: "paper",
        summary: "PL140 as in the paper (Kuklisova Pavelkova 2025): one mode at the poles of its Table 2 (146.7 Hz), \
                  Bouc-Wen hysteresis of 13 % of the stroke, no noise",
        reference: "L. Kuklisova Pavelkova, ICINCO 2025, Table 2 (poles); Low & Guo 1995, DOI 10.1109/84.475550",
        spec: paper,
    },
    Preset {
        name: "pl140",
        summary: "PL140.10, +-1000 um: three modes, Preisach hysteresis of 13 % of the stroke, creep, 500 mA driver, \
                  noisy 16-bit sensor",
        reference: SHEET,
        spec: || bench_preisach(&PL140),
    },
    Preset {
        name: "pl140-bouc-wen",
        summary: "PL140.10 like `pl140`, with Bouc-Wen hysteresis of 13 % of the stroke: no wiping-out of minor loops",
        reference: SHEET_BOUC_WEN,
        spec: bench_bouc_wen,
    },
    Preset {
        name: "pl140-nonlinear",
        summary: "PL140.10 like `pl140`, outside every model here: a sensor curved by 1 % at full stroke, a first mode \
                  that rings 3 % lower at half the stroke, mechanics fed back into the hysteresis (coupling 0.1)",
        reference: "PI datasheet PL112-PL140, 31.07.2020; M. Goldfarb, N. Celanovic 1997, DOI 10.1109/37.588158",
        spec: nonlinear,
    },
    as_pl140("pl128", "PL128.10, +-450 um, resonance near 360 Hz, otherwise like `pl140`", || bench_preisach(&PL128)),
    as_pl140("pl127", "PL127.10, +-450 um, resonance near 420 Hz, otherwise like `pl140`", || bench_preisach(&PL127)),
    as_pl140("pl122", "PL122.10, +-310 um, resonance near 600 Hz, otherwise like `pl140`", || bench_preisach(&PL122)),
    as_pl140("pl112", "PL112.10, +-100 um, resonance near 1800 Hz, otherwise like `pl140`", || bench_preisach(&PL112)),
    Preset {
        name: "p885",
        summary: "stack P-885.51 under 1 kg: 18 um from 0 to 120 V, resonance near 1120 Hz, hysteresis of 12 % of the \
                  stroke, 300 mA driver, capacitive sensor",
        reference: actuators::STACK_SOURCE,
        spec: actuators::stack,
    },
    Preset {
        name: "p611",
        summary: "flexure stage P-611.1S with a load of 30 g: 120 um from -20 to 120 V, modes near 290 and 900 Hz, \
                  hysteresis of 13 % of the stroke, 140 mA driver, strain gauge of 1 kHz bandwidth",
        reference: actuators::STAGE_SOURCE,
        spec: actuators::stage,
    },
    Preset {
        name: "tb3507",
        summary: "tube scanner TB3507, lateral: +-19.5 um at +-264 V (here driven to +-250 V), resonance near 2900 Hz \
                  with Q = 50, hysteresis of 10 % of the stroke",
        reference: actuators::TUBE_SOURCE,
        spec: actuators::tube,
    },
    Preset {
        name: "bouc-wen-benchmark",
        summary: "the Bouc-Wen benchmark of system identification: a mass on a spring with a hysteretic force that its \
                  displacement drives, resonance near 36 Hz; 1 V stands for 1 N. For its own integration take a \
                  sampling period of 1/15000 s, then decimate by 20",
        reference: "J. P. Noel, M. Schoukens 2016, DOI 10.4121/12967592",
        spec: bouc_wen_benchmark,
    },
];

const fn as_pl140(name: &'static str, summary: &'static str, spec: fn() -> Spec) -> Preset {
    Preset { name, summary, reference: SHEET, spec }
}

impl Preset {
    /// The plant called `name`.
    ///
    /// # Errors
    /// [`Error::Unknown`] with all names.
    pub fn find(name: &str) -> Result<&'static Self, Error> {
        row("plant", PLANTS.iter(), |row| row.name, name)
    }

    /// Its parameters.
    pub fn spec(&self) -> Spec {
        (self.spec)()
    }
}

fn paper() -> Spec {
    Spec {
        driver: DriverSpec::default(),
        creep_per_decade: 0.0,
        beam: BeamSpec::Modes(vec![mode(146.7, 0.061, 1.0)]),
        sensor: SensorSpec::default(),
        logged: Logged::After,
        ..bench_bouc_wen()
    }
}

/// A bender with an amplifier, and a sensor of twice its range. The noise is 2e-4 of the displacement, 0.2 um for the
/// PL140.
fn bench(bender: &Bender, hysteresis: HysteresisSpec) -> Spec {
    let capacitance_f = bender.capacitance;
    Spec {
        driver: DriverSpec { lag_s: 1e-4, current_a: Some(0.5), capacitance_f, ..Default::default() },
        hysteresis,
        middle_v: 0.0,
        creep_per_decade: 0.015,
        creep_from_s: 0.1,
        coupling: 0.0,
        beam: BeamSpec::Cantilever(Cantilever {
            length_m: bender.free_length,
            thickness_m: bender.thickness,
            youngs_modulus_pa: bender.youngs_modulus(),
            density_kg_per_m3: DENSITY,
            damping: vec![0.03; 3],
        }),
        sensor: SensorSpec {
            noise_rms_m: 2e-4 * bender.displacement,
            range_m: Some(2.0 * bender.displacement),
            bits: Some(16),
            ..Default::default()
        },
        logged: Logged::Before,
        inner_steps: 20,
    }
}

/// The modes of the PL140 (see `beam.rs`), of which the first softens.
fn nonlinear() -> Spec {
    let plain = bench_preisach(&PL140);
    let first = BeamMode { softening_per_m: 140.0, ..mode(166.3, 0.03, 0.891) };
    Spec {
        coupling: 0.1,
        beam: BeamSpec::Modes(vec![first, mode(1042.0, 0.03, 0.0788), mode(2918.0, 0.03, 0.0165)]),
        sensor: SensorSpec { curvature: 0.02, ..plain.sensor },
        ..plain
    }
}

/// Newmark's step is the sampling period, and the force of a sample acts at its end.
fn bouc_wen_benchmark() -> Spec {
    Spec {
        driver: DriverSpec { min_v: -1000.0, max_v: 1000.0, ..DriverSpec::default() },
        hysteresis: HysteresisSpec::Linear { range_v: 100.0, displacement_m: 1e-3 },
        creep_per_decade: 0.0,
        beam: BeamSpec::Oscillator(Oscillator {
            mass_kg: 2.0,
            damping_kg_per_s: 10.0,
            stiffness_n_per_m: 5e4,
            alpha_n_per_m: 5e4,
            beta: 1e3,
            gamma: 0.8,
            delta: -1.1,
        }),
        sensor: SensorSpec::default(),
        logged: Logged::After,
        inner_steps: 1,
        ..bench_bouc_wen()
    }
}

pub(crate) fn mode(frequency_hz: f64, damping: f64, share: f64) -> BeamMode {
    BeamMode { frequency_hz, damping, share, softening_per_m: 0.0 }
}

fn bench_preisach(bender: &Bender) -> Spec {
    bench(bender, actuators::preisach(30.0, bender.displacement, 0.13))
}

fn bench_bouc_wen() -> Spec {
    let (range_v, displacement_m) = (30.0, PL140.displacement);
    let law = HysteresisSpec::BoucWen { range_v, displacement_m, width: 0.13, beta_per_v: 0.020, gamma_per_v: 0.005 };
    bench(&PL140, law)
}

#[cfg(test)]
mod tests {
    use super::super::Plant;
    use super::*;

    #[test]
    fn every_plant_has_a_summary_and_a_source() {
        for (i, plant) in PLANTS.iter().enumerate() {
            assert!(!plant.summary.is_empty() && plant.reference.len() > 10, "{}", plant.name);
            assert!(PLANTS[..i].iter().all(|other| other.name != plant.name), "{} twice", plant.name);
            assert_eq!(Preset::find(plant.name).unwrap().summary, plant.summary);
        }
        assert!(Preset::find("pl14O").unwrap_err().to_string().contains("did you mean `pl140`?"));
    }

    #[test]
    fn every_plant_is_bit_identical_after_json() {
        for plant in PLANTS {
            let spec = plant.spec();
            assert_eq!(Spec::from_json(&spec.to_json().unwrap()).unwrap(), spec, "{}", plant.name);
        }
    }

    #[test]
    fn every_plant_stays_bounded_and_comes_to_rest() {
        for preset in PLANTS {
            let plant = Plant::new(&preset.spec(), 5e-4).unwrap();
            // Hard switching, then 1 s of rest.
            let mut u: Vec<f64> = (0..2000).map(|i| if i / 7 % 2 == 0 { 30.0 } else { -30.0 }).collect();
            u.extend([0.0; 2000]);
            let y = plant.run(&u).y;
            let stroke = 1e6 * preset.spec().hysteresis.displacement_m();
            assert!(y.iter().all(|y| y.is_finite() && y.abs() < 20.0 * stroke), "{}", preset.name);
            assert!((y[3999] - y[3800]).abs() < 0.01 * stroke, "{} does not come to rest", preset.name);
        }
    }
}
