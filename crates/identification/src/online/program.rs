//! The estimator as a program, for exports: [`Online::step`] with the parts that the model and the settings need.

use super::{GAIN_RANGE, MAX_FACTOR, MAX_RATIO, MAX_REFLECTION, MAX_ROW, Online};
use piezoid_models::program::{Block, Program};
use piezoid_numerics::error::Error;

impl Online {
    /// Adds the estimator to the program of its model: a block `online_state`, the state in its order, and a function
    /// `online_step(s: online_state, u, y)`, which returns the expected response.
    ///
    /// # Errors
    /// Returns an error if `program` is not that of the model.
    pub fn extend(&self, program: &mut Program) -> Result<(), Error> {
        let mut block = Block::new("online_state", "the model with moving parameters");
        if self.model.hysteresis().order() > 0 {
            block = block.part("hysteresis", "hysteresis");
        }
        if self.model.driver().is_some() {
            block = block.part("driver", "driver");
        }
        block = self.fields(block);
        let fits = [
            (self.weights.as_ref(), "recursive least squares of the weights, in groups"),
            (self.linear.as_ref(), "recursive least squares of the linear block"),
            (Some(&self.gain), "recursive least squares of gain and offset"),
        ];
        for (factor, about) in fits {
            let Some(factor) = factor else { continue };
            program.add(factor.block(about))?;
            block = block.part(factor.name(), factor.name());
        }
        let has_move = program.function("hysteresis_move").is_some();
        program.add(self.constants(block).text(&self.text(has_move)))
    }

    /// The fields between the parts, at rest.
    fn fields(&self, block: Block) -> Block {
        let mut x = self.initial();
        let s = self.layout.state(&mut x);
        block
            .number("input", *s.input)
            .number("error", *s.error)
            .number("gain", *s.gain)
            .number("offset", *s.offset)
            .numbers("factor", s.factor.to_vec())
            .numbers("a", s.a.to_vec())
            .numbers("b", s.b.to_vec())
            .numbers("lag", s.lag.to_vec())
            .numbers("inputs", s.inputs.to_vec())
            .numbers("outputs", s.outputs.to_vec())
            .numbers("filtered_in", s.filtered_in.to_vec())
            .numbers("filtered_out", s.filtered_out.to_vec())
            .number("mean", *s.mean)
            .number("power", *s.power)
            .number("phase", *s.phase)
    }

    fn constants(&self, block: Block) -> Block {
        let (scales, layout, linear) = (&self.scales, &self.layout, self.model.linear());
        let weights = self.model.hysteresis().linear_weights().map_or(&[][..], |linear| linear.weights);
        let numbers = [
            ("lowest", scales.inputs.0),
            ("highest", scales.inputs.1),
            ("fresh", scales.fresh),
            ("dead_zone", self.dead_zone),
            ("stroke", scales.stroke),
            ("least_power", scales.least_power),
            ("drift", scales.drift),
            ("of_gain", scales.of_gain),
            ("of_a", scales.of_a),
            ("of_b", scales.of_b),
            ("most_b", scales.most_b),
            ("still", scales.still),
            ("lowest_offset", scales.offsets.0),
            ("highest_offset", scales.offsets.1),
            ("least_gain", GAIN_RANGE.0),
            ("most_gain", GAIN_RANGE.1),
            ("most_factor", MAX_FACTOR),
            ("most_ratio", MAX_RATIO),
            ("most_row", MAX_ROW),
            ("most_reflection", MAX_REFLECTION),
        ];
        let tables = [
            ("rate", &self.rates[..]),
            ("lag_gain", &self.shares),
            ("weight", weights),
            ("share", &scales.share),
            ("start_a", linear.a()),
            ("start_b", linear.b()),
        ];
        let counts = [
            ("groups", layout.groups),
            ("lags", layout.lags),
            ("taps", layout.taps),
            ("past", layout.past),
            ("delay", self.delay),
            ("moving", linear.b().len() - self.delay),
            ("filtered", layout.filtered[0]),
        ];
        let block = numbers.into_iter().fold(block, |block, (name, value)| block.constant(name, value));
        let block = tables.into_iter().fold(block, |block, (name, values)| block.table(name, values));
        counts.into_iter().fold(block, |block, (name, value)| block.count(name, value))
    }

