//! Particle swarm optimisation with time-varying acceleration: equations (2) to (7) of the paper.
//!
//! ```text
//! v <- w v + c1 r1 (p_best - x) + c2 r2 (g_best - x)      (2)
//! x <- x + v                                              (3)
//! p_best <- x  only when f(x) < f(p_best)                 (4)
//! c1 = 2.5 - 2 i / alpha,  c2 = 0.5 + 2 i / alpha         (5), (6)
//! w = w_max - (w_max - w_min) i / alpha                   (7)
//! ```
//!
//! Kennedy & Eberhart 1995 (doi:10.1109/ICNN.1995.488968); inertia: Shi & Eberhart 1998 (doi:10.1109/ICEC.1998.699146);
//! acceleration: Ratnaweera et al. 2004 (doi:10.1109/TEVC.2004.826071).
//!
//! r1 and r2 are one number each per particle and iteration, as in (2). (If drawn for every dimension, which is also
//! common, the search ends more often at the kinks of a sum of absolute errors.) In the printed equation (4) g_best is
//! the best of the current positions; usually it is the best position of any particle so far. [`GlobalBest`] has both.
//! The paper does not specify the following: the largest velocity is a share of the box; a particle that reaches a
//! bound stays there with velocity 0; a cost of NaN counts as the largest cost. Each particle has its own random
//! stream, so the result does not depend on the number of threads.
//!
//! Why: docs/decisions/study-of-the-paper.md, "The swarm draws r1 and r2 once per particle".
//! Why: docs/decisions/study-of-the-paper.md, "g_best is the best position of all iterations".

use super::{Bounds, Minimum, Reason};
use crate::error::Error;
use crate::progress::{Progress, Stage};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// Maximum number of particles and of iterations.
const MAX_PARTICLES_OR_ITERATIONS: usize = 10_000_000;

/// The cost that a swarm minimises. Every `Fn(&[f64]) -> f64` that can be shared between threads is a cost.
#[doc(hidden)]
pub trait Cost: Sync {
    /// Writes the cost of each particle; `positions` has the particles one after another.
    ///
    /// A cost is used only if it is below `limits` (the best cost of the particle so far). Otherwise any number not
    /// below the limit may be returned, so that a sum of non-negative terms can stop early.
    fn evaluate(&self, positions: &[f64], limits: &[f64], costs: &mut [f64]);
}

impl<F: Fn(&[f64]) -> f64 + Sync> Cost for F {
    fn evaluate(&self, positions: &[f64], _limits: &[f64], costs: &mut [f64]) {
        for (x, cost) in positions.chunks_exact(positions.len() / costs.len()).zip(costs) {
            *cost = self(x);
        }
    }
}

/// Definition of g_best in equation (2).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum GlobalBest {
    /// The best position of any particle so far, as usual.
    #[default]
    Ever,
    /// The best of the current positions: equation (4) of the paper as printed.
    Current,
}

/// Options of the search. The defaults are those of the paper; if it gives none, the usual values.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct SwarmSettings {
    /// Swarm size S.
    pub particles: usize,
    /// Total number of iterations, alpha in (5) to (7).
    pub iterations: usize,
    /// Inertia weight at the start, w_max in (7).
    pub inertia_max: f64,
    /// Inertia weight at the end, w_min in (7).
    pub inertia_min: f64,
    /// Largest velocity, as a share of the box per step.
    pub velocity_max: f64,
    /// Definition of g_best.
    pub global_best: GlobalBest,
    /// The search stops when the cost is at or below this value.
    pub threshold: Option<f64>,
    /// The search stops when the cost has not decreased for this number of iterations.
    pub stall: Option<usize>,
    /// Seed of the random streams.
    pub seed: u64,
    /// Evaluates particles on the threads of the current rayon pool; the result is the same.
    pub parallel: bool,
}

impl Default for SwarmSettings {
    fn default() -> Self {
        SwarmSettings {
            particles: 50,
            iterations: 500,
            inertia_max: 0.9,
            inertia_min: 0.4,
            velocity_max: 0.2,
            global_best: GlobalBest::Ever,
            threshold: None,
            stall: None,
            seed: 1,
            parallel: false,
        }
    }
}

/// A swarm between two iterations.
#[derive(Debug, Clone)]
struct Swarm {
    settings: SwarmSettings,
    bounds: Bounds,
    streams: Vec<ChaCha8Rng>,
    x: Vec<f64>,
    v: Vec<f64>,
    p_best: Vec<f64>,
    p_cost: Vec<f64>,
    g_best: Vec<f64>,
    history: Vec<f64>,
    courses: Vec<Vec<f64>>,
    improved: usize,
}

