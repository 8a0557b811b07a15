//! The page of the study: what was done, what is seen, and why.

use super::words::{self, mse, percent};
use super::{Frequency, METHODS, RANGE_USED, RISING, Study, StudyBlock, StudyRow, figures};
use crate::page::{Cell, Fact, Page, PageTable, Section, Text, sentence};
use piezoid::hammerstein::OperatorTrial;
use piezoid::series::ends;

impl Study {
    /// The report on one or more studies: one file that opens from disk.
    pub fn page(studies: &[Study]) -> Page {
        let page = Page::new("The paper, end to end")
            .subtitle("Hammerstein model of the PL140 bender: two branches a frequency, ARX by particle swarm, on a simulated actuator; and one model of all frequencies beside it")
            .section(introduction());
        let page = studies.iter().fold(page, |page, study| {
            let page = page.section(linear_block(study)).section(loops(study)).section(joint(study));
            page.section(tests(study)).section(test_signal(study))
        });
        page.section(methods())
    }
}

fn introduction() -> Section {
    Section::new("What was done")
        .text(
            "L. Kuklisova Pavelkova (ICINCO 2025) models a piezo bender as a hysteresis block followed by linear dynamics. A small \
             random binary signal identifies the dynamics; their inverse turns the answer to a sine into the hidden variable z; the \
             loop of z over the voltage u, split in two, is the hysteresis block. This page repeats the experiment on simulated \
             actuators that share no code with the models, at the paper's frequencies and beyond them.",
        )
        .text(format!("The test signal of the paper is periodic and step-wise; no more is known of it. Here it is a sine in {used} steps a \
             period, each held as equally long as whole samples allow, the highest at the amplitude of the sine that the branches come from. On \
             twin “paper” this comes nearest to the paper's Table 1, of all numbers of steps and levels that are tried. While a step is \
             held, the rule as printed reads the descending branch; with the direction held, the model stays on the branch it was on.", used = Study::STEPS_USED))
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
        Fact::new(format!("{zero:.3}"), "", "|z|, the modulus of its outermost zero; above 1, (8) is unstable"),
    ];
    let mut section =
        Section::new(format!("Twin “{}”: the linear block", study.plant.name)).text(study.plant.summary).facts(facts);
    section = section.table(table_2(study));
    for note in &study.notes {
        section = section.note("To know", note.as_str());
    }
    if let Some(gain) = study.noise_gain {
        let which = if swarm.arx.inverse().is_ok() { "The inverse (8)" } else { "The inverse of the whole record" };
        let rings = swarm.arx.zeros().iter().any(|z| z.re < -0.9 && z.re > -1.0 && z.im == 0.0);
        let ringing = if rings {
            " The zero near -1 that sampling puts there makes it ring at half the sampling rate; averaging over a branch takes the \
             ringing out again."
        } else {
            ""
        };
        section = section
            .text(format!("{which} turns 1 µm rms of sensor noise into {:.3} V rms of z.{ringing}", 1e-3 * gain));
    }
    section = section.text(
        "Equation (1) has no constant, and a sensor has: one a record is found by least squares and taken off before the swarm starts. \
         Nor does the paper state the box that the swarm starts in, the number of particles, their inertia or their largest velocity. Here \
         a1 and a2 are sought within the bounds of a stable block, 2 and 1, each b within the largest output over the largest input; 50 \
         particles, inertia from 0.9 to 0.4, and a fifth of the box per iteration are customary. How near the swarm comes to the least \
         cost there is, the next figure says.",
    );
    section.figure(figures::convergence(study)).figure(figures::courses(study)).figure(figures::response(study))
}

fn table_2(study: &Study) -> PageTable {
    let table = PageTable::new("Linear block by each estimator (the paper's Table 2)").text("estimator");
    let table = ["a1", "a2", "b0 [mm/V]", "b1 [mm/V]", "b2 [mm/V]", "pole [Hz]", "damping"]
        .into_iter()
        .fold(table, PageTable::number);
    let table = table.text("zeros").number("sum |e| [mm]");
    let row = |block: &StudyBlock| -> Vec<Cell> {
        let mut cells: Vec<Cell> = vec![block.name.into()];
        cells.extend(block.printed().into_iter().map(Cell::from));
        let poles = block.arx.poles();
        let each =
            |what: &dyn Fn(&piezoid::linear::Pole) -> String| poles.iter().map(what).collect::<Vec<_>>().join(" / ");
        cells.push(each(&|p| format!("{:.1}", p.hz)).into());
        cells.push(each(&|p| format!("{:.3}", p.damping)).into());
        let zeros: Vec<String> = block.arx.zeros().iter().map(ToString::to_string).collect();
        let zeros = Cell::from(zeros.join(", "));
        cells.push(if block.arx.inverse().is_ok() { zeros } else { zeros.bad() });
        cells.push(block.fit.as_ref().map_or(Cell::from("-"), |f| format!("{:.5}", f.residuals.sum_abs).into()));
        cells
    };
    let table = study.blocks.iter().fold(table, |table, block| table.row(row(block)));
    table.note(
        "printed: the row of 5 Hz of the paper's Table 2, printed-80hz that of 80 Hz. By the paper's text the block is identified only \
         once; its table has a row a frequency, and they differ in b0. Four decimals leave the static gain uncertain by a third. Zeros in \
         colour make (8) unstable.",
    )
    .note(words::units(study))
}

