//! Operators as weighted sums of known responses, so that the weights can be fitted without an inverse.
//!
//! ```text
//! z = sum_k w_k phi_k[u; p]
//! ```
//! For fixed shape parameters p every operator is linear in its weights w (Tellinen's has one weight). An LTI block G
//! keeps this property: G z = sum_k w_k (G phi_k). Therefore the weights follow from a convex least-squares problem on
//! filtered responses. Only p needs a search (Golub & Pereyra 2003, DOI 10.1088/0266-5611/19/2/201).

use super::Hysteresis;
use super::real::Sensitive;
use piezoid_numerics::error::Error;
use std::fmt::Debug;
use std::sync::Arc;

/// Data from which the basis of an operator is made.
#[derive(Debug, Clone, PartialEq)]
pub struct BasisDesign {
    /// Sampling period [s].
    pub ts: f64,
    /// The lowest and the highest input [input unit].
    pub range: (f64, f64),
    /// Number of thresholds, levels or knots; `None` takes the operator's default.
    pub elements: Option<usize>,
    /// Frequencies of the records [Hz], ascending; empty if they have none.
    pub frequencies: Vec<f64>,
}

impl BasisDesign {
    /// Half the range of the inputs [input unit].
    pub(super) fn half(&self) -> f64 {
        0.5 * (self.range.1 - self.range.0)
    }
}

/// An operator with its state: the next input to the next z.
pub type SensitiveOperator<'a> = Box<dyn FnMut(Sensitive) -> Sensitive + 'a>;

/// The responses phi_k of an operator, and the operator for given weights.
///
/// ```
/// use piezoid_models::hysteresis::{BasisDesign, Operator};
/// let design = BasisDesign { ts: 5e-4, range: (-30.0, 30.0), elements: Some(4), frequencies: vec![] };
/// let basis = (Operator::find("prandtl-ishlinskii")?.basis)(&design)?;
/// let block = basis.operator(&vec![0.2; basis.len()])?;
/// let (mut x, mut phi) = (basis.initial(), vec![0.0; basis.len()]);
/// basis.step(&mut x, 10.0, &mut phi);
/// assert!((block.simulate(&[10.0])[0] - 0.2 * phi.iter().sum::<f64>()).abs() < 1e-12);
/// # Ok::<(), piezoid::Error>(())
/// ```
#[allow(clippy::len_without_is_empty)] // never empty
pub trait Basis: Debug + Send + Sync {
    /// Number of weights.
    fn len(&self) -> usize;

    /// Length of the state.
    fn order(&self) -> usize;

    /// The state at rest, where every phi is 0.
    fn initial(&self) -> Vec<f64> {
        vec![0.0; self.order()]
    }

    /// One sample: advances the state `x` by the input `u` and writes the responses to `phi`.
    fn step(&self, x: &mut [f64], u: f64, phi: &mut [f64]);

    /// For each weight, true if it must not be negative for physical reasons.
    fn non_negative(&self) -> Vec<bool>;

    /// Linear combinations of weights, as (weight, factor), that are small if the operator is smooth.
    fn roughness(&self) -> Vec<Vec<(usize, f64)>> {
        Vec::new()
    }

    /// The shape parameters p. Those with a positive lower bound are searched on a logarithmic scale.
    fn shape(&self) -> Vec<ShapeParameter> {
        Vec::new()
    }

    /// The same basis with other shape parameters.
    ///
    /// # Errors
    /// Returns an error if the number of parameters differs from [`shape`](Basis::shape), or if the operator does not
    /// allow them.
    fn reshaped(&self, shape: &[f64]) -> Result<Box<dyn Basis>, Error>;

    /// The basis with these responses alone, if the records are to select among them; `None` if all belong to the
    /// operator.
    fn with_terms(&self, _terms: &[usize]) -> Option<Box<dyn Basis>> {
        None
    }

    /// The same for inputs with another sampling period [s], if its responses are such a selection.
    fn with_period(&self, _ts: f64) -> Option<Box<dyn Basis>> {
        None
    }

    /// For each shape parameter the sensitivity dz/dp_j at each sample of `u`, from rest.
    fn slopes(&self, _weights: &[f64], _u: &[f64]) -> Vec<Vec<f64>> {
        Vec::new()
    }

