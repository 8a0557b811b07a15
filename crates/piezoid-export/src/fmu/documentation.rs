//! The page for people.

use super::Fmu;
use super::variables::Role;
use super::xml::escape;
use piezoid::number::{round, short};
use piezoid::system::System;

pub(super) fn page(fmu: &Fmu) -> String {
    let (model, entry) = (fmu.wanted.model, fmu.entry());
    let rows = fmu.variables.iter().filter(|v| v.role != Role::State).map(|v| {
        let start = v.start.map_or(String::new(), round);
        let (unit, about) = (escape(&v.unit), escape(&v.about));
        format!(
            "<tr><td><code>{}</code></td><td>{}</td><td>{unit}</td><td>{start}</td><td>{about}</td></tr>\n",
            v.name,
            v.role.words().0
        )
    });
    let states = fmu.variables.iter().filter(|v| v.role == Role::State).count();
    let known = model.identified().map_or(String::new(), |known| {
        format!(
            "<p>It was identified on inputs from {} to {} {}; beyond them nothing is known.</p>\n",
            short(known.u[0]),
            short(known.u[1]),
            escape(&model.units().u)
        )
    });
    format!(
        "\
<!DOCTYPE html>
<html lang=\"en\">
<head><meta charset=\"utf-8\"><title>{name}</title></head>
<body>
<h1>{name}</h1>
<p>{about}, of a piezo actuator identified by piezoid: hysteresis <code>{operator}</code>, {lags} lags of creep, a linear block of
order {order}, sampled every {ts} s.</p>
{known}<table>
<tr><th>variable</th><th>causality</th><th>unit</th><th>start</th><th>what it is</th></tr>
{rows}</table>
<p>The {states} numbers of the state stand below <code>state</code>. They can be set before the initialisation ends, at rest they are as
they start.</p>
<h2>Steps</h2>
<p>The communication step is {ts} s or a whole multiple of it; any other is refused. What is set at the time <i>t</i> enters the samples of
the step that begins there, and the output after the step is the answer of the last of them: the series that piezoid simulates,
one step later on the clock. Before the first step the output is what the initial state would answer to the input.</p>
<p>What enters is <i>gain</i> times the input plus <i>offset</i>, both of which can be changed between steps. Values that are not finite,
unknown variables and calls out of turn are refused; the category <code>logStatusError</code> says why, and nothing has changed.</p>
<h2>Sources</h2>
<p>To build the library anew: <code>cc -std=c99 -O2 -ffp-contract=off -fPIC -shared -fvisibility=hidden {sources}</code>.
With <code>-D FMI{major}_FUNCTION_PREFIX={name}_</code> the functions of several FMUs fit into one program.</p>
</body>
</html>
",
        name = fmu.name,
        about = escape(&capital(&entry.about)),
        operator = model.hysteresis().operator().name,
        lags = model.creep().lags().len(),
        order = model.linear().a().len(),
        ts = round(model.ts()),
        rows = rows.collect::<String>(),
        sources = fmu.names()[1..].join(" "),
        major = &fmu.version.number[..1],
    )
}

/// `text` as a sentence begins.
fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| first.to_uppercase().chain(letters).collect())
}
