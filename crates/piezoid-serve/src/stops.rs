//! `DELETE /api/calls/{id}`: a call that moves an instrument stops it, and its answer, which says where the instrument
//! was left, still comes. The call has this id as its header `piezoid-call`.

use crate::Shared;
use crate::failure::Failure;
use axum::extract::{Path, State};
use axum::http::{HeaderMap, StatusCode};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::sync::Notify;

/// The header of a call that has its id.
const ID: &str = "piezoid-call";

/// Longest id [bytes].
const LONGEST: usize = 64;

/// The calls that can be stopped, by their ids.
#[derive(Debug, Clone, Default)]
pub(crate) struct Stops(Arc<Mutex<HashMap<String, Arc<Notify>>>>);

/// One of them, until it is dropped.
#[derive(Debug)]
pub(crate) struct Stop {
    id: Option<String>,
    requested: Arc<Notify>,
    all: Stops,
}

impl Stops {
    fn all(&self) -> MutexGuard<'_, HashMap<String, Arc<Notify>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// A call with these headers, which can be stopped if it has an id that no other call has.
    pub(crate) fn call(&self, headers: &HeaderMap) -> Stop {
        let id = headers.get(ID).and_then(|id| id.to_str().ok()).filter(|id| id.len() <= LONGEST).map(String::from);
        let requested = Arc::new(Notify::new());
        let id = id.filter(|id| !self.all().contains_key(id));
        if let Some(id) = &id {
            self.all().insert(id.clone(), requested.clone());
        }
        Stop { id, requested, all: self.clone() }
    }
}

impl Stop {
    /// Waits until it is to stop.
    pub(crate) async fn requested(&self) {
        self.requested.notified().await;
    }
}

impl Drop for Stop {
    fn drop(&mut self) {
        if let Some(id) = &self.id {
            self.all.all().remove(id);
        }
    }
}

/// Stops a call.
pub(crate) async fn stop(State(server): Shared, Path(id): Path<String>) -> Result<StatusCode, Failure> {
    match server.calls.stops.all().get(&id) {
        Some(requested) => {
            requested.notify_one();
            Ok(StatusCode::NO_CONTENT)
        }
        None => Err(Failure::new(StatusCode::NOT_FOUND, "no call of this id is at work that can be stopped")),
    }
}
