"""Figures: their labels, their data, and settings that they must not change."""

import doctest
import subprocess
import sys
from itertools import combinations

import matplotlib as mpl

mpl.use("Agg")

import numpy as np
import piezoid as pz
import pytest
from matplotlib import pyplot as plt
from matplotlib.colors import to_rgb
from piezoid.control import reference

TS = 5e-4
PLANT = pz.plants["pl140"]


def measured(u):
    return PLANT.measure(u, ts=TS)


@pytest.fixture(scope="module")
def record():
    return measured(pz.excite.rising_sine(ts=TS, duration=1, amplitude=28, frequency=5))


@pytest.fixture(scope="module")
def small():
    return measured(pz.excite.prbs(ts=TS, duration=2, amplitude=1))


@pytest.fixture(scope="module")
def model(small, record):
    return pz.identify(small_signal=[small], large_signal=[record], operator="prandtl-ishlinskii")


@pytest.fixture(scope="module")
def validation(model):
    unseen = measured(pz.excite.triangle(ts=TS, duration=0.8, amplitude=20, frequency=5))
    return model.validate(unseen, skip=0.1)


@pytest.fixture(scope="module")
def comparison(model):
    expected = reference("triangle", model, peak=300, frequency=5, duration=0.4)
    return pz.control(PLANT, model, {"triangle": expected}, controller=["gain", "feed-forward"])


@pytest.fixture(autouse=True)
def closed():
    yield
    plt.close("all")


@pytest.fixture(scope="module")
def drawings(record, small, model, validation, comparison):
    """Every function with its arguments, and the number of Axes that it draws into."""
    return {
        "loops of a record": (lambda ax=None: pz.plot.loops(record, ax=ax), 1),
        "loops of records": (lambda ax=None: pz.plot.loops({5: record, "small": small}, ax=ax), 1),
        "loops of a validation": (lambda ax=None: pz.plot.loops(validation, ax=ax), 1),
        "loops of validations": (lambda ax=None: pz.plot.loops({2: validation, 5: validation}, ax=ax), 2),
        "branches": (lambda ax=None: pz.plot.branches(model, ax=ax), 1),
        "series of a record": (lambda ax=None: pz.plot.series(record, ax=ax), 2),
        "series of a validation": (lambda ax=None: pz.plot.series(validation, ax=ax), 3),
        "residuals": (lambda ax=None: pz.plot.residuals(validation, ax=ax), 3),
        "frequencies": (lambda ax=None: pz.plot.frequencies([validation, model.validate(small)], ax=ax), 1),
        "amplitudes": (lambda ax=None: pz.plot.frequencies(validation, by="amplitude", measure="rmse", ax=ax), 1),
        "response": (lambda ax=None: pz.plot.response(model, ax=ax), 2),
        "tracking": (lambda ax=None: pz.plot.tracking(comparison, ax=ax), 2),
    }


def line(ax, label):
    return next(found for found in ax.get_lines() if found.get_label() == label)


def test_every_axis_has_its_unit_in_brackets(drawings):
    for name, (draw, n) in drawings.items():
        axes = np.ravel(draw(plt.figure().subplots(n)))
        for label in [label for a in axes for label in (a.get_xlabel(), a.get_ylabel())]:
            assert label.endswith("]") and " [" in label and "[u" not in label, (name, label)


def test_axes_that_are_given_are_drawn_into_and_no_figure_is_made(drawings):
    for name, (draw, n) in drawings.items():
        figure, input = plt.subplots(n)
        before = plt.get_fignums()
        drawn = draw(input)
        assert plt.get_fignums() == before, name
        assert list(np.ravel(drawn)) == list(np.ravel(input)) and all(a.has_data() for a in np.ravel(input)), name


def test_a_number_of_axes_that_does_not_fit_is_refused_with_both_numbers(validation, record):
    with pytest.raises(pz.PiezoidError, match=r"2 of Axes: this figure takes 3 Axes"):
        pz.plot.series(validation, ax=plt.subplots(2)[1])
    with pytest.raises(pz.PiezoidError, match="1 of Figure: this figure takes 1 Axes"):
        pz.plot.loops(record, ax=plt.figure())


