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

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;

    fn input() -> Vec<f64> {
        (0..400).map(|t| 1.0 + (f64::from(t) * 0.07).sin()).collect()
    }

    #[test]
    fn a_causal_inverse_gives_every_sample() {
        let arx = Arx::new(5e-4, vec![1.2, -0.7], vec![0.5, 0.1]).unwrap();
        let u = input();
        let mut x = arx.settled(1.0);
        let y: Vec<f64> = arx.resume(&mut x, &u).iter().map(|y| y + 7.0).collect();
        let (z, note) = arx.hidden(7.0, &y).unwrap();
        assert_eq!(note, None);
        assert_close(&z, &u, 0.0, 1e-9);
    }

    #[test]
    fn without_one_the_record_is_inverted_as_a_whole_but_for_its_end() {
        let arx = Arx::new(5e-4, vec![1.2, -0.7], vec![0.5, 1.2, 0.1]).unwrap();
        let (u, mut x) = (input(), arx.settled(1.0));
        let y: Vec<f64> = arx.resume(&mut x, &u).iter().map(|y| y - 3.0).collect();
        let (z, note) = arx.hidden(-3.0, &y).unwrap();
        assert!(note.unwrap().ends_with("z is computed non-causally from the whole record"));
        assert_eq!(z.len(), 400 - arx.undetermined_samples());
        assert_close(&z, &u[..z.len()], 0.0, 5e-3);
        let message = arx.hidden(-3.0, &y[..arx.undetermined_samples()]).unwrap_err().to_string();
        assert!(message.contains("record longer, or choose another order"), "{message}");
    }
}
