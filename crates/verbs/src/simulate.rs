//! The response of a plant or a model to a drive signal.

use super::DataFile;
use piezoid_control::feedback::{SimulatedActuator, StandInPlant};
use piezoid_models::hammerstein::{InitialCondition, Model};
use piezoid_numerics::error::Error;
use piezoid_numerics::number::quantity;
use piezoid_numerics::options::{OptionKind, OptionRow, options};
use piezoid_numerics::series::ends;
use piezoid_numerics::system::System;
use piezoid_records::formats::{ColumnSelection, Table, TextWriter};
use piezoid_records::record::{Record, Units};
use piezoid_twins::{Plant, Spec};
use std::io::Write;

const INITIAL_CONDITIONS: OptionKind = OptionKind::Choice(&[
    ("rest", "At rest, with a jump to the first input"),
    ("settled", "Settled at the first input"),
    ("from-above", "Settled at the first input, after a fall from the top of the range"),
    ("from-below", "Settled at the first input, after a rise from the bottom of the range"),
    ("demagnetised", "Settled at the first input, after a decaying sine about it"),
    ("motion", "In motion as in the record, as if the record had begun earlier"),
]);

options! {
    /// How to simulate.
    #[derive(Copy)]
    pub struct SimulateOptions {
        /// Initial condition: at rest; settled at the first input, directly or after cycles over the whole range; or in
        /// motion as in the record.
        begin: InitialCondition = InitialCondition::Rest, OptionRow::new(INITIAL_CONDITIONS);
        /// Seed of the plant's noise.
        seed: u64 = 1, OptionRow::new(OptionKind::Integer(0, u64::MAX));
        /// Add the standard deviation of a model's response, which the operator gaussian-process states.
        deviation: bool = false, OptionRow::new(OptionKind::Switch);
    }
}

/// An input and the response to it.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulated {
    /// Sampling period [s].
    pub ts: f64,
    /// The input.
    pub u: Vec<f64>,
    /// The response.
    pub y: Vec<f64>,
    /// Its standard deviation [output unit]; empty unless it is asked for.
    pub deviation: Vec<f64>,
    /// Their units.
    pub units: Units,
    /// The limits that were reached, as text; empty if there were none.
    pub reached: String,
}

/// What is simulated.
#[derive(Debug)]
pub enum Subject {
    /// A plant: a twin in V and um, or a stand-in in the units of its records.
    Plant(SimulatedActuator),
    /// A model.
    Model(Box<Model>),
}

/// A simulation that goes on from piece to piece of its input.
struct Run<'a> {
    ts: f64,
    system: Simulator<'a>,
    state: Vec<f64>,
    /// Number of samples so far.
    samples: usize,
}

