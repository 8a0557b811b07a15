//! Twins of actuators other than benders: a stack, a flexure stage and a tube scanner.
//!
//! Stroke, voltages, capacitance, stiffness, resonance and dimensions are those of data sheets, which call them typical
//! (+-10 to 20 %). Assumed, because data sheets do not state it: the shape of the loop, the damping, the second mode of
//! the stage, the lag of the drivers. Open-loop hysteresis of 10 to 15 % and creep of 1 to 2 % per decade are those of
//! PI's tutorial on piezo technology; G. Clayton et al., "Hysteresis and vibration compensation in piezoactuators by
//! integrating charge control and inverse feedforward" (IFAC Mechatronics 2006), measured 8.8 % on a tube.
//!
//! A payload M on a spring k with the moving mass m lowers the resonance, as the data sheet of the stage confirms
//! (400 Hz without load, 300 Hz with 30 g, 195 Hz with 100 g):
//! ```text
//! m = k / (2 pi f)^2,    f' = f sqrt(m / (m + M))
//! ```
//! A tube bends like the cantilever of `beam.rs` whose thickness t has the same ratio of inertia to area:
//! ```text
//! I / A = (D^2 + d^2) / 16 = t^2 / 12
//! ```
//! The noise of the sensors is that of A. J. Fleming, "A review of nanometer resolution position sensors", Sensors and
//! Actuators A 190, 106 (2013), DOI 10.1016/j.sna.2012.10.016: 20 pm/sqrt(Hz) for capacitive sensors, and for strain
//! gauges 23 nm in 1 kHz bandwidth (six times the rms). Not modelled: preload springs, the other axes, shear of the
//! tube, which lowers its second mode.

use super::presets::mode;
use super::spec::{BeamSpec, Cantilever, DriverSpec, HysteresisSpec, Logged, SensorSpec, Spec};
use std::f64::consts::TAU;

pub(super) const STACK_SOURCE: &str =
    "PI Ceramic, data sheet P-882 - P-888 PICMA Stack (P-885.51, typical values); driver: PiezoDrive PDu150CL";
pub(crate) const STAGE_SOURCE: &str = "PI, data sheet P-611.1 (P-611.1S, typical values); driver: PI E-503; sensor: \
                                       Fleming 2013, DOI 10.1016/j.sna.2012.10.016";
pub(super) const TUBE_SOURCE: &str =
    "PiezoDrive, Piezoelectric Tube Scanners, table of specifications (TB3507), mmech.com; driver: PiezoDrive TD250";

/// Time constant of a sensor with 10 kHz bandwidth [s].
const LAG_10_KHZ: f64 = 1.6e-5;

/// P-885.51, 5 x 5 x 18 mm: 18 um at 120 V, 50 N/um, 1.5 uF. 70 kHz is the resonance with free ends; glued down at one
/// end the stack has half of it. The load of 1 kg is ours.
pub(super) fn stack() -> Spec {
    Spec {
        driver: DriverSpec { min_v: -20.0, max_v: 120.0, lag_s: 2e-5, current_a: Some(0.3), capacitance_f: 1.5e-6 },
        hysteresis: preisach(60.0, 9e-6, 0.12),
        middle_v: 60.0,
        creep_per_decade: 0.015,
        creep_from_s: 0.1,
        coupling: 0.0,
        beam: BeamSpec::Modes(vec![mode(loaded(35e3, 50e6, 1.0), 0.02, 1.0)]),
        sensor: SensorSpec {
            lag_s: LAG_10_KHZ,
            noise_rms_m: 1e-9,
            range_m: Some(40e-6),
            bits: Some(18),
            ..Default::default()
        },
        logged: Logged::Before,
        inner_steps: 20,
    }
}

/// P-611.1S: 120 um from -20 to 120 V, 0.2 N/um, 400 Hz, 1.5 uF. The reading of its strain gauge is curved by 0.1 % of
/// 120 um.
pub(super) fn stage() -> Spec {
    Spec {
        driver: DriverSpec { min_v: -20.0, max_v: 120.0, lag_s: 5e-5, current_a: Some(0.14), capacitance_f: 1.5e-6 },
        hysteresis: preisach(70.0, 60e-6, 0.13),
        middle_v: 50.0,
        beam: BeamSpec::Modes(vec![mode(loaded(400.0, 0.2e6, 0.03), 0.02, 0.95), mode(900.0, 0.015, 0.04)]),
        sensor: SensorSpec {
            lag_s: 1.6e-4,
            noise_rms_m: 4e-9,
            // From 0 to half the range R, c y^2 / R differs by c R / 16 from the straight line between its ends.
            curvature: 0.008,
            range_m: Some(240e-6),
            ..stack().sensor
        },
        ..stack()
    }
}

