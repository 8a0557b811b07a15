//! The figures of the study: the paper's Figs 2 to 5, and the causes of its errors.

use super::words;
use super::{Frequency, METHODS, Study, TS, TestSignal};
use crate::each::Each;
use crate::hysteresis_part::StraightLine;
use crate::plot::{Axes, Axis, Figure, Role, Series};
use piezoid::linear::Arx;
use piezoid_models::hysteresis::Branches;

/// Labelled frequencies on axes [Hz]: not all would fit.
const TICKS: [f64; 7] = [5.0, 10.0, 20.0, 40.0, 80.0, 160.0, 250.0];

/// Periods of the test in a figure.
const PERIODS: f64 = 2.0;

impl Study {
    /// Every figure of a study with the name of its file, in the order of the page.
    pub fn figures(&self) -> Vec<(String, Figure)> {
        let name = |what: &str| format!("{}-{what}", self.plant.name);
        let mut all = vec![
            (name("convergence"), convergence(self)),
            (name("courses"), courses(self)),
            (name("response"), response(self)),
        ];
        all.extend(self.frequencies.iter().map(|f| (name(&format!("loop-{:03.0}hz", f.hz)), hysteresis_loop(f))));
        all.extend(self.frequencies.iter().map(|f| (name(&format!("test-{:03.0}hz", f.hz)), test(f))));
        all.push((name("width"), width(self)));
        all.push((name("error"), error(self)));
        all.push((name("test-signal"), test_signal(self)));
        all.push((name("deviation"), deviation(self)));
        all
    }
}

fn iterations(n: usize) -> Vec<f64> {
    (0..n).map(|i| i as f64).collect()
}

/// The swarm's best cost over the optimum: Fig 3, first half.
pub(super) fn convergence(study: &Study) -> Figure {
    let best = &study.convergence;
    let printed = &study.convergence_as_printed;
    let n = best.len() - 1;
    let (first, last) = (best[0], best[n]);
    let caption = format!("The best sum of absolute errors falls from {first:.3} to {last:.6} mm in {n} iterations.");
    let compared = study.optimum.map_or(String::new(), |optimum| {
        let above = |history: &[f64]| (history.last().copied().unwrap_or(f64::NAN) / optimum - 1.0).max(1e-12);
        let (ever, current) = (above(best), above(printed));
        format!(
            " The exact minimum of a block of this form is {optimum:.6} mm (linear programming); the result of the \
            swarm is larger by a relative {ever:.0e}. All particles are attracted to the best position found so far, \
            as is customary. With the best of the current positions, as the paper prints equation (4), their result is \
            larger by a relative {current:.0e}."
        )
    });
    let (best_line, printed_line) =
        (Series::line(&iterations(best.len()), best), Series::dashed(&iterations(printed.len()), printed));
    let axes = Axes::new("iteration", Axis::log("sum of absolute errors [mm]"))
        .with(best_line.role(Role::Model).named("g_best: the best so far"))
        .with(printed_line.role(Role::Residual).named("of the current positions"))
        .each(study.optimum, |axes, optimum| axes.at_y(optimum, "exact optimum"));
    Figure::new("Swarm convergence", caption + &compared).panel(axes)
}