enum Simulator<'a> {
    /// A plant with its parameters, and the jumps of its voltage so far.
    Plant(Box<Plant>, &'a Spec, Jumps),
    StandIn(Box<StandInPlant>),
    Model(&'a Model),
}

impl SimulateOptions {
    /// The response to the input in a file.
    ///
    /// # Errors
    /// Returns an error for a file without an input, for an input with another unit or, of a model, another sampling
    /// period, and for a response that overflows. The errors of [`Plant::new`].
    pub fn run(&self, subject: &Subject, input: &DataFile, columns: &ColumnSelection) -> Result<Simulated, Error> {
        let mut result = Simulated {
            ts: 0.0,
            u: Vec::new(),
            y: Vec::new(),
            deviation: Vec::new(),
            units: subject.units(),
            reached: String::new(),
        };
        result.reached = self.in_pieces(subject, input, columns, &mut |piece| {
            result.ts = piece.ts;
            result.u.extend(piece.u);
            result.y.extend(piece.y);
            result.deviation.extend(piece.deviation);
            Ok(())
        })?;
        Ok(result)
    }

    /// The same, written to a file of this name; returns the limits that were reached. From CSV to CSV, a few megabytes
    /// are held, however long the input is, if the simulation begins at rest or settled and the input is not cut.
    ///
    /// # Errors
    /// The errors of [`run`](SimulateOptions::run), of [`Simulated::written`], and of writing.
    pub fn write(
        &self,
        subject: &Subject,
        (input, columns): (&DataFile, &ColumnSelection),
        (name, to): (&str, &mut dyn Write),
    ) -> Result<String, Error> {
        let (mut to, mut writer) = (Some(to), None);
        self.in_pieces(subject, input, columns, &mut |piece| {
            let (names, columns): (Vec<_>, Vec<_>) = piece.columns().into_iter().unzip();
            let mut write = || {
                if let Some(to) = to.take() {
                    writer =
                        Some(TextWriter::new(to, piece.ts, &names.iter().map(String::as_str).collect::<Vec<_>>())?);
                }
                writer.as_mut().map_or(Ok(()), |writer| writer.rows(&columns))
            };
            write().map_err(|error| error.of(name))
        })
    }

    /// Simulates piece by piece, which `take` gets. Returns the limits that were reached.
    fn in_pieces(
        &self,
        subject: &Subject,
        input: &DataFile,
        columns: &ColumnSelection,
        take: &mut dyn FnMut(Simulated) -> Result<(), Error>,
    ) -> Result<String, Error> {
        let mut run = None;
        // All other initial conditions depend on the whole input, and so does an interpolation.
        let interpolates = subject.models().any(Model::interpolates);
        let pieces: Box<dyn Iterator<Item = _>> = match self.begin {
            InitialCondition::Rest | InitialCondition::Settled if !interpolates => {
                Box::new(input.input_in_pieces(columns)?)
            }
            _ => Box::new(std::iter::once(input.input(columns))),
        };
        for piece in pieces {
            let signal = piece?;
            let ts = signal.ts;
            let u = signal.samples_in(&subject.units().u, "the input").map_err(|error| error.of(&input.name))?;
            let run = match &mut run {
                Some(run) => run,
                none => none.insert(self.begin(subject, ts, &u).map_err(|error| error.about(&input.name))?),
            };
            let deviation = if self.deviation { run.deviation(&u)? } else { Vec::new() };
            let y = run.respond(&u)?;
            take(Simulated { ts, u, y, deviation, units: subject.units(), reached: String::new() })?;
        }
        Ok(run.map(Run::reached).unwrap_or_default())
    }

    /// A simulation at the beginning of the inputs `u`.
    fn begin<'a>(&self, subject: &'a Subject, ts: f64, u: &[f64]) -> Result<Run<'a>, Error> {
        let (system, state) = match subject {
            Subject::Model(model) => {
                Record::same_sampling("the model", model.ts(), "the input", ts)?;
                (Simulator::Model(model), model.before(u, self.begin))
            }
            Subject::Plant(SimulatedActuator::StandIn(stand_in)) => {
                Record::same_sampling("the stand-in", stand_in.ts(), "the input", ts)?;
                let plant = stand_in.plant(self.seed);
                let state = plant.before(u, self.begin);
                (Simulator::StandIn(Box::new(plant)), state)
            }
            Subject::Plant(SimulatedActuator::Twin(spec)) => {
                let plant = Plant::new(spec, ts)?.with_seed(self.seed);
                let state = self.before(&plant, u);
                let first = u.first().copied().filter(|_| self.begin != InitialCondition::Rest).unwrap_or_default();
                let jumps = Jumps { last: limited(spec, first), most: 0.0 };
                (Simulator::Plant(Box::new(plant), spec, jumps), state)
            }
        };
        Ok(Run { ts, system, state, samples: 0 })
    }

    /// The state of a plant before the input `u` [V].
    pub fn before(&self, plant: &Plant, u: &[f64]) -> Vec<f64> {
        let settled = || plant.settled(u.first().copied().unwrap_or_default());
        match self.begin {
            InitialCondition::Rest => plant.initial(),
            InitialCondition::Settled => settled(),
            InitialCondition::Motion => {
                let mut x = settled();
                plant.resume(&mut x, u);
                x
            }
            InitialCondition::FromAbove | InitialCondition::FromBelow | InitialCondition::Demagnetised => {
                let mut x = settled();
                let sweep = self.begin.inputs_before(u, ends(u.iter().copied()));
                let waits = std::iter::repeat_n(sweep[sweep.len() - 1], sweep.len());
                plant.resume(&mut x, &sweep.iter().copied().chain(waits).collect::<Vec<_>>());
                x
            }
        }
    }
}