impl SwarmSettings {
    /// Steps 1 to 7 of the paper's algorithm. `progress` is called before every iteration.
    ///
    /// ```
    /// use piezoid_numerics::optimize::{Bounds, swarm::SwarmSettings};
    /// let sphere = |x: &[f64]| x.iter().map(|v| v * v).sum::<f64>();
    /// let bounds = Bounds::new(vec![-5.0; 3], vec![5.0; 3])?;
    /// let settings = SwarmSettings { iterations: 200, ..SwarmSettings::default() };
    /// let minimum = settings.minimise(&sphere, bounds, &mut piezoid::progress::Stage::ignore)?;
    /// assert!(minimum.cost < 1e-9);
    /// # Ok::<(), piezoid::Error>(())
    /// ```
    ///
    /// # Errors
    /// Returns an error if there are no particles or iterations, if an inertia weight is not between 0 and 1, or if the
    /// largest velocity is not positive.
    pub fn minimise(self, cost: &impl Cost, bounds: Bounds, progress: &mut Progress) -> Result<Minimum, Error> {
        Ok(Swarm::new(cost, bounds, self)?.run(cost, progress))
    }
}

impl Swarm {
    /// Draws random positions and velocities of the particles and evaluates them (steps 1 to 5).
    fn new(cost: &impl Cost, bounds: Bounds, settings: SwarmSettings) -> Result<Self, Error> {
        check(&settings)?;
        let (s, d) = (settings.particles, bounds.dimension());
        let stream = |m: usize| {
            let mut random = ChaCha8Rng::seed_from_u64(settings.seed);
            random.set_stream(m as u64);
            random
        };
        let mut swarm = Swarm {
            streams: (0..s).map(stream).collect(),
            x: vec![0.0; s * d],
            v: vec![0.0; s * d],
            p_best: vec![0.0; s * d],
            p_cost: vec![f64::MAX; s],
            g_best: vec![0.0; d],
            history: Vec::new(),
            courses: Vec::new(),
            improved: 0,
            settings,
            bounds,
        };
        for (m, random) in swarm.streams.iter_mut().enumerate() {
            for i in 0..d {
                let (low, width) = (swarm.bounds.low[i], swarm.bounds.high[i] - swarm.bounds.low[i]);
                swarm.x[m * d + i] = low + width * random.random::<f64>();
                swarm.v[m * d + i] = swarm.settings.velocity_max * width * (2.0 * random.random::<f64>() - 1.0);
            }
        }
        swarm.p_best.clone_from(&swarm.x);
        swarm.g_best.copy_from_slice(&swarm.x[..d]);
        swarm.update_bests(cost);
        Ok(swarm)
    }

    /// Number of iterations so far.
    fn iteration(&self) -> usize {
        self.history.len() - 1
    }

    /// Runs the search to its end.
    fn run(mut self, cost: &impl Cost, progress: &mut Progress) -> Minimum {
        let reason = loop {
            let (done, total) = (self.iteration(), self.settings.iterations);
            if let Some(reason) = self.ended() {
                break reason;
            }
            let figures = &[("cost", self.history[done])];
            if progress(Stage { figures, ..Stage::new("swarm", done, total) }).is_break() {
                break Reason::Cancelled;
            }
            self.advance();
            self.update_bests(cost);
        };
        let (x, cost) = (self.courses[self.iteration()].clone(), self.history[self.iteration()]);
        Minimum { x, cost, history: self.history, courses: self.courses, reason }
    }

    /// Step 7: the reason to end the search, if there is one.
    fn ended(&self) -> Option<Reason> {
        let (i, settings) = (self.iteration(), &self.settings);
        if settings.threshold.is_some_and(|t| self.history[i] <= t) {
            Some(Reason::Threshold)
        } else if i >= settings.iterations {
            Some(Reason::Iterations)
        } else if settings.stall.is_some_and(|n| i >= self.improved + n) {
            Some(Reason::Stall)
        } else {
            None
        }
    }

    /// Step 6: moves every particle by (2) and (3), with the coefficients of (5) to (7) at this iteration.
    fn advance(&mut self) {
        let (s, d) = (&self.settings, self.bounds.dimension());
        let share = (self.iteration() + 1) as f64 / s.iterations as f64;
        let (c1, c2) = (2.5 - 2.0 * share, 0.5 + 2.0 * share);
        let w = s.inertia_max - (s.inertia_max - s.inertia_min) * share;
        for (m, random) in self.streams.iter_mut().enumerate() {
            let (r1, r2): (f64, f64) = (random.random(), random.random());
            for i in 0..d {
                let k = m * d + i;
                let (low, high) = (self.bounds.low[i], self.bounds.high[i]);
                let v_max = s.velocity_max * (high - low);
                let v = w * self.v[k] + c1 * r1 * (self.p_best[k] - self.x[k]) + c2 * r2 * (self.g_best[i] - self.x[k]);
                self.v[k] = v.clamp(-v_max, v_max);
                self.x[k] += self.v[k];
                if self.x[k] < low || self.x[k] > high {
                    self.x[k] = self.x[k].clamp(low, high);
                    self.v[k] = 0.0;
                }
            }
        }
    }

