// The lists of the library and the options of its calls. Written by `cargo xtask generate bindings`.

/** An option. */
export interface OptionRow<Name extends string = string> {
  name: Name;
  kind: "choice" | "integer" | "number" | "numbers" | "pair" | "switch" | "text" | "texts";
  choices: [string, string][] | null;
  unit: string;
  help: string;
  group: string;
  list: string;
  requires: string;
  default: boolean | null | number | number[] | string;
  usual: string;
  rule: string;
  required: boolean;
}

/** A member of a family. */
export interface Member {
  name: string;
  summary: string;
  reference: string;
}

/** All lists. */
export interface Lists {
  operations: {
    name: string;
    summary: string;
    module: string;
    roles: {
      name: string;
      least: number;
      many: boolean;
    }[];
    options: OptionRow[];
  }[];
  columns: OptionRow[];
  operators: {
    name: string;
    summary: string;
    reference: string;
    aliases: string[];
    minor_loops: boolean;
    needs_minor_loops: boolean;
    rate_independent: boolean;
    wipes_out: boolean;
    class: string;
    learned: boolean;
    picture: string;
  }[];
  excitations: {
    name: string;
    summary: string;
    reference: string;
    options: OptionRow[];
  }[];
  plants: Member[];
  drivers: {
    name: string;
    summary: string;
    reference: string;
    capacitance: null | number;
    low: null | number;
    high: null | number;
    slew: null | number;
    current: null | number;
    continuous: null | number;
    gain: null | number;
    bandwidth: null | number;
  }[];
  actuators: {
    name: string;
    maker: string;
    model: string;
    kind: "amplified" | "bender" | "stack" | "stage" | "tube";
    low: number;
    high: number;
    stroke: number;
    unit: string;
    stroke_at: number[];
    capacitance: null | number;
    resonance: null | number;
    stiffness: null | number;
    blocking_force: null | number;
    reference: string;
    summary: string;
  }[];
  controllers: {
    name: string;
    summary: string;
    reference: string;
    uses_feed_forward?: boolean;
  }[];
  references: {
    name: string;
    summary: string;
  }[];
  targets: {
    name: string;
    summary: string;
    reference: string;
    operators: Record<string, string[]>;
    takes: string[];
  }[];
  estimators: Member[];
  formats: {
    name: string;
    extensions: string[];
    summary: string;
    reference: string;
  }[];
  methods: {
    name: string;
    summary: string;
  }[];
}