def test_lines_hold_what_was_measured_and_what_the_model_said(record, validation):
    [shown] = pz.plot.loops(record).get_lines()
    assert np.array_equal(shown.get_xdata(), record.u) and np.array_equal(shown.get_ydata(), record.y)
    counted = slice(validation.start, None)
    assert validation.start == 200
    loops = pz.plot.loops(validation)
    assert np.array_equal(line(loops, "measured").get_ydata(), validation.record.y[counted])
    assert np.array_equal(line(loops, "free run").get_ydata(), validation.simulated[counted])
    u, y, left = pz.plot.series(validation)
    assert np.array_equal(u.get_lines()[0].get_xydata().T, [validation.record.t[counted], validation.record.u[counted]])
    assert np.array_equal(line(y, "measured").get_ydata(), validation.record.y[counted])
    assert np.array_equal(left.get_lines()[-1].get_ydata(), validation.residual[counted])


def test_records_share_a_panel_and_numbers_are_frequencies(record, small):
    ax = pz.plot.loops({5: record, "PRBS": small})
    assert [text.get_text() for text in ax.get_legend().get_texts()] == ["5 Hz", "PRBS"]
    with pytest.raises(pz.PiezoidError, match="a list cannot be drawn here: give a Record or a Validation"):
        pz.plot.loops([record])


def test_branches_go_the_way_their_names_say_and_close(model):
    ax = pz.plot.branches(model)
    up, down = line(ax, "ascending"), line(ax, "descending")
    (low, high), (u, z) = model.input_range, (up.get_xdata(), up.get_ydata())
    assert (u[0], u[-1]) == pytest.approx((low, high)) and np.all(np.diff(u) > 0) and np.all(np.diff(z) > 0)
    assert np.all(np.diff(down.get_xdata()) < 0)
    # Without creep the loop is closed, and the descending branch lies above the ascending one.
    assert down.get_ydata()[-1] == pytest.approx(z[0], abs=1e-9)
    over = np.interp(u, down.get_xdata()[::-1], down.get_ydata()[::-1]) - z
    assert over.min() > -1e-9 and over.max() > 5
    # The minor loops lie above the ascending branch too.
    for minor in ax.get_lines():
        assert np.all(minor.get_ydata() >= np.interp(minor.get_xdata(), u, z) - 1e-6)
    assert len(ax.get_lines()) > 5


def test_a_model_that_knows_no_range_asks_for_one(model):
    document = {key: part for key, part in model.to_dict().items() if key != "identified"}
    blind = pz.Model.from_dict(document | {"hysteresis": {"operator": "proportional", "gain": 1.0}})
    with pytest.raises(pz.PiezoidError, match="does not state its input range"):
        pz.plot.branches(blind)
    assert pz.plot.branches(blind, over=(0, 10)).dataLim.x1 == 10


def test_the_bound_of_white_noise_is_that_of_the_figures(validation):
    _, noise, _ = pz.plot.residuals(validation)
    band = noise.patches[0].get_extents().transformed(noise.transData.inverted())
    assert band.y1 == pytest.approx(validation.figures["whiteness"]["autocorrelation_bound"])


def test_too_few_residuals_to_correlate_are_counted(model):
    short = model.validate(measured(pz.excite.sine(ts=TS, duration=0.05, amplitude=20, frequency=50)))
    assert short.figures["whiteness"] is None
    _, counts, _ = pz.plot.residuals(short)
    assert sum(bar.get_height() for bar in counts.patches) == 100


def test_errors_by_frequency_are_those_of_the_table(model, small, validation):
    wide = model.validate(small)
    ax = pz.plot.frequencies([validation, wide])
    assert np.array_equal(line(ax, "spectrum").get_xydata(), wide.table[["at", "nrmse_percent"]])
    assert np.array_equal(line(ax, "cycles").get_xydata(), validation.table[["at", "nrmse_percent"]])
    assert ax.get_xscale() == "log"
    with pytest.raises(pz.PiezoidError, match="their inputs have no cycles"):
        pz.plot.frequencies(wide, by="amplitude")


