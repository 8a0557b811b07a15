//! The page of the study: procedure, results, and causes.

use super::words::{self, mse, percent};
use super::{Frequency, METHODS, RANGE_USED, RISING, Study, StudyBlock, StudyRow, figures};
use crate::each::Each;
use crate::page::{Cell, Fact, Page, PageTable, Section, Text, sentence};
use piezoid::hammerstein::OperatorTrial;
use piezoid::linear::Pole;
use piezoid_numerics::series::ends;

impl Study {
    /// The report on one or more studies: one file that opens from disk.
    pub fn page(studies: &[Study]) -> Page {
        let subtitle = "Hammerstein model of the PL140 bender: two branches per frequency, ARX by particle swarm, on a \
            simulated actuator; and one model for all frequencies";
        let parts = [linear_block, loops, joint, tests, test_signal];
        Page::new("Reproduction of the paper's experiment")
            .subtitle(subtitle)
            .section(introduction())
            .each(studies.iter().flat_map(|study| parts.map(|part| part(study))), Page::section)
            .section(methods())
    }
}

fn introduction() -> Section {
    Section::new("Procedure")
        .text(
            "L. Kuklisova Pavelkova (ICINCO 2025) models a piezo bender as a hysteresis block followed by linear \
            dynamics. A small-signal random binary sequence identifies the dynamics; their inverse converts the \
            response to a sine into the hidden variable z; the loop of z over the voltage u, split in two, is the \
            hysteresis block. This page repeats the experiment on simulated actuators that share no code with the \
            models, at the paper's frequencies and at higher ones.",
        )
        .text(format!(
            "The test signal of the paper is periodic and step-wise; the paper gives no details. Here it is \
            a sine in {used} steps per period, all of nearly equal length in whole samples, the highest at the amplitude of the sine from which the branches are identified. On twin “paper” its errors are the closest to the \
            paper's Table 1 of all tested numbers of steps and levels. While a step is held, the rule as printed reads \
            the descending branch; with the direction held, the model stays on its branch.",
            used = Study::STEPS_USED
        ))
}

fn linear_block(study: &Study) -> Section {
    let swarm = &study.blocks[1];
    let pole = swarm.arx.poles().pop();
    let hz = pole.map_or("none".into(), |p| format!("{:.1}", p.hz));
    let damping = pole.map_or("none".into(), |p| format!("{:.3}", p.damping));
    let zero = swarm.arx.zeros().last().map_or(0.0, |z| z.modulus());
    let facts = [
        Fact::new(hz, "Hz", "pole of the estimated block (the paper's Table 2: 146.7 Hz)"),
        Fact::new(damping, "", "its damping ratio (the paper's Table 2: 0.061)"),
        Fact::new(format!("{zero:.3}"), "", "|z|, the modulus of its outermost zero; if above 1, (8) is unstable"),
    ];
    let noise = |gain: f64| {
        let which = if swarm.arx.inverse().is_ok() { "the inverse (8)" } else { "the inverse of the whole record" };
        let rings = swarm.arx.zeros().iter().any(|z| z.re < -0.9 && z.re > -1.0 && z.im == 0.0);
        let ringing = if rings {
            " The sampling zero near -1 makes it ring at half the sampling rate; averaging over a branch removes the \
            ringing."
        } else {
            ""
        };
        let gain = 1e-3 * gain;
        format!("The noise gain of {which} is {gain:.3} V rms of z per 1 µm rms of sensor noise.{ringing}")
    };
    let compared = match study.optimum {
        Some(_) => " The next figure compares the result with the exact minimum.",
        None => "",
    };
    let search = format!(
        "Equation (1) has no constant, but a sensor has an offset: one per record is estimated by least squares and \
        removed before the swarm starts. The paper does not state the search range of the swarm, the number of \
        particles, their inertia or their largest velocity. Here a1 and a2 are searched within ±2 and ±1, the bounds of a stable \
        block, and each b within ± the largest output divided by the largest input. 50 particles, an inertia from 0.9 \
        to 0.4, and a largest velocity of a fifth of the range per iteration \
        are customary.{compared}"
    );
    Section::new(format!("Twin “{}”: the linear block", study.plant.name))
        .text(study.plant.summary)
        .facts(facts)
        .table(table_2(study))
        .each(&study.notes, |section, note| section.note("Note", note.as_str()))
        .each(study.noise_gain, |section, gain| section.text(noise(gain)))
        .text(search)
        .each([figures::convergence(study), figures::courses(study), figures::response(study)], Section::figure)
}

