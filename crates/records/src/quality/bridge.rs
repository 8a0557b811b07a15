//! Interpolation over masked samples, for methods that cannot omit samples.

/// `y` interpolated linearly over samples that are not `usable`, constant at the ends of the record.
pub fn bridged(y: &[f64], usable: &[bool]) -> Vec<f64> {
    let mut y = y.to_vec();
    let mut before = None;
    for t in (0..y.len()).filter(|t| usable[*t]) {
        let from = before.map_or(0, |b| b + 1);
        let (start, rise) = before.map_or((y[t], 0.0), |b| (y[b], (y[t] - y[b]) / (t - b) as f64));
        (from..t).for_each(|k| y[k] = start + rise * (k + 1 - from) as f64);
        before = Some(t);
    }
    if let Some(last) = before {
        let end = y[last];
        y[last + 1..].fill(end);
    }
    y
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn masked_samples_are_interpolated_and_the_ends_are_constant() {
        let (y, no) = ([9.0, 9.0, 1.0, 9.0, 9.0, 4.0, 5.0, 9.0], false);
        let usable = [no, no, true, no, no, true, true, no];
        assert_eq!(bridged(&y, &usable), [1.0, 1.0, 1.0, 2.0, 3.0, 4.0, 5.0, 5.0]);
        assert_eq!(bridged(&y, &[no; 8]), y);
    }
}
