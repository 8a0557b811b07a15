//! `piezoid serve`: the page of piezoid for the users of this machine, with native speed and a project folder on disk.
//!
//! ```text
//! GET    /                     the page, which is part of the program
//! POST   /api/call             a packed request -> lines of progress, an empty line, the packed answer
//! DELETE /api/calls/{id}       stops a call that moves an instrument; its answer still comes
//! GET    /api/files            the project folder: names, sizes, times of change
//! GET    /api/files/{name}     a file; PUT and DELETE take If-Match and If-None-Match
//! GET    /api/lists            what menus and forms need
//! GET    /api/openapi.json     all of this for programs
//! GET    /api/health           the version, and a proof that this server has the key
//! ```
//! Every call runs in a process of its own ([`answer`]): it is ended when its client goes, whatever it does, and a
//! fault in it ends neither the server nor other calls. Packed requests and answers are those of `piezoid_operations`.

mod body;
mod calls;
mod failure;
mod files;
mod guard;
mod key;
mod listen;
mod lock;
mod names;
mod page;
mod stops;
mod tags;
#[cfg(test)]
mod tests;
mod worker;

pub use worker::answer;

use axum::Router;
use axum::http::{StatusCode, header};
use axum::middleware::from_fn_with_state;
use axum::routing::{delete, get, post};
use failure::{Failure, document};
use lock::Lock;
use piezoid::Error;
use piezoid_host::temporary;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Duration;

/// What is served, and where.
#[derive(Debug, Clone)]
pub struct Settings {
    /// The project folder; it is created if it does not exist.
    pub folder: PathBuf,
    /// The port on the loopback interface; 0 is any free one.
    pub port: u16,
    /// Largest request and largest file [bytes].
    pub limit: u64,
    /// A program that calls [`answer`], and its arguments.
    pub worker: (PathBuf, Vec<String>),
}

/// The state of the server.
struct Server {
    port: u16,
    key: String,
    limit: u64,
    folder: files::Folder,
    calls: calls::Calls,
}

/// The state of the server, as a request gets it.
type Shared = axum::extract::State<Arc<Server>>;

/// How long file operations may go on when the server ends.
const GRACE: Duration = Duration::from_millis(700);

/// Serves until a signal that asks to end. `ready` gets the address of the page, with its key.
///
/// # Errors
/// Returns the reason why the folder cannot be used, for example by another server, or why the port cannot be opened,
/// and what to do.
pub fn serve(settings: &Settings, ready: impl FnOnce(&str)) -> Result<(), Error> {
    let failed = |e: std::io::Error| Error::Content(format!("the server cannot start: {e}"));
    let runtime = tokio::runtime::Builder::new_current_thread().max_blocking_threads(8).enable_all().build();
    let runtime = runtime.map_err(failed)?;
    let served = runtime.block_on(async {
        let (mut lock, key) = prepared(&settings.folder)?;
        let (listeners, port) = listen::bind(settings.port).await?;
        let address = format!("http://127.0.0.1:{port}/?key={key}");
        lock.tell(&format!("http://127.0.0.1:{port}/"));
        let router = router(settings, port, key);
        let ended = ended().map_err(failed)?;
        ready(&address);
        tokio::select! {
            never = listen::listen(listeners, router) => match never {},
            () = ended => {}
        }
        Ok(lock)
    });
    // Ends connections, and with them calls. A file that is being replaced is replaced.
    runtime.shutdown_timeout(GRACE);
    served.map(drop)
}

/// Waits for a signal that asks to end, except those that `nohup` has this process ignore; signals are handled from the
/// call on.
#[cfg(unix)]
fn ended() -> std::io::Result<impl Future<Output = ()>> {
    use tokio::signal::unix::{SignalKind, signal};
    let kinds = [SignalKind::interrupt(), SignalKind::terminate(), SignalKind::hangup()];
    let heard = kinds.into_iter().filter(|kind| !piezoid_host::signals::is_ignored(kind.as_raw_value()));
    let mut heard = heard.map(signal).collect::<Result<Vec<_>, _>>()?;
    Ok(std::future::poll_fn(move |context| {
        let came = |signal: &mut tokio::signal::unix::Signal| signal.poll_recv(context).is_ready();
        match heard.iter_mut().any(came) {
            true => std::task::Poll::Ready(()),
            false => std::task::Poll::Pending,
        }
    }))
}

/// Waits for Ctrl-C; it is handled from the call on.
#[cfg(windows)]
fn ended() -> std::io::Result<impl Future<Output = ()>> {
    let mut interrupt = tokio::signal::windows::ctrl_c()?;
    Ok(async move { drop(interrupt.recv().await) })
}

/// Makes the project folder, locks it, and removes what servers left that were ended by force; a new key for it.
fn prepared(folder: &Path) -> Result<(Lock, String), Error> {
    let failed = |e| Error::Content(format!("the project folder {} cannot be used: {e}", folder.display()));
    std::fs::create_dir_all(folder).map_err(failed)?;
    let lock = Lock::of(folder)?;
    if lock.is_held() {
        temporary::sweep_uploads(folder);
    }
    temporary::sweep_files(folder);
    Ok((lock, key::key(folder).map_err(failed)?))
}

/// What answers requests.
fn router(settings: &Settings, port: u16, key: String) -> Router {
    let Settings { folder, limit, worker, .. } = settings;
    let folder = files::Folder::new(folder.clone());
    let server =
        Arc::new(Server { port, key, limit: *limit, folder, calls: calls::Calls::new(worker.clone(), *limit) });
    let unknown = || async { Failure::new(StatusCode::NOT_FOUND, "there is no such path: see /api/openapi.json") };
    let misused = || async { Failure::new(StatusCode::METHOD_NOT_ALLOWED, "this path does not take this method") };
    let api = Router::new()
        .route("/call", post(calls::call))
        .route("/calls/{id}", delete(stops::stop))
        .route("/files", get(files::list))
        .route("/files/{name}", get(files::read).put(files::write).delete(files::remove))
        .route("/lists", get(|| async { document(&serde_json::json!(piezoid_operations::catalogue())) }))
        .route("/openapi.json", get(described))
        .fallback(unknown)
        .method_not_allowed_fallback(misused)
        .layer(from_fn_with_state(server.clone(), guard::locked));
    Router::new()
        .route("/api/health", get(key::health))
        .nest("/api", api)
        .fallback_service(get(page::page).fallback(misused))
        .method_not_allowed_fallback(misused)
        .layer(from_fn_with_state(server.clone(), guard::guard))
        .with_state(server)
}

/// The interface as an OpenAPI document.
async fn described() -> impl axum::response::IntoResponse {
    let text = include_str!("openapi.json").replace("VERSION", env!("CARGO_PKG_VERSION"));
    ([(header::CONTENT_TYPE, "application/json")], text)
}