def test_the_response_is_that_of_the_model_with_its_resonance_marked(model):
    gain, phase = pz.plot.response(model)
    hz, shown = gain.get_lines()[0].get_data()
    assert np.array_equal(shown, abs(model.response(hz)))
    assert hz[np.argmax(shown)] == pytest.approx(model.resonance[0], rel=0.01)
    assert phase.get_lines()[1].get_xdata()[0] == model.resonance[0]
    assert f"{model.resonance[0]:.4g} Hz" in gain.texts[0].get_text()


def test_tracking_shows_wanted_reached_and_error(comparison):
    path, left = pz.plot.tracking(comparison)
    run = comparison.run("feed-forward")
    assert np.array_equal(line(path, "reference").get_ydata(), run["r"])
    assert np.array_equal(line(path, "feed-forward").get_ydata(), run["y"])
    assert np.array_equal(line(left, "feed-forward").get_ydata(), run["r"] - run["y"])
    assert line(path, "reference").get_xdata()[1] == TS
    only, _ = pz.plot.tracking(comparison, controllers=["gain"])
    assert [found.get_label() for found in only.get_lines()] == ["reference", "gain"]


def test_what_cannot_be_drawn_is_refused_before_a_figure_is_made(model, record, validation):
    for wrong in (
        lambda: pz.plot.loops({5: record, 20: validation}),
        lambda: pz.plot.series([1.0, 2.0]),
        lambda: pz.plot.residuals(record),
        lambda: pz.plot.frequencies(record),
        lambda: pz.plot.frequencies(validation, by="time"),
        lambda: pz.plot.frequencies(validation, measure="mae"),
        lambda: pz.plot.branches(record),
        lambda: pz.plot.response(record),
        lambda: pz.plot.tracking(model),
    ):
        with pytest.raises(pz.PiezoidError):
            wrong()
    assert plt.get_fignums() == []


def test_nothing_of_matplotlib_stays_changed(drawings):
    before = dict(mpl.rcParams)
    for draw, _ in drawings.values():
        draw()
    with pz.plot.style(width="double"):
        assert mpl.rcParams["figure.figsize"][0] == 7.0
    with pytest.raises(ZeroDivisionError), pz.plot.style():
        raise ZeroDivisionError
    assert dict(mpl.rcParams) == before


def test_a_figure_keeps_its_style_after_the_style_has_ended(record):
    with pz.plot.style():
        ax = pz.plot.loops(record)
    ax.figure.canvas.draw()
    tick = ax.xaxis.get_major_ticks()[0]
    assert tick.label1.get_fontsize() == 7 and tick.tick1line.get_markersize() == 2.5
    assert tick.label1.get_fontfamily() == ax.xaxis.label.get_fontfamily() != ["sans-serif"]
    assert tuple(ax.figure.get_size_inches()) == pytest.approx((3.4, 0.8 * 3.4))


def test_widths_are_single_double_or_inches():
    with pz.plot.style(5.1):
        assert mpl.rcParams["figure.figsize"][0] == 5.1
    for wrong in ("triple", -1):
        with pytest.raises(pz.PiezoidError, match=f"width = {wrong}"), pz.plot.style(wrong):
            pass


def test_nothing_sticks_out_of_the_figure_or_lies_over_the_data(drawings):
    for width in ("single", "double"):
        for name, (draw, _) in drawings.items():
            with pz.plot.style(width):
                axes = np.ravel(draw())
            figure = axes[0].figure
            figure.canvas.draw()
            tight, size = figure.get_tightbbox(), figure.get_size_inches()
            assert tight.x0 > -0.02 and tight.y0 > -0.02 and np.all(tight.max < size + 0.02), (name, width, tight, size)
            for legend in [a.get_legend() for a in axes if a.get_legend()] + figure.legends:
                taken = legend.get_window_extent().shrunk(0.98, 0.98)
                assert not any(taken.overlaps(a.get_window_extent().shrunk(0.98, 0.98)) for a in axes), (name, width)
            plt.close(figure)


