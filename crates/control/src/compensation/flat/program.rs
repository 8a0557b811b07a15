//! The inverse as a program, in the same order as its step.

use super::taps::{REACH, TAPS};
use super::{Drive, FORCE, Flat, LEAST_BEND, LEAST_STIFFNESS, Parts, ROOT_STEPS, Slow, WITHIN};
use piezoid_models::program::{Block, Program};
use piezoid_numerics::error::Error;

impl Flat {
    /// Adds a block `ff_state` and a function `ff_step(s: ff_state, r)`, within the limits `ends` of the input and its
    /// largest change `step` per sample, to the program of the model.
    ///
    /// # Errors
    /// [`Error::Content`] if the program is not that of the model.
    pub(in super::super) fn extend(&self, program: &mut Program, ends: (f64, f64), step: f64) -> Result<(), Error> {
        let by_input = matches!(self.drive, Drive::Input { .. });
        let has_direct = matches!(self.drive, Drive::Displacement { direct, .. } if direct != 0.0);
        let acts = matches!(self.drive, Drive::Input { force, .. } if force != 0.0);
        let (softening, curve) = (self.mode.softening, self.model.dynamics().curve);
        let (remembers, creeps, slews) =
            (self.model.hysteresis().order() > 0, !self.creep.is_empty(), step.is_finite());
        let moved = match (creeps || !by_input, program.function("hysteresis_move").is_some()) {
            (true, _) => "let inner = STEP;",
            // The output is not needed.
            (false, true) => "hysteresis_move(s.hysteresis, next);",
            (false, false) if remembers => "STEP;",
            (false, false) => "",
        };
        let at = if self.waits() == 0 { "k".into() } else { format!("k + {}", self.waits()) };
        let law = [
            if softening < 0.0 || curve != 0.0 { ROOT } else { "" },
            if softening < 0.0 { STIFFENS } else { "" },
            if softening > 0.0 { SOFTENS } else { "" },
            READ,
            if self.bends != 0.0 { BENDS } else { "" },
            if has_direct { DIRECT } else { "" },
            if by_input { "" } else { DISPLACEMENT },
            MOVES,
            if by_input { INPUT } else { INVERSE },
            if acts { OF_FORCE } else { "" },
            if by_input && self.beside() > 0 { VIBRATION } else { "" },
            if by_input { SEARCHED } else { "" },
            WITHIN_LIMITS,
        ];
        let text = law
            .concat()
            .replace("READING", if curve == 0.0 { "read" } else { "bent / ff_root(curve * bent)" })
            .replace(
                "BENT",
                if curve == 0.0 { "" } else { "let bent = clamp(read, -farthest_reading, farthest_reading);" },
            )
            .replace("AWAY", if softening == 0.0 { "a" } else { "ff_away(a)" })
            .replace("BEHIND", if self.lags() { BEHIND } else { "wished = within;" })
            .replace("WITHOUT_CREEP", if creeps { "for j in 0..lags { z = z - s.crept[j]; }" } else { "" })
            .replace("WITH_CREEP", if creeps { "for j in 0..lags { z += s.crept[j]; }" } else { "" })
            .replace("MOVED", moved)
            .replace("CREEPS", if creeps { CREEPS } else { "" })
            .replace("STEP", if remembers { "hysteresis(s.hysteresis, next)" } else { "hysteresis(next)" })
            .replace("SEARCH(", if remembers { "hysteresis_inverse(s.hysteresis, " } else { "hysteresis_inverse(" })
            .replace("LIMITED", if slews { SLEWS } else { "u = clamp(u, low, high);" })
            .replace("AT", &at);
        let block = self.constants(self.fields(remembers)).constant("low", ends.0).constant("high", ends.1);
        let block = if slews { block.constant("most_change", step) } else { block };
        program.add(block.text(&text))
    }

    /// The state.
    fn fields(&self, remembers: bool) -> Block {
        let mut x = self.initial();
        let Parts { q, p, beside, held, v, crept, .. } = self.parts(&mut x);
        let about = "the feed-forward: the inverse of mechanics with hysteresis in feedback";
        let mut block = Block::new("ff_state", about).number("before", 0.0);
        for (name, values) in [("q", q), ("p", p), ("beside", beside), ("held", held), ("v", v), ("crept", crept)] {
            block = block.numbers(name, values.to_vec());
        }
        if remembers { block.part("hysteresis", "hysteresis") } else { block }
    }

    fn constants(&self, block: Block) -> Block {
        let dynamics = self.model.dynamics();
        let lags = |of: fn(&Slow) -> f64| self.creep.iter().map(of).collect::<Vec<_>>();
        let (numbers, of_q, between) = match &self.drive {
            Drive::Displacement { sensed, direct } => {
                (vec![("of_p", self.mode.sensed), ("direct", *direct), ("of_input", self.mode.input)], sensed, &[][..])
            }
            Drive::Input { displacement, force, z, between, vibration, ends, left } => {
                let of = [("of_p", *displacement), ("of_force", *force), ("of_reached", *z)];
                let search = [("of_input", dynamics.sensed), ("lowest", ends.0), ("highest", ends.1)];
                let lag = [("left", left[0]), ("gone", 1.0 - left[0]), ("left_at_end", left[1])];
                ([of, search, lag].concat(), vibration, &between[..])
            }
        };
        let own = [
            ("rest", dynamics.offset),
            ("farthest", self.farthest),
            ("farthest_reading", self.farthest_reading),
            ("curve", dynamics.curve),
            ("bending", self.bends),
            ("softening", self.mode.softening.abs()),
            ("least_stiffness", LEAST_STIFFNESS),
            ("least_bend", LEAST_BEND),
            ("of_z", self.mode.hysteretic),
            ("creeps", self.creeps),
        ];
        let block = own.into_iter().chain(numbers).fold(block, |block, (name, value)| block.constant(name, value));
        let tables = [
            ("across", &self.across[..]),
            ("estimates", &self.estimates),
            ("vibrates", &self.vibrates),
            ("of_q", of_q),
            ("holds", &self.held),
            ("between", between),
            ("adds", &lags(|lag| lag.adds)),
            ("leaves", &lags(|lag| lag.leaves)),
        ];
        let block = tables.into_iter().fold(block, |block, (name, values)| block.table(name, values));
        let counts = [
            ("taps", TAPS),
            ("older", self.waits() + TAPS - 1),
            ("root_steps", ROOT_STEPS),
            ("reach", REACH),
            ("other_reach", REACH - 1),
            ("force_at", FORCE),
            ("within_at", WITHIN),
            ("other_p", WITHIN + REACH - 2),
            ("lags", self.creep.len()),
        ];
        counts.into_iter().fold(block, |block, (name, n)| block.count(name, n))
    }
}