/// The history of each coefficient: Fig 3, as the paper draws it.
pub(super) fn courses(study: &Study) -> Figure {
    let courses = study.blocks[1].fit.as_ref().map(|f| f.courses.as_slice()).unwrap_or_default();
    let (t, names) = (iterations(courses.len()), ["a1", "a2", "b0", "b1", "b2"]);
    let line = |k: usize| {
        let course: Vec<f64> = courses.iter().map(|theta| theta[k]).collect();
        Series::line(&t, &course).role(Role::accent(k)).named(names[k])
    };
    let a = Axes::new("iteration", "a").with(line(0)).with(line(1));
    let b = Axes::new("iteration", "b [mm/V]").with(line(2)).with(line(3)).with(line(4));
    // The limits are 1 % of the largest a, and of the largest b.
    let end = courses.last().cloned().unwrap_or_default();
    let size = |k: std::ops::Range<usize>| end[k].iter().fold(0.0f64, |m, c| m.max(c.abs()));
    let limits =
        if end.len() == 5 { [vec![0.01 * size(0..2); 2], vec![0.01 * size(2..5); 3]].concat() } else { Vec::new() };
    let away =
        |theta: &Vec<f64>| theta.iter().zip(&end).zip(&limits).any(|((now, end), limit)| (now - end).abs() > *limit);
    let caption = format!(
        "The coefficients of the best position so far, by iteration. The paper's Fig. 3 shows histories of the search \
        without stating the particle. From iteration {} on the coefficients stay within 1 % of their final values, \
        relative to the largest a and the largest b.",
        courses.iter().rposition(away).map_or(0, |last| last + 1)
    );
    Figure::new("Course of the estimated coefficients", caption).panel(a).panel(b).stacked()
}

/// Gain and phase of the printed and of the estimated block.
pub(super) fn response(study: &Study) -> Figure {
    let hz: Vec<f64> = (0..=300).map(|k| 2.0 * (450.0f64).powf(f64::from(k) / 300.0)).collect();
    let curve = |arx: &Arx, what: &dyn Fn(piezoid_models::linear::Response) -> f64| {
        hz.iter().map(|&f| what(arx.response(f))).collect::<Vec<f64>>()
    };
    let (printed, own) = (&study.blocks[0].arx, &study.blocks[1].arx);
    let gain = |arx: &Arx| curve(arx, &|r| r.gain / arx.dc_gain().abs());
    let phase = |arx: &Arx| curve(arx, &|r| r.phase.to_degrees());
    let axis = || Axis::log("f [Hz]").ticks(&[2.0, 5.0, 10.0, 20.0, 40.0, 80.0, 160.0, 320.0, 900.0]).tight();
    let [phase_printed, phase_own] = [printed, own].map(|arx| arx.response(80.0).phase.to_degrees());
    let caption = format!(
        "Gain over static gain, and phase. At 80 Hz the phase of the paper's Table 2 is {phase_printed:.0}°, that of \
        the block estimated here {phase_own:.0}°. The inverse of a block with more phase lead delays z by the \
        difference, which widens the loop."
    );
    Figure::new("Frequency response of the linear blocks", caption)
        .panel(
            Axes::new(axis(), Axis::log("gain / static gain"))
                .with(Series::line(&hz, &gain(printed)).role(Role::Descending).named("the paper's Table 2"))
                .with(Series::line(&hz, &gain(own)).role(Role::Model).dashes(1).named("estimated by the swarm")),
        )
        .panel(
            Axes::new(axis(), "phase [°]")
                .with(Series::line(&hz, &phase(printed)).role(Role::Descending))
                .with(Series::line(&hz, &phase(own)).role(Role::Model).dashes(1)),
        )
        .stacked()
}

fn branch(branches: &Branches, read: impl Fn(f64) -> f64) -> (Vec<f64>, Vec<f64>) {
    let (low, high) = branches.range();
    (0..=120).map(|k| low + (high - low) * f64::from(k) / 120.0).map(|u| (u, read(u))).unzip()
}

/// The loop of the hidden variable with its separating line and branches, and the loop of the joint model: Figs 2, 4
/// and 5. Beside it the same without the least-squares line of the loop.
pub(super) fn hysteresis_loop(f: &Frequency) -> Figure {
    let [whole, rest] = loop_panels(f);
    let figure = Figure::new(format!("Loop at {} Hz", f.hz), loop_caption(f)).medium().panel(whole);
    figure.panel(rest.unnamed()).columns(2)
}

/// The same as two figures a frequency.
pub(super) fn hysteresis_loops(study: &Study) -> impl Iterator<Item = Figure> {
    study.frequencies.iter().flat_map(|f| {
        let [whole, rest] = loop_panels(f);
        let titles = [format!("Loop at {} Hz", f.hz), format!("Loop at {} Hz without its straight line", f.hz)];
        let figure = |(title, panel)| Figure::new(title, loop_caption(f)).medium().panel(panel);
        titles.into_iter().zip([whole, rest]).map(figure).collect::<Vec<_>>()
    })
}

