//! The record in a file, prepared.

use super::File;
use crate::error::Error;
use crate::formats::ColumnSelection;
use crate::preparation::PrepareOptions;
use crate::record::Record;

impl File {
    /// The record in this file after the steps of `options`. If it is resampled, its times may be uneven: the samples
    /// are interpolated first, and the record's history says so.
    ///
    /// # Errors
    /// The errors of [`File::record`] and of [`PrepareOptions::run`].
    #[doc(hidden)]
    pub fn prepared(&self, columns: &ColumnSelection, options: &PrepareOptions) -> Result<Record, Error> {
        let record = self.read(|table| table.resampled(columns, options.resample))?;
        options.run(&record).map_err(|error| error.about(&self.name))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A record with a period of 1 ms whose stamps are off by up to `jitter` [ms].
    fn file(jitter: f64) -> File {
        let mut text = String::from("t_s,u_V,y_um\n");
        for k in 0..400 {
            let t = 1e-3 * (f64::from(k) + jitter * f64::from(k * 7919 % 13 - 6) / 6.0);
            text += &format!("{t:.7},{:.6},{:.6}\n", (30.0 * t).sin(), 20.0 * (30.0 * t).cos());
        }
        File::new("jitter.csv", text)
    }

    fn resampled(file: &File, ts: f64) -> Result<Record, Error> {
        let options = PrepareOptions { resample: Some(ts), ..PrepareOptions::default() };
        file.prepared(&ColumnSelection::default(), &options)
    }

    #[test]
    fn uneven_times_are_refused_unless_the_record_is_resampled() {
        let file = file(0.2);
        let refused = file.prepared(&ColumnSelection::default(), &PrepareOptions::default()).unwrap_err().to_string();
        assert!(refused.contains("use `prepare` with the option resample = 0.001;"), "{refused}");
        for (ts, count) in [(1e-3, 400), (4e-3, 100), (5e-4, 799)] {
            let record = resampled(&file, ts).unwrap();
            assert_eq!((record.ts(), record.len().abs_diff(count) <= 1), (ts, true), "{}", record.len());
            // The first stamp is 0.2 ms early.
            let at = |k: usize| 30.0 * (k as f64 * ts - 2e-4);
            let inner = record.len() / 10..record.len() * 9 / 10;
            let worst = inner.map(|k| (record.u()[k] - at(k).sin()).abs()).fold(0.0, f64::max);
            assert!(worst < 1e-3, "{worst} at {ts} s");
            let told = &record.history()[0];
            assert!(told.starts_with("uneven times (steps of 6.333e-4 s to 0.001067 s"), "{told}");
        }
    }

    #[test]
    fn even_times_are_resampled_as_ever() {
        let record = resampled(&file(0.0), 2e-3).unwrap();
        assert!(record.history().iter().all(|step| !step.contains("uneven")), "{:?}", record.history());
    }

    #[test]
    fn a_long_gap_is_not_bridged() {
        let whole = String::from_utf8(file(0.2).bytes).unwrap();
        let lines: Vec<&str> =
            whole.lines().enumerate().filter(|(k, _)| !(101..=150).contains(k)).map(|(_, l)| l).collect();
        let gap = File::new("gap.csv", lines.join("\n"));
        let refused = resampled(&gap, 1e-3).unwrap_err().to_string();
        assert!(refused.contains("there is no sample from 0.09"), "{refused}");
        let (_, from) = refused.rsplit_once("give `from` = ").unwrap();
        let columns = ColumnSelection { from: from.parse().ok(), ..ColumnSelection::default() };
        let options = PrepareOptions { resample: Some(1e-3), ..PrepareOptions::default() };
        assert_eq!(gap.prepared(&columns, &options).unwrap().len(), 250);
    }

    #[test]
    fn times_that_stand_still_are_not_resampled() {
        let still = File::new("still.csv", "t_s,u_V,y_um\n0,1,2\n0.1,1,2\n0.1,1,2\n0.3,1,2\n");
        assert!(resampled(&still, 0.1).unwrap_err().to_string().contains("two rows have the time 0.1 s"));
    }
}
