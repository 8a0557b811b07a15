//! Validation of a record that is too long to be held, by three passes over its file.
//!
//! 1. Range, path and means of the record, and its first section.
//! 2. The free run: drift of the error, whether the input is regular, reversals.
//! 3. The free run again, without what was removed: sums over all samples, and sections one after the other.
//!
//! Error figures, drift, residual tests, cycles and loops are those of the whole record. Of these, each section has its
//! own, which are averaged or joined: spectra, noise floor, frequency band, rate of cycles and defects. The past of the
//! record is that of its first section.
//!
//! It does not do: models that interpolate their input, cycles that are longer than a section, periods of the input
//! above a third of a section, and defects that only the whole shows.

use super::bins::{self, Bin, CycleBins};
use super::drift::DriftSums;
use super::facts::{Facts, Shape, inner_reversals};
use super::floor::SectionNoise;
use super::initial_condition::likeliest;
use super::loops::LoopSums;
use super::metrics::ErrorSums;
use super::whiteness::{LaggedSums, Whiteness};
use super::{ComparedRun, Figures, Floor, Offset, ValidateOptions, Validation, errors, factor};
use piezoid_models::hammerstein::{Domain, Model};
use piezoid_numerics::error::Error;
use piezoid_records::formats::LongRecord;
use piezoid_records::quality::InSections;
use piezoid_records::record::Record;
use piezoid_records::waveform::{Cycle, CycleSearch, Turn, period};
use std::collections::VecDeque;

/// Number of first samples that are kept.
const FIRST_SAMPLES: usize = 1000;

impl Validation {
    /// The comparison of [`validate_with`](super::Validate::validate_with) for a record that is read in pieces; also
    /// the domain of the input that counts, and the first samples of the record. A model that interpolates its input
    /// needs a record that is held.
    ///
    /// # Errors
    /// The errors of [`validate_with`](super::Validate::validate_with), and those of reading.
    pub fn of_long(
        model: &Model,
        record: &LongRecord,
        options: &ValidateOptions,
    ) -> Result<(Validation, Domain, Record), Error> {
        let k = factor(model, record.ts(), record.units())?;
        let start = Record::span(options.skip, f64::INFINITY, record.ts(), record.len())?.start;
        let mut survey = Survey::of(record, start)?;
        let (n, ts, free_offset) = (record.len() - start, record.ts(), options.offset != Offset::Kept);
        let [u, y] = &survey.head;
        let initial_condition = likeliest(model, (u, y), (record.len(), survey.path), k, free_offset);
        let before = model.before(u, initial_condition);
        let first = first_samples(record, std::mem::take(&mut survey.head))?;
        let run = FreeRun { model, record, before, k, start };
        let (mut trend, mut search, mut inner) =
            (DriftSums::new(n), CycleSearch::new(survey.ends), inner_reversals(model));
        let mut has_cycles = false;
        run.pass(&mut |u, y, simulated| {
            y.iter().zip(&simulated).for_each(|(y, s)| trend.add(y - s, *s));
            u.iter().for_each(|u| has_cycles |= search.add(*u).is_some());
            inner.iter_mut().for_each(|inner| u.iter().for_each(|u| inner.add(*u)));
            Ok(())
        })?;
        has_cycles |= search.end().is_some();
        has_cycles &= search.is_regular();
        let found = trend.drift(ts);
        let (mean, slope, mean_error, drift) = match options.offset {
            Offset::Kept => (0.0, 0.0, found.mean, found),
            Offset::Free => (found.mean, 0.0, 0.0, trend.remaining(false, ts)),
            Offset::Drift => (found.mean, found.slope, 0.0, trend.remaining(true, ts)),
        };
        let [mean_u, mean_y] = survey.means(n);
        let (mut sums, mut lags) = (ErrorSums::new(mean_y), LaggedSums::new(mean_u, mean_error));
        let mut shape = Shape::new([mean_y, trend.mean_simulated() + mean]);
        let ends = record.section_ends(n).collect();
        let search = has_cycles.then(|| CycleSearch::new(survey.ends));
        let mut sections = Sections::new(model, record, (start, ends), search);
        let mut t = 0;
        run.pass(&mut |u, y, mut simulated| {
            for s in &mut simulated {
                *s += mean + slope * (t as f64 - 0.5 * (n as f64 - 1.0));
                t += 1;
            }
            for (y, s) in y.iter().zip(&simulated) {
                sums.add(*y, *s);
                shape.add(*y, *s);
            }
            lags.add(u, &errors(y, &simulated));
            sections.add(u, y, &simulated)
        })?;
        let metrics = sums.metrics();
        let unknown = || Error::Content("the record is empty".into());
        let mut facts = sections.facts.ok_or_else(unknown)?;
        facts.domain =
            Domain { u: [survey.ends.0, survey.ends.1], slew: survey.step / ts, mean: [mean_u; 2], ..facts.domain };
        facts.findings = sections.findings.findings();
        let domain = facts.domain;
        let [by_frequency, by_amplitude] = sections.bins.bins();
        let figures = Figures {
            metrics,
            start,
            initial_condition,
            options,
            found,
            drift,
            mean_error,
            by_frequency: if sections.search.is_none() { Bin::merged(&sections.spectra) } else { by_frequency },
            by_amplitude,
            whiteness: Whiteness::of_sums(&lags),
            floor: sections.noise.flatten().and_then(|noise| Floor::above(&noise, &metrics, &drift)),
            loops: sections.loops.loops(),
            facts: Some(facts),
            inner_reversals: inner.map_or(0, |inner| inner.count),
            shape,
        };
        let validation = figures.validation(Some(model), ts, &record.units().y, Vec::new());
        Ok((validation, domain, first))
    }
}