fn loop_caption(f: &Frequency) -> String {
    let [own, joint] = [&f.own, &f.joint].map(|found| 100.0 * found.found.branches.width());
    let agreement = 100.0 * f.own.found.agreement;
    format!(
        "The width of the loop is {own:.1} % of its height; {agreement:.0} % of its points lie on the side of the line \
         that matches their direction. The loop of the joint model opens by {joint:.1} %."
    )
}

/// What is drawn of z over u.
type Drawn = fn(&StraightLine, &[f64], &[f64]) -> Vec<f64>;

/// z over u, and z less a straight line over u.
fn loop_panels(f: &Frequency) -> [Axes; 2] {
    let found = &f.own.found;
    let (up_u, up_z) = branch(&found.branches, |u| found.branches.ascending(u));
    let (down_u, down_z) = branch(&found.branches, |u| found.branches.descending(u));
    let [(u0, z0), (u1, z1)] = found.line;
    // The last period, closed.
    let period = (1.0 / (f.hz * TS)).ceil() as usize + 1;
    let last = f.joint.u.len().saturating_sub(period);
    let (joint_u, joint_z) = (&f.joint.u[last..], &f.joint.z[last..]);
    let line = StraightLine::through(&f.own.u, &f.own.z);
    let joint_line = StraightLine::through(joint_u, joint_z);
    let panel = |title: String, label: &str, of: Drawn| {
        let joint = Series::line(joint_u, &of(&joint_line, joint_u, joint_z)).role(Role::Accent5);
        Axes::new("u [V]", label)
            .titled(title)
            .with(Series::dots(&f.own.u, &of(&line, &f.own.u, &f.own.z)).role(Role::Measured).named("samples"))
            .with(Series::line(&up_u, &of(&line, &up_u, &up_z)).role(Role::Ascending).named("ascending"))
            .with(Series::line(&down_u, &of(&line, &down_u, &down_z)).role(Role::Descending).named("descending"))
            .with(joint.dashes(1).named("joint model"))
            .with(Series::dashed(&[u0, u1], &of(&line, &[u0, u1], &[z0, z1])).named("separating line"))
    };
    let width = format!("{} Hz: {:.1} % wide", f.hz, 100.0 * found.branches.width());
    let whole = panel(width, "z [V]", |_, _, z| z.to_vec());
    let rest = panel(format!("{} Hz, without the straight line", f.hz), "z − line [V]", StraightLine::taken_from);
    [whole, rest]
}

/// Test and predictions over the last periods, with their errors.
pub(super) fn test(f: &Frequency) -> Figure {
    let y = f.test.y();
    let from = y.len() - ((PERIODS / (f.hz * TS)).round() as usize).clamp(1, y.len());
    let t: Vec<f64> = (0..y.len() - from).map(|k| 1e3 * k as f64 * TS).collect();
    let mut answer = Axes::new(Axis::new("t [ms]").tight(), "y [mm]").height(0.8).titled(format!("{} Hz", f.hz));
    let mut errors = Axes::new(Axis::new("t [ms]").tight(), "error [mm]").height(0.5);
    let shown = [
        ("printed-rule", "rule as printed", Role::Descending),
        ("held-direction", "direction held", Role::Model),
        ("joint", "joint model", Role::Accent5),
    ];
    let mut words = Vec::new();
    for (method, name, role) in shown {
        let Some(row) = f.row(method) else { continue };
        let error: Vec<f64> = row.simulated[from..].iter().zip(&y[from..]).map(|(s, y)| y - s).collect();
        // Dashed, so that a line beneath stays visible.
        let dashes = usize::from(method == "joint");
        answer = answer.with(Series::line(&t, &row.simulated[from..]).role(role).dashes(dashes).named(name));
        errors = errors.with(Series::line(&t, &error).role(role).dashes(dashes));
        words.push(format!("error with the {name}: {:.2} % of peak-to-peak", row.metrics.rms_pp_percent));
    }
    let answer = answer.with(Series::wide(&t, &y[from..]).named("twin"));
    Figure::new(format!("Test at {} Hz", f.hz), words.join("; ")).medium().panel(answer).panel(errors).stacked()
}