def test_colours_differ_in_grey():
    def lightness(colour):
        linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in to_rgb(colour)]
        return 116 * float(np.dot((0.2126, 0.7152, 0.0722), linear)) ** (1 / 3) - 16

    together = [("ascending", "descending"), ("measured", "model"), ("measured", "residual")]
    pairs = [(pz.plot.COLOURS[a], pz.plot.COLOURS[b]) for a, b in together]
    assert all(abs(lightness(a) - lightness(b)) > 20 for a, b in pairs)
    assert all(abs(lightness(a) - lightness(b)) > 8 for a, b in combinations(pz.plot.EQUALS, 2))


def test_a_search_is_drawn_while_it_runs(record):
    figure = pz.plot.search(record)
    model = pz.identify(record, operator="stop,bouc-wen", order=2, progress=figure)
    loop, ranking, residual = figure.axes
    assert sorted(figure.errors) == ["bouc-wen", "stop"] == sorted(text.get_text() for text in ranking.get_yticklabels())
    assert figure.model.validate(record, offset="free").nrmse_percent < 2 * model.validate(record).nrmse_percent + 1
    assert len(loop.lines) == 2 and len(residual.lines) == 2 and residual.get_xlabel() == "time [s]"
    plt.close("all")


def python(code):
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)


def test_without_matplotlib_all_but_figures_works_and_figures_say_what_to_install():
    blocked = "import sys; sys.modules['matplotlib'] = None; import piezoid as pz; pz.plants['pl140']; "
    for use in ("pz.plot", "from piezoid import plot"):
        done = python(blocked + use)
        assert done.stderr.endswith("PiezoidError: figures need matplotlib: pip install piezoid[plot]\n"), done.stderr


def test_matplotlib_is_imported_by_who_draws_alone():
    ask = "print('matplotlib' in sys.modules); "
    done = python("import sys, piezoid as pz; " + ask + "pz.plot; " + ask)
    assert done.stdout.split() == ["False", "True"], done.stderr
    with pytest.raises(AttributeError, match="no attribute 'plots'"):
        pz.plots


def test_the_example_runs():
    done = doctest.testmod(pz.plot)
    assert done.attempted >= 5 and done.failed == 0


def test_the_figure_of_moves_marks_tolerance_and_settling_of_each_run(model):
    path = np.repeat([0.0, 100.0, -50.0], 400)
    found = pz.timing(model, path, plant="pl140", tolerance="10um", smooth=0.02, driver="pl140")
    axes = found.plot()
    assert len(axes) == 3, "two steps and the error"
    for k, ax in enumerate(axes[:2]):
        settled = [run["steps"][k]["settling_s"] for run in found.figures["runs"]]
        marked = [line.get_xdata()[0] for line in ax.lines if line.get_marker() == "o"]
        step = found.figures["runs"][0]["steps"][k]
        assert np.allclose(marked, [1e3 * (step["at_s"] + s) for s in settled if s is not None])
        assert ax.get_xlim()[0] < 1e3 * step["at_s"] < ax.get_xlim()[1]
    lines = {line.get_label(): line for line in axes[2].lines}
    for name, y in found.displacements.items():
        assert np.array_equal(lines[name].get_ydata(), y - found.path)
    assert axes[2].get_ylim()[1] <= 80.0 and axes[2].get_ylabel() == "error [µm]"
    # A scan has no steps: it is drawn whole.
    scan = pz.timing(model, 50.0 * np.sin(np.arange(2000) / 50), tolerance="10um", driver="pl140").plot()
    assert len(scan) == 2
    with pytest.raises(pz.PiezoidError, match="is no timing"):
        pz.plot.moves(model)
