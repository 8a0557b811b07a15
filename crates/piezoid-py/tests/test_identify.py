"""Identification by both methods, with progress, interruption and other threads."""

from __future__ import annotations

import os
import signal
import subprocess
import threading
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import piezoid as pz
import pytest


def test_the_same_records_give_the_same_model_in_any_form(
    small: pz.Record, rich: pz.Record, model: pz.Model, tmp_path: Path
) -> None:
    small.save(tmp_path / "small.csv")
    again = pz.identify(small_signal=tmp_path / "small.csv", large_signal=[rich.to_frame()], operator="prandtl-ishlinskii")
    assert again == model
    assert again.provenance["command"] == "piezoid.identify" and again.provenance["seed"] == 1
    assert again.provenance["options"] == {"operator": "prandtl-ishlinskii"}
    file, frame = again.provenance["files"]
    assert file["file"] == "small.csv" and len(file["sha256"]) == 64 and "file" not in frame


BINARY = Path(os.environ.get("CARGO_TARGET_DIR", Path(__file__).parents[3] / "target")) / "debug/piezoid"


@pytest.mark.skipif(not BINARY.exists(), reason="SKIPPED: there is no command line to compare with: cargo build makes it")
@pytest.mark.parametrize("how", ["--operator bouc-wen", "--method paper --iterations 60"])
def test_the_command_line_finds_the_same_to_the_bit(how: str, small: pz.Record, tmp_path: Path) -> None:
    u = pz.excite.sine(ts=5e-4, duration=1, amplitude=28, frequency=5)
    small.save(tmp_path / "small.csv")
    pz.plants["pl140"].measure(u, 5e-4).save(tmp_path / "sine.mat")
    line = f"identify sine.mat {how} --small-signal small.csv -o m.json".split()
    subprocess.run([BINARY, *line], cwd=tmp_path, check=True, capture_output=True)
    settings = dict(zip([word[2:] for word in how.split()[::2]], how.split()[1::2], strict=True))
    numbers = {name: int(value) for name, value in settings.items() if value.isdigit()}
    found = pz.identify(small_signal=tmp_path / "small.csv", large_signal=tmp_path / "sine.mat", **(settings | numbers))
    found.save(tmp_path / "python.json")
    texts = [(tmp_path / name).read_text(encoding="utf-8") for name in ("m.json", "python.json")]
    named = texts[0].replace('"command": "piezoid identify"', '"command": "piezoid.identify"')
    assert texts[1] == named, "is the command line that of this source? cargo build"
    again = subprocess.run([BINARY, "identify", "--again", "python.json", "small.csv", "sine.mat"], cwd=tmp_path, check=True, capture_output=True)
    assert b"Equal to python.json to the bit" in again.stdout


def test_the_papers_way_gives_branches(small: pz.Record) -> None:
    u = pz.excite.sine(ts=5e-4, duration=2, amplitude=28, frequency=5)
    sine = pz.plants["pl140"].measure(u, 5e-4)
    found = pz.identify(small_signal=small, large_signal=sine, method="paper", particles=20, iterations=60)
    assert found.operator == "two-branch" and len(found.a) == 2
    # Equation (4) as printed gives another search, which ends elsewhere if it is stopped early.
    printed = pz.identify(small_signal=small, large_signal=sine, method="paper", particles=20, iterations=60, global_best="current")
    assert printed.a.tolist() != found.a.tolist() and printed.a == pytest.approx(found.a, rel=0.5)


def test_of_several_operators_the_better_is_taken(small: pz.Record, rich: pz.Record) -> None:
    found = pz.identify(small_signal=small, large_signal=rich, operator="proportional, prandtl-ishlinskii")
    assert found.operator == "prandtl-ishlinskii"


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"operator": "preisac"}, "did you mean `preisach`?"),
        ({"method": "best"}, "joint or paper"),
        ({"operator": 3}, "no operator called `3`"),
        ({"driver_lag": "1 mm"}, "driver_lag = 1 mm: must be a number, 0 or more [s]"),
        ({"particles": 10}, "particles = 10: is an option of the method paper"),
        ({"method": "paper", "elements": 10}, "elements = 10: is an option of the method joint"),
        ({"driver": "bd300"}, "capacitance"),
        ({"method": "paper", "split": "half"}, "line or direction"),
        ({"method": "paper", "global_best": "last"}, "ever or current"),
    ],
)
def test_settings_that_make_no_sense_are_refused(rich: pz.Record, settings: dict[str, object], message: str) -> None:
    with pytest.raises(pz.PiezoidError) as raised:
        pz.identify(data=rich, **settings)  # type: ignore[arg-type]
    assert message in str(raised.value)