impl Subject {
    /// Units of input and response.
    fn units(&self) -> Units {
        match self {
            Subject::Plant(SimulatedActuator::Twin(_)) => Units::default(),
            Subject::Plant(SimulatedActuator::StandIn(stand_in)) => stand_in.units().clone(),
            Subject::Model(model) => model.units().clone(),
        }
    }

    /// The models in it.
    fn models(&self) -> impl Iterator<Item = &Model> {
        let models = match self {
            Subject::Plant(SimulatedActuator::Twin(_)) => [None, None],
            Subject::Plant(SimulatedActuator::StandIn(stand_in)) => [Some(stand_in.model()), Some(stand_in.other())],
            Subject::Model(model) => [Some(&**model), None],
        };
        models.into_iter().flatten()
    }
}

impl Run<'_> {
    /// The response to the next inputs; an error if it is not finite.
    fn respond(&mut self, u: &[f64]) -> Result<Vec<f64>, Error> {
        let y = match &mut self.system {
            Simulator::Model(model) => model.follow(&mut self.state, u),
            Simulator::StandIn(plant) => plant.resume(&mut self.state, u),
            Simulator::Plant(plant, spec, jumps) => {
                u.iter().for_each(|u| jumps.add(limited(spec, *u)));
                plant.resume(&mut self.state, u)
            }
        };
        if let Some(k) = y.iter().position(|y| !y.is_finite()) {
            let time = (self.samples + k) as f64 * self.ts;
            let why = "the model is unstable, or the input far too large";
            return Err(Error::Content(format!("the output overflows at {time} s: {why}")));
        }
        self.samples += u.len();
        Ok(y)
    }

    /// The standard deviation of the response to the next inputs.
    fn deviation(&self, u: &[f64]) -> Result<Vec<f64>, Error> {
        let found = match &self.system {
            Simulator::Model(model) => model.deviation(&self.state, u),
            Simulator::Plant(..) | Simulator::StandIn(_) => None,
        };
        found.ok_or_else(|| {
            let rule = "needs a model whose operator states one, in series with its mechanics: identify it with \
                        --operator gaussian-process";
            Error::parameter("deviation", true, rule)
        })
    }

    /// The limits that a plant has reached, as text.
    fn reached(self) -> String {
        let Simulator::Plant(plant, spec, jumps) = &self.system else { return String::new() };
        let saturation = plant.saturation(&self.state);
        let mut reached = if saturation.any() { saturation.to_string() } else { String::new() };
        if saturation.current_limited > 0 {
            reached += &jumps.only(spec, self.ts).unwrap_or_default();
        }
        reached
    }
}

/// The largest change of the voltage from one sample to the next [V].
struct Jumps {
    last: f64,
    most: f64,
}

impl Jumps {
    fn add(&mut self, u: f64) {
        self.most = self.most.max((u - self.last).abs());
        self.last = u;
    }

    /// Why the current is at its limit although the drive is slow enough for the driver: a held voltage jumps from
    /// sample to sample, and a plan counts the mean current over a sampling period. `None` if the drive is too fast.
    fn only(&self, spec: &Spec, ts: f64) -> Option<String> {
        let (limit, farad) = (spec.driver.current_a?, spec.driver.capacitance_f);
        let most = self.most * farad / ts;
        let rounded = |current: f64| format!("{current:.3e}").parse().unwrap_or(current);
        (most <= limit).then(|| {
            format!(
                " at the jump from one held voltage to the next, and only there. The driver can follow the drive: the \
                 mean current over a sampling period, which plans compare with the limit, is at most {} of {}. A \
                 shorter sampling period makes the jumps smaller",
                quantity(rounded(most), "A"),
                quantity(limit, "A")
            )
        })
    }
}

