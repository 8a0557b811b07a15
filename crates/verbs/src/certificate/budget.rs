//! The uncertainty budget, with the clauses of the GUM:
//!
//! ```text
//! u_i = value / divisor                                  4.2, 4.3
//! u_c^2 = sum (c_i u_i)^2                                5.1.2, uncorrelated
//! nu_eff = u_c^4 / sum ((c_i u_i)^4 / nu_i)              G.4.1, Welch-Satterthwaite, truncated to a whole number
//! U = k u_c,  k = t(coverage, nu_eff)                    6.2, G.3
//! ```
//! Where the errors of a record are not normal, and fewer of them than `coverage` lie within, k is as large as they
//! need (G.1.4: the distribution itself).
//!
//! Reference: JCGM 100:2008, Guide to the expression of uncertainty in measurement.

use libm::{ceil, floor, log10, pow};
use piezoid_numerics::student::coverage_factor;
use serde::Serialize;

/// Evaluation of a standard uncertainty: by statistics (4.2 of the GUM), or by other means (4.3).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub enum Evaluation {
    /// From the records.
    A,
    /// From what is stated.
    B,
}

/// A source of uncertainty: a row of the budget.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Contribution {
    /// The source.
    pub source: &'static str,
    /// Its value: an rms, a half-width, or an expanded uncertainty [`unit`].
    pub value: f64,
    /// The unit of value and standard uncertainty.
    pub unit: String,
    /// How the standard uncertainty was evaluated.
    pub evaluation: Evaluation,
    /// The distribution: `normal`, `rectangular`, or `known` for an error whose value is known.
    pub distribution: &'static str,
    /// The value over the standard uncertainty.
    pub divisor: f64,
    /// The standard uncertainty [`unit`].
    pub standard: f64,
    /// The sensitivity coefficient: change of the displacement with the quantity [output unit / `unit`].
    pub sensitivity: f64,
    /// Contribution to the combined standard uncertainty [output unit].
    pub contribution: f64,
    /// Degrees of freedom; `None` if there are infinitely many.
    pub degrees_of_freedom: Option<f64>,
    /// Share of the variance [%].
    pub share_percent: f64,
    /// Where the value is from.
    pub because: String,
}

impl Contribution {
    /// A row of a displacement with a normal distribution that the records show.
    pub(super) fn measured(source: &'static str, rms: f64, unit: &str, nu: f64, because: String) -> Self {
        let degrees_of_freedom = nu.is_finite().then_some(nu);
        let row = Contribution::new((source, because), (rms, unit), 1.0, 1.0);
        Contribution { evaluation: Evaluation::A, degrees_of_freedom, ..row }
    }

    /// A row that is stated, with a normal distribution.
    pub(super) fn new(
        (source, because): (&'static str, String),
        (value, unit): (f64, &str),
        divisor: f64,
        sensitivity: f64,
    ) -> Self {
        let standard = value / divisor;
        Contribution {
            source,
            value,
            unit: unit.into(),
            evaluation: Evaluation::B,
            distribution: "normal",
            divisor,
            standard,
            sensitivity,
            contribution: (sensitivity * standard).abs(),
            degrees_of_freedom: None,
            share_percent: 0.0,
            because,
        }
    }

    /// A row of a stated half-width.
    pub(super) fn rectangular(of: (&'static str, String), half_width: (f64, &str), sensitivity: f64) -> Self {
        Contribution { distribution: "rectangular", ..Contribution::new(of, half_width, 3f64.sqrt(), sensitivity) }
    }
}

/// A budget with what follows from it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Budget {
    /// The sources.
    pub rows: Vec<Contribution>,
    /// Combined standard uncertainty [output unit].
    pub standard: f64,
    /// Effective degrees of freedom; `None` if there are infinitely many.
    pub degrees_of_freedom: Option<f64>,
    /// The quantile of Student's t-distribution.
    pub student_k: f64,
    /// Coverage factor: this quantile, or more if the errors of the record need more.
    pub k: f64,
    /// Expanded uncertainty, not rounded [output unit].
    pub expanded: f64,
}

impl Budget {
    /// The budget of these rows, for a coverage probability between 0 and 1.
    pub(super) fn of(mut rows: Vec<Contribution>, coverage: f64) -> Self {
        let variance: f64 = rows.iter().map(|row| row.contribution * row.contribution).sum();
        for row in &mut rows {
            row.share_percent =
                if variance > 0.0 { 100.0 * row.contribution * row.contribution / variance } else { 0.0 };
        }
        let of_row = |row: &Contribution| row.degrees_of_freedom.map_or(0.0, |nu| row.contribution.powi(4) / nu);
        let spread: f64 = rows.iter().map(of_row).sum();
        let nu = variance * variance / spread;
        let degrees_of_freedom = nu.is_finite().then_some(nu);
        let k = coverage_factor(coverage, degrees_of_freedom.map_or(f64::INFINITY, |nu| floor(nu).max(1.0)));
        let standard = variance.sqrt();
        Budget { rows, standard, degrees_of_freedom, student_k: k, k, expanded: k * standard }
    }

