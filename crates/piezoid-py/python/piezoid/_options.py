"""The options of the library as keywords of functions. Written by `cargo xtask generate bindings`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, Literal, TypedDict

if TYPE_CHECKING:
    from typing_extensions import Required


class CertificateOptions(TypedDict, total=False):
    """Keywords of `Model.certificate`.

    coverage: Coverage probability of the expanded uncertainty [%]; default: 95.45
    noise: What the noise of the records is taken for ["unknown" or "sensor"]; default: unknown
    mean_error: What happens to the mean error of the predictions ["included" or "corrected"]; default: included
    skip: Time at the start of each record that the error figures leave out [s]; default: 0
    offset: Offset of the model ["kept" or "free" or "drift"]; default: kept

    Uncertainties as stated:

    sensor_calibration: Expanded uncertainty of the scale of the sensor, relative to the displacement, from its
        certificate [%]
    sensor_k: Coverage factor of sensor_calibration; default: 2
    sensor_linearity: Largest deviation of the sensor from its straight line: a number in the output unit, or with a
        unit (50nm)
    resolution: Smallest step of the reading, written like sensor_linearity
    drift: Largest drift of sensor and actuator from the records to the use, written like sensor_linearity
    temperature_coefficient: Change of the displacement per kelvin: a length such as 20nm, or a share of the
        displacement such as 0.1%
    temperature_half_width: Largest difference of the temperature from that of the records [K]
    voltage_gain: Expanded uncertainty of the gain of driver and voltmeter, relative to the voltage [%]
    voltage_k: Coverage factor of voltage_gain; default: 2
    voltage_offset: Largest offset of the voltage, in the unit of the input [V]

    Certificate:

    temperature: Temperature of the records [degC]
    date: Date of issue, such as 2026-11-30: a certificate does not read the clock
    measured: Date on which the records were measured; default: the date of issue
    number: Number of the certificate; default: one from the hashes of all files
    issuer: Who states it
    person: The person responsible; default: the issuer
    customer: Who it is for
    country: Country of the issuer: two letters (ISO 3166-1)
    item: The actuator: manufacturer and type
    serial: Serial number of the actuator
    sensor: The sensor of the records, with the number of its certificate
    """

    coverage: float | str
    noise: Literal["unknown", "sensor"]
    mean_error: Literal["included", "corrected"]
    sensor_calibration: float | str | None
    sensor_k: float
    sensor_linearity: str | None
    resolution: str | None
    drift: str | None
    temperature_coefficient: str | None
    temperature_half_width: float | str | None
    voltage_gain: float | str | None
    voltage_k: float
    voltage_offset: float | str | None
    temperature: float | str | None
    date: str | None
    measured: str | None
    number: str | None
    issuer: str | None
    person: str | None
    customer: str | None
    country: str | None
    item: str | None
    serial: str | None
    sensor: str | None
    skip: float | str
    offset: Literal["kept", "free", "drift"]


class ColumnOptions(TypedDict, total=False):
    """Keywords of `read` and `inspect`.

    ts: Sampling period, for files without a time column [s]
    fs: Sampling rate, in place of the sampling period [Hz]
    time_unit: Unit of the time column: s, ms, us, ns, min or h; default: the one in its name
    time_col: Name or number of the time column; default: t_s, or the one named like a time
    input_col: Name or number of the input column; default: u_V, or the one named like a voltage
    output_col: Name or number of the output column; default: y_*, or the one named like a displacement
    input_unit: Unit of the input; default: the one in its name
    output_unit: Unit of the output; default: the one in its name
    input_scale: Factor of the input, such as 20 for an amplifier of gain 20 whose input was recorded; default: 1
    output_scale: Factor of the output, such as 5um/V for a sensor; default: 1
    """

    ts: float | str | None
    fs: float | str | None
    time_unit: str | None
    time_col: str | int | None
    input_col: str | int | None
    output_col: str | int | None
    input_unit: str | None
    output_unit: str | None
    input_scale: float | str | None
    output_scale: float | str | None


class CompareOptions(TypedDict, total=False):
    """Keywords of `compare`.

    skip: Time at the start of each record that the error figures leave out [s]; default: 0
    offset: Offset of the model ["kept" or "free" or "drift"]; default: kept

    Identified methods:

    held_out: Share at the end of each training record that no method is fitted to, and on which all are compared;
        unless there are other records for this; default: 0.25
    effort: How much the search tries, as in identify ["quick" or "usual" or "thorough"]; default: usual
    seed: Seed of the search; default: 1
    driver: The driver used for the records; give it if its current or slew limit was reached (see `pz.drivers`)
    capacitance: Capacitance of the load, for the driver's current limit [F]
    driver_lag: Time constant of the driver, where it is known [s]
    driver_slew: Slew rate of the driver, if known [V/s]
    """

    skip: float | str
    offset: Literal["kept", "free", "drift"]
    held_out: float
    effort: Literal["quick", "usual", "thorough"]
    seed: int
    driver: str | None
    capacitance: float | str | None
    driver_lag: float | str | None
    driver_slew: float | str | None


class CompensateOptions(TypedDict, total=False):
    """Keywords of `Model.compensate`.

    clip: Clip the voltage to the limits, instead of refusing a reference that exceeds them
    iterations: Largest number of iterations that correct the error left in the model's free run; default: 0
    model_error: Error of the model over peak-to-peak, if a validation found a larger one than its file states [%]
    smooth: Smooth steps and corners to minimum-jerk moves of this duration [s]
    notch: Filter the reference with a notch at the model's resonance
    zvd: Shape the reference (ZVD) so that the resonance is not excited

    Driver:

    driver: The driver whose limits the voltage must keep (see `pz.drivers`)
    capacitance: Capacitance of the load, for the current limit [F]
    low: Lowest voltage [V]
    high: Highest voltage [V]
    slew: Largest slew rate of the voltage [V/s]
    current: Largest current, in both directions; needs capacitance [A]
    """

    clip: bool
    iterations: int
    model_error: float | str | None
    driver: str | None
    capacitance: float | str | None
    low: float | str | None
    high: float | str | None
    slew: float | str | None
    current: float | str | None
    smooth: float | str | None
    notch: bool
    zvd: bool


class TimingOptions(TypedDict, total=False):
    """Keywords of `timing`.

    tolerance: Largest error of a settled displacement: a number in the model's output unit, or with a unit, such as
        0.1um; default: 1 % of the height of the path
    step: Height of the step up and down that is the path if none is given, written like tolerance; default: a tenth of
        the stroke
    iterations: Largest number of iterations that correct the error left in the model's free run; default: 0
    smooth: Smooth steps and corners to minimum-jerk moves of this duration [s]
    notch: Filter the reference with a notch at the model's resonance
    zvd: Shape the reference (ZVD) so that the resonance is not excited

    Driver:

    driver: The driver whose limits the voltage must keep (see `pz.drivers`)
    capacitance: Capacitance of the load, for the current limit [F]
    low: Lowest voltage [V]
    high: Highest voltage [V]
    slew: Largest slew rate of the voltage [V/s]
    current: Largest current, in both directions; needs capacitance [A]
    """

    tolerance: str | None
    step: str | None
    iterations: int
    smooth: float | str | None
    notch: bool
    zvd: bool
    driver: str | None
    capacitance: float | str | None
    low: float | str | None
    high: float | str | None
    slew: float | str | None
    current: float | str | None


class ControlOptions(TypedDict, total=False):
    """Keywords of `control`.

    preview: Number of future samples of the reference that controllers may use; default: all
    clip: Clip the feed-forward to the limits, instead of refusing a reference that exceeds them
    seed: Seed of the noise and of the draws; default: 1
    delay_samples: Sensor delay in samples; controllers are tuned for it; default: 0
    gain_margin: Gain margin that controllers are tuned to [dB]; default: 6
    phase_margin: Phase margin that controllers are tuned to [degrees]; default: 45

    Driver:

    driver: The driver whose limits the voltage must keep (see `pz.drivers`)
    capacitance: Capacitance of the load, for the current limit [F]
    low: Lowest voltage [V]
    high: Highest voltage [V]
    slew: Largest slew rate of the voltage [V/s]
    current: Largest current, in both directions; needs capacitance [A]
    """

    preview: int | None
    clip: bool
    seed: int
    driver: str | None
    capacitance: float | str | None
    low: float | str | None
    high: float | str | None
    slew: float | str | None
    current: float | str | None
    delay_samples: int
    gain_margin: float | str
    phase_margin: float | str


class ExportOptions(TypedDict, total=False):
    """Keywords of `export`.

    name: Name prefix of the exported functions, types and files; default: piezo_model
    float: Use single precision
    preview: Samples of the reference that the feed-forward knows in advance; 0: as few as it needs; default: 0
    controller: A feedback controller to export with the model, tuned to it: any feedback of `pz.controllers` except
        predictive
    online: Export the estimator of `online` too, which follows gain, weights and linear block on the target
    delay_samples: Sensor delay in samples; controllers are tuned for it; default: 0
    gain_margin: Gain margin that controllers are tuned to [dB]; default: 6
    phase_margin: Phase margin that controllers are tuned to [degrees]; default: 45

    Waveforms:

    clip: Clip the voltage to the limits, instead of refusing a reference that exceeds them
    servo_cycle: Servo cycle of the GCS controller [s]; default: 5e-5
    range: Voltages [V] at 0 % and at 100 % of the NV200 amplifier, as its commands avmin and avmax report them

    Driver:

    driver: The driver whose limits the voltage must keep (see `pz.drivers`)
    capacitance: Capacitance of the load, for the current limit [F]
    low: Lowest voltage [V]
    high: Highest voltage [V]
    slew: Largest slew rate of the voltage [V/s]
    current: Largest current, in both directions; needs capacitance [A]

    Estimator:

    moves: What moves: a list of gain, offset, weights and linear, or auto for all that the model allows; default: auto
    gain_memory: Memory of the gain; the offset has ten times as much [samples]; default: 50
    memory: Memory of weights and linear block [samples]; default: 5000
    groups: Number of groups in which the weights of the hysteresis move; default: 4
    excitation: Rms of the alternating response, relative to half the stroke, below which only the offset moves [%];
        default: 1
    dead_zone: Errors up to this, in the unit of the output, move nothing; default: 0
    """

    name: str
    float: bool
    preview: int
    controller: str | None
    online: bool
    clip: bool
    servo_cycle: float | str
    range: Sequence[float] | None
    driver: str | None
    capacitance: float | str | None
    low: float | str | None
    high: float | str | None
    slew: float | str | None
    current: float | str | None
    delay_samples: int
    gain_margin: float | str
    phase_margin: float | str
    moves: str
    gain_memory: float | str
    memory: float | str
    groups: int
    excitation: float | str
    dead_zone: float


class IdentifyOptions(TypedDict, total=False):
    """Keywords of `identify`.

    method: Method of identification ["joint" or "paper"]; default: joint
    operator: The hysteresis operator (see `pz.operators`), or several separated by commas; auto tries all laws, all
        also the learned operators, and auto,-NAME all laws but one. The simplest one that predicts held-out parts as
        well as the best is selected. With the paper's method, auto selects two-branch or rate-scheduled; default: auto
    order: Order of the linear block; default: chosen; 2 by the paper's method
    seed: Seed of the swarm; default: 1

    Joint method:

    structure: Where hysteresis is ["hammerstein" or "feedback" or "auto"]; default: hammerstein
    effort: How much the search tries ["quick" or "usual" or "thorough"]; default: usual
    elements: Number of thresholds, levels or knots of the operator; default: default of the operator
    creep: Identify creep; default: true
    fractional_creep: Creep that grows as a power of time: its order is fitted, in place of a gain for each of its lags
    driver: The driver used for the records; give it if its current or slew limit was reached (see `pz.drivers`)
    capacitance: Capacitance of the load, for the driver's current limit [F]
    driver_lag: Time constant of the driver, where it is known [s]
    driver_slew: Slew rate of the driver, if known [V/s]

    Paper's method:

    estimator: The estimator of the linear block (see `pz.estimators`); default: swarm
    split: How the points of a loop are divided between the ascending and the descending branch ["line" or "direction"];
        default: line
    bins: Number of averaged points on each branch, between the reversals; default: 16
    reading: Which branch is read while the input is held ["held" or "printed"]; default: held
    particles: Particles of the swarm; default: 50
    iterations: Iterations of the swarm; default: 500
    global_best: The position that attracts all particles, g_best in equation (2) of the paper ["ever" or "current"];
        default: ever
    """

    method: Literal["joint", "paper"]
    operator: str
    structure: Literal["hammerstein", "feedback", "auto"]
    effort: Literal["quick", "usual", "thorough"]
    order: int | None
    seed: int
    elements: int | None
    creep: bool
    fractional_creep: bool
    driver: str | None
    capacitance: float | str | None
    driver_lag: float | str | None
    driver_slew: float | str | None
    estimator: str | None
    split: Literal["line", "direction"] | None
    bins: int | None
    reading: Literal["held", "printed"] | None
    particles: int | None
    iterations: int | None
    global_best: Literal["ever", "current"] | None


class InverseOptions(TypedDict, total=False):
    """Keywords of `Model.inverse`.

    clip: Clip the voltage to the limits, instead of refusing a reference that exceeds them
    model_error: Error of the model over peak-to-peak, if a validation found a larger one than its file states [%]

    Driver:

    driver: The driver whose limits the voltage must keep (see `pz.drivers`)
    capacitance: Capacitance of the load, for the current limit [F]
    low: Lowest voltage [V]
    high: Highest voltage [V]
    slew: Largest slew rate of the voltage [V/s]
    current: Largest current, in both directions; needs capacitance [A]
    """

    clip: bool
    model_error: float | str | None
    driver: str | None
    capacitance: float | str | None
    low: float | str | None
    high: float | str | None
    slew: float | str | None
    current: float | str | None


class OnlineOptions(TypedDict, total=False):
    """Keywords of `Online`.

    begin: State of the actuator before the first sample: at rest, or settled at the first input ["rest" or "settled"];
        default: settled
    every: Time between two rows of parameters [s]; default: a twentieth of a record, 1 s of a stream

    Estimator:

    moves: What moves: a list of gain, offset, weights and linear, or auto for all that the model allows; default: auto
    gain_memory: Memory of the gain; the offset has ten times as much [samples]; default: 50
    memory: Memory of weights and linear block [samples]; default: 5000
    groups: Number of groups in which the weights of the hysteresis move; default: 4
    excitation: Rms of the alternating response, relative to half the stroke, below which only the offset moves [%];
        default: 1
    dead_zone: Errors up to this, in the unit of the output, move nothing; default: 0
    """

    begin: Literal["rest", "settled"]
    every: float | str | None
    moves: str
    gain_memory: float | str
    memory: float | str
    groups: int
    excitation: float | str
    dead_zone: float


class PlanOptions(TypedDict, total=False):
    """Keywords of `plan`.

    range: Lowest and highest voltage of the application [V]; default: those of the actuator
    bandwidth: Highest frequency of the application [Hz]
    actuator: The actuator, for its range, capacitance and resonance (see `pz.actuators`)
    ts: Sampling period; drives with too many samples have a multiple of it [s]; default: from bandwidth and resonance
    points: Samples that the controller holds of a drive and of a record; default: 200000
    joins: True if it joins voltages by straight lines: drives that have too many samples are then sampled less often,
        otherwise they are shortened; default: true
    cycle: Servo cycle of the controller: sampling periods are multiples of it [s]; default: any sampling period

    Driver:

    driver: The driver whose limits the voltage must keep (see `pz.drivers`)
    capacitance: Capacitance of the load, for the current limit [F]
    low: Lowest voltage [V]
    high: Highest voltage [V]
    slew: Largest slew rate of the voltage [V/s]
    current: Largest current, in both directions; needs capacitance [A]
    """

    range: Sequence[float] | None
    bandwidth: Required[float | str]
    actuator: str | None
    ts: float | str | None
    points: int
    joins: bool
    cycle: float | str | None
    driver: str | None
    capacitance: float | str | None
    low: float | str | None
    high: float | str | None
    slew: float | str | None
    current: float | str | None


class PrepareOptions(TypedDict, total=False):
    """Keywords of `Record.prepare`.

    input_offset: Offset that is added to the input after scaling, in the unit of the input; default: 0
    output_offset: Offset that is added to the output after scaling, in the unit of the output; default: 0
    outliers: Replace single spikes of the output by interpolation
    detrend: Subtract the mean or a straight line from the output ["mean" or "line"]
    average: Average all periods: the result is one period long
    period: Period of the input [s]; default: found in the input
    delay: Delay of the output. The output is shifted earlier by this time; later if the value is negative [s]
    decimate: Keep every N-th sample, after an anti-alias filter
    resample: New sampling period, by band-limited interpolation; uneven times of a file are made even first [s]
    """

    input_offset: float
    output_offset: float
    outliers: bool
    detrend: Literal["mean", "line"] | None
    average: bool
    period: float | str | None
    delay: float | str | None
    decimate: int | None
    resample: float | str | None


class SimulateOptions(TypedDict, total=False):
    """Keywords of `Plant.simulate`.

    begin: Initial condition: at rest; settled at the first input, directly or after cycles over the whole range; or in
        motion as in the record ["rest" or "settled" or "from-above" or "from-below" or "demagnetised" or "motion"];
        default: rest
    seed: Seed of the plant's noise; default: 1
    """

    begin: Literal["rest", "settled", "from-above", "from-below", "demagnetised", "motion"]
    seed: int


class StudyOptions(TypedDict, total=False):
    """Keywords of `study`.

    seed: Seed of the swarm and of the plant's noise; default: 1
    """

    seed: int


class SwarmOptions(TypedDict, total=False):
    """Keywords of `linear.fit`.

    seed: Seed of the swarm; default: 1

    Paper's method:

    particles: Particles of the swarm; default: 50
    iterations: Iterations of the swarm; default: 500
    global_best: The position that attracts all particles, g_best in equation (2) of the paper ["ever" or "current"];
        default: ever
    """

    seed: int
    particles: int | None
    iterations: int | None
    global_best: Literal["ever", "current"] | None


class ValidateOptions(TypedDict, total=False):
    """Keywords of `Model.validate`.

    skip: Time at the start of each record that the error figures leave out [s]; default: 0
    offset: Offset of the model ["kept" or "free" or "drift"]; default: kept
    """

    skip: float | str
    offset: Literal["kept", "free", "drift"]


DEFAULTS: dict[str, dict[str, Any]] = {
    "CertificateOptions": {
        "coverage": 95.45,
        "noise": "unknown",
        "mean_error": "included",
        "sensor_calibration": None,
        "sensor_k": 2.0,
        "sensor_linearity": None,
        "resolution": None,
        "drift": None,
        "temperature_coefficient": None,
        "temperature_half_width": None,
        "voltage_gain": None,
        "voltage_k": 2.0,
        "voltage_offset": None,
        "temperature": None,
        "date": None,
        "measured": None,
        "number": None,
        "issuer": None,
        "person": None,
        "customer": None,
        "country": None,
        "item": None,
        "serial": None,
        "sensor": None,
        "skip": 0.0,
        "offset": "kept",
    },
    "ColumnOptions": {
        "ts": None,
        "fs": None,
        "time_unit": None,
        "time_col": None,
        "input_col": None,
        "output_col": None,
        "input_unit": None,
        "output_unit": None,
        "input_scale": None,
        "output_scale": None,
    },
    "CompareOptions": {
        "skip": 0.0,
        "offset": "kept",
        "held_out": 0.25,
        "effort": "usual",
        "seed": 1,
        "driver": None,
        "capacitance": None,
        "driver_lag": None,
        "driver_slew": None,
    },
    "CompensateOptions": {
        "clip": False,
        "iterations": 0,
        "model_error": None,
        "driver": None,
        "capacitance": None,
        "low": None,
        "high": None,
        "slew": None,
        "current": None,
        "smooth": None,
        "notch": False,
        "zvd": False,
    },
    "TimingOptions": {
        "tolerance": None,
        "step": None,
        "iterations": 0,
        "smooth": None,
        "notch": False,
        "zvd": False,
        "driver": None,
        "capacitance": None,
        "low": None,
        "high": None,
        "slew": None,
        "current": None,
    },
    "ControlOptions": {
        "preview": None,
        "clip": False,
        "seed": 1,
        "driver": None,
        "capacitance": None,
        "low": None,
        "high": None,
        "slew": None,
        "current": None,
        "delay_samples": 0,
        "gain_margin": 6.0,
        "phase_margin": 45.0,
    },
    "ExportOptions": {
        "name": "piezo_model",
        "float": False,
        "preview": 0,
        "controller": None,
        "online": False,
        "clip": False,
        "servo_cycle": 0.00005,
        "range": None,
        "driver": None,
        "capacitance": None,
        "low": None,
        "high": None,
        "slew": None,
        "current": None,
        "delay_samples": 0,
        "gain_margin": 6.0,
        "phase_margin": 45.0,
        "moves": "auto",
        "gain_memory": 50.0,
        "memory": 5000.0,
        "groups": 4,
        "excitation": 1.0,
        "dead_zone": 0.0,
    },
    "IdentifyOptions": {
        "method": "joint",
        "operator": "auto",
        "structure": "hammerstein",
        "effort": "usual",
        "order": None,
        "seed": 1,
        "elements": None,
        "creep": True,
        "fractional_creep": False,
        "driver": None,
        "capacitance": None,
        "driver_lag": None,
        "driver_slew": None,
        "estimator": None,
        "split": None,
        "bins": None,
        "reading": None,
        "particles": None,
        "iterations": None,
        "global_best": None,
    },
    "InverseOptions": {
        "clip": False,
        "model_error": None,
        "driver": None,
        "capacitance": None,
        "low": None,
        "high": None,
        "slew": None,
        "current": None,
    },
    "OnlineOptions": {
        "begin": "settled",
        "every": None,
        "moves": "auto",
        "gain_memory": 50.0,
        "memory": 5000.0,
        "groups": 4,
        "excitation": 1.0,
        "dead_zone": 0.0,
    },
    "PlanOptions": {
        "range": None,
        "bandwidth": 50.0,
        "actuator": None,
        "ts": None,
        "points": 200000,
        "joins": True,
        "cycle": None,
        "driver": None,
        "capacitance": None,
        "low": None,
        "high": None,
        "slew": None,
        "current": None,
    },
    "PrepareOptions": {
        "input_offset": 0.0,
        "output_offset": 0.0,
        "outliers": False,
        "detrend": None,
        "average": False,
        "period": None,
        "delay": None,
        "decimate": None,
        "resample": None,
    },
    "SimulateOptions": {
        "begin": "rest",
        "seed": 1,
    },
    "StudyOptions": {
        "seed": 1,
    },
    "SwarmOptions": {
        "seed": 1,
        "particles": None,
        "iterations": None,
        "global_best": None,
    },
    "ValidateOptions": {
        "skip": 0.0,
        "offset": "kept",
    },
}
"""The defaults by class and name; None if an option has no value by default."""
