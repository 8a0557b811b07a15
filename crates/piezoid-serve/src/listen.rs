//! Ports of the loopback interface, and the connections to them.

use axum::{Extension, Router};
use hyper::server::conn::http1::Builder;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use piezoid::Error;
use std::convert::Infallible;
use std::io::{self, ErrorKind};
use std::net::{Ipv4Addr, Ipv6Addr};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::Notify;

/// How many connections are open, if not more have shown the key.
const CONNECTIONS: usize = 300;

/// Most headers of a request, and their bytes together.
const HEADERS: usize = 64;
const HEADER_BYTES: usize = 1 << 16;

/// Attempts to find a port that is free for both versions of the protocol.
const ATTEMPTS: usize = 20;

/// Opens a port on 127.0.0.1, and on ::1 if this machine has it.
///
/// # Errors
/// Returns the reason, and what to do. A port that another program has on ::1 is in use too: `localhost` would lead
/// there.
pub(crate) async fn bind(port: u16) -> Result<(Vec<TcpListener>, u16), Error> {
    let mut attempts = if port == 0 { ATTEMPTS } else { 1 };
    loop {
        attempts -= 1;
        match both(port).await {
            Ok(bound) => return Ok(bound),
            Err(e) if e.kind() == ErrorKind::AddrInUse && attempts > 0 => {}
            Err(e) => return Err(Error::Content(message(port, &e))),
        }
    }
}

fn message(port: u16, error: &io::Error) -> String {
    let any = "give another --port, or --port 0 for any that is free";
    match error.kind() {
        ErrorKind::AddrInUse => format!(
            "port {port} is in use, perhaps by another `piezoid serve`: open the address that it printed, or {any}"
        ),
        _ => format!("port {port} cannot be opened: {error}: {any}"),
    }
}

async fn both(port: u16) -> io::Result<(Vec<TcpListener>, u16)> {
    let first = TcpListener::bind((Ipv4Addr::LOCALHOST, port)).await?;
    let port = first.local_addr()?.port();
    match TcpListener::bind((Ipv6Addr::LOCALHOST, port)).await {
        Ok(second) => Ok((vec![first, second], port)),
        Err(e) if e.kind() == ErrorKind::AddrInUse => Err(e),
        Err(_) => Ok((vec![first], port)),
    }
}

/// A connection. Where too many are open, the oldest that has not shown the key is closed: who has the key finds a
/// place, however many others open connections.
#[derive(Default)]
pub(crate) struct Place {
    has_key: AtomicBool,
    closed: Notify,
}

impl Place {
    /// A request on this connection had the key.
    pub(crate) fn shown(&self) {
        self.has_key.store(true, Ordering::Relaxed);
    }
}

/// The open connections, the oldest first.
#[derive(Clone, Default)]
struct Places(Arc<Mutex<Vec<Arc<Place>>>>);

impl Places {
    fn enter(&self) -> Arc<Place> {
        let mut all = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        if all.len() >= CONNECTIONS
            && let Some(oldest) = all.iter().position(|place| !place.has_key.load(Ordering::Relaxed))
        {
            all.remove(oldest).closed.notify_one();
        }
        let place = Arc::new(Place::default());
        all.push(place.clone());
        place
    }

    fn leave(&self, place: &Arc<Place>) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).retain(|other| !Arc::ptr_eq(other, place));
    }
}

/// Serves the connections to these ports.
pub(crate) async fn listen(listeners: Vec<TcpListener>, router: Router) -> Infallible {
    let places = Places::default();
    for listener in listeners {
        let (places, router) = (places.clone(), router.clone());
        tokio::spawn(async move {
            loop {
                match listener.accept().await {
                    Ok((stream, _)) => drop(tokio::spawn(connection(stream, router.clone(), places.clone()))),
                    // No file descriptor is left, for example.
                    Err(_) => tokio::time::sleep(Duration::from_millis(100)).await,
                }
            }
        });
    }
    std::future::pending().await
}

/// Answers the requests of a connection. Heads must arrive within 30 s.
async fn connection(stream: TcpStream, router: Router, places: Places) {
    drop(stream.set_nodelay(true));
    let place = places.enter();
    let mut server = Builder::new();
    server.timer(TokioTimer::new()).max_headers(HEADERS).max_buf_size(HEADER_BYTES);
    let service = TowerToHyperService::new(router.layer(Extension(place.clone())));
    tokio::select! {
        // A client that goes is no error.
        _ = server.serve_connection(TokioIo::new(stream), service) => {}
        () = place.closed.notified() => {}
    }
    places.leave(&place);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn a_port_in_use_is_an_error_that_says_what_to_do() {
        let (taken, port) = bind(0).await.unwrap();
        assert!(!taken.is_empty());
        let message = bind(port).await.unwrap_err().to_string();
        assert!(message.starts_with(&format!("port {port} is in use")) && message.contains("--port 0"), "{message}");
    }
}