    /// The same with an expanded uncertainty of at least this size [output unit].
    pub(super) fn at_least(self, size: f64) -> Self {
        if size > self.expanded && self.standard > 0.0 {
            Budget { k: size / self.standard, expanded: size, ..self }
        } else {
            self
        }
    }
}

/// A number of decimals: below 0 for digits before the point.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Digit(i32);

impl Digit {
    /// An uncertainty rounded up to two significant digits, and their last digit (7.2.6 of the GUM).
    pub(super) fn of(uncertainty: f64) -> (f64, Digit) {
        if uncertainty <= 0.0 || !uncertainty.is_finite() {
            return (uncertainty, Digit(0));
        }
        let up = |digit: i32| {
            let unit = pow(10.0, f64::from(digit));
            // What is already round stays so.
            ceil(uncertainty * unit * (1.0 - 1e-12)) / unit
        };
        let digit = 1 - floor(log10(uncertainty)) as i32;
        let rounded = up(digit);
        let digit = if rounded * pow(10.0, f64::from(digit)) > 99.5 { digit - 1 } else { digit };
        (up(digit), Digit(digit))
    }

    /// A number rounded to this digit, as text.
    pub fn text(self, x: f64) -> String {
        if self.0 >= 0 {
            let text = format!("{x:.*}", self.0.min(300) as usize);
            let is_zero = text.trim_start_matches('-').chars().all(|c| c == '0' || c == '.');
            return if is_zero { text.trim_start_matches('-').into() } else { text };
        }
        let unit = pow(10.0, f64::from(-self.0));
        format!("{:.0}", (x / unit).round() * unit + 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use piezoid_testing::assert_close;

    #[test]
    fn the_budget_of_the_end_gauge_of_the_gum_has_its_numbers() {
        // Annex H.1, table H.1: contributions [nm] and degrees of freedom.
        let rows = [(25.0, 18.0), (5.8, 24.0), (3.9, 5.0), (6.7, 8.0), (2.9, 50.0), (16.6, 2.0)];
        let rows = rows.map(|(u, nu)| Contribution::measured("", u, "nm", nu, String::new()));
        let budget = Budget::of(rows.into(), 0.99);
        // u_c = 32 nm, nu_eff = 16.7, truncated to 16, k = 2.92, U = 93 nm.
        assert_close(&[budget.standard, budget.k], &[31.7, 2.92], 0.01, 0.0);
        assert_eq!(budget.degrees_of_freedom.map(|nu| nu.floor()), Some(16.0));
        assert_eq!(Digit::of(budget.expanded).0, 93.0);
        assert_close(&[budget.rows.iter().map(|row| row.share_percent).sum()], &[100.0], 1e-12, 0.0);
    }

    #[test]
    fn a_half_width_is_divided_by_the_root_of_three_and_has_no_spread() {
        let row = Contribution::rectangular(("", String::new()), (0.3, "K"), 2.0);
        assert_close(&[row.standard, row.contribution], &[0.173205, 0.346410], 1e-5, 0.0);
        let budget = Budget::of(vec![row], 0.9545);
        assert_eq!(budget.degrees_of_freedom, None);
        assert_close(&[budget.k], &[2.0], 1e-4, 0.0);
    }

    #[test]
    fn uncertainties_are_rounded_up_to_two_digits_and_results_to_the_same_digit() {
        let rounded = |u: f64| {
            let (up, digit) = Digit::of(u);
            (digit.text(up), digit.text(-1234.5678), digit.text(-1e-9))
        };
        let text = |a: &str, b: &str, c: &str| (a.to_string(), b.to_string(), c.to_string());
        assert_eq!(rounded(0.05213), text("0.053", "-1234.568", "0.000"));
        assert_eq!(rounded(0.0996), text("0.10", "-1234.57", "0.00"));
        assert_eq!(rounded(0.053), text("0.053", "-1234.568", "0.000"));
        assert_eq!(rounded(1.0), text("1.0", "-1234.6", "0.0"));
        assert_eq!(rounded(1234.0), text("1300", "-1200", "0"));
        assert_eq!(Digit::of(0.0).0, 0.0);
    }

    #[test]
    fn without_any_uncertainty_nothing_is_undefined() {
        let budget = Budget::of(vec![Contribution::measured("", 0.0, "um", 4.0, String::new())], 0.95);
        assert_eq!((budget.expanded, budget.rows[0].share_percent), (0.0, 0.0));
    }
}