fn loops(study: &Study) -> Section {
    let turned: Vec<String> =
        study.frequencies.iter().filter(|f| !f.own.found.ascending_below).map(|f| f.hz.to_string()).collect();
    let mut words = "Grey dots are samples of voltage and hidden variable, hidden by the curves where these fit; so is the loop of the joint model. The dashed line through the two turning points splits them; \
                     the curves are splines through the averages on either side. Which side is the ascending one the data decide."
        .to_string();
    let slowest = &study.frequencies[0];
    let span = |x: &[f64]| ends(x.iter().copied()).1 - ends(x.iter().copied()).0;
    let times = span(&slowest.own.z) / span(&slowest.own.u);
    if !(0.67..1.5).contains(&times) {
        words += &format!(
            " At {} Hz z spans {times:.1} times the voltage: by so much the static gain of the estimated block is off.",
            slowest.hz
        );
    }
    let against = |f: &&Frequency| f.own.found.line[1].1 < f.own.found.line[0].1;
    let against: Vec<String> = study.frequencies.iter().filter(against).map(|f| f.hz.to_string()).collect();
    if !against.is_empty() {
        words += &format!(
            " At {} Hz the line falls: z runs against u, lagging by more than a quarter of a period. No ceramic does that; what the \
             linear block lacks, and the driver's lag, are left to z.",
            against.join(", ")
        );
    }
    match turned.as_slice() {
        [] if !against.is_empty() => {}
        [] => words += " Rising voltage lies on the lower side at every frequency, as it does on a piezo loop.",
        some => {
            words +=
                &format!(" At {} Hz the loop has turned round: rising voltage lies on the upper side.", some.join(", "))
        }
    }
    Section::new(format!("Twin “{}”: the loops", study.plant.name))
        .figures(
            4,
            "Loops with separating line and branches (the paper's Figs 2, 4, 5)",
            words,
            study.frequencies.iter().map(figures::hysteresis_loop),
        )
        .figure(figures::width(study))
}

fn joint(study: &Study) -> Section {
    let model = &study.joint.model;
    let poles: Vec<String> = model.linear().poles().iter().map(|p| format!("{:.1}", p.hz)).collect();
    let held_out = |t: &&OperatorTrial| t.operator == model.hysteresis().operator().name;
    let held_out = study.joint.trials.iter().find(held_out).map_or(f64::NAN, |t| t.held_out_percent);
    let facts = [
        Fact::new(model.hysteresis().operator().name, "", "the operator chosen"),
        Fact::new(percent(held_out), "%", "rms error of what was held out, of peak-to-peak"),
        Fact::new(poles.join(" / "), "Hz", "poles of its linear block"),
    ];
    let table =
        PageTable::new("Operators tried, and what they leave of records held out in turn [% rms of peak-to-peak]");
    let table = table.text("operator").number("parameters").number("held out");
    let row = |t: &OperatorTrial| -> Vec<Cell> {
        let held_out = Cell::from(if t.refused.is_some() { "-".into() } else { percent(t.held_out_percent) });
        let held_out = if t.as_good { held_out.best() } else { held_out };
        vec![Text::new().code(t.operator).into(), t.parameters.to_string().into(), held_out]
    };
    let table = study.joint.trials.iter().fold(table, |table, t| table.row(row(t)));
    let rising: Vec<String> = RISING.iter().map(f64::to_string).collect();
    let driver = match model.driver() {
        Some(_) => " Lag and current limit of the driver, which the experimenter knows, were given to it.",
        None => "",
    };
    let words = format!(
        "The same PRBS and rising sines of {} Hz, a second each, identify hysteresis, creep and dynamics together, by the error of the \
         free run: an operator that remembers where the voltage has turned, behind it the linear block. Nothing is inverted, so the \
         zeros of the block do not matter; one model serves every frequency and amplitude.{driver}",
        rising.join(", ")
    );
    let section =
        Section::new(format!("Twin “{}”: one model of all frequencies", study.plant.name)).text(words).facts(facts);
    let note = "In colour: as good as the best, within what the records can tell. The simplest of these is taken.";
    study
        .joint
        .notes
        .iter()
        .fold(section.table(table.note(note)), |section, note| section.note("To know", sentence(note)))
}