const ROOT: &str = "
// The root h of h * h - h = v, which is 1 for v = 0.
fn ff_root(v) {
    let x = v;
    if x < least_bend { x = least_bend; }
    let h = 1.0;
    if x > 0.0 { h = 1.0 + x; }
    for k in 0..root_steps { h = (h * h + x) / (2.0 * h - 1.0); }
    return h;
}
";

const STIFFENS: &str = "
// How far the force is from the displacement of the mode.
fn ff_away(a) {
    return a / ff_root(softening * magnitude(a));
}
";

const SOFTENS: &str = "
// How far the force is from the displacement of the mode.
fn ff_away(a) {
    let left = 1.0 - softening * magnitude(a);
    if left < least_stiffness { left = least_stiffness; }
    return a / left;
}
";

const READ: &str = "
// One sample: requested displacement r to actuator input u.
fn ff_step(s: ff_state, r) {
    // The displacement there; if it is not finite, the last one stays.
    let read = r - rest;
    let q = s.q[0];
    if magnitude(read) <= most {
        BENT
        q = clamp(READING, -farthest, farthest);
    }
    for k in 0..older down { s.q[k + 1] = s.q[k]; }
    s.q[0] = q;
    // The displacement of the mode.
    let p = 0.0;
    for k in 0..taps { p += across[k] * s.q[AT]; }
";

const BENDS: &str = "
    let estimate = 0.0;
    for k in 0..taps { estimate += estimates[k] * s.q[AT]; }
    p = p - bending * (ff_away(estimate) - estimate);
";

const DIRECT: &str = "
    p = p - direct * (2.0 * s.beside[0] - s.beside[1]);
";

const DISPLACEMENT: &str = "
    // It drives the hysteresis.
    let others = 0.0;
    for k in 0..taps { others += of_q[k] * s.q[AT]; }
    let next = of_p * p + others;
    let z = s.beside[0];
    if magnitude(next) <= most {
        MOVED
        z = creeps * inner;
        WITH_CREEP
        CREEPS
    }
    s.beside[2] = s.beside[1];
    s.beside[1] = s.beside[0];
    s.beside[0] = z;
";

const MOVES: &str = "
    // The force that moves it so.
    for k in 0..other_p down { s.p[k + 1] = s.p[k]; }
    s.p[0] = p;
    let a = 0.0;
    for k in 0..taps { a += vibrates[k] * s.p[k]; }
    let force = s.p[force_at] + AWAY;
";

const INVERSE: &str = "
    // The held input of which driver and converter make the voltage.
    for k in 0..other_reach down { s.held[k + 1] = s.held[k]; }
    s.held[0] = (force - of_z * s.beside[2]) / of_input;
    let wished = 0.0;
    for k in 0..reach { wished += holds[k] * s.held[k]; }
";

const INPUT: &str = "
    // z within the sample of the input, and what the motion adds to the input of the hysteresis there.
    for k in 0..other_reach down { s.held[k + 1] = s.held[k]; }
    s.held[0] = force;
    let z = 0.0;
    let smooth = 0.0;
    for k in 0..reach { z += holds[k] * s.held[k]; }
    for k in 0..reach { smooth += between[k] * s.p[k + force_at]; }
    z = z / of_z;
    let back = of_p * smooth + of_reached * z;
";

const OF_FORCE: &str = "
    let others = 0.0;
    for k in 0..reach { others += between[k] * s.held[k]; }
    back += of_force * others;
";

const VIBRATION: &str = "
    let vibration = 0.0;
    for k in 0..taps { vibration += of_q[k] * s.q[AT]; }
    for k in 0..within_at down { s.beside[k + 1] = s.beside[k]; }
    s.beside[0] = vibration;
    back = back - s.beside[within_at];
";

const SEARCHED: &str = "
    WITHOUT_CREEP
    let next = SEARCH(z / creeps, back + lowest, back + highest);
    let within = (next - back) / of_input;
    let wished = s.before;
    if magnitude(within) <= most {
        MOVED
        CREEPS
        BEHIND
    }
";

const BEHIND: &str = "// The driver moves to it from where it was.
        wished = (within - left * s.v[0]) / gone;
        s.v[0] = wished + (s.v[0] - wished) * left_at_end;";

const CREEPS: &str = "for j in 0..lags { s.crept[j] += adds[j] * inner - leaves[j] * s.crept[j]; }";

const WITHIN_LIMITS: &str = "
    // Of an input that is not finite the last one stays.
    let u = s.before;
    if magnitude(wished) <= most { u = wished; }
    LIMITED
    s.before = u;
    return u;
}
";

const SLEWS: &str = "let from = clamp(s.before - most_change, low, high);
    let to = clamp(s.before + most_change, low, high);
    u = clamp(u, from, to);";