/// Width of the loops with the estimated block and with that of Table 2.
pub(super) fn width(study: &Study) -> Figure {
    let hz: Vec<f64> = study.frequencies.iter().map(|f| f.hz).collect();
    let widths =
        |found: &dyn Fn(&Frequency) -> f64| study.frequencies.iter().map(|f| 100.0 * found(f)).collect::<Vec<_>>();
    let own = widths(&|f| f.own.found.branches.width());
    let printed = widths(&|f| f.by_table_2.found.branches.width());
    let joint = widths(&|f| f.joint.found.branches.width());
    let [[low, high], [own_low, own_high], [printed_low, printed_high], [joint_low, joint_high]] =
        [&hz, &own, &printed, &joint].map(|values| [values[0], values[values.len() - 1]]);
    let caption = format!(
        "The same records with two linear blocks. With the estimated one the loop of z is {own_low:.0} % wide at {low} \
        Hz and {own_high:.0} % at {high} Hz; with that of the paper's Table 2 the width goes from {printed_low:.0} % \
        to {printed_high:.0} %. A negative width is an inverted loop. The joint model needs no inverse: its loop is \
        {joint_low:.0} % wide at {low} Hz and {joint_high:.0} % at {high} Hz."
    );
    Figure::new("Width of the loop against frequency", caption).panel(
        Axes::new(Axis::log("f [Hz]").ticks(&TICKS), Axis::new("loop width [% of height]").from(0.0))
            .with(Series::marked(&hz, &printed).role(Role::Descending).named("by the paper's Table 2"))
            .with(Series::marked(&hz, &own).role(Role::Model).named("by the estimated block"))
            .with(Series::marked(&hz, &joint).role(Role::Accent5).named("of the joint model")),
    )
}

/// Errors below this are drawn as this [mm^2].
pub(super) const FLOOR: f64 = 1e-6;

/// Mean squared error of every method against frequency, with the printed Table 1.
pub(super) fn error(study: &Study) -> Figure {
    let hz: Vec<f64> = study.frequencies.iter().map(|f| f.hz).collect();
    let roles = [Role::Descending, Role::Model, Role::Muted, Role::Residual, Role::Accent5];
    let mut axes = Axes::new(Axis::log("f [Hz]").ticks(&TICKS), Axis::log("MSE [mm²]").from(FLOOR));
    for (k, (method, role)) in METHODS.iter().zip(roles).enumerate() {
        let rows = study.frequencies.iter().filter_map(|f| f.row(method.name));
        let mse: Vec<f64> = rows.map(|r| r.metrics.mse.max(FLOOR)).collect();
        axes = axes.with(Series::marked(&hz, &mse).role(role).dashes(k).named(method.name));
    }
    let (f, mse): (Vec<f64>, Vec<f64>) = Study::PRINTED_MSE.iter().copied().unzip();
    // Dashed, so that a line beneath stays visible.
    axes = axes.with(Series::dashed(&f, &mse).role(Role::Reference).named("the paper's Table 1"));
    let below = study.frequencies.iter().flat_map(|f| &f.rows).any(|r| r.metrics.mse < FLOOR);
    let floor =
        if below { format!(" Errors below {FLOOR:e} mm² are drawn at {FLOOR:e} mm².") } else { String::new() };
    let caption = format!(
        "Mean squared error of every method on a stepped sine of {used} steps per period, and the values of the \
        paper's Table 1.{floor}",
        used = Study::STEPS_USED
    );
    Figure::new("Error on the test signal against frequency", caption).panel(axes)
}

