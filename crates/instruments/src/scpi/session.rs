//! A generator and an oscilloscope as an [`Instrument`].

use super::generator::Generator;
use super::line::Line;
use super::oscilloscope::{Oscilloscope, Probe};
use super::wave::{HIGHEST, MEMORY, Wave};
use crate::checks::{at_place, range};
use crate::gcs::{Axis, Controller};
use crate::instrument::measured_by;
use crate::moves::Moves;
use crate::watch::Watch;
use crate::{ConnectOptions, Drive, Instrument, InstrumentOptions, Left, Rest, Setup};
use piezoid::progress::Progress;
use piezoid::{Error, Record, Units};
use serde_json::Value;

/// Name of the only axis, in messages.
pub(crate) const AXIS: &str = "1";

/// Sampling periods are multiples of this one [s].
const CYCLE: f64 = 1e-6;

/// Error of a voltage that says nothing [V].
const NOISE: f64 = 0.05;

/// Connections to both instruments.
pub(crate) struct Scpi<'a> {
    generator: Generator<'a>,
    oscilloscope: Oscilloscope<'a>,
    setup: Setup,
    /// What was prepared.
    wave: Option<Wave>,
    /// The voltage before anything moved [V].
    start: Option<f64>,
    /// Where the output is, and the last voltage of the drive [V]; least time of a slow move [s].
    at: f64,
    last: f64,
    ramp: f64,
}

impl<'a> Scpi<'a> {
    /// What a generator reports. Nothing moves, and nothing is set.
    pub(crate) fn look(options: &ConnectOptions, progress: &mut Progress) -> Result<Controller, Error> {
        let line = Line::open((&options.host, options.port), options.patience(), Watch::new(progress))?;
        let axis = Axis {
            name: AXIS.into(),
            unit: "um".into(),
            servo: None,
            position: None,
            // It does not know the amplifier.
            voltage: None,
            range: None,
        };
        Ok(Controller {
            identity: line.identity,
            error: 0,
            is_moving: false,
            generators: Vec::new(),
            cycle: Some(CYCLE),
            table: Some(MEMORY),
            recorder: None,
            axes: vec![axis],
        })
    }

    /// Connects to both, and checks that the output stands still. Nothing moves.
    pub(crate) fn open(options: &InstrumentOptions, progress: &'a mut Progress<'_>) -> Result<Self, Error> {
        let limits = options.limits.limits()?.unwrap_or_default();
        let gain = options.gain.ok_or_else(|| {
            Error::Content("a generator does not know the amplifier: ".into()).needing(vec![("gain", Value::Null)])
        })?;
        // The range of an amplifier is not known to a generator.
        range(&limits, None)?;
        let range = range(&limits, Some((-HIGHEST * gain, HIGHEST * gain)))?;
        if let Some(axis) = options.axis.as_ref().filter(|axis| *axis != AXIS) {
            return Err(Error::parameter("axis", axis, "can only be 1 with SCPI: choose an output by --channel"));
        }
        let (scpi, connection) = (&options.scpi, &options.connection);
        let sensor = Probe { channel: scpi.sensor_channel, scale: scpi.scale()? };
        let scale = scpi.monitor_gain.unwrap_or(gain);
        let monitor = scpi.monitor_channel.map(|channel| Probe { channel, scale });
        if monitor.is_some_and(|monitor| monitor.channel == sensor.channel) {
            return Err(Error::parameter("monitor_channel", sensor.channel, "is that of the sensor: choose another"));
        }
        let (span, (host, port)) = (scpi.span()?, scpi.address(&connection.host)?);
        let watch = Watch::new(progress);
        let beside = watch.beside();
        let line = Line::open((&connection.host, connection.port), connection.patience(), watch)?;
        let mut generator =
            Generator { line, channel: options.channel.unwrap_or(1), gain, range, fastest: limits.fastest() };
        generator.check()?;
        let line = Line::open((&host, port), connection.patience(), beside)?;
        let mut oscilloscope = Oscilloscope { line, monitor, sensor, span };
        let holds = vec![("the generator", MEMORY), ("the oscilloscope", oscilloscope.holds()?)];
        let setup = Setup {
            identity: format!("{} with {}", generator.line.identity, oscilloscope.line.identity),
            axis: AXIS.into(),
            unit: "V".into(),
            range,
            limits,
            cycle: options.cycle.unwrap_or(CYCLE),
            holds,
            joins: true,
            servo: None,
        };
        let ramp = options.ramp;
        Ok(Scpi { generator, oscilloscope, setup, wave: None, start: None, at: 0.0, last: 0.0, ramp })
    }
}

impl Instrument for Scpi<'_> {
    fn setup(&self) -> &Setup {
        &self.setup
    }

    fn prepare(&mut self, drive: &Drive) -> Result<(), Error> {
        self.setup.check(drive)?;
        self.generator.watch().enter(drive.what);
        self.oscilloscope.line.wire.watch.enter(drive.what);
        let generator = &mut self.generator;
        let wave = Wave::new(drive, generator.gain, generator.fastest, generator.range)?;
        at_place(AXIS, generator.voltage()?, generator.range, NOISE)?;
        self.oscilloscope.configure(drive, &wave)?;
        generator.upload(&wave)?;
        self.wave = Some(wave);
        Ok(())
    }

    fn play(&mut self, drive: &Drive) -> Result<Record, Error> {
        let Some(wave) = &self.wave else { return Err(Error::Content("no drive was prepared".into())) };
        let generator = &mut self.generator;
        if self.start.is_none() {
            let start = generator.voltage()?;
            (self.start, self.at) = (Some(start), start);
            generator.switch_on()?;
        }
        let offset = generator.gain * wave.offset;
        generator.ramp(self.at, offset, drive.ramp)?;
        self.at = offset;
        if offset == drive.u[0] {
            generator.settle(offset, drive.settle)?;
        }
        generator.expect(offset, "after the move to the first voltage of the drive")?;
        generator.arm(wave)?;
        self.oscilloscope.arm(wave)?;
        generator.play(wave)?;
        (self.last, self.ramp) = (drive.u.last().copied().unwrap_or_default(), drive.ramp);
        let (u, y) = self.oscilloscope.read(drive, wave)?;
        let units = Units { u: "V".into(), y: "um".into() };
        let record = Record::new(drive.ts, u.unwrap_or_else(|| drive.u.to_vec()), y)?.with_units(units);
        Ok(measured_by(&self.setup.identity, record))
    }

    fn rest(&mut self, rest: Rest) -> Result<Left, Error> {
        self.generator.watch().enter("");
        if let Some(start) = self.start {
            // The wave has gone back from the last voltage of the drive to its offset.
            let target = match rest {
                Rest::Start => start,
                Rest::Zero => 0.0,
                Rest::Stay => self.last,
            };
            self.generator.ramp(self.at, target, self.ramp)?;
            self.at = target;
            self.generator.expect(target, "after the move to rest")?;
        }
        self.generator.left()
    }

    fn stop(&mut self) -> (Left, String) {
        self.generator.stop()
    }
}
