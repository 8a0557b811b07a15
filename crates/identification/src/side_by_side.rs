//! Independent fits side by side, on the threads of the pool; the thread that calls reports their progress.

use crate::fit::StepCallback;
use piezoid_numerics::error::Error;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{TryRecvError, channel};

/// The results of `work` on each item, in their order. `report` gets the number of an item before each step of its
/// work, and its result when all items before it have one too.
///
/// # Errors
/// The first error of `report`, which ends all work at its next step.
pub(crate) fn side_by_side<I: Send, T: Send>(
    items: Vec<I>,
    work: impl Fn(I, StepCallback) -> T + Sync,
    mut report: impl FnMut(usize, Option<&T>) -> Result<(), Error>,
) -> Result<Vec<T>, Error> {
    let mut results: Vec<Option<T>> = items.iter().map(|_| None).collect();
    let (is_cancelled, work) = (&AtomicBool::new(false), &work);
    let (sender, receiver) = channel();
    let mut outcome = Ok(());
    rayon::in_place_scope_fifo(|scope| {
        for (k, item) in items.into_iter().enumerate() {
            let sender = sender.clone();
            scope.spawn_fifo(move |_| {
                let mut watch = |_: usize| match is_cancelled.load(Ordering::Relaxed) {
                    true => Err(Error::Cancelled { what: String::new(), done: 0, total: 0 }),
                    false => {
                        // The receiver lives as long as the scope.
                        _ = sender.send((k, None));
                        Ok(())
                    }
                };
                let result = work(item, &mut watch);
                _ = sender.send((k, Some(result)));
            });
        }
        drop(sender);
        let mut reported = 0;
        loop {
            let news = match receiver.try_recv() {
                Err(TryRecvError::Empty) => match rayon::yield_now() {
                    Some(rayon::Yield::Executed) => continue,
                    // The other threads do all the work that is left.
                    _ => receiver.recv().ok(),
                },
                Err(TryRecvError::Disconnected) => break,
                Ok(news) => Some(news),
            };
            let Some((k, result)) = news else { continue };
            let is_step = result.is_none();
            results[k] = result.or(results[k].take());
            if outcome.is_err() {
                continue;
            }
            let mut reports = if is_step { report(k, None) } else { Ok(()) };
            while let (Ok(()), Some(Some(result))) = (&reports, results.get(reported)) {
                reports = report(reported, Some(result));
                reported += 1;
            }
            is_cancelled.store(reports.is_err(), Ordering::Relaxed);
            outcome = reports;
        }
    });
    outcome.map(|()| results.into_iter().flatten().collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn on(threads: usize, test: impl Fn() + Sync + Send) {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(test);
    }

    #[test]
    fn results_are_in_the_order_of_the_items_and_reported_in_it() {
        let test = || {
            let mut reported = Vec::new();
            let work = |k: usize, watch: StepCallback| {
                (0..10 - k).for_each(|step| watch(step).unwrap());
                k * k
            };
            let found = side_by_side((0..10).collect(), work, |k, result| {
                reported.extend(result.map(|result| (k, *result)));
                Ok(())
            });
            let squares: Vec<usize> = (0..10).map(|k| k * k).collect();
            assert_eq!(reported, squares.iter().copied().enumerate().collect::<Vec<_>>());
            assert_eq!(found, Ok(squares));
        };
        test();
        on(1, test);
        on(2, test);
    }

    #[test]
    fn an_error_of_the_report_ends_the_work_at_its_next_step() {
        let test = || {
            let work = |_: usize, watch: StepCallback| (0..1_000_000).map_while(|step| watch(step).ok()).count();
            let why = Error::Content("enough".into());
            let found = side_by_side(vec![0, 1, 2], work, |_, _| Err(why.clone()));
            assert_eq!(found, Err(why.clone()));
        };
        test();
        on(2, test);
    }
}
