//! Where the time of an identification goes: a subscriber of its spans. Spans of the target `stage` are parts of the
//! search; the others are kernels. Each counts without the spans inside it.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};
use tracing::field::{Field, Visit};
use tracing::{Event, Id, Metadata, Subscriber, span};

/// A kind of span.
#[derive(Debug, Clone, PartialEq)]
struct Kind {
    name: String,
    is_stage: bool,
}

/// What was measured.
#[derive(Debug, Default)]
struct State {
    kinds: Vec<Kind>,
    /// The stages that have begun, from the outermost on.
    stages: Vec<String>,
    /// For each stage and kernel, the number of spans and their time on all threads.
    sums: BTreeMap<(String, String), (usize, Duration)>,
}

/// A profile.
#[derive(Debug, Default)]
pub struct Profile(Mutex<State>);

thread_local! {
    /// The spans of this thread: when they began, and the time of the spans inside them.
    static OPEN: RefCell<Vec<(Instant, Duration)>> = const { RefCell::new(Vec::new()) };
}

impl Profile {
    fn with<T>(&self, work: impl FnOnce(&mut State) -> T) -> T {
        work(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// The sums by outermost stage and kernel so far, which begin anew. Time in which the stage itself waits is the
    /// kernel `-`.
    pub fn take(&self) -> BTreeMap<(String, String), (usize, Duration)> {
        self.with(|state| std::mem::take(&mut state.sums))
    }

    fn kind(&self, id: &Id) -> Kind {
        self.with(|state| state.kinds[id.into_u64() as usize - 1].clone())
    }
}

/// The number of weights of a fit, as a word.
struct Size(&'static str);

impl Visit for Size {
    fn record_debug(&mut self, _: &Field, _: &dyn std::fmt::Debug) {}

    fn record_u64(&mut self, _: &Field, weights: u64) {
        self.0 = match weights {
            1 => " of z",
            2..40 => " of few weights",
            _ => " of many weights",
        };
    }
}

/// Records a profile.
pub struct Recorder(pub &'static Profile);

impl Subscriber for Recorder {
    fn enabled(&self, _: &Metadata<'_>) -> bool {
        true
    }

    fn new_span(&self, attributes: &span::Attributes<'_>) -> Id {
        let mut size = Size("");
        attributes.record(&mut size);
        let of = attributes.metadata();
        let kind = Kind { name: format!("{}{}", of.name(), size.0), is_stage: of.target() == "stage" };
        let place = self.0.with(|state| {
            let known = state.kinds.iter().position(|one| *one == kind);
            known.unwrap_or_else(|| {
                state.kinds.push(kind);
                state.kinds.len() - 1
            })
        });
        Id::from_u64(place as u64 + 1)
    }

    fn record(&self, _: &Id, _: &span::Record<'_>) {}

    fn record_follows_from(&self, _: &Id, _: &Id) {}

    fn event(&self, _: &Event<'_>) {}

    fn enter(&self, id: &Id) {
        let kind = self.0.kind(id);
        if kind.is_stage {
            self.0.with(|state| state.stages.push(kind.name));
        }
        OPEN.with_borrow_mut(|open| open.push((Instant::now(), Duration::ZERO)));
    }

    fn exit(&self, id: &Id) {
        let kind = self.0.kind(id);
        let Some((start, inside)) = OPEN.with_borrow_mut(Vec::pop) else { return };
        let whole = start.elapsed();
        OPEN.with_borrow_mut(|open| open.iter_mut().last().into_iter().for_each(|last| last.1 += whole));
        self.0.with(|state| {
            let stage = state.stages.first().cloned().unwrap_or_default();
            let kernel = if kind.is_stage { "-".into() } else { kind.name.clone() };
            let sum = state.sums.entry((stage, kernel)).or_default();
            *sum = (sum.0 + 1, sum.1 + whole.saturating_sub(inside));
            if kind.is_stage
                && let Some(place) = state.stages.iter().rposition(|name| *name == kind.name)
            {
                state.stages.remove(place);
            }
        });
    }
}
