//! States of a constant motion.

use super::{Drive, Flat, Parts};

/// Iterations of a settled state in which z adds to the displacement.
const SETTLING: usize = 30;

/// A constant motion: the state of the hysteresis, and what follows from it.
struct Still {
    q: f64,
    p: f64,
    z: f64,
    /// H(s).
    inner: f64,
    v: f64,
    hysteresis: Vec<f64>,
}

impl Flat {
    /// The input that holds the reading `r`, and the state there, after the way from rest; at rest for an `r` that is
    /// not finite.
    pub(in super::super) fn settled(&self, r: f64) -> (f64, Vec<f64>) {
        let q = self.displacement(r);
        if !q.is_finite() {
            return self.at(self.rest());
        }
        let operator = self.model.hysteresis();
        let mut hysteresis = operator.initial();
        match &self.drive {
            Drive::Displacement { sensed, direct } => {
                let of_q = sensed.iter().sum::<f64>() * q;
                let mut z = 0.0;
                // One is enough unless z is a part of q.
                for _ in 0..if *direct == 0.0 { 1 } else { SETTLING } {
                    hysteresis = operator.initial();
                    let s = self.mode.sensed * (self.share * q - direct * z) + of_q;
                    z = self.settles * operator.step(&mut hysteresis, s);
                }
                let p = self.share * q - direct * z;
                let v = (p - self.mode.hysteretic * z) / self.mode.input;
                self.at(Still { q, p, z, inner: z / self.settles, v, hysteresis })
            }
            Drive::Input { displacement, force, z: of_z, ends, .. } => {
                let p = self.share * q;
                let z = p / self.mode.hysteretic;
                let back = (displacement + force) * p + of_z * z;
                let ends = (back + ends.0, back + ends.1);
                let s = operator.invert(&hysteresis, z / self.settles, ends).u;
                let inner = operator.step(&mut hysteresis, s);
                self.at(Still { q, p, z, inner, v: (s - back) / self.model.dynamics().sensed, hysteresis })
            }
        }
    }

    /// The state at rest.
    pub(in super::super) fn initial(&self) -> Vec<f64> {
        self.at(self.rest()).1
    }

    /// Rest: the input is 0, and so is s.
    fn rest(&self) -> Still {
        let mut hysteresis = self.model.hysteresis().initial();
        let inner = self.model.hysteresis().step(&mut hysteresis, 0.0);
        let z = self.settles * inner;
        let p = self.mode.hysteretic * z;
        Still { q: p / self.share, p, z, inner, v: 0.0, hysteresis }
    }

    /// The input and the state of a constant motion.
    fn at(&self, still: Still) -> (f64, Vec<f64>) {
        let mut x = vec![0.0; self.order()];
        let Parts { q, p, beside, held, v, crept, hysteresis } = self.parts(&mut x);
        let is_moved = matches!(self.drive, Drive::Displacement { .. });
        q.fill(still.q);
        p.fill(still.p);
        beside.fill(if is_moved { still.z } else { 0.0 });
        held.fill(if is_moved { still.v } else { still.p });
        v.fill(still.v);
        crept.iter_mut().zip(&self.creep).for_each(|(c, lag)| *c = lag.settled * still.inner);
        hysteresis.copy_from_slice(&still.hysteresis);
        (still.v, x)
    }
}