/// TB3507, 35 mm long, 7 mm in diameter, wall 0.66 mm: 39 um at +-264 V, 10 nF per quadrant, 3000 Hz. The constants are
/// those of the ceramic of the benders, whose E / rho fits the 3000 Hz within 4 %.
pub(super) fn tube() -> Spec {
    let (outer, wall): (f64, f64) = (7e-3, 0.66e-3);
    let inner = outer - 2.0 * wall;
    Spec {
        driver: DriverSpec { min_v: -250.0, max_v: 250.0, lag_s: 1e-5, current_a: None, capacitance_f: 10e-9 },
        hysteresis: preisach(264.0, 19.5e-6, 0.10),
        middle_v: 0.0,
        beam: BeamSpec::Cantilever(Cantilever {
            length_m: 35e-3,
            thickness_m: (0.75 * (outer * outer + inner * inner)).sqrt(),
            youngs_modulus_pa: 62.1e9,
            density_kg_per_m3: super::catalogue::DENSITY,
            damping: vec![0.01; 2],
        }),
        sensor: SensorSpec { noise_rms_m: 2e-9, range_m: Some(50e-6), ..stack().sensor },
        ..stack()
    }
}

/// The ceramic, with a loop of the shape of the benders.
pub(super) fn preisach(range_v: f64, displacement_m: f64, width: f64) -> HysteresisSpec {
    HysteresisSpec::Preisach { range_v, displacement_m, width, half_width_v: range_v / 1.5, asymmetry: 0.3 }
}