    /// The operator from rest, a sample at a time, with the derivatives of z by some parameters, on which weights,
    /// shape and input may depend. `None` if the operator has none.
    fn sensitive<'a>(&'a self, _weights: &'a [Sensitive], _shape: &'a [Sensitive]) -> Option<SensitiveOperator<'a>> {
        None
    }

    /// z for each sample of `u`, from rest.
    ///
    /// # Errors
    /// Those of [`operator`](Basis::operator).
    fn output(&self, weights: &[f64], u: &[f64]) -> Result<Vec<f64>, Error> {
        Ok(self.operator(weights)?.simulate(u))
    }

    /// The operator with these weights.
    ///
    /// # Errors
    /// Returns an error if the number of weights differs from [`len`](Basis::len), or if the operator does not allow
    /// them.
    fn operator(&self, weights: &[f64]) -> Result<Arc<dyn Hysteresis>, Error>;
}

/// A shape parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ShapeParameter {
    /// Name, as in model files.
    pub name: &'static str,
    /// Value.
    pub value: f64,
    /// Lower bound of the search.
    pub low: f64,
    /// Upper bound of the search.
    pub high: f64,
}

/// Returns an error unless `what` has `need` numbers.
pub(super) fn counted(operator: &str, what: &str, have: usize, need: usize) -> Result<(), Error> {
    if have == need {
        return Ok(());
    }
    Err(Error::parameter(what, format!("{have} numbers"), format!("must be {need} numbers for this {operator}")))
}

/// Returns an error unless `what` has from `least` to `most` numbers.
pub(super) fn counted_within(what: &str, have: usize, least: usize, most: usize) -> Result<(), Error> {
    if (least..=most).contains(&have) {
        return Ok(());
    }
    Err(Error::parameter(what, format!("{have} numbers"), format!("must be {least} to {most} numbers")))
}

/// Second differences of the weights `from` up to `to`.
pub(super) fn curvature(from: usize, to: usize) -> Vec<Vec<(usize, f64)>> {
    (from + 1..to.saturating_sub(1)).map(|k| vec![(k - 1, 1.0), (k, -2.0), (k + 1, 1.0)]).collect()
}

#[cfg(test)]
mod tests {
    //! Contract tests of all bases, on ranges about zero, from zero, above zero, and tiny.
    use super::*;
    use crate::hysteresis::OPERATORS;
    use crate::hysteresis::real::{LANES, Several};
    use nalgebra::{DMatrix, DVector};
    use piezoid_testing::assert_close;

    const TS: f64 = 5e-4;

    fn design(range: (f64, f64)) -> BasisDesign {
        BasisDesign { ts: TS, range, elements: None, frequencies: vec![5.0, 20.0, 80.0] }
    }

    /// Every operator's basis, on every range.
    fn bases() -> impl Iterator<Item = (&'static str, Box<dyn Basis>, Vec<f64>)> {
        let ranges = [(-30.0, 30.0), (0.0, 100.0), (20.0, 60.0), (0.0, 0.001)];
        OPERATORS
            .iter()
            .flat_map(move |o| ranges.map(|range| (o.name, (o.basis)(&design(range)).unwrap(), drive(range))))
    }

    /// Nested loops that fill the range.
    fn drive((low, high): (f64, f64)) -> Vec<f64> {
        let at = |t: f64| 0.6 * (0.05 * t).sin() + 0.4 * (0.173 * t).sin();
        (0..1200).map(|t| 0.5 * (low + high) + 0.5 * (high - low) * at(f64::from(t))).collect()
    }

    /// Weights of different sizes.
    fn weights(basis: &dyn Basis) -> Vec<f64> {
        (0..basis.len()).map(|k| 1.0 + 0.5 * (1.7 * k as f64).sin()).collect()
    }

    /// phi along `u`, one column per response.
    fn responses(basis: &dyn Basis, u: &[f64]) -> DMatrix<f64> {
        let (mut x, mut phi) = (basis.initial(), vec![0.0; basis.len()]);
        let rows = u.iter().flat_map(|&u| {
            basis.step(&mut x, u, &mut phi);
            phi.clone()
        });
        DMatrix::from_row_iterator(u.len(), basis.len(), rows)
    }

    fn peak(z: &[f64]) -> f64 {
        z.iter().fold(0.0, |m, z| m.max(z.abs()))
    }

    #[test]
    fn every_response_is_zero_at_rest() {
        for (name, basis, _) in bases() {
            let mut phi = vec![1.0; basis.len()];
            let mut x = basis.initial();
            assert_eq!(x.len(), basis.order(), "{name}");
            basis.step(&mut x, 0.0, &mut phi);
            assert!(phi.iter().all(|phi| *phi == 0.0), "{name}: {phi:?}");
        }
    }