    /// The functions. What does not move, and past values that are not there, leave no text.
    fn text(&self, has_move: bool) -> String {
        let (weights, linear, past) = (self.weights.is_some(), self.linear.is_some(), self.layout.past > 0);
        let ratio = if self.moves.gain { "mean" } else { "1.0" };
        let parts = [
            (weights, MOVE_FACTORS.replace("RATIO", ratio)),
            (linear && past, STABLE.into()),
            (linear, marked(&MOVE_COEFFICIENTS.replace("RATIO", ratio), past)),
            (linear, marked(FILTER, past)),
            (true, OPEN.into()),
            (true, self.groups_text(has_move)),
            (true, "    let crept = 0.0;\n    let response = 0.0;\n    for m in 0..groups {\n".into()),
            (true, "        let z = part[m];\n".into()),
            (self.layout.lags > 0, CREEP.into()),
            (true, "        let sum = s.b[0] * z;\n".into()),
            (self.layout.taps > 0, past_values("inputs", "taps", "s.b[k + 1]", "z")),
            (past, past_values("outputs", "past", "s.a[k]", "sum")),
            (weights, "        s.weights_fit.row[m] = sum;\n".into()),
            (true, "        crept += s.factor[m] * z;\n        response += s.factor[m] * sum;\n    }\n".into()),
            (linear, "    online_filter(s, crept, response);\n".into()),
            (true, MEASURE.into()),
            (weights, WEIGHTS.into()),
            (linear, LINEAR.into()),
            (weights || linear, TURN.into()),
            (self.moves.gain || self.moves.offset, self.gain_text()),
            (self.moves.offset, "            } else {\n                s.offset += drift * e;\n".into()),
            (true, CLOSE.into()),
        ];
        parts.into_iter().filter_map(|(is, text)| is.then_some(text)).collect()
    }

    /// The hidden variable of each group.
    fn groups_text(&self, has_move: bool) -> String {
        let hidden = self.model.hidden_call("", "input");
        let Some(linear) = self.model.hysteresis().linear_weights().filter(|_| self.moves.weights) else {
            return format!("    part[0] = {hidden};\n");
        };
        let step = if has_move { "hysteresis_move(s.hysteresis, input)".into() } else { hidden };
        let response = linear.response.replace("x.", "s.hysteresis.").replace(" u", " input");
        let group = |(m, group): (usize, &std::ops::Range<usize>)| match group.start {
            0 => "    part[0] += weight[0] * input;\n".to_string(),
            start => format!(
                "    for k in {}..{} {{ part[{m}] += weight[k + 1] * ({response}); }}\n",
                start - 1,
                group.end - 1
            ),
        };
        format!("    {step};\n{}", self.groups.iter().enumerate().map(group).collect::<String>())
    }

    fn gain_text(&self) -> String {
        let row = if self.moves.gain { "clamp(response * of_gain, -most_row, most_row)" } else { "0.0" };
        GAIN.replace("GAIN", row).replace("OFFSET", if self.moves.offset { "1.0" } else { "0.0" })
    }
}

/// Removes the lines marked for past outputs if there are none, and the marks.
fn marked(text: &str, past: bool) -> String {
    text.lines()
        .filter(|line| past || !line.ends_with("//A"))
        .map(|line| line.trim_end_matches("//A").to_string() + "\n")
        .collect()
}

/// Text that adds past values of a group and then stores the newest.
fn past_values(name: &str, count: &str, coefficient: &str, newest: &str) -> String {
    let first = format!("s.{name}[m * {count}]");
    format!(
        "        for k in 0..{count} {{ sum += {coefficient} * s.{name}[m * {count} + k]; }}
        for k in 1..{count} down {{ s.{name}[m * {count} + k] = s.{name}[m * {count} + k - 1]; }}
        {first} = {newest};\n"
    )
}

const MOVE_FACTORS: &str = "
// Takes a step of the factors of the groups; the change of their mean goes to the gain.
fn online_factors(s: online_state) {
    let moved = [0.0; groups];
    let mean = 0.0;
    for m in 0..groups {
        moved[m] = clamp(s.factor[m] + s.weights_fit.step[m] * of_gain, 0.0, most_factor);
        mean += share[m] * moved[m];
    }
    if mean * most_ratio > 1.0 && mean < most_ratio {
        let ratio = RATIO;
        for m in 0..groups {
            s.factor[m] = clamp(moved[m] / ratio, 0.0, most_factor);
            s.weights_fit.away[m] = (s.factor[m] - 1.0) / of_gain;
        }
        s.gain = s.gain * ratio;
    }
}
";

const STABLE: &str = "
// 1 if all poles of the denominator in the rows of the estimator are within the unit circle (Jury's criterion).
fn online_stable(s: online_state) {
    let stable = 1.0;
    let c = [0.0; past];
    let next = [0.0; past];
    for i in 0..past { c[i] = s.linear_fit.row[i]; }
    for j in 0..past down {
        let last = c[j];
        if stable > 0.0 && last > -most_reflection && last < most_reflection {
            let scale = 1.0 / (1.0 - last * last);
            for i in 0..j { next[i] = (c[i] + last * c[j - 1 - i]) * scale; }
            for i in 0..j { c[i] = next[i]; }
        } else {
            stable = 0.0;
        }
    }
    return stable;
}
";

