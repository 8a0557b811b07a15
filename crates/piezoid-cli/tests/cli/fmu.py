"""Imports FMUs with FMPy or libcosim: `fmu.py CHECK FMU,RUN.csv ...`, where the run is what piezoid simulates.

Says the name of each, and ends with status 0 where all is well.
"""

import shutil
import sys
from contextlib import contextmanager

import fmpy
import numpy as np
from fmpy.fmi1 import FMICallException
from fmpy.simulation import instantiate_fmu
from fmpy.validation import validate_fmu


class Instance:
    """An instance of either version."""

    # What the logger received. FMPy has one for all instances, that of the latest, so all of them have to stay.
    texts = []
    alive = []

    @staticmethod
    def messages(*message):
        Instance.texts.append(message[-1].decode())

    def __init__(self, folder, description, logging=True):
        self.by_name = {v.name: v for v in description.modelVariables}
        self.ts = float(self.by_name["ts"].start)
        self.second = description.fmiVersion == "2.0"
        self.fmu = instantiate_fmu(folder, description, "CoSimulation", logger=Instance.messages, debug_logging=logging)
        Instance.alive.append(self)

    def begin(self, start=0.0):
        if self.second:
            self.fmu.setupExperiment(startTime=start)
            self.fmu.enterInitializationMode()
        else:
            self.fmu.enterInitializationMode(startTime=start)
        self.fmu.exitInitializationMode()
        return self

    def get(self, *names):
        references = [self.by_name[name].valueReference for name in names]
        return list(self.fmu.getReal(references) if self.second else self.fmu.getFloat64(references))

    def set(self, name, value):
        (self.fmu.setReal if self.second else self.fmu.setFloat64)([self.by_name[name].valueReference], [value])

    def time(self):
        return self.fmu.getRealStatus(2) if self.second else self.get("time")[0]

    def step(self, k, n=1):
        self.fmu.doStep(currentCommunicationPoint=k * self.ts, communicationStepSize=n * self.ts)

    def run(self, k, u, n=1):
        """The output after the step of n samples from sample k, the input held."""
        self.set("u", u)
        self.step(k, n)
        return self.get("y")[0]

    def keep(self):
        return self.fmu.getFMUstate() if self.second else self.fmu.getFMUState()

    def bring(self, state):
        (self.fmu.setFMUstate if self.second else self.fmu.setFMUState)(state)

    def free(self, state):
        (self.fmu.freeFMUstate if self.second else self.fmu.freeFMUState)(state)

    def serialised(self, state):
        return (self.fmu.serializeFMUstate if self.second else self.fmu.serializeFMUState)(state)

    def deserialised(self, data):
        return (self.fmu.deSerializeFMUstate if self.second else self.fmu.deserializeFMUState)(data)

    def refuses(self, words, call):
        """`call` ends with an error that says these words, and changes nothing."""
        everything = list(self.by_name)
        before = self.get(*everything)
        del self.texts[:]
        try:
            call()
        except FMICallException as error:
            assert error.status == 3, error
        else:
            raise AssertionError(f"not refused: {words}")
        assert any(words in text for text in self.texts), (words, self.texts)
        after = self.get(*everything)
        assert np.array_equal(before, after), (words, before, after)


@contextmanager
def imported(path):
    folder = fmpy.extract(path)
    description = fmpy.read_model_description(path)
    try:
        yield lambda logging=True: Instance(folder, description, logging)
    finally:
        shutil.rmtree(folder)


def series(path):
    rows = np.loadtxt(path, delimiter=",", skiprows=1)
    return rows[:, 1], rows[:, 2]


def validates(path, run=None):
    problems = validate_fmu(path)
    assert not problems, problems


def simulates(path, run, tolerance="0"):
    """The importer's own loop gives the run bit for bit, or to this part of its stroke."""
    u, y = series(run)
    ts = float(next(v.start for v in fmpy.read_model_description(path).modelVariables if v.name == "ts"))
    inputs = np.array([(k * ts, v) for k, v in enumerate(u)], dtype=[("time", float), ("u", float)])
    result = fmpy.simulate_fmu(path, stop_time=len(u) * ts, output_interval=ts, input=inputs, output=["y"])
    assert len(result) == len(u) + 1, len(result)
    off = abs(result["y"][1:] - y) / np.ptp(y)
    assert off.max() <= float(tolerance), f"off by {off.max()} of the stroke at {off.argmax()}"


