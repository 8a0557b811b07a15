//! Identification of all parts together.

mod equations;
mod estimate;
mod held_out;
mod layout;
mod products;
mod refine;
mod runs;
mod signals;
mod solve;

use crate::driver::{Driver, SUBSTEPS};
use crate::error::Error;
use crate::hammerstein::Model;
use crate::hysteresis::{self, Design};
use crate::linear::{self, Orders};
use crate::creep::Lag;
use crate::optimize::swarm;
use crate::progress::{Progress, unwatched};
use crate::record::Record;
use crate::series::ends;
use estimate::Estimate;
use runs::Run;

/// How to identify jointly.
#[derive(Debug, Clone)]
pub struct Joint {
    /// Operator.
    pub operator: String,
    /// Order.
    pub order: usize,
    /// Known driver.
    pub driver: Option<Driver>,
    /// Elements
    pub elements: Option<usize>,
}

/// Joint.
///
/// # Errors
/// Many.
pub fn identify_joint(small: &[Record], rich: &[Record], how: &Joint, _progress: &mut Progress) -> Result<Model, Error> {
    let ts = rich[0].ts();
    let mut runs: Vec<Run> = small.iter().map(|r| Run::new(r, false)).chain(rich.iter().map(|r| Run::new(r, true))).collect();
    runs::fold(&mut runs);
    let range = ends(runs.iter().flat_map(|r| r.record.u()).copied());
    let longest = runs.iter().map(|r| r.record.duration()).fold(0.0, f64::max);
    let mut lags = Vec::new();
    let mut tau = 10.0 * ts;
    while tau < longest {
        lags.push(Lag { tau_s: tau, gain: 0.0 });
        tau *= 10.0;
    }
    let faster = if how.driver.is_some() { ts / SUBSTEPS as f64 } else { ts };
    let design = Design { ts: faster, range, elements: how.elements, frequencies: Vec::new() };
    let fit = if small.is_empty() {
        let least_squares = linear::estimator("least-squares")?;
        let env = |n: &str| std::env::var(n).ok().and_then(|v| v.parse::<usize>().ok()).unwrap_or(0);
        let mut fit = linear::fit(rich, Orders { na: 0, nb: 1, delay: 0 }, least_squares, &swarm::Settings::default(), &mut unwatched)?;
        let k = fit.arx.b()[0];
        let mut b = vec![0.0; env("PZ_DELAY")];
        let pole = 0.2;
        let a: Vec<f64> = match env("PZ_NA") { 0 => vec![], 1 => vec![pole], _ => vec![2.0*pole, -pole*pole] };
        let dc = 1.0 - a.iter().sum::<f64>();
        b.push(0.999 * k * dc);
        for _ in 0..env("PZ_NB") { b.push(1e-3 * k * dc / env("PZ_NB") as f64); }
        fit.arx = crate::linear::Arx::new(ts, a, b)?;
        fit
    } else {
        let least_squares = linear::estimator("least-squares")?;
        linear::fit(small, Orders { na: how.order, nb: how.order, delay: 1 }, least_squares, &swarm::Settings::default(), &mut unwatched)?
    };
    let basis = (hysteresis::operator(&how.operator)?.basis)(&design)?;
    let weights = vec![0.0; basis.len()];
    let estimate = Estimate { driver: how.driver, basis, weights, lags, linear: fit.arx };
    let t0 = std::time::Instant::now();
    let fitted = refine::refine(estimate, &mut runs, solve::Freed::All, &|_| Ok(()))?;
    let e = &fitted.estimate;
    eprintln!("fitted in {:?}: held out {:.4} %, lambda {:e}, lags {:?}, poles {:?}", t0.elapsed(), 100.0 * fitted.held_out.rms_pp(), fitted.held_out.lambda, e.lags, e.linear.poles());
    eprintln!("  left %pp {:?}", fitted.left.iter().map(|l| 100.0 * l.sqrt()).collect::<Vec<_>>());
    eprintln!("  shape {:?}", e.basis.shape());
    // offsets
    let mut offsets: Vec<f64> = Vec::new();
    for (own, run) in fitted.own.iter().zip(&runs) {
        let c = own.last().copied().unwrap_or(0.0);
        let phi = estimate::Responses::before(e, run).now().to_vec();
        let z0: f64 = phi.iter().zip(&e.weights).map(|(p, w)| p * w).sum();
        let creep: f64 = 1.0 + e.lags.iter().map(|l| l.gain).sum::<f64>();
        offsets.push(c - e.linear.dc_gain() * creep * z0);
    }
    eprintln!("  offsets {offsets:?}");
    offsets.sort_by(f64::total_cmp);
    let offset = offsets[offsets.len() / 2];
    e.model(offset)
}
