//! Particle swarm optimisation with time-varying acceleration, as the paper's equations (2) to (7).
//!
//! ```text
//! v <- w v + c1 r1 (p_best - x) + c2 r2 (g_best - x)      (2)
//! x <- x + v                                              (3)
//! p_best <- x  only when f(x) < f(p_best)                 (4)
//! c1 = 2.5 - 2 i / alpha,  c2 = 0.5 + 2 i / alpha         (5), (6)
//! w = w_max - (w_max - w_min) i / alpha                   (7)
//! ```
//!
//! Kennedy & Eberhart 1995 (doi:10.1109/ICNN.1995.488968); inertia: Shi & Eberhart 1998
//! (doi:10.1109/ICEC.1998.699146); acceleration: Ratnaweera et al. 2004 (doi:10.1109/TEVC.2004.826071).
//!
//! Where the paper is silent: r1 and r2 are drawn anew for every dimension; a velocity is limited to a share of the
//! box; a particle that reaches a wall stays on it and loses the velocity that took it there; a cost that is not a
//! number counts as the worst there is. Each particle draws from a random stream of its own, so threads change nothing.

use super::{Bounds, Minimum, Reason};
use crate::error::Error;
use crate::progress::{Progress, Stage};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

/// What a swarm minimises. Every `Fn(&[f64]) -> f64` that may be shared between threads is a cost.
pub trait Cost: Sync {
    /// Writes the cost of each particle; `positions` holds the particles one after another.
    ///
    /// A particle's cost matters only where it is below `limits` (its own best so far): once it is certain to reach
    /// that limit, any number not below it will do, which lets a sum of non-negative terms stop early.
    fn evaluate(&self, positions: &[f64], limits: &[f64], costs: &mut [f64]);
}

impl<F: Fn(&[f64]) -> f64 + Sync> Cost for F {
    fn evaluate(&self, positions: &[f64], _limits: &[f64], costs: &mut [f64]) {
        for (x, cost) in positions.chunks_exact(positions.len() / costs.len()).zip(costs) {
            *cost = self(x);
        }
    }
}

/// How the swarm searches. The defaults are the paper's where it states them, else what is customary.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// Swarm size S.
    pub particles: usize,
    /// Total number of iterations, alpha in (5) to (7).
    pub iterations: usize,
    /// Inertia weight at the start, w_max in (7).
    pub inertia_max: f64,
    /// Inertia weight at the end, w_min in (7).
    pub inertia_min: f64,
    /// Largest velocity, as a share of the box a step.
    pub velocity_max: f64,
    /// Stop once the cost is at or below this.
    pub threshold: Option<f64>,
    /// Stop once the cost has not fallen for this many iterations.
    pub stall: Option<usize>,
    /// Seed of the random streams.
    pub seed: u64,
    /// Evaluate particles on the threads of the current rayon pool; the result is the same.
    pub parallel: bool,
}

impl Default for Settings {
    fn default() -> Self {
        Settings {
            particles: 50,
            iterations: 500,
            inertia_max: 0.9,
            inertia_min: 0.4,
            velocity_max: 0.2,
            threshold: None,
            stall: None,
            seed: 1,
            parallel: false,
        }
    }
}

/// A swarm between two iterations: all there is to checkpoint. It serialises, and a search that goes on from the
/// copy gives the same bytes as one that was never interrupted.
///
/// ```
/// use piezoid::optimize::{Bounds, swarm::{Settings, Swarm}};
/// let sphere = |x: &[f64]| x.iter().map(|v| v * v).sum::<f64>();
/// let bounds = Bounds::new(vec![-5.0; 3], vec![5.0; 3])?;
/// let mut swarm = Swarm::new(&sphere, bounds, Settings { iterations: 200, ..Settings::default() })?;
/// let minimum = swarm.run(&sphere, &mut piezoid::progress::unwatched);
/// assert!(minimum.cost < 1e-9);
/// # Ok::<(), piezoid::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Swarm {
    settings: Settings,
    bounds: Bounds,
    x: Vec<f64>,
    v: Vec<f64>,
    p_best: Vec<f64>,
    p_cost: Vec<f64>,
    g_best: Vec<f64>,
    history: Vec<f64>,
    improved: usize,
}

/// Steps 1 to 7 of the paper's algorithm in one call.
///
/// # Errors
/// As [`Swarm::new`].
pub fn minimise(
    cost: &impl Cost,
    bounds: Bounds,
    settings: Settings,
    progress: &mut Progress,
) -> Result<Minimum, Error> {
    Ok(Swarm::new(cost, bounds, settings)?.run(cost, progress))
}