def steps(path, run):
    """Held inputs may be stepped over at once, inputs are scaled before they enter, instances are apart."""
    u, y = series(run)
    with imported(path) as new:
        whole, scaled, other = new().begin(), new(), new().begin()
        scaled.set("u_gain", 4.0)
        scaled.begin()
        scaled.set("u_offset", -1.0)
        for k in range(200):
            assert whole.run(k, u[k]) == y[k]
            assert abs(scaled.run(k, 0.25 * (u[k] + 1.0)) - y[k]) <= 1e-9 * abs(y).max()
            other.run(k, -u[k])
        at_once, one_by_one = new().begin(), new().begin()
        for k in range(0, 100, 10):
            held = [one_by_one.run(k + i, u[k]) for i in range(10)]
            assert at_once.run(k, u[k], 10) == held[-1]
        assert at_once.time() == 90 * at_once.ts + 10 * at_once.ts


def states(path, run):
    """States are kept, brought back, written down, and read by another instance; they can be set before the run."""
    u, y = series(run)
    with imported(path) as new:
        one, two = new().begin(), new()
        for k in range(150):
            one.run(k, u[k])
        assert one.time() == 150 * one.ts
        state = one.keep()
        data = one.serialised(state)
        names = [name for name in one.by_name if name.startswith("state.")]
        values = one.get(*names)
        assert [one.run(k, u[k]) for k in range(150, 300)] == list(y[150:300])
        one.bring(state)
        assert one.time() == 150 * one.ts and one.get(*names) == values
        assert [one.run(k, u[k]) for k in range(150, 300)] == list(y[150:300])
        two.bring(two.deserialised(data))
        assert [two.run(k, u[k]) for k in range(150, 300)] == list(y[150:300])
        three = new()
        for name, value in zip(names, values):
            three.set(name, value)
        three.begin()
        assert [three.run(k, u[150 + k]) for k in range(150)] == list(y[150:300])
        broken = bytes([data[0] ^ 1]) + data[1:]
        one.refuses("no state of this FMU", lambda: one.deserialised(broken))
        one.refuses("no state of this FMU", lambda: one.deserialised(data[:-1]))
        one.free(state)
        two.fmu.reset()
        two.begin()
        assert [two.run(k, u[k]) for k in range(50)] == list(y[:50])