const MOVE_COEFFICIENTS: &str = "
// Takes a step of the linear block if it leaves that stable; the change of its static gain goes to the gain.
fn online_linear(s: online_state) {
    let rest = 1.0;
    let sum = 0.0;
    // The rows are free until the next sample: they hold the new coefficients.
    for i in 0..past {//A
        s.linear_fit.row[i] = s.a[i] + s.linear_fit.step[i] * of_a;//A
        rest -= s.linear_fit.row[i];//A
    }//A
    for k in 0..moving {
        s.linear_fit.row[past + k] = clamp(s.b[delay + k] + s.linear_fit.step[past + k] * of_b, -most_b, most_b);
        sum += s.linear_fit.row[past + k];
    }
    let mean = sum / (rest * still);
    let stable = 1.0;
    if mean * most_ratio > 1.0 && mean < most_ratio {
        stable = online_stable(s);//A
    } else {
        stable = 0.0;
    }
    if stable > 0.0 {
        let ratio = RATIO;
        for i in 0..past {//A
            s.a[i] = s.linear_fit.row[i];//A
            s.linear_fit.away[i] = (s.a[i] - start_a[i]) / of_a;//A
        }//A
        for k in 0..moving {
            s.b[delay + k] = s.linear_fit.row[past + k] / ratio;
            s.linear_fit.away[past + k] = (s.b[delay + k] - start_b[delay + k]) / of_b;
        }
        s.gain = s.gain * ratio;
    }
}
";

const FILTER: &str = "
// Input and output of the linear block behind 1 / A: the derivatives by its coefficients.
fn online_filter(s: online_state, crept, response) {
    let by_a = s.gain * of_a;//A
    let by_b = s.gain * of_b;
    let v = response;//A
    let w = crept;
    for i in 0..past {//A
        v += s.a[i] * s.filtered_out[i];//A
        s.linear_fit.row[i] = clamp(s.filtered_out[i] * by_a, -most_row, most_row);//A
        w += s.a[i] * s.filtered_in[i];//A
    }//A
    for i in 1..past down { s.filtered_out[i] = s.filtered_out[i - 1]; }//A
    s.filtered_out[0] = v;//A
    for k in 1..filtered down { s.filtered_in[k] = s.filtered_in[k - 1]; }
    s.filtered_in[0] = w;
    for k in 0..moving {
        s.linear_fit.row[past + k] = clamp(s.filtered_in[delay + k] * by_b, -most_row, most_row);
    }
}
";

const OPEN: &str = "
// One sample: input and reading to the response that was expected. The parameters move: gain, offset, factor, a, b.
fn online_step(s: online_state, u, y) {
    // An input that is no number is held, and one far beyond the range counts as its end.
    if magnitude(u) <= measurable { s.input = clamp(u, lowest, highest); }
    let input = s.input;
    let part = [0.0; groups];
";

const CREEP: &str = "        for k in 0..lags {
            s.lag[m * lags + k] += rate[k] * (part[m] - s.lag[m * lags + k]);
            z += lag_gain[k] * s.lag[m * lags + k];
        }
";

const MEASURE: &str = "    let expected = s.offset + s.gain * response;
    s.mean += fresh * (response - s.mean);
    let off = response - s.mean;
    s.power += fresh * (off * off - s.power);
    // A reading that is no number is skipped.
    if magnitude(y) <= measurable {
        s.error = y - expected;
        if s.error > dead_zone || s.error < -dead_zone {
            let e = clamp(s.error, -stroke, stroke);
            if s.power >= least_power {
";

const WEIGHTS: &str = "                // The slow estimators take turns.
                if s.phase == 0.0 {
                    let scale = s.gain * of_gain;
                    for m in 0..groups {
                        s.weights_fit.row[m] = clamp(s.weights_fit.row[m] * scale, -most_row, most_row);
                    }
                    weights_fit_update(s.weights_fit, e);
                    weights_fit_recall(s.weights_fit);
                    online_factors(s);
                }
";

const LINEAR: &str = "                if s.phase == 1.0 {
                    linear_fit_update(s.linear_fit, e);
                    online_linear(s);
                } else if s.phase == 2.0 {
                    linear_fit_recall(s.linear_fit);
                }
";

const TURN: &str = "                if s.phase < 2.0 { s.phase += 1.0; } else { s.phase = 0.0; }
";

const GAIN: &str = "                s.gain_fit.row[0] = GAIN;
                s.gain_fit.row[1] = OFFSET;
                gain_fit_update(s.gain_fit, e);
                gain_fit_recall(s.gain_fit);
                s.gain += s.gain_fit.step[0] * of_gain;
                s.offset += s.gain_fit.step[1];
";

const CLOSE: &str = "            }
            s.gain = clamp(s.gain, least_gain, most_gain);
            s.offset = clamp(s.offset, lowest_offset, highest_offset);
        }
    }
    return expected;
}
";
