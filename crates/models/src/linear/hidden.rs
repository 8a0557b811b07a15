//! The hidden variable z of a record, by the inverse of the linear block.

use super::Arx;
use piezoid_numerics::error::Error;
use piezoid_numerics::system::System;

impl Arx {
    /// Step 4 of the paper: z by the causal inverse of this linear block. If that is unstable, the whole record is
    /// inverted, with a note; then z is shorter than y by the undetermined samples at the end.
    ///
    /// # Errors
    /// [`Error::NoInverse`] if the block has no stable inverse of either kind, or `y` is too short for it.
    pub fn hidden(&self, offset: f64, y: &[f64]) -> Result<(Vec<f64>, Option<String>), Error> {
        let centred: Vec<f64> = y.iter().map(|y| y - offset).collect();
        let first = centred.first().copied().unwrap_or(0.0);
        match self.inverse() {
            Ok(inverse) => Ok((inverse.resume(&mut inverse.settled(first), &centred), None)),
            Err(why) => {
                let (undetermined, n) = (self.undetermined_samples(), y.len());
                if undetermined >= n {
                    let because = format!(
                        "{why}; the inverse of the whole record does not determine the last {undetermined} of its {n} \
                         samples: record longer, or choose another order"
                    );
                    return Err(Error::NoInverse { kind: "usable", because });
                }
                let mut z = self.invert_whole(&centred)?;
                z.truncate(n - undetermined);
                Ok((z, Some(format!("{why}; z is computed non-causally from the whole record"))))
            }
        }
    }
}