def refusals(path, run):
    """What makes no sense is refused, with the reason, and changes nothing."""
    u, y = series(run)
    with imported(path) as new:
        fresh = new()
        starts = {name: v.start for name, v in fresh.by_name.items() if v.start is not None}
        assert fresh.get(*starts) == [float(v) for v in starts.values()]
        fresh.refuses("instantiated but not initialised", lambda: fresh.step(0))
        one = new().begin()
        for k in range(20):
            one.run(k, u[k])
        half = lambda: one.fmu.doStep(currentCommunicationPoint=20 * one.ts, communicationStepSize=1.5 * one.ts)
        one.refuses(f"make it a multiple of {one.ts:.12g} s", half)
        one.refuses("no whole number of samples", lambda: one.step(20, 0))
        one.refuses("no whole number of samples", lambda: one.step(20, -1))
        one.refuses("no whole number of samples", lambda: one.step(20, float("nan")))
        one.refuses("continue from that time", lambda: one.step(25))
        one.refuses("not finite", lambda: one.set("u", float("nan")))
        one.refuses("not finite", lambda: one.set("u", float("inf")))
        one.refuses("cannot be set", lambda: one.set("y", 1.0))
        one.refuses("cannot be set", lambda: one.set("ts", 1.0))
        state = next(name for name in starts if name.startswith("state."))
        one.refuses("before the initialisation ends", lambda: one.set(state, 1.0))
        one.refuses("initialised already", lambda: one.fmu.enterInitializationMode())
        one.refuses("no such category", lambda: one.fmu.setDebugLogging(True, ["nonsense"]))
        get, put = (one.fmu.getReal, one.fmu.setReal) if one.second else (one.fmu.getFloat64, one.fmu.setFloat64)
        one.refuses("no such variable", lambda: get([99999]))
        one.refuses("no such variable", lambda: put([99999], [0.0]))
        integers = one.fmu.getInteger if one.second else one.fmu.getInt32
        one.refuses("no variables of this type", lambda: integers([1]))
        assert list(get([])) == [] and list(integers([])) == []
        # A hair off a whole number of samples is rounding.
        one.fmu.doStep(currentCommunicationPoint=20 * one.ts, communicationStepSize=one.ts * (1.0 + 1e-9))
        assert [one.run(k, u[k]) for k in range(21, 50)] is not None
        one.fmu.terminate()
        one.refuses("terminated", lambda: one.step(50))
        one.fmu.reset()
        one.begin()
        assert [one.run(k, u[k]) for k in range(50)] == list(y[:50])
        logged(new)
        free = one.fmu.fmi2FreeInstance if one.second else one.fmu.fmi3FreeInstance
        free(None)
        one.fmu.guid = "{0}"
        del Instance.texts[:]
        try:
            logger = {"callbacks": one.fmu.callbacks} if one.second else {"logMessage": Instance.messages}
            one.fmu.instantiate(loggingOn=True, **logger)
        except Exception as error:
            assert "Failed to instantiate" in str(error), error
        else:
            raise AssertionError("a foreign token was not refused")
        assert "of the same FMU" in Instance.texts[0], Instance.texts


def logged(new):
    """The logger receives the requested messages."""

    def messages(call):
        del Instance.texts[:]
        try:
            call()
        except FMICallException:
            pass
        return list(Instance.texts)

    assert messages(lambda: new().begin()) == ["instantiated", "initialised"]
    quiet, loud = new(logging=False), new()
    assert messages(quiet.begin) == []
    # In version 2 it is debugging alone that is off.
    assert len(messages(lambda: quiet.step(7))) == (1 if quiet.second else 0)
    loud.fmu.setDebugLogging(False, ["logEvents"])
    assert messages(loud.fmu.reset) == []
    assert len(messages(lambda: loud.step(0))) == 1
    loud.fmu.setDebugLogging(False, ["logStatusError"])
    assert messages(lambda: loud.step(0)) == []
    loud.fmu.setDebugLogging(True, [])
    assert messages(loud.fmu.reset) == ["reset"]


def cosimulates(path, run):
    """libcosim, which stands on FMI Library, gives the run bit for bit."""
    from libcosimpy.CosimExecution import CosimExecution
    from libcosimpy.CosimManipulator import CosimManipulator
    from libcosimpy.CosimObserver import CosimObserver
    from libcosimpy.CosimSlave import CosimLocalSlave

    u, y = series(run)
    by_name = {v.name: v for v in fmpy.read_model_description(path).modelVariables}
    execution = CosimExecution.from_step_size(step_size=round(float(by_name["ts"].start) * 1e9))
    slave = execution.add_local_slave(local_slave=CosimLocalSlave(fmu_path=path, instance_name="actuator"))
    setter, getter = CosimManipulator.create_override(), CosimObserver.create_last_value()
    execution.add_manipulator(manipulator=setter)
    execution.add_observer(observer=getter)
    references = {name: [by_name[name].valueReference] for name in ("u", "y")}
    for k in range(len(u)):
        assert setter.slave_real_values(slave_index=slave, variable_references=references["u"], values=[u[k]])
        assert execution.step(), k
        assert getter.last_real_values(slave_index=slave, variable_references=references["y"]) == [y[k]], k


if __name__ == "__main__":
    check, *fmus = sys.argv[1:]
    checks = [validates, simulates, steps, states, refusals, cosimulates]
    for fmu in fmus:
        print(fmu, flush=True)
        next(c for c in checks if c.__name__ == check)(*fmu.split(","))
