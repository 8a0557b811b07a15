//! Tracking, noise, poor excitation, splits, and the program. The data come from twins, which share no code with the
//! models, or from a generator here.

use super::*;
use piezoid_models::creep::{Creep, Lag};
use piezoid_models::driver::DriverModel;
use piezoid_models::hammerstein::Domain;
use piezoid_models::hysteresis::{OPERATORS, Operator};
use piezoid_models::linear::Arx;
use piezoid_models::program::Machine;

const TS: f64 = 5e-4;

/// A model of this operator with a resonance at 147 Hz and creep.
fn model(operator: &str) -> Model {
    let law = (Operator::find(operator).unwrap().example)(TS).unwrap();
    let block = Arx::new(TS, vec![1.7424, -0.9453], vec![0.0, 3.0, 2.8]).unwrap();
    let creep = Creep::new(TS, vec![Lag { tau_s: 0.1, gain: 0.01 }, Lag { tau_s: 1.0, gain: 0.01 }]).unwrap();
    Model::new(law, block, 2.0)
        .unwrap()
        .with_creep(creep)
        .unwrap()
        .with_identified(Domain::of_input(&[-30.0, 30.0], TS))
}

/// Noise of variance 1, independent of the library's generators.
struct Noise(u64);

impl Noise {
    fn next(&mut self) -> f64 {
        let mut uniform = || {
            self.0 ^= self.0 << 13;
            self.0 ^= self.0 >> 7;
            self.0 ^= self.0 << 17;
            (self.0 >> 11) as f64 / (1u64 << 53) as f64
        };
        (0..12).map(|_| uniform()).sum::<f64>() - 6.0
    }
}

/// Sines of 23, 61 and 140 Hz, at most 28.
fn drive(t: usize) -> f64 {
    let at = |hz: f64| (std::f64::consts::TAU * hz * TS * t as f64).sin();
    14.0 * at(23.0) + 10.0 * at(61.0) + 4.0 * at(140.0)
}

fn check_program(model: &Model, settings: &OnlineSettings) {
    let online = Online::new(model, settings).unwrap();
    let mut program = model.program().unwrap();
    online.extend(&mut program).unwrap();
    let mut machine = Machine::new(&program, "online_state", false);
    let mut x = online.initial();
    assert_eq!(machine.state(), x);
    let y: Vec<f64> = model.simulate(&(0..400).map(drive).collect::<Vec<_>>());
    let mut noise = Noise(7);
    for (t, y) in y.into_iter().enumerate() {
        let (mut u, mut y) = (drive(t), 1.2 * y + 0.1 * noise.next());
        match t {
            100 => u = f64::NAN,
            120 => y = f64::INFINITY,
            140 => (u, y) = (1e30, -1e30),
            _ => {}
        }
        let expected = online.step(&mut x, u, y);
        let answer = machine.call("online_step", &[u, y]).unwrap()[0];
        let name = model.hysteresis().operator().name;
        assert_eq!(answer.to_bits(), expected.to_bits(), "{name} at {t}");
        assert_eq!(machine.state(), x, "{name} at {t}");
    }
}

#[test]
fn the_program_of_every_operator_and_setting_is_bit_identical() {
    for operator in OPERATORS {
        check_program(&model(operator.name), &OnlineSettings::default());
    }
    let plays = || (Operator::find("stop").unwrap().example)(TS).unwrap();
    let range = Domain::of_input(&[-30.0, 30.0], TS);
    for moves in 0..16u8 {
        let is = |bit: u8| moves & bit != 0;
        let moves = Moves { gain: is(1), offset: is(2), weights: is(4), linear: is(8) };
        let settings = OnlineSettings { moves: Some(moves), groups: 3, ..OnlineSettings::default() };
        check_program(&model("prandtl-ishlinskii"), &settings);
        for (a, b) in
            [(vec![], vec![0.5, 0.3]), (vec![0.6], vec![0.4]), (vec![1.2, -0.5, 0.1], vec![0.0, 0.0, 1.0, 0.3])]
        {
            let model = Model::new(plays(), Arx::new(TS, a, b).unwrap(), -1.0).unwrap().with_identified(range);
            check_program(&model, &settings);
        }
    }
    let driver = DriverModel::new(1e-4, Some(2e4)).unwrap();
    let law = (Operator::find("preisach").unwrap().example)(TS / DriverModel::SUBSTEPS as f64).unwrap();
    let model = Model::from_blocks(Some(driver), law, Arx::gain(TS, 3.0).unwrap(), 0.0).unwrap();
    check_program(&model.with_identified(range), &OnlineSettings::default());
}