/// The free run of a model on a record.
struct FreeRun<'a> {
    model: &'a Model,
    record: &'a LongRecord<'a>,
    /// The state before the first sample.
    before: Vec<f64>,
    /// The factor from the unit of the model to that of the record.
    k: f64,
    /// First sample that counts.
    start: usize,
}

/// Takes input, output and free run of a piece.
type TakeRun<'a> = &'a mut dyn FnMut(&[f64], &[f64], Vec<f64>) -> Result<(), Error>;

impl FreeRun<'_> {
    /// A pass over the samples that count.
    fn pass(&self, take: TakeRun) -> Result<(), Error> {
        let (mut x, mut t) = (self.before.clone(), 0);
        self.record.read(&mut |u, y| {
            let mut simulated = self.model.follow(&mut x, u);
            simulated.iter_mut().for_each(|s| *s *= self.k);
            let skipped = self.start.saturating_sub(t).min(u.len());
            t += u.len();
            take(&u[skipped..], &y[skipped..], simulated.split_off(skipped))
        })
    }
}

/// The first samples of a record, with its units and history.
fn first_samples(record: &LongRecord, [mut u, mut y]: [Vec<f64>; 2]) -> Result<Record, Error> {
    u.truncate(FIRST_SAMPLES);
    y.truncate(FIRST_SAMPLES);
    let first = Record::new(record.ts(), u, y)?.with_units(record.units().clone());
    Ok(record.history().iter().cloned().fold(first, Record::with_step))
}

/// What a first pass shows: of all samples the path of the input, of those that count the rest.
struct Survey {
    /// Input and output of the first section.
    head: [Vec<f64>; 2],
    path: f64,
    /// The smallest and the largest input, and its largest change from one sample to the next.
    ends: (f64, f64),
    step: f64,
    sums: [f64; 2],
}

impl Survey {
    fn of(record: &LongRecord, start: usize) -> Result<Self, Error> {
        let held = record.section_ends(record.len()).next().unwrap_or(0);
        let ends = (f64::INFINITY, f64::NEG_INFINITY);
        let mut survey = Survey { head: [Vec::new(), Vec::new()], path: 0.0, ends, step: 0.0, sums: [0.0; 2] };
        let (mut t, mut last) = (0, None);
        record.read(&mut |u, y| {
            for (head, samples) in survey.head.iter_mut().zip([u, y]) {
                head.extend(samples.iter().take(held - head.len()));
            }
            for (u, y) in u.iter().zip(y) {
                let step = last.map_or(0.0, |last: f64| (u - last).abs());
                survey.path += step;
                if t >= start {
                    survey.ends = (survey.ends.0.min(*u), survey.ends.1.max(*u));
                    survey.step = survey.step.max(if t > start { step } else { 0.0 });
                    survey.sums = [survey.sums[0] + u, survey.sums[1] + y];
                }
                (last, t) = (Some(*u), t + 1);
            }
            Ok(())
        })?;
        Ok(survey)
    }

    /// Means of input and output over the `n` samples that count.
    fn means(&self, n: usize) -> [f64; 2] {
        self.sums.map(|sum| sum / n as f64)
    }
}