/// Methods shown over the test signal: name, labels for stepped sines and staircases, role.
const SHOWN: [(&str, [&str; 2], Role); 4] = [
    ("printed-rule", ["rule as printed", "staircase"], Role::Descending),
    (TestSignal::UPPER_RULE, ["upper branch", ""], Role::Ascending),
    ("held-direction", ["direction held", ""], Role::Model),
    ("table2-arx", ["linear block of Table 2", ""], Role::Residual),
];

/// An axis of steps per period, or levels.
fn steps() -> Axis {
    let ends = (f64::from(*TestSignal::STEPS.start()), f64::from(*TestSignal::STEPS.end()));
    Axis::new("steps per period, or levels")
        .ticks(&[4.0, 7.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 40.0])
        .range(ends.0, ends.1)
}

/// One curve per form: solid for stepped sines, dashed for staircases.
fn by_form(study: &Study, axes: Axes, role: Role, names: [&str; 2], value: impl Fn(&TestSignal) -> f64) -> Axes {
    TestSignal::FORMS.into_iter().zip(names).enumerate().fold(axes, |axes, (k, (form, name))| {
        let signals = study.test_signals.iter().filter(|s| s.form == form);
        let (steps, values): (Vec<f64>, Vec<f64>) = signals.map(|s| (f64::from(s.steps), value(s))).unzip();
        let series = if k == 0 { Series::line(&steps, &values) } else { Series::dashed(&steps, &values) };
        axes.with(series.role(role).named(name))
    })
}

/// Table 1 over the form and the number of steps of the test signal.
pub(super) fn test_signal(study: &Study) -> Figure {
    let title = "Error against the steps of the test signal, and the paper's Table 1";
    let figure = Figure::new(title, words::over_test_signals(study)).medium().columns(2);
    figure.each(over_steps(study), Figure::panel)
}

/// The same with one figure per frequency.
pub(super) fn test_signals(study: &Study) -> impl Iterator<Item = Figure> {
    over_steps(study).into_iter().zip(Study::PRINTED_MSE).map(|(axes, (hz, printed))| {
        let caption = format!("The paper's Table 1 has {printed} mm².");
        Figure::new(format!("Test signals of {hz} Hz"), caption).medium().panel(axes)
    })
}

/// Mean squared errors against steps and levels, one panel per frequency of Table 1.
fn over_steps(study: &Study) -> Vec<Axes> {
    let panel = |(k, (hz, printed)): (usize, &(f64, f64))| {
        let y = Axis::log("MSE [mm²]").from(FLOOR);
        let axes = Axes::new(steps(), y).titled(format!("{hz} Hz")).at_y(*printed, "paper");
        axes.each(&SHOWN, |axes, (method, names, role)| {
            let names = if k == 0 { *names } else { [""; 2] };
            by_form(study, axes, *role, names, |signal| signal.of(method)[k].max(FLOOR))
        })
    };
    Study::PRINTED_MSE.iter().enumerate().map(panel).collect()
}

/// Deviation of each test signal from the paper's Table 1.
pub(super) fn deviation(study: &Study) -> Figure {
    let found = |method: &str| {
        let found = TestSignal::nearest(&study.test_signals, method);
        found.map_or(String::new(), |s| format!("{} ({:.0} %)", s.words(), 100.0 * s.deviation(method)))
    };
    let [printed, upper, table_2] = ["printed-rule", TestSignal::UPPER_RULE, "table2-arx"].map(found);
    let caption = format!(
        "The largest of the four deviations from the paper's Table 1, in % of its value. Solid: sines in steps of \
        equal length, against steps per period; dashed: staircases, against levels. Closest with the rule as printed \
        is a {printed}; if the upper branch of the rule is the one that lies above, a {upper}; with the linear block \
        of the paper's Table 2, a {table_2}."
    );
    let axes = Axes::new(steps(), Axis::log("largest deviation from the paper's Table 1 [%]"));
    let shown = SHOWN.iter().filter(|(method, ..)| *method != "held-direction");
    let axes = axes.each(shown, |axes, (method, names, role)| {
        by_form(study, axes, *role, *names, |signal| 100.0 * signal.deviation(method))
    });
    Figure::new("Deviation of each test signal from the paper's Table 1", caption).panel(axes)
}