def test_the_former_names_of_records_still_work(small: pz.Record, rich: pz.Record, model: pz.Model) -> None:
    assert pz.identify(linear=small, rich=rich, operator="prandtl-ishlinskii") == model


def test_data_beside_small_signals_are_large_signals(small: pz.Record, rich: pz.Record, model: pz.Model) -> None:
    assert pz.identify([rich], small_signal=[small], operator="prandtl-ishlinskii") == model
    with pytest.raises(pz.PiezoidError, match="large_signal is the same as data"):
        pz.identify(data=rich, large_signal=rich)
    with pytest.raises(pz.PiezoidError, match="0 samples"):
        pz.identify()


def test_a_lag_that_outlasts_the_records_is_no_part_of_a_model(rich: pz.Record) -> None:
    # Once a pole at 0.99999 gave a small residual here, but an offset of 880 um, which its state compensated.
    found = pz.identify(data=rich, operator="prandtl-ishlinskii", order=2, elements=6)
    assert found.validate(rich).nrmse_percent < 4 and abs(found.offset) < 20
    assert np.abs(np.roots(np.r_[1.0, -found.a])).max() <= np.exp(-rich.ts / rich.duration) + 1e-9


def test_who_watches_is_told_and_may_stop(rich: pz.Record) -> None:
    message: list[tuple[str, int, int]] = []
    pz.identify(data=rich, operator="stop", order=2, progress=lambda *stage: message.append(stage))
    assert message[-1] == ("stop", 4, 4), "the end is reported too"
    assert {what for what, _, _ in message} >= {"linear block", "stop"} and all(done <= total for _, done, total in message)

    def stop(what: str, done: int, total: int) -> None:
        raise KeyError("enough")

    with pytest.raises(KeyError, match="enough") as stopped:
        pz.identify(data=rich, operator="stop", order=2, progress=stop)
    assert not hasattr(stopped.value, "model"), "there was none yet"

    def stop_late(what: str, done: int, total: int) -> None:
        if what == "stop":
            raise KeyError("enough")

    with pytest.raises(KeyError, match="enough") as stopped:
        pz.identify(data=rich, operator="stop", order=2, progress=stop_late)
    best = stopped.value.model
    assert best.provenance["verdict"]["cancelled_in"] == "stop" and best.validate(rich).nrmse_percent < 20


def test_progress_may_be_a_bar(rich: pz.Record, capsys: pytest.CaptureFixture[str]) -> None:
    pz.identify(data=rich, operator="stop", order=2, progress=True)
    assert "linear block" in capsys.readouterr().err

    from tqdm import tqdm

    with tqdm(disable=False) as mine:
        pz.identify(data=rich, operator="stop", order=2, progress=mine)
        assert mine.n == mine.total == 4
    pz.identify(data=rich, operator="stop", order=2, progress=tqdm)
    assert "stop" in capsys.readouterr().err
    with pytest.raises(pz.PiezoidError, match="progress = 5"):
        pz.identify(data=rich, progress=5)  # type: ignore[arg-type]


@pytest.fixture
def heeded() -> Iterator[None]:
    """Enables Ctrl-C, which processes started in the background ignore."""
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)


@pytest.mark.usefixtures("heeded")
@pytest.mark.parametrize("work", ["identify", "simulate", "measure"])
def test_ctrl_c_ends_long_work(work: str, rich: pz.Record, model: pz.Model) -> None:
    # Without Ctrl-C, each takes a minute or more.
    long = {
        "identify": lambda: [pz.identify(data=rich) for _ in range(100)],
        "simulate": lambda: [model.simulate(u) for _ in range(300)],
        "measure": lambda: pz.plants["pl140"].measure(u),
    }
    u = np.zeros(10**7)
    pressed = threading.Timer(0.3, os.kill, (os.getpid(), signal.SIGINT))
    pressed.start()
    began = time.perf_counter()
    with pytest.raises(KeyboardInterrupt):
        long[work]()
    pressed.join()
    assert time.perf_counter() - began < 20


def test_other_threads_run_on_while_it_works(rich: pz.Record) -> None:
    counted, stop = [0], threading.Event()

    def count() -> None:
        while not stop.is_set():
            counted[0] += 1
            time.sleep(1e-3)

    counter = threading.Thread(target=count)
    counter.start()
    before, began = counted[0], time.perf_counter()
    pz.identify(data=rich, operator="prandtl-ishlinskii")
    stop.set()
    counter.join()
    # The counter would stand still if the interpreter's lock were held.
    assert counted[0] - before > 0.1 * (time.perf_counter() - began) / 1e-3 / 2