/// The sections of a record, one after the other, and the cycles that begin in them.
struct Sections<'a> {
    model: &'a Model,
    record: &'a LongRecord<'a>,
    /// First sample that counts; where the sections to come end after it.
    start: usize,
    ends: VecDeque<usize>,
    /// Input, output and free run of the section, after those of cycles that go on; the number of samples before them.
    held: [Vec<f64>; 3],
    before: usize,
    /// Number of samples of earlier sections.
    done: usize,
    /// `None` for an input without cycles.
    search: Option<CycleSearch>,
    /// Cycles whose surroundings are not complete, and the start of the last one that was complete.
    cycles: VecDeque<[Turn; 3]>,
    last: usize,
    bins: CycleBins,
    loops: LoopSums,
    spectra: Vec<Bin>,
    facts: Option<Facts>,
    findings: InSections,
    /// The noise; `None` inside if that of a section is unknown.
    noise: Option<Option<SectionNoise>>,
}

impl<'a> Sections<'a> {
    fn new(
        model: &'a Model,
        record: &'a LongRecord<'a>,
        (start, ends): (usize, VecDeque<usize>),
        search: Option<CycleSearch>,
    ) -> Self {
        Sections {
            model,
            record,
            start,
            ends,
            held: [Vec::new(), Vec::new(), Vec::new()],
            before: 0,
            done: 0,
            search,
            cycles: VecDeque::new(),
            last: 0,
            bins: CycleBins::default(),
            loops: LoopSums::default(),
            spectra: Vec::new(),
            facts: None,
            findings: InSections::default(),
            noise: None,
        }
    }

    /// The next samples.
    fn add(&mut self, u: &[f64], y: &[f64], simulated: &[f64]) -> Result<(), Error> {
        let mut from = 0;
        while let Some(end) = self.ends.front().copied().filter(|_| from < u.len()) {
            let to = u.len().min(from + end - (self.before + self.held[0].len()));
            self.held.iter_mut().zip([u, y, simulated]).for_each(|(held, new)| held.extend(&new[from..to]));
            from = to;
            if self.before + self.held[0].len() == end {
                self.ends.pop_front();
                self.cycles();
                self.section()?;
                self.drop_samples(end);
            }
        }
        Ok(())
    }

    /// Adds the cycles that this section completes.
    fn cycles(&mut self) {
        let [u, y, simulated] = &self.held;
        let (is_last, first) = (self.ends.is_empty(), self.done - self.before);
        let Some(search) = &mut self.search else { return };
        self.cycles.extend(u[first..].iter().filter_map(|u| search.add(*u)));
        if is_last {
            self.cycles.extend(search.end());
        }
        // The loop of a cycle needs a quarter more on either side.
        let is_complete = |[a, _, b]: &[Turn; 3]| is_last || b.at + (b.at - a.at) / 4 < self.before + u.len();
        while let Some([a, peak, b]) = self.cycles.pop_front_if(|cycle| is_complete(cycle)) {
            self.last = a.at;
            if a.at < self.before {
                continue;
            }
            let cycle = Cycle::of(u, [a, peak, b].map(|turn| turn.at - self.before), self.record.ts());
            self.bins.add(y, simulated, &cycle);
            self.loops.add(u, y, simulated, &cycle);
        }
    }

    /// Adds what this section alone shows.
    fn section(&mut self) -> Result<(), Error> {
        let [u, y, simulated] = self.held.each_ref().map(|held| &held[self.done - self.before..]);
        let section = Record::new(self.record.ts(), u.to_vec(), y.to_vec())?.with_units(self.record.units().clone());
        let run = ComparedRun { record: &section, simulated };
        // Its search needs most memory: before the errors are there.
        let period = period(u);
        if self.search.is_none() {
            self.spectra = Bin::merged(self.spectra.iter().chain(&bins::by_spectrum(&run)));
        }
        let noise = SectionNoise::of(&run, period, &errors(y, simulated));
        self.noise = Some(match self.noise {
            None => noise,
            Some(known) => known.zip(noise).map(|(known, noise)| known.and(noise)),
        });
        let facts = Facts::of_section(self.model, &section);
        self.facts = Some(match self.facts.take() {
            None => facts,
            Some(known) => known.and(facts),
        });
        self.findings.add(&section, self.start + self.done);
        Ok(())
    }

    /// Drops the samples up to the end of a section, except those of cycles that are not complete.
    fn drop_samples(&mut self, end: usize) {
        let longest = end - self.done;
        self.done = end;
        let kept = if self.search.is_some() { self.last.max(end - longest) } else { end };
        let dropped = kept - self.before.min(kept);
        self.held.iter_mut().for_each(|held| drop(held.drain(..dropped)));
        self.before = kept.max(self.before);
    }
}

#[cfg(test)]
mod tests;