    /// Steps 4 and 5: evaluates the particles and updates the bests by (4).
    fn update_bests(&mut self, cost: &impl Cost) {
        let d = self.bounds.dimension();
        let mut costs = vec![f64::MAX; self.settings.particles];
        // Costs above the best of a particle are needed only for the best of the current positions.
        let current = self.settings.global_best == GlobalBest::Current;
        let unlimited = if current { vec![f64::MAX; costs.len()] } else { Vec::new() };
        let limits = if current { &unlimited } else { &self.p_cost };
        if self.settings.parallel {
            let share = costs.len().div_ceil(rayon::current_num_threads());
            (self.x.par_chunks(share * d), limits.par_chunks(share), costs.par_chunks_mut(share))
                .into_par_iter()
                .for_each(|(x, limits, costs)| cost.evaluate(x, limits, costs));
        } else {
            cost.evaluate(&self.x, limits, &mut costs);
        }
        let mut best = self.history.last().copied().unwrap_or(f64::MAX);
        let mut course = self.courses.last().cloned().unwrap_or_else(|| self.x[..d].to_vec());
        for (m, (&f, x)) in costs.iter().zip(self.x.chunks_exact(d)).enumerate() {
            if f < self.p_cost[m] {
                self.p_cost[m] = f;
                self.p_best[m * d..(m + 1) * d].copy_from_slice(x);
            }
            if f < best {
                best = f;
                course.copy_from_slice(x);
                self.improved = self.history.len();
            }
        }
        // A cost of NaN counts as the largest cost.
        let least = (1..costs.len()).fold(0, |m, k| if costs[k] < costs[m].min(f64::MAX) { k } else { m });
        self.g_best.copy_from_slice(if current { &self.x[least * d..][..d] } else { &course });
        self.history.push(best);
        self.courses.push(course);
    }
}