/** The options of each call by name. */
export interface CallOptions {
  /** Show what data files hold, how they are read and what seems wrong; write a profile of a rig. */
  inspect: {
  };
  /** Prepare a record: cut, filter, decimate, resample, average periods, align, repair, calibrate. */
  prepare: {
    /** Offset that is added to the input after scaling, in the unit of the input */
    input_offset?: number | string;
    /** Offset that is added to the output after scaling, in the unit of the output */
    output_offset?: number | string;
    /** Replace single spikes of the output by interpolation */
    outliers?: boolean;
    /** Subtract the mean or a straight line from the output */
    detrend?: "mean" | "line";
    /** Average all periods: the result is one period long */
    average?: boolean;
    /** Period of the input [s] */
    period?: number | string;
    /** Delay of the output. The output is shifted earlier by this time; later if the value is negative [s] */
    delay?: number | string;
    /** Keep every N-th sample, after an anti-alias filter */
    decimate?: number;
    /** New sampling period, by band-limited interpolation; uneven times of a file are made even first [s] */
    resample?: number | string;
  };
  /** Make a drive signal: PRBS, sines, chirps, steps. */
  excite: {
    /** The kind of signal */
    kind?: string;
    /** Sampling period [s] */
    ts: number | string;
    /** Duration of the signal [s] */
    duration: number | string;
    /** Clip the signal to the limits, instead of refusing one that exceeds them */
    clip?: boolean;
    /** Unit of the amplitude: `V` for a drive signal, a unit of displacement such as `um` for a reference */
    unit?: string;
    /** The driver whose limits the voltage must keep (see {list}) */
    driver?: string;
    /** Capacitance of the load, for the current limit [F] */
    capacitance?: number | string;
    /** Lowest voltage [V] */
    low?: number | string;
    /** Highest voltage [V] */
    high?: number | string;
    /** Largest slew rate of the voltage [V/s] */
    slew?: number | string;
    /** Largest current, in both directions; needs {capacitance} [A] */
    current?: number | string;
  };
  /** Plan the records of an identification: the drives within a driver's limits, and what each is for. */
  plan: {
    /** Lowest and highest voltage of the application [V] */
    range?: [number, number];
    /** Highest frequency of the application [Hz] */
    bandwidth: number | string;
    /** The actuator, for its range, capacitance and resonance (see {list}) */
    actuator?: string;
    /** Sampling period; drives with too many samples have a multiple of it [s] */
    ts?: number | string;
    /** Samples that the controller holds of a drive and of a record */
    points?: number;
    /** True if it joins voltages by straight lines: drives that have too many samples are then sampled less often, otherwise they are shortened */
    joins?: boolean;
    /** Servo cycle of the controller: sampling periods are multiples of it [s] */
    cycle?: number | string;
    /** The driver whose limits the voltage must keep (see {list}) */
    driver?: string;
    /** Capacitance of the load, for the current limit [F] */
    capacitance?: number | string;
    /** Lowest voltage [V] */
    low?: number | string;
    /** Highest voltage [V] */
    high?: number | string;
    /** Largest slew rate of the voltage [V/s] */
    slew?: number | string;
    /** Largest current, in both directions; needs {capacitance} [A] */
    current?: number | string;
  };
  /** Check records of a real actuator and pack them as evidence for all, or check such an archive. */
  contribute: {
    /** Licence of the records */
    licence?: "CC-BY-4.0" | "CC0-1.0";
    /** The actuator: manufacturer, type, what it carries */
    actuator?: string;
    /** The driver: manufacturer, type, gain, and where the voltage was measured */
    driver?: string;
    /** The sensor: manufacturer, type, range, bandwidth */
    sensor?: string;
    /** Who measured the records, as it shall be stated */
    who?: string;
    /** Conditions: temperature, load, preload, age */
    conditions?: string;
  };
  /** Run a plant or a model on a drive signal. */
  simulate: {
    /** The plant to simulate, unless a model or a stand-in is given */
    plant?: string;
    /** Initial condition: at rest; settled at the first input, directly or after cycles over the whole range; or in motion as in the record */
    begin?: "rest" | "settled" | "from-above" | "from-below" | "demagnetised" | "motion";
    /** Seed of the plant's noise */
    seed?: number;
    /** Add the standard deviation of a model's response, which the operator gaussian-process states */
    deviation?: boolean;
  };
  /** Show the hysteresis loop of a record: its reversals, separating line and branches. */
  loops: {
    /** How the points are divided between the ascending and the descending branch */
    split?: "line" | "direction";
    /** Number of averaged points on each branch, between the reversals */
    bins?: number;
    /** The separating line: its z at the lowest and at the highest input */
    line?: [number, number];
  };
  /** Identify a model from measured records. */
  identify: {
    /** Method of identification */
    method?: "joint" | "paper";
    /** The hysteresis operator (see {list}), or several separated by commas; auto tries all laws, all also the learned operators, and auto,-NAME all laws but one. The simplest one that predicts held-out parts as well as the best is selected. With the paper's method, auto selects two-branch or rate-scheduled */
    operator?: string;
    /** Where hysteresis is */
    structure?: "hammerstein" | "feedback" | "auto";
    /** How much the search tries */
    effort?: "quick" | "usual" | "thorough";
    /** Order of the linear block */
    order?: number;
    /** Seed of the swarm */
    seed?: number;
    /** Number of thresholds, levels or knots of the operator */
    elements?: number;
    /** Identify creep */
    creep?: boolean;
    /** Creep that grows as a power of time: its order is fitted, in place of a gain for each of its lags */
    fractional_creep?: boolean;
    /** The driver used for the records; give it if its current or slew limit was reached (see {list}) */
    driver?: string;
    /** Capacitance of the load, for the driver's current limit [F] */
    capacitance?: number | string;
    /** Time constant of the driver, where it is known [s] */
    driver_lag?: number | string;
    /** Slew rate of the driver, if known [V/s] */
    driver_slew?: number | string;
    /** The estimator of the linear block (see {list}) */
    estimator?: string;
    /** How the points of a loop are divided between the ascending and the descending branch */
    split?: "line" | "direction";
    /** Number of averaged points on each branch, between the reversals */
    bins?: number;
    /** Which branch is read while the input is held */
    reading?: "held" | "printed";
    /** Particles of the swarm */
    particles?: number;
    /** Iterations of the swarm */
    iterations?: number;
    /** The position that attracts all particles, g_best in equation (2) of the paper */
    global_best?: "ever" | "current";
  };
  /** Make a stand-in for an actuator: a second model of its records, to try voltages and controllers on. */
  "stand-in": {
  };
  /** Validate a model on records that were not used to identify it. */
  validate: {
    /** Time at the start of each record that the error figures leave out [s] */
    skip?: number | string;
    /** Offset of the model */
    offset?: "kept" | "free" | "drift";
  };
  /** Compute the voltage for a requested displacement. */
  compensate: {
    /** Also play the path on this plant, with and without compensation */
    plant?: string;
    /** Clip the voltage to the limits, instead of refusing a reference that exceeds them */
    clip?: boolean;
    /** Largest number of iterations that correct the error left in the model's free run */
    iterations?: number;
    /** Error of the model over peak-to-peak, if a validation found a larger one than its file states [%] */
    model_error?: number | string;
    /** The driver whose limits the voltage must keep (see {list}) */
    driver?: string;
    /** Capacitance of the load, for the current limit [F] */
    capacitance?: number | string;
    /** Lowest voltage [V] */
    low?: number | string;
    /** Highest voltage [V] */
    high?: number | string;
    /** Largest slew rate of the voltage [V/s] */
    slew?: number | string;
    /** Largest current, in both directions; needs {capacitance} [A] */
    current?: number | string;
    /** Smooth steps and corners to minimum-jerk moves of this duration [s] */
    smooth?: number | string;
    /** Filter the reference with a notch at the model's resonance */
    notch?: boolean;
    /** Shape the reference (ZVD) so that the resonance is not excited */
    zvd?: boolean;
  };
  /** Time moves along a path: settling, overshoot, scan lag; find the fastest step and flyback. */
  timing: {
    /** Also play the path on this plant */
    plant?: string;
    /** Largest error of a settled displacement: a number in the model's output unit, or with a unit, such as 0.1um */
    tolerance?: string;
    /** Height of the step up and down that is the path if none is given, written like {tolerance} */
    step?: string;
    /** Largest number of iterations that correct the error left in the model's free run */
    iterations?: number;
    /** Smooth steps and corners to minimum-jerk moves of this duration [s] */
    smooth?: number | string;
    /** Filter the reference with a notch at the model's resonance */
    notch?: boolean;
    /** Shape the reference (ZVD) so that the resonance is not excited */
    zvd?: boolean;
    /** The driver whose limits the voltage must keep (see {list}) */
    driver?: string;
    /** Capacitance of the load, for the current limit [F] */
    capacitance?: number | string;
    /** Lowest voltage [V] */
    low?: number | string;
    /** Highest voltage [V] */
    high?: number | string;
    /** Largest slew rate of the voltage [V/s] */
    slew?: number | string;
    /** Largest current, in both directions; needs {capacitance} [A] */
    current?: number | string;
  };
  /** Follow gain, hysteresis weights and linear block of a model along a stream or a record. */
  online: {
    /** State of the actuator before the first sample: at rest, or settled at the first input */
    begin?: "rest" | "settled";
    /** Time between two rows of parameters [s] */
    every?: number | string;
    /** What moves: a list of gain, offset, weights and linear, or auto for all that the model allows */
    moves?: string;
    /** Memory of the gain; the offset has ten times as much [samples] */
    gain_memory?: number | string;
    /** Memory of weights and linear block [samples] */
    memory?: number | string;
    /** Number of groups in which the weights of the hysteresis move */
    groups?: number;
    /** Rms of the alternating response, relative to half the stroke, below which only the offset moves [%] */
    excitation?: number | string;
    /** Errors up to this, in the unit of the output, move nothing */
    dead_zone?: number | string;
  };
  /** Close the loop on a simulated actuator and compare controllers. */
  control: {
    /** The plant that is controlled, unless a stand-in is given */
    plant?: string;
    /** Controllers to compare, such as feed-forward+pi */
    controller?: string[];
    /** References: files, or names such as sine:5 */
    reference?: string[];
    /** Peak of named references, in the model's output unit */
    amplitude?: number | string;
    /** Number of future samples of the reference that controllers may use */
    preview?: number;
    /** Noise of the sensor, rms in the model's output unit */
    noise?: number | string;
    /** Clip the feed-forward to the limits, instead of refusing a reference that exceeds them */
    clip?: boolean;
    /** Also simulate random plants whose parameters differ from those of the plant by up to this many percent, on the first reference [%] */
    tolerance?: number | string;
    /** Number of these random plants */
    draws?: number;
    /** Seed of the noise and of the draws */
    seed?: number;
    /** The driver whose limits the voltage must keep (see {list}) */
    driver?: string;
    /** Capacitance of the load, for the current limit [F] */
    capacitance?: number | string;
    /** Lowest voltage [V] */
    low?: number | string;
    /** Highest voltage [V] */
    high?: number | string;
    /** Largest slew rate of the voltage [V/s] */
    slew?: number | string;
    /** Largest current, in both directions; needs {capacitance} [A] */
    current?: number | string;
    /** Sensor delay in samples; controllers are tuned for it */
    delay_samples?: number;
    /** Gain margin that controllers are tuned to [dB] */
    gain_margin?: number | string;
    /** Phase margin that controllers are tuned to [degrees] */
    phase_margin?: number | string;
  };
  /** Write a self-contained HTML report on a model and its free-run errors on records. */
  report: {
    /** Address of the page that has the project open, for a link to it */
    project?: string;
    /** Time at the start of each record that the error figures leave out [s] */
    skip?: number | string;
    /** Offset of the model */
    offset?: "kept" | "free" | "drift";
  };
  /** Certify the displacement that a model predicts: its expanded uncertainty, after the GUM. */
  certificate: {
    /** Coverage probability of the expanded uncertainty [%] */
    coverage?: number | string;
    /** What the noise of the records is taken for */
    noise?: "unknown" | "sensor";
    /** What happens to the mean error of the predictions */
    mean_error?: "included" | "corrected";
    /** Expanded uncertainty of the scale of the sensor, relative to the displacement, from its certificate [%] */
    sensor_calibration?: number | string;
    /** Coverage factor of {sensor_calibration} */
    sensor_k?: number | string;
    /** Largest deviation of the sensor from its straight line: a number in the output unit, or with a unit (50nm) */
    sensor_linearity?: string;
    /** Smallest step of the reading, written like {sensor_linearity} */
    resolution?: string;
    /** Largest drift of sensor and actuator from the records to the use, written like {sensor_linearity} */
    drift?: string;
    /** Change of the displacement per kelvin: a length such as 20nm, or a share of the displacement such as 0.1% */
    temperature_coefficient?: string;
    /** Largest difference of the temperature from that of the records [K] */
    temperature_half_width?: number | string;
    /** Expanded uncertainty of the gain of driver and voltmeter, relative to the voltage [%] */
    voltage_gain?: number | string;
    /** Coverage factor of {voltage_gain} */
    voltage_k?: number | string;
    /** Largest offset of the voltage, in the unit of the input [V] */
    voltage_offset?: number | string;
    /** Temperature of the records [degC] */
    temperature?: number | string;
    /** Date of issue, such as 2026-11-30: a certificate does not read the clock */
    date?: string;
    /** Date on which the records were measured */
    measured?: string;
    /** Number of the certificate */
    number?: string;
    /** Who states it */
    issuer?: string;
    /** The person responsible */
    person?: string;
    /** Who it is for */
    customer?: string;
    /** Country of the issuer: two letters (ISO 3166-1) */
    country?: string;
    /** The actuator: manufacturer and type */
    item?: string;
    /** Serial number of the actuator */
    serial?: string;
    /** The sensor of the records, with the number of its certificate */
    sensor?: string;
    /** Time at the start of each record that the error figures leave out [s] */
    skip?: number | string;
    /** Offset of the model */
    offset?: "kept" | "free" | "drift";
  };
  /** Compare models, operators and structures on the same records. */
  compare: {
    /** Address of the page that has the project open, for a link to it */
    project?: string;
    /** The record whose loops and residuals are drawn; by default the first */
    record?: string;
    /** Time at the start of each record that the error figures leave out [s] */
    skip?: number | string;
    /** Offset of the model */
    offset?: "kept" | "free" | "drift";
    /** Hysteresis operators to identify, separated by commas, a row each (see {list}): all is each operator, auto the one that identify selects. They share one search for the structure */
    operators?: string;
    /** Structures to identify, separated by commas: hammerstein (each of the operators), no-creep, order-N (both with the selected operator), linear (no hysteresis), feedback and auto, as in identify */
    structures?: string;
    /** Share at the end of each training record that no method is fitted to, and on which all are compared; unless there are other records for this */
    held_out?: number | string;
    /** How much the search tries, as in identify */
    effort?: "quick" | "usual" | "thorough";
    /** Seed of the search */
    seed?: number;
    /** The driver used for the records; give it if its current or slew limit was reached (see {list}) */
    driver?: string;
    /** Capacitance of the load, for the driver's current limit [F] */
    capacitance?: number | string;
    /** Time constant of the driver, where it is known [s] */
    driver_lag?: number | string;
    /** Slew rate of the driver, if known [V/s] */
    driver_slew?: number | string;
  };
  /** Repeat the paper's experiment from end to end, as tables and a report. */
  study: {
    /** The plant to study (see {list}) */
    plant?: string;
    /** Seed of the swarm and of the plant's noise */
    seed?: number;
  };
  /** Export a model and its inverse as code or tables: C, FMU, Simulink, structured text, Rust, waveforms. */
  export: {
    /** The target language or format */
    target?: string;
    /** Name prefix of the exported functions, types and files */
    name?: string;
    /** Use single precision */
    float?: boolean;
    /** Samples of the reference that the feed-forward knows in advance; 0: as few as it needs */
    preview?: number;
    /** A feedback controller to export with the model, tuned to it: any feedback of {list} except predictive */
    controller?: string;
    /** Export the estimator of `online` too, which follows gain, weights and linear block on the target */
    online?: boolean;
    /** Clip the voltage to the limits, instead of refusing a reference that exceeds them */
    clip?: boolean;
    /** Servo cycle of the GCS controller [s] */
    servo_cycle?: number | string;
    /** Voltages [V] at 0 % and at 100 % of the NV200 amplifier, as its commands avmin and avmax report them */
    range?: [number, number];
    /** The driver whose limits the voltage must keep (see {list}) */
    driver?: string;
    /** Capacitance of the load, for the current limit [F] */
    capacitance?: number | string;
    /** Lowest voltage [V] */
    low?: number | string;
    /** Highest voltage [V] */
    high?: number | string;
    /** Largest slew rate of the voltage [V/s] */
    slew?: number | string;
    /** Largest current, in both directions; needs {capacitance} [A] */
    current?: number | string;
    /** Sensor delay in samples; controllers are tuned for it */
    delay_samples?: number;
    /** Gain margin that controllers are tuned to [dB] */
    gain_margin?: number | string;
    /** Phase margin that controllers are tuned to [degrees] */
    phase_margin?: number | string;
    /** What moves: a list of gain, offset, weights and linear, or auto for all that the model allows */
    moves?: string;
    /** Memory of the gain; the offset has ten times as much [samples] */
    gain_memory?: number | string;
    /** Memory of weights and linear block [samples] */
    memory?: number | string;
    /** Number of groups in which the weights of the hysteresis move */
    groups?: number;
    /** Rms of the alternating response, relative to half the stroke, below which only the offset moves [%] */
    excitation?: number | string;
    /** Errors up to this, in the unit of the output, move nothing */
    dead_zone?: number | string;
  };
  /** Show the identity of a controller, and the limits it reports; nothing moves. */
  controller: {
    /** What the controller speaks */
    protocol?: "gcs" | "nv200" | "scpi";
    /** Address or name of the controller in the network */
    host?: string;
    /** TCP port of the controller; that of an NV200 is 23, that of an instrument with SCPI 5025 or 5555 */
    port?: number;
    /** Time for a whole answer [s] */
    timeout?: number | string;
  };
  /** Play a drive on a controller, and record what the actuator does. */
  acquire: {
    /** Wait at the first value before the drive [s] */
    settle?: number | string;
    /** Join the values by straight lines, instead of holding each for a sampling period */
    join?: boolean;
    /** The drive is positions: play them in closed loop. The servo must be on, and stays on */
    closed_loop?: boolean;
    /** Axis to drive */
    axis?: string;
    /** Voltage that an open-loop value of 1 gives; some controllers count open-loop values in micrometres. With SCPI, the gain of the amplifier [V] */
    gain?: number | string;
    /** Number of the output channel and wave generator of the axis */
    channel?: number;
    /** Time of the move to the first value, and of the move to {rest}; longer if the limits need it [s] */
    ramp?: number | string;
    /** Where the axis goes after the drive */
    rest?: "start" | "zero" | "stay";
    /** Servo cycle of the controller [s] */
    cycle?: number | string;
    /** What the controller speaks */
    protocol?: "gcs" | "nv200" | "scpi";
    /** Address or name of the controller in the network */
    host?: string;
    /** TCP port of the controller; that of an NV200 is 23, that of an instrument with SCPI 5025 or 5555 */
    port?: number;
    /** Time for a whole answer [s] */
    timeout?: number | string;
    /** The driver whose limits the voltage must keep (see {list}) */
    driver?: string;
    /** Capacitance of the load, for the current limit [F] */
    capacitance?: number | string;
    /** Lowest voltage [V] */
    low?: number | string;
    /** Highest voltage [V] */
    high?: number | string;
    /** Largest slew rate of the voltage [V/s] */
    slew?: number | string;
    /** Largest current, in both directions; needs {capacitance} [A] */
    current?: number | string;
    /** Address of the oscilloscope, as HOST or HOST:PORT */
    oscilloscope?: string;
    /** Channel of the oscilloscope at the voltage monitor of the amplifier */
    monitor_channel?: number;
    /** Voltage at the actuator for 1 V at the monitor [V] */
    monitor_gain?: number | string;
    /** Channel of the oscilloscope at the sensor */
    sensor_channel?: number;
    /** Displacement for 1 V of the sensor [um] */
    sensitivity?: number | string;
    /** Lowest and highest voltage of the sensor [V] */
    sensor_range?: [number, number];
  };
  /** Measure, identify and straighten an actuator on a controller, and measure how well it follows a path. */
  campaign: {
    /** Highest frequency of the application [Hz] */
    bandwidth: number | string;
    /** Lowest and highest voltage of the application [V] */
    range?: [number, number];
    /** The actuator, for its range, capacitance and resonance (see {list}) */
    actuator?: string;
    /** Sampling period of the model [s] */
    period?: number | string;
    /** Wait after each demagnetisation, until creep has decayed [s] */
    wait?: number | string;
    /** Hysteresis operators to identify: auto, names separated by commas, or auto,-NAME */
    operator?: string;
    /** Axis to drive */
    axis?: string;
    /** Voltage that an open-loop value of 1 gives; some controllers count open-loop values in micrometres. With SCPI, the gain of the amplifier [V] */
    gain?: number | string;
    /** Number of the output channel and wave generator of the axis */
    channel?: number;
    /** Time of the move to the first value, and of the move to {rest}; longer if the limits need it [s] */
    ramp?: number | string;
    /** Where the axis goes after the drive */
    rest?: "start" | "zero" | "stay";
    /** Servo cycle of the controller [s] */
    cycle?: number | string;
    /** What the controller speaks */
    protocol?: "gcs" | "nv200" | "scpi";
    /** Address or name of the controller in the network */
    host?: string;
    /** TCP port of the controller; that of an NV200 is 23, that of an instrument with SCPI 5025 or 5555 */
    port?: number;
    /** Time for a whole answer [s] */
    timeout?: number | string;
    /** The driver whose limits the voltage must keep (see {list}) */
    driver?: string;
    /** Capacitance of the load, for the current limit [F] */
    capacitance?: number | string;
    /** Lowest voltage [V] */
    low?: number | string;
    /** Highest voltage [V] */
    high?: number | string;
    /** Largest slew rate of the voltage [V/s] */
    slew?: number | string;
    /** Largest current, in both directions; needs {capacitance} [A] */
    current?: number | string;
    /** Address of the oscilloscope, as HOST or HOST:PORT */
    oscilloscope?: string;
    /** Channel of the oscilloscope at the voltage monitor of the amplifier */
    monitor_channel?: number;
    /** Voltage at the actuator for 1 V at the monitor [V] */
    monitor_gain?: number | string;
    /** Channel of the oscilloscope at the sensor */
    sensor_channel?: number;
    /** Displacement for 1 V of the sensor [um] */
    sensitivity?: number | string;
    /** Lowest and highest voltage of the sensor [V] */
    sensor_range?: [number, number];
  };
  /** Show what a campaign is going to measure, and what will move; nothing moves. */
  agenda: CallOptions["campaign"];
  /** Time moves along a path on a controller: settling, overshoot, scan lag. */
  moves: {
    /** Also play the path on this plant */
    plant?: string;
    /** Wait after each demagnetisation, until creep has decayed [s] */
    wait?: number | string;
    /** Largest error of a settled displacement: a number in the model's output unit, or with a unit, such as 0.1um */
    tolerance?: string;
    /** Height of the step up and down that is the path if none is given, written like {tolerance} */
    step?: string;
    /** Largest number of iterations that correct the error left in the model's free run */
    iterations?: number;
    /** Smooth steps and corners to minimum-jerk moves of this duration [s] */
    smooth?: number | string;
    /** Filter the reference with a notch at the model's resonance */
    notch?: boolean;
    /** Shape the reference (ZVD) so that the resonance is not excited */
    zvd?: boolean;
    /** Axis to drive */
    axis?: string;
    /** Voltage that an open-loop value of 1 gives; some controllers count open-loop values in micrometres. With SCPI, the gain of the amplifier [V] */
    gain?: number | string;
    /** Number of the output channel and wave generator of the axis */
    channel?: number;
    /** Time of the move to the first value, and of the move to {rest}; longer if the limits need it [s] */
    ramp?: number | string;
    /** Where the axis goes after the drive */
    rest?: "start" | "zero" | "stay";
    /** Servo cycle of the controller [s] */
    cycle?: number | string;
    /** What the controller speaks */
    protocol?: "gcs" | "nv200" | "scpi";
    /** Address or name of the controller in the network */
    host?: string;
    /** TCP port of the controller; that of an NV200 is 23, that of an instrument with SCPI 5025 or 5555 */
    port?: number;
    /** Time for a whole answer [s] */
    timeout?: number | string;
    /** The driver whose limits the voltage must keep (see {list}) */
    driver?: string;
    /** Capacitance of the load, for the current limit [F] */
    capacitance?: number | string;
    /** Lowest voltage [V] */
    low?: number | string;
    /** Highest voltage [V] */
    high?: number | string;
    /** Largest slew rate of the voltage [V/s] */
    slew?: number | string;
    /** Largest current, in both directions; needs {capacitance} [A] */
    current?: number | string;
    /** Address of the oscilloscope, as HOST or HOST:PORT */
    oscilloscope?: string;
    /** Channel of the oscilloscope at the voltage monitor of the amplifier */
    monitor_channel?: number;
    /** Voltage at the actuator for 1 V at the monitor [V] */
    monitor_gain?: number | string;
    /** Channel of the oscilloscope at the sensor */
    sensor_channel?: number;
    /** Displacement for 1 V of the sensor [um] */
    sensitivity?: number | string;
    /** Lowest and highest voltage of the sensor [V] */
    sensor_range?: [number, number];
  };
}

export type CallName = keyof CallOptions;