/// The resonance [Hz] with the payload `load` [kg], from the one without load [Hz] and the stiffness [N/m].
fn loaded(unloaded: f64, stiffness: f64, load: f64) -> f64 {
    let moving = stiffness / (TAU * unloaded).powi(2);
    unloaded * (moving / (moving + load)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::super::{Plant, Preset};
    use super::*;
    use piezoid_numerics::system::System;
    use piezoid_records::excitation::Actuator;
    use piezoid_testing::assert_close;

    /// The plant without noise, converter and lag of its sensor, and without creep.
    fn quiet(name: &str, ts: f64) -> Plant {
        let spec = Preset::find(name).unwrap().spec();
        let sensor = SensorSpec::default();
        Plant::new(&Spec { sensor, creep_per_decade: 0.0, logged: Logged::After, ..spec }, ts).unwrap()
    }

    /// Readings [um] at the ends of `voltages`, each held for `hold` samples.
    fn held(plant: &Plant, hold: usize, voltages: &[f64]) -> Vec<f64> {
        let u: Vec<f64> = voltages.iter().flat_map(|&v| vec![v; hold]).collect();
        plant.run(&u).y.into_iter().skip(hold - 1).step_by(hold).collect()
    }

    #[test]
    fn the_strokes_are_those_of_the_data_sheets() {
        let stack = held(&quiet("p885", 1e-3), 400, &[0.0, 120.0, 0.0, 100.0, 0.0]);
        assert_close(&stack[..3], &[0.0, 18.0, 0.0], 1e-6, 1e-6);
        // The data sheet has 15 um +-10 % at 100 V.
        assert_close(&[stack[3] - stack[2]], &[15.0], 0.1, 0.0);
        let stage = held(&quiet("p611", 1e-3), 1500, &[120.0, -20.0, 120.0, -20.0]);
        assert_close(&[stage[2] - stage[1], stage[2] - stage[3]], &[120.0, 120.0], 1e-6, 0.0);
        // In closed loop it has 100 um, so it must reach them from 0 V.
        assert!(stage[0] > 100.0, "{stage:?}");
        // 39 um at +-264 V; the amplifier ends at +-250 V.
        let tube = held(&quiet("tb3507", 1e-3), 200, &[250.0, -250.0, 250.0]);
        assert_close(&[tube[2] - tube[1]], &[39.0 * 250.0 / 264.0], 0.02, 0.0);
    }

    #[test]
    fn the_twins_are_those_of_the_catalogue() {
        for (plant, name) in [("pl140", "pl140"), ("p885", "p-885.51"), ("p611", "p-611.1s"), ("tb3507", "tb3507")] {
            let (spec, actuator) = (Preset::find(plant).unwrap().spec(), Actuator::find(name).unwrap());
            assert_eq!(Some(spec.driver.capacitance_f), actuator.capacitance, "{plant}");
            assert!(actuator.low <= spec.driver.min_v && spec.driver.max_v <= actuator.high, "{plant}");
        }
    }

    #[test]
    fn unipolar_plants_start_at_rest_at_zero_volts() {
        for name in ["p885", "p611"] {
            let plant = quiet(name, 1e-3);
            assert_close(&plant.run(&[0.0; 5]).y, &[0.0; 5], 0.0, 1e-12);
            assert_eq!(plant.settled(0.0), plant.initial());
        }
    }

    /// Frequency [Hz] of the oscillation after a step from 0 to `v` [V].
    fn rings(name: &str, ts: f64, v: f64) -> f64 {
        let y = quiet(name, ts).run(&vec![v; 1500]).y;
        let still = y[1200..].iter().sum::<f64>() / 300.0;
        // Times of the downward crossings, between two samples.
        let falls = y.windows(2).enumerate().filter(|(_, w)| w[0] > still && w[1] <= still);
        let times: Vec<f64> = falls.map(|(t, w)| ts * (t as f64 + (w[0] - still) / (w[0] - w[1]))).take(11).collect();
        10.0 / (times[10] - times[0])
    }

    #[test]
    fn the_resonances_are_those_of_the_data_sheets_with_the_load() {
        // A mass of 1 kg on 50 N/um.
        assert_close(&[rings("p885", 2e-5, 1.0)], &[(50e6f64 / 1.001).sqrt() / TAU], 2e-3, 0.0);
        // The data sheet has 300 Hz with 30 g and 195 Hz with 100 g.
        assert_close(&[rings("p611", 1e-4, 1.0), loaded(400.0, 0.2e6, 0.1)], &[300.0, 195.0], 0.05, 0.0);
        assert_close(&[rings("tb3507", 1e-5, 1.0)], &[3000.0], 0.04, 0.0);
        // Half of the 70 kHz of the free stack is what its stiffness and a third of its mass give.
        let third = 5e-3 * 5e-3 * 18e-3 * 7800.0 / 3.0;
        assert_close(&[(50e6f64 / third).sqrt() / TAU], &[35e3], 0.1, 0.0);
    }

    #[test]
    fn a_slow_loop_has_the_width_and_a_small_one_is_narrow() {
        /// Width over height of the second period of a triangle between the two voltages.
        fn width(name: &str, low: f64, high: f64) -> f64 {
            let leg = |a: f64, b: f64| (0..400).map(move |i| a + (b - a) * f64::from(i) / 400.0);
            let middle = 0.5 * (low + high);
            let period = || leg(middle, high).chain(leg(high, low)).chain(leg(low, middle));
            let y = quiet(name, 5e-3).run(&period().chain(period()).collect::<Vec<_>>()).y;
            let (rising, falling) = (y[1200], y[1800]);
            let (top, bottom) = y[1200..].iter().fold((f64::MIN, f64::MAX), |(a, b), &y| (a.max(y), b.min(y)));
            (falling - rising) / (top - bottom)
        }
        let full = [width("p885", 0.0, 120.0), width("p611", -20.0, 120.0), width("tb3507", -250.0, 250.0)];
        assert_close(&full, &[0.12, 0.13, 0.10], 0.06, 0.0);
        assert!(width("tb3507", -10.0, 10.0) < 0.01);
    }

    #[test]
    fn creep_and_noise_are_those_of_the_specification() {
        for (name, v, noise) in [("p885", 100.0, 1e-3), ("p611", 100.0, 4e-3), ("tb3507", 250.0, 2e-3)] {
            let spec = Preset::find(name).unwrap().spec();
            let plant = Plant::new(&Spec { sensor: SensorSpec::default(), ..spec.clone() }, 0.05).unwrap();
            // From 1 to 10 s after the step, relative to the displacement after 0.1 s.
            let y = plant.run(&[v; 201]).y;
            assert_close(&[y[200] / y[20]], &[1.03 / 1.015], 2e-3, 0.0);
            let still = Plant::new(&spec, 1e-3).unwrap().run(&[0.0; 4000]).y;
            let rms = (still.iter().map(|y| y * y).sum::<f64>() / 4000.0).sqrt();
            // The converter adds 1 / sqrt(12) of its code.
            let code = 2e6 * spec.sensor.range_m.unwrap() / 2f64.powi(18);
            assert_close(&[rms], &[(noise * noise + code * code / 12.0).sqrt()], 0.05, 0.0);
        }
    }

    #[test]
    fn the_strain_gauge_lags_and_is_curved_by_a_tenth_of_a_percent() {
        let sensor = SensorSpec { noise_rms_m: 0.0, bits: None, ..stage().sensor };
        let plant = Plant::new(&Spec { sensor, creep_per_decade: 0.0, ..stage() }, 1e-3).unwrap();
        let mut x = plant.initial();
        let (read, straight): (Vec<f64>, Vec<f64>) =
            [0.0, 60.0, 120.0].into_iter().map(|v| (plant.resume(&mut x, &[v; 1500])[1499], plant.tip(&x))).unzip();
        let chord = read[2] / straight[2];
        let off = (read[1] - chord * straight[1]) / straight[2];
        assert!(off.abs() > 5e-4 && off.abs() < 1.2e-3, "{off:e}");
        assert_close(&[stage().sensor.lag_s], &[1.0 / (TAU * 1000.0)], 0.01, 0.0);
    }
}