    #[test]
    fn the_weighted_sum_of_the_responses_is_the_operator() {
        for (name, basis, u) in bases() {
            let w = weights(&*basis);
            let sum = responses(&*basis, &u) * DVector::from(w.clone());
            let operator = basis.operator(&w).unwrap();
            assert_eq!(operator.operator().name, name);
            println!("{name}");
            assert_close(&operator.simulate(&u), sum.as_slice(), 1e-12, 1e-12 * sum.amax());
        }
    }

    #[test]
    fn non_negative_and_roughness_refer_to_existing_weights() {
        for (name, basis, _) in bases() {
            assert_eq!(basis.non_negative().len(), basis.len(), "{name}");
            assert!(basis.roughness().iter().flatten().all(|(k, c)| *k < basis.len() && *c != 0.0), "{name}");
        }
    }

    #[test]
    fn shape_parameters_are_within_their_bounds_and_the_bounds_are_allowed() {
        for (name, basis, u) in bases() {
            let shape = basis.shape();
            for bound in [|s: &ShapeParameter| s.low, |s: &ShapeParameter| s.high] {
                let at_bound = basis.reshaped(&shape.iter().map(bound).collect::<Vec<_>>()).unwrap();
                let phi = responses(&*at_bound, &u);
                assert!(phi.iter().all(|phi| phi.is_finite()), "{name}");
            }
            for s in &shape {
                assert!(s.low < s.value && s.value < s.high, "{name}: {s:?}");
            }
            let same = basis.reshaped(&shape.iter().map(|s| s.value).collect::<Vec<_>>()).unwrap();
            assert_eq!(same.shape(), shape, "{name}");
        }
    }

    #[test]
    fn errors_about_shape_parameters_name_them() {
        // Tellinen's branches may have any value: where they cross, the loop is closed.
        for (name, basis, _) in bases().filter(|(name, ..)| *name != "tellinen") {
            let shape = basis.shape();
            for (j, s) in shape.iter().enumerate() {
                let mut off: Vec<f64> = shape.iter().map(|s| s.value).collect();
                off[j] = -1e9;
                let message = basis.reshaped(&off).unwrap_err().to_string();
                assert!(message.starts_with(&format!("{} = -1000000000: must", s.name)), "{name}: {message}");
                off[j] = f64::NAN;
                assert!(basis.reshaped(&off).is_err(), "{name}");
            }
        }
    }

    #[test]
    fn the_slope_equals_the_difference_of_reshaped_operators() {
        for (name, basis, u) in bases() {
            // Away from the initial values, some of which are at a kink.
            let off = |s: &ShapeParameter| s.value + 0.07 * s.value.abs() + 0.003 * (s.high - s.low);
            let basis = basis.reshaped(&basis.shape().iter().map(off).collect::<Vec<_>>()).unwrap();
            let (w, shape) = (weights(&*basis), basis.shape());
            let slopes = basis.slopes(&w, &u);
            for (j, s) in shape.iter().enumerate() {
                let h = 1e-5 * (s.value.abs() + 0.01 * (s.high - s.low));
                let moved = |by: f64| {
                    let p: Vec<f64> =
                        shape.iter().enumerate().map(|(i, s)| s.value + if i == j { by } else { 0.0 }).collect();
                    basis.reshaped(&p).unwrap().operator(&w).unwrap().simulate(&u)
                };
                let difference: Vec<f64> = moved(h).iter().zip(moved(-h)).map(|(a, b)| (a - b) / (2.0 * h)).collect();
                let slope = &slopes[j];
                println!("{name}: {}", s.name);
                assert!(peak(slope) > 0.0, "{name}: {} has no effect", s.name);
                assert_close(slope, &difference, 1e-5, 1e-5 * peak(&difference));
            }
        }
    }

    #[test]
    fn least_squares_recovers_an_operator_from_its_own_output() {
        for (name, basis, u) in bases() {
            let operator = basis.operator(&weights(&*basis)).unwrap();
            let z = DVector::from(operator.simulate(&u));
            let phi = responses(&*basis, &u);
            let svd = phi.clone().svd(true, true);
            let mut fit = DVector::zeros(basis.len());
            // Iterative refinement: the residual is fitted again.
            (0..3).for_each(|_| fit += svd.solve(&(&z - &phi * &fit), 1e-13 * svd.singular_values[0]).unwrap());
            let found = basis.operator(fit.as_slice()).unwrap();
            println!("{name}");
            assert_close(&found.simulate(&u), z.as_slice(), 0.0, 1e-9 * z.amax());
        }
    }