fn table_2(study: &Study) -> PageTable {
    let numbers = ["a1", "a2", "b0 [mm/V]", "b1 [mm/V]", "b2 [mm/V]", "pole [Hz]", "damping"];
    let table = PageTable::new("Linear block by each estimator (the paper's Table 2)").text("estimator");
    let table = table.each(numbers, PageTable::number).text("zeros").number("sum |e| [mm]");
    let row = |block: &StudyBlock| -> Vec<Cell> {
        let poles = block.arx.poles();
        let each = |what: fn(&Pole) -> String| poles.iter().map(what).collect::<Vec<_>>().join(" / ");
        let [hz, damping] = [each(|p| format!("{:.1}", p.hz)), each(|p| format!("{:.3}", p.damping))].map(Cell::from);
        let zeros: Vec<String> = block.arx.zeros().iter().map(ToString::to_string).collect();
        let zeros = Cell::from(zeros.join(", "));
        let zeros = if block.arx.inverse().is_ok() { zeros } else { zeros.bad() };
        let sum = block.fit.as_ref().map_or("-".into(), |f| format!("{:.5}", f.residuals.sum_abs));
        let coefficients = block.printed().into_iter().map(Cell::from);
        std::iter::once(block.name.into()).chain(coefficients).chain([hz, damping, zeros, sum.into()]).collect()
    };
    table.rows(study.blocks.iter().map(row)).note(
        "printed: the row of 5 Hz of the paper's Table 2, printed-80hz that of 80 Hz. According to the paper the block \
        is identified only once, but its table has one row per frequency, with different b0. With four decimals the static gain is only known to within a third. Coloured zeros make (8) unstable.",
    )
    .note(words::units(study))
}

fn loops(study: &Study) -> Section {
    let inverted: Vec<String> =
        study.frequencies.iter().filter(|f| !f.own.found.ascending_below).map(|f| f.hz.to_string()).collect();
    let mut words = "Grey dots are samples of voltage and hidden variable; the curves and the loop of the joint model \
        may cover them. The dashed line through the two reversal points splits the loop; the curves are splines \
        through the averages on each side. Which side is the ascending branch is determined from the data. Beside each \
        loop: the same less the least-squares straight line (of the samples; of its own loop for the joint model), so \
        that the width is seen."
        .to_string();
    let slowest = &study.frequencies[0];
    let span = |x: &[f64]| ends(x.iter().copied()).1 - ends(x.iter().copied()).0;
    let times = span(&slowest.own.z) / span(&slowest.own.u);
    if !(0.67..1.5).contains(&times) {
        words += &format!(
            " At {} Hz z spans {times:.1} times the voltage: the static gain of the estimated block is wrong by this \
            factor.",
            slowest.hz
        );
    }
    let falling = |f: &&Frequency| f.own.found.line[1].1 < f.own.found.line[0].1;
    let falling: Vec<String> = study.frequencies.iter().filter(falling).map(|f| f.hz.to_string()).collect();
    if !falling.is_empty() {
        words += &format!(
            " At {} Hz the line falls: z lags u by more than a quarter of a period. This is not a property of \
            ceramics: z contains the errors of the linear block and the lag of the driver.",
            falling.join(", ")
        );
    }
    match inverted.as_slice() {
        [] if !falling.is_empty() => {}
        [] => words += " The ascending branch lies below at every frequency, as in a piezo loop.",
        some => words += &format!(" At {} Hz the loop is inverted: the ascending branch lies above.", some.join(", ")),
    }
    let title = "Loops with separating line and branches (the paper's Figs 2, 4, 5)";
    Section::new(format!("Twin “{}”: the loops", study.plant.name))
        .figures(2, title, words, figures::hysteresis_loops(study))
        .figure(figures::width(study))
}

fn joint(study: &Study) -> Section {
    let model = &study.joint.model;
    let poles: Vec<String> = model.linear().poles().iter().map(|p| format!("{:.1}", p.hz)).collect();
    let taken = |t: &&OperatorTrial| t.operator == model.hysteresis().operator().name;
    let held_out = study.joint.trials.iter().find(taken).map_or(f64::NAN, |t| t.held_out_percent);
    let facts = [
        Fact::new(model.hysteresis().operator().name, "", "the operator chosen"),
        Fact::new(percent(held_out), "%", "held-out rms error, of peak-to-peak"),
        Fact::new(poles.join(" / "), "Hz", "poles of its linear block"),
    ];
    let title = "Operators tried, and their errors on held-out records and in free run [% rms of peak-to-peak]";
    let table = PageTable::new(title).text("operator").number("parameters").number("held out").number("free run");
    let row = |t: &OperatorTrial| -> Vec<Cell> {
        let errors = [t.held_out_percent, t.free_run_percent];
        let errors = errors.map(|error| Cell::from(if t.refused.is_some() { "-".into() } else { percent(error) }));
        let errors = if t.as_good { errors.map(Cell::best) } else { errors };
        [Text::new().code(t.operator).into(), t.parameters.to_string().into()].into_iter().chain(errors).collect()
    };
    let rising: Vec<String> = RISING.iter().map(f64::to_string).collect();
    let driver = match model.driver() {
        Some(_) => {
            " The lag and the current limit of the driver are known to the experimenter and given to the method."
        }
        None => "",
    };
    let words = format!(
        "The same PRBS and rising sines of {} Hz, one second each, identify hysteresis, creep and dynamics together by \
        the error of the free run: an operator with memory of the reversals, followed by the linear block. Nothing is \
        inverted, so the zeros of the block do not matter. One model covers every frequency and amplitude.{driver}",
        rising.join(", ")
    );
    let note =
        "Coloured: as good as the best within the accuracy of the records. Among these the simplest is selected.";
    Section::new(format!("Twin “{}”: one model for all frequencies", study.plant.name))
        .text(words)
        .facts(facts)
        .table(table.rows(study.joint.trials.iter().map(row)).note(note))
        .each(&study.joint.notes, |section, note| section.note("Note", sentence(note)))
}