fn check(s: &SwarmSettings) -> Result<(), Error> {
    let count = |name, n| match n {
        1..=MAX_PARTICLES_OR_ITERATIONS => Ok(()),
        _ => Err(Error::parameter(name, n, format!("must be from 1 to {MAX_PARTICLES_OR_ITERATIONS}"))),
    };
    count("particles", s.particles)?;
    count("iterations", s.iterations)?;
    crate::error::positive("velocity_max", s.velocity_max, "boxes per step")?;
    for (name, w) in [("inertia_max", s.inertia_max), ("inertia_min", s.inertia_min)] {
        if !(0.0..=1.0).contains(&w) {
            return Err(Error::parameter(name, w, "must be between 0 and 1"));
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::progress::Stage;
    use proptest::prelude::*;
    use std::ops::ControlFlow;

    fn rosenbrock(x: &[f64]) -> f64 {
        x.windows(2).map(|w| 100.0 * (w[1] - w[0] * w[0]).powi(2) + (1.0 - w[0]).powi(2)).sum()
    }

    fn bounds(d: usize) -> Bounds {
        Bounds::new(vec![-2.0; d], vec![3.0; d]).unwrap()
    }

    #[test]
    fn the_velocity_is_that_of_equation_2() {
        let settings = SwarmSettings { particles: 3, iterations: 10, ..SwarmSettings::default() };
        let before = Swarm::new(&rosenbrock, bounds(2), settings).unwrap();
        let mut after = before.clone();
        after.advance();
        for m in 0..3 {
            let mut random = before.streams[m].clone();
            let (r1, r2): (f64, f64) = (random.random(), random.random());
            for i in 0..2 {
                let k = 2 * m + i;
                let by_hand = 0.85 * before.v[k]
                    + 2.3 * r1 * (before.p_best[k] - before.x[k])
                    + 0.7 * r2 * (before.g_best[i] - before.x[k]);
                let inside = by_hand.clamp(-1.0, 1.0);
                let free = (-2.0..=3.0).contains(&(before.x[k] + inside));
                piezoid_testing::assert_close(&[after.v[k]], &[if free { inside } else { 0.0 }], 1e-12, 0.0);
            }
        }
    }

    #[test]
    fn g_best_is_the_best_ever_or_the_best_of_the_current_positions() {
        for global_best in [GlobalBest::Ever, GlobalBest::Current] {
            let settings = SwarmSettings { particles: 8, iterations: 40, global_best, ..SwarmSettings::default() };
            let mut swarm = Swarm::new(&rosenbrock, bounds(2), settings).unwrap();
            let mut differing = 0;
            for _ in 0..40 {
                swarm.advance();
                swarm.update_bests(&rosenbrock);
                let best = swarm.history[swarm.iteration()];
                let now = swarm.x.chunks(2).map(rosenbrock).fold(f64::MAX, f64::min);
                let expected = if global_best == GlobalBest::Ever { best } else { now };
                assert_eq!(rosenbrock(&swarm.g_best), expected);
                differing += usize::from(now > best);
            }
            assert!(differing > 0, "the two never differed");
        }
    }

    #[test]
    fn a_cancelled_search_is_the_beginning_of_a_whole_one() {
        let settings = SwarmSettings { iterations: 120, ..SwarmSettings::default() };
        let whole = settings.clone().minimise(&rosenbrock, bounds(3), &mut Stage::ignore).unwrap();
        let until_70 = |s: Stage| if s.done == 70 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
        let part = settings.minimise(&rosenbrock, bounds(3), &mut { until_70 }).unwrap();
        assert_eq!((part.reason, &part.history[..]), (Reason::Cancelled, &whole.history[..71]));
    }

    #[test]
    fn the_result_does_not_depend_on_threads() {
        for global_best in [GlobalBest::Ever, GlobalBest::Current] {
            let settings = SwarmSettings { iterations: 60, global_best, ..SwarmSettings::default() };
            let parallel = SwarmSettings { parallel: true, ..settings.clone() };
            let one = settings.minimise(&rosenbrock, bounds(4), &mut Stage::ignore).unwrap();
            assert_eq!(parallel.minimise(&rosenbrock, bounds(4), &mut Stage::ignore).unwrap(), one);
        }
    }

    #[test]
    fn the_reason_for_the_end_is_reported() {
        let reason =
            |settings: SwarmSettings| settings.minimise(&rosenbrock, bounds(2), &mut Stage::ignore).unwrap().reason;
        let settings = SwarmSettings { iterations: 300, ..SwarmSettings::default() };
        assert_eq!(reason(settings.clone()), Reason::Iterations);
        assert_eq!(reason(SwarmSettings { threshold: Some(1.0), ..settings.clone() }), Reason::Threshold);
        let flat = |_: &[f64]| 1.0;
        let stalled = SwarmSettings { stall: Some(7), ..settings };
        let minimum = stalled.minimise(&flat, bounds(2), &mut Stage::ignore).unwrap();
        assert_eq!((minimum.reason, minimum.history.len()), (Reason::Stall, 8));
    }

    #[test]
    fn a_cost_of_nan_counts_as_the_largest() {
        let half = |x: &[f64]| if x[0] < 0.0 { f64::NAN } else { x[0] };
        let minimum = SwarmSettings::default().minimise(&half, bounds(1), &mut Stage::ignore).unwrap();
        assert!((0.0..1e-6).contains(&minimum.cost));
        let never = SwarmSettings::default().minimise(&|_: &[f64]| f64::NAN, bounds(1), &mut Stage::ignore).unwrap();
        assert_eq!(never.cost, f64::MAX);
    }

    #[test]
    fn invalid_settings_are_errors() {
        let message = |settings| Swarm::new(&rosenbrock, bounds(2), settings).unwrap_err().to_string();
        assert!(message(SwarmSettings { particles: 0, ..SwarmSettings::default() }).contains("particles = 0"));
        let settings = SwarmSettings { inertia_min: f64::NAN, ..SwarmSettings::default() };
        assert!(message(settings).contains("inertia_min = NaN"));
        assert!(Bounds::new(vec![1.0], vec![1.0]).unwrap_err().to_string().contains("bounds[0] = 1 to 1"));
    }

    proptest! {
        #[test]
        fn the_best_cost_never_increases_and_belongs_to_its_point(seed: u64, particles in 1..20usize, current: bool) {
            let global_best = if current { GlobalBest::Current } else { GlobalBest::Ever };
            let settings = SwarmSettings { seed, particles, iterations: 30, global_best, ..SwarmSettings::default() };
            let minimum = settings.minimise(&rosenbrock, bounds(3), &mut Stage::ignore).unwrap();
            prop_assert!(minimum.history.windows(2).all(|w| w[1] <= w[0]));
            prop_assert_eq!(rosenbrock(&minimum.x), minimum.cost);
            prop_assert!(minimum.courses.iter().zip(&minimum.history).all(|(x, f)| rosenbrock(x) == *f));
            prop_assert!(minimum.x.iter().all(|x| (-2.0..=3.0).contains(x)));
        }
    }
}