    #[test]
    fn a_wrong_number_of_weights_or_shape_parameters_is_an_error() {
        for (name, basis, _) in bases() {
            for wrong in [0, basis.len() + 1] {
                let message = basis.operator(&vec![1.0; wrong]).unwrap_err().to_string();
                assert!(message.starts_with(&format!("weights = {wrong} numbers: must be")), "{message}");
            }
            let message = basis.reshaped(&vec![0.1; basis.shape().len() + 1]).unwrap_err().to_string();
            assert!(message.contains("shape") && message.contains(name), "{message}");
        }
    }

    #[test]
    fn inputs_that_are_not_finite_do_not_panic() {
        for (_, basis, u) in bases() {
            let odd = [f64::NAN, u[3], f64::INFINITY, u[4], 1e300, -1e300, f64::NEG_INFINITY, u[5]];
            basis.operator(&weights(&*basis)).unwrap().simulate(&odd);
            responses(&*basis, &odd);
            basis.slopes(&weights(&*basis), &odd);
        }
    }

    #[test]
    fn the_output_is_that_of_the_operator() {
        for (name, basis, u) in bases() {
            let w = weights(&*basis);
            assert_eq!(basis.output(&w, &u).unwrap(), basis.operator(&w).unwrap().simulate(&u), "{name}");
            assert!(basis.output(&w[1..], &u).is_err(), "{name}");
        }
    }

    #[test]
    fn responses_that_records_select_are_those_of_the_whole() {
        let mut selecting = Vec::new();
        for (name, basis, u) in bases() {
            let chosen = [0, basis.len() - 1];
            assert_eq!(basis.with_terms(&chosen).is_some(), basis.with_period(2.0 * TS).is_some(), "{name}");
            let (Some(some), Some(slow)) = (basis.with_terms(&chosen), basis.with_period(2.0 * TS)) else { continue };
            selecting.push(name);
            assert_eq!((some.len(), slow.len()), (2, basis.len()), "{name}");
            assert_eq!(responses(&*some, &u), responses(&*basis, &u).select_columns(&chosen), "{name}");
            assert_eq!(slow.operator(&weights(&*basis)).unwrap().ts(), 2.0 * TS, "{name}");
        }
        selecting.dedup();
        assert_eq!(selecting, ["narx"]);
    }

    #[test]
    fn an_operator_with_derivatives_has_the_values_and_the_slopes_of_its_basis() {
        let mut without = Vec::new();
        for (name, basis, u) in bases() {
            let (w, shape) = (weights(&*basis), basis.shape());
            let (phi, slopes) = (responses(&*basis, &u), basis.slopes(&w, &u));
            assert_eq!(slopes.len(), shape.len(), "{name}");
            // By the first and the last weight, then by the first shape parameters.
            let (chosen, by_shape) = ([0, w.len() - 1], shape.len().min(LANES - 2));
            let seeded = |value: f64, lane: Option<usize>| {
                let slope = std::array::from_fn(|k| f64::from(u8::from(lane == Some(k))));
                Sensitive { value, slope: Several(slope) }
            };
            let lane = |k: usize| chosen.iter().position(|c| *c == k);
            let of_weights: Vec<Sensitive> = w.iter().enumerate().map(|(k, &w)| seeded(w, lane(k))).collect();
            let of_shape: Vec<Sensitive> =
                shape.iter().enumerate().map(|(j, s)| seeded(s.value, Some(j + 2))).collect();
            let Some(mut run) = basis.sensitive(&of_weights, &of_shape) else {
                without.push(name);
                continue;
            };
            println!("{name}");
            let found: Vec<Sensitive> = u.iter().map(|&u| run(u.into())).collect();
            let slope = |lane: usize| -> Vec<f64> { found.iter().map(|z| z.slope.0[lane]).collect() };
            let values: Vec<f64> = found.iter().map(|z| z.value).collect();
            let rounding = 1e-12 * phi.amax();
            assert_close(&values, &basis.output(&w, &u).unwrap(), 1e-12, rounding * w.len() as f64);
            for (lane, k) in chosen.into_iter().enumerate() {
                let known: Vec<f64> = phi.column(k).iter().copied().collect();
                assert_close(&slope(lane), &known, 1e-12, rounding);
            }
            for (j, known) in slopes.iter().enumerate().take(by_shape) {
                assert_close(&slope(j + 2), known, 1e-9, 1e-9 * peak(known));
            }
        }
        without.dedup();
        assert_eq!(without, ["proportional", "two-branch", "rate-scheduled", "tellinen"]);
    }

    #[test]
    fn every_row_of_the_roughness_has_a_weight() {
        for (name, basis, _) in bases() {
            assert!(basis.roughness().iter().all(|row| !row.is_empty()), "{name}");
        }
    }
}