impl Swarm {
    /// Places the particles and their velocities at random in the box and evaluates them (steps 1 to 5).
    ///
    /// # Errors
    /// Refuses a swarm without particles or iterations, weights or velocity limits that are not positive and finite.
    pub fn new(cost: &impl Cost, bounds: Bounds, settings: Settings) -> Result<Self, Error> {
        check(&settings)?;
        let (s, d) = (settings.particles, bounds.dimension());
        let mut swarm = Swarm {
            x: vec![0.0; s * d],
            v: vec![0.0; s * d],
            p_best: vec![0.0; s * d],
            p_cost: vec![f64::MAX; s],
            g_best: vec![0.0; d],
            history: Vec::with_capacity(settings.iterations + 1),
            improved: 0,
            settings,
            bounds,
        };
        for m in 0..s {
            let mut random = swarm.stream(m, 0);
            for i in 0..d {
                let (low, width) = (swarm.bounds.low[i], swarm.bounds.high[i] - swarm.bounds.low[i]);
                swarm.x[m * d + i] = low + width * random.random::<f64>();
                swarm.v[m * d + i] = swarm.settings.velocity_max * width * (2.0 * random.random::<f64>() - 1.0);
            }
        }
        swarm.p_best.clone_from(&swarm.x);
        swarm.judge(cost);
        Ok(swarm)
    }

    /// Iterations done.
    pub fn iteration(&self) -> usize {
        self.history.len() - 1
    }

    /// Iterates until something ends the search. `progress` is called before every iteration; when it breaks, the
    /// swarm stands between two iterations and may be kept as a checkpoint.
    pub fn run(&mut self, cost: &impl Cost, progress: &mut Progress) -> Minimum {
        let d = self.bounds.dimension();
        let mut streams: Vec<_> =
            (0..self.settings.particles).map(|m| self.stream(m, words(d) * (1 + self.iteration() as u128))).collect();
        let reason = loop {
            let (done, total) = (self.iteration(), self.settings.iterations);
            if let Some(reason) = self.ended() {
                break reason;
            }
            if progress(Stage { what: "swarm", done, total }).is_break() {
                break Reason::Cancelled;
            }
            self.advance(&mut streams);
            self.judge(cost);
        };
        let best = self.history[self.iteration()];
        Minimum { x: self.g_best.clone(), cost: best, history: self.history.clone(), reason }
    }

    /// Step 7: whether the search has ended, and why.
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
    fn advance(&mut self, streams: &mut [ChaCha8Rng]) {
        let (s, d) = (&self.settings, self.bounds.dimension());
        let share = (self.iteration() + 1) as f64 / s.iterations as f64;
        let (c1, c2) = (2.5 - 2.0 * share, 0.5 + 2.0 * share);
        let w = s.inertia_max - (s.inertia_max - s.inertia_min) * share;
        for (m, random) in streams.iter_mut().enumerate() {
            for i in 0..d {
                let k = m * d + i;
                let (low, high) = (self.bounds.low[i], self.bounds.high[i]);
                let v_max = s.velocity_max * (high - low);
                let (r1, r2): (f64, f64) = (random.random(), random.random());
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

    /// Steps 4 and 5: evaluates the particles and renews the bests by (4).
    fn judge(&mut self, cost: &impl Cost) {
        let d = self.bounds.dimension();
        let mut costs = vec![f64::MAX; self.settings.particles];
        if self.settings.parallel {
            let share = costs.len().div_ceil(rayon::current_num_threads());
            (self.x.par_chunks(share * d), self.p_cost.par_chunks(share), costs.par_chunks_mut(share))
                .into_par_iter()
                .for_each(|(x, limits, costs)| cost.evaluate(x, limits, costs));
        } else {
            cost.evaluate(&self.x, &self.p_cost, &mut costs);
        }
        let mut best = self.history.last().copied().unwrap_or(f64::INFINITY);
        for (m, &f) in costs.iter().enumerate() {
            let particle = m * d..(m + 1) * d;
            if f < self.p_cost[m] {
                self.p_cost[m] = f;
                self.p_best[particle.clone()].copy_from_slice(&self.x[particle.clone()]);
            }
            if self.p_cost[m] < best {
                best = self.p_cost[m];
                self.g_best.copy_from_slice(&self.p_best[particle]);
                self.improved = self.history.len();
            }
        }
        self.history.push(best);
    }

    /// The random stream of particle `m`, from the 32-bit word `at` on.
    fn stream(&self, m: usize, at: u128) -> ChaCha8Rng {
        let mut random = ChaCha8Rng::seed_from_u64(self.settings.seed);
        random.set_stream(m as u64);
        random.set_word_pos(at);
        random
    }
}

/// 32-bit words a particle draws an iteration, and once before the first: two numbers of 64 bits a dimension.
fn words(dimension: usize) -> u128 {
    4 * dimension as u128
}

fn check(s: &Settings) -> Result<(), Error> {
    let count = |name, n| match n {
        0 => Err(Error::parameter(name, 0, "must be at least 1")),
        _ => Ok(()),
    };
    count("particles", s.particles)?;
    count("iterations", s.iterations)?;
    crate::error::positive("velocity_max", s.velocity_max, "boxes a step")?;
    for (name, w) in [("inertia_max", s.inertia_max), ("inertia_min", s.inertia_min)] {
        if !(0.0..=1.0).contains(&w) {
            return Err(Error::parameter(name, w, "must lie between 0 and 1"));
        }
    }
    Ok(())
}