fn tests(study: &Study) -> Section {
    let caption = "Two periods of the test signal in free run, and the error of each reading. With the rule as printed every held \
                   step falls to the descending branch.";
    let section = Section::new(format!("Twin “{}”: the tests", study.plant.name));
    let section = words::paragraphs(study).into_iter().fold(section, Section::text);
    section
        .table(errors(study, true, "Mean squared error on the test signal [mm²] (the paper's Table 1)", |r| {
            mse(r.metrics.mse)
        }))
        .figure(figures::error(study))
        .table(errors(study, false, "The same as rms error [% of peak-to-peak]", |r| percent(r.metrics.rms_pp_percent)))
        .figures(2, "Test and prediction", caption, study.frequencies.iter().map(figures::test))
}

/// What every method leaves at every frequency, beside Table 1 or alone.
fn errors(study: &Study, beside_table_1: bool, title: &str, told: impl Fn(&StudyRow) -> String) -> PageTable {
    let table = PageTable::new(title).number("f [Hz]").number("u [V]");
    let table = METHODS.iter().fold(table, |t, m| t.number(m.name));
    let table = if beside_table_1 { table.number("paper") } else { table };
    let row = |f: &Frequency| -> Vec<Cell> {
        let cell = |r: &StudyRow| {
            let best = f.rows.iter().all(|other| r.metrics.mse <= 1.001 * other.metrics.mse);
            if best { Cell::from(told(r)).best() } else { told(r).into() }
        };
        let mut cells: Vec<Cell> = vec![f.hz.to_string().into(), f.amplitude.to_string().into()];
        cells.extend(f.rows.iter().map(cell));
        if beside_table_1 {
            let printed = Study::PRINTED_MSE.iter().find(|(hz, _)| *hz == f.hz);
            cells.push(printed.map_or(Cell::from("-"), |(_, mse)| Cell::from(format!("{mse:.4}"))).muted());
        }
        cells
    };
    let table = study.frequencies.iter().fold(table, |table, f| table.row(row(f)));
    table.note(format!(
        "u: amplitude of sine and test signal; lowered so that the tip stays within {:.0} % of the range of a sensor that has one.",
        100.0 * RANGE_USED
    ))
}

/// Table 1 over what the paper leaves open of its test signal.
fn test_signal(study: &Study) -> Section {
    let title = "The nearest test signals: mean squared error by the rule as printed [mm²], and the largest deviation from the paper's Table 1";
    let table = Study::PRINTED_MSE
        .iter()
        .fold(PageTable::new(title).text("test signal"), |t, (hz, _)| t.number(format!("{hz} Hz")));
    let row = |words: String, errors: [f64; 4], off: String| -> Vec<Cell> {
        let errors = errors.map(|e| Cell::from(format!("{e:.4}")));
        std::iter::once(words.into()).chain(errors).chain([off.into()]).collect()
    };
    let mut signals: Vec<_> = study.test_signals.iter().collect();
    signals.sort_by(|p, q| p.deviation("printed-rule").total_cmp(&q.deviation("printed-rule")));
    let paper = row("the paper's Table 1".into(), Study::PRINTED_MSE.map(|(_, mse)| mse), String::new());
    let table = signals.iter().take(NEAREST).fold(table.number("deviation [%]").row(paper), |table, signal| {
        let off = format!("{:.0}", 100.0 * signal.deviation("printed-rule"));
        table.row(row(signal.words(), signal.of("printed-rule"), off))
    });
    Section::new(format!("Twin “{}”: the paper's Table 1 over the test signal", study.plant.name))
        .figures(
            2,
            "The paper's Table 1 over the test signal",
            words::over_test_signals(study),
            figures::test_signals(study),
        )
        .figure(figures::deviation(study))
        .table(table)
}

/// Test signals that the table shows.
const NEAREST: usize = 5;

fn methods() -> Section {
    let table = PageTable::new("Methods").text("method").text("what it is");
    let table = METHODS.iter().fold(table, |t, m| t.row([Text::new().code(m.name), m.summary.into()]));
    Section::new("How to read and repeat it")
        .table(table)
        .text(
            "Every error is that of a free run from rest, compared after the first 0.5 s. Branches are identified on a sine and tested \
             on the stepped sine of the same frequency and amplitude: this is the paper's test, and says nothing of other amplitudes, \
             minor loops or mixed frequencies, which two branches cannot follow. The joint model is identified on other records than \
             these, and on four frequencies of the eight.",
        )
        .listing("piezoid study\npiezoid study --plant pl140 --seed 1 --json study.json")
}