/// A voltage within the range of a driver.
fn limited(spec: &Spec, u: f64) -> f64 {
    u.clamp(spec.driver.min_v, spec.driver.max_v)
}

impl Simulated {
    /// Input and response as a file of this name.
    ///
    /// # Errors
    /// The errors of [`Table::write`].
    pub fn written(&self, name: &str) -> Result<Vec<u8>, Error> {
        let columns = self.columns();
        let columns: Vec<_> = columns.iter().map(|(name, column)| (name.as_str(), *column)).collect();
        Table::write(name, self.ts, &columns)
    }

    /// Its columns by name.
    fn columns(&self) -> Vec<(String, &[f64])> {
        let Units { u, y } = &self.units;
        let columns = [(format!("u_{u}"), &self.u), (format!("y_{y}"), &self.y), (format!("sd_{y}"), &self.deviation)];
        columns.into_iter().map(|(name, column)| (name, &column[..])).filter(|(_, column)| !column.is_empty()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::File;
    use piezoid_twins::Preset;

    /// A sine of 50 Hz every 1 ms is planned with a seventh of the driver's current; the twin then reported that the
    /// current was at its limit.
    #[test]
    fn a_drive_that_the_driver_follows_is_told_to_reach_the_limit_in_jumps_only() {
        let reached = |volts: f64, ts: f64| {
            let u: Vec<f64> = (0..200).map(|t| volts * (0.314_159 * f64::from(t)).sin()).collect();
            let input: DataFile = File::new("u.csv", Table::write("u.csv", ts, &[("u_V", &u)]).unwrap()).into();
            let plant = Subject::Plant(Preset::find("pl140").unwrap().spec().into());
            SimulateOptions::default().run(&plant, &input, &ColumnSelection::default()).unwrap().reached
        };
        let (slow, fast) = (reached(28.0, 1e-3), reached(28.0, 5e-5));
        assert!(slow.contains("samples limited by the driver's current at the jump from one held"), "{slow}");
        assert!(slow.contains("is at most 70.95 mA of 500 mA"), "{slow}");
        assert!(fast.ends_with("samples limited by the driver's current"), "{fast}");
        assert_eq!(reached(10.0, 1e-3), "");
    }

    #[test]
    fn a_gaussian_process_states_its_deviation_in_a_third_column() {
        use piezoid_models::hysteresis::Operator;
        use piezoid_models::linear::Arx;
        let model = |operator: &str| {
            let hysteresis = (Operator::find(operator).unwrap().example)(1e-3).unwrap();
            Subject::Model(Box::new(
                Model::new(hysteresis, Arx::new(1e-3, vec![0.5], vec![1.0]).unwrap(), 0.0).unwrap(),
            ))
        };
        let u: Vec<f64> = (0..300).map(|t| (0.15 * f64::from(t) + 10.0) * (0.2 * f64::from(t)).sin()).collect();
        let input: DataFile = File::new("u.csv", Table::write("u.csv", 1e-3, &[("u_V", &u)]).unwrap()).into();
        let options = SimulateOptions { deviation: true, ..SimulateOptions::default() };
        let columns = &ColumnSelection::default();
        let found = options.run(&model("gaussian-process"), &input, columns).unwrap();
        let mut written = Vec::new();
        options.write(&model("gaussian-process"), (&input, columns), ("y.csv", &mut written)).unwrap();
        assert_eq!(found.written("y.csv").unwrap(), written);
        assert!(String::from_utf8(written).unwrap().starts_with("t_s,u_V,y_um,sd_um\n"));
        let most = |samples: &[f64]| samples.iter().copied().fold(0.0, f64::max);
        let (within, beyond) = found.deviation.split_at(60);
        assert!(0.0 < most(within) && 2.0 * most(within) < most(beyond), "{} {}", most(within), most(beyond));
        let refused = options.run(&model("preisach"), &input, columns).unwrap_err().to_string();
        assert!(refused.contains("--operator gaussian-process"), "{refused}");
    }
}