fn tests(study: &Study) -> Section {
    let caption = "Two periods of the test signal in free run, and the error of each method. With the rule as printed \
                   the model jumps to the descending branch at every held step.";
    let title = "Mean squared error on the test signal [mm²] (the paper's Table 1)";
    Section::new(format!("Twin “{}”: the tests", study.plant.name))
        .each(words::paragraphs(study), Section::text)
        .table(errors(study, true, title, |r| mse(r.metrics.mse)))
        .figure(figures::error(study))
        .table(errors(study, false, "The same as rms error [% of peak-to-peak]", |r| percent(r.metrics.rms_pp_percent)))
        .figures(2, "Test and prediction", caption, study.frequencies.iter().map(figures::test))
}

/// The errors of every method at every frequency, with or without the paper's Table 1.
fn errors(study: &Study, beside_table_1: bool, title: &str, text: impl Fn(&StudyRow) -> String) -> PageTable {
    let paper = beside_table_1.then_some("paper");
    let columns = METHODS.iter().map(|method| method.name).chain(paper);
    let table = PageTable::new(title).number("f [Hz]").number("u [V]").each(columns, PageTable::number);
    let row = |f: &Frequency| -> Vec<Cell> {
        let cell = |r: &StudyRow| {
            let best = f.rows.iter().all(|other| r.metrics.mse <= 1.001 * other.metrics.mse);
            if best { Cell::from(text(r)).best() } else { text(r).into() }
        };
        let mut cells: Vec<Cell> = vec![f.hz.to_string().into(), f.amplitude.to_string().into()];
        cells.extend(f.rows.iter().map(cell));
        if beside_table_1 {
            let printed = Study::PRINTED_MSE.iter().find(|(hz, _)| *hz == f.hz);
            cells.push(printed.map_or(Cell::from("-"), |(_, mse)| Cell::from(format!("{mse:.4}"))).muted());
        }
        cells
    };
    table.rows(study.frequencies.iter().map(row)).note(format!(
        "u: amplitude of sine and test signal; lowered so that the tip stays within {:.0} % of the range of a sensor \
        that has one.",
        100.0 * RANGE_USED
    ))
}

/// Table 1 over the unknown properties of the test signal.
fn test_signal(study: &Study) -> Section {
    let title = "The closest test signals: mean squared error with the rule as printed [mm²], and the largest \
        deviation from the paper's Table 1";
    let frequencies = Study::PRINTED_MSE.map(|(hz, _)| format!("{hz} Hz"));
    let table = PageTable::new(title).text("test signal").each(frequencies, PageTable::number);
    let row = |words: String, errors: [f64; 4], off: String| -> Vec<Cell> {
        let errors = errors.map(|e| Cell::from(format!("{e:.4}")));
        std::iter::once(words.into()).chain(errors).chain([off.into()]).collect()
    };
    let mut signals: Vec<_> = study.test_signals.iter().collect();
    signals.sort_by(|p, q| p.deviation("printed-rule").total_cmp(&q.deviation("printed-rule")));
    let paper = row("the paper's Table 1".into(), Study::PRINTED_MSE.map(|(_, mse)| mse), String::new());
    let nearest = signals.into_iter().take(NEAREST).map(|signal| {
        let off = format!("{:.0}", 100.0 * signal.deviation("printed-rule"));
        row(signal.words(), signal.of("printed-rule"), off)
    });
    let table = table.number("deviation [%]").row(paper).rows(nearest);
    let caption = words::over_test_signals(study);
    Section::new(format!("Twin “{}”: error against the steps of the test signal", study.plant.name))
        .figures(2, "The paper's Table 1 over the test signal", caption, figures::test_signals(study))
        .figure(figures::deviation(study))
        .table(table)
}

/// Number of test signals in the table.
const NEAREST: usize = 5;

fn methods() -> Section {
    let rows = METHODS.iter().map(|method| [Text::new().code(method.name), method.summary.into()]);
    let table = PageTable::new("Methods").text("method").text("description").rows(rows);
    Section::new("How to read and reproduce it")
        .table(table)
        .text(
            "Every error is that of a free run from rest, compared after the first 0.5 s. Branches are identified on a \
            sine and tested on the stepped sine of the same frequency and amplitude. This is the paper's test. It does \
            not cover other amplitudes, minor loops or mixed frequencies, which two branches cannot follow. The joint model is identified on different records, at four of the eight frequencies.",
        )
        .listing("piezoid study\npiezoid study --plant pl140 --seed 1 --json study.json")
}
