//! Ports of the loopback interface, and the connections to them.

use axum::Router;
use hyper::server::conn::http1::Builder;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use piezoid::Error;
use std::convert::Infallible;
use std::io::{self, ErrorKind};
use std::net::{Ipv4Addr, Ipv6Addr};
use std::sync::Arc;
use std::time::Duration;
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::Semaphore;

/// How many connections are open; others wait.
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
            Err(e) => return Err(Error::Content(told(port, &e))),
        }
    }
}

fn told(port: u16, error: &io::Error) -> String {
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

/// Serves the connections to these ports.
pub(crate) async fn listen(listeners: Vec<TcpListener>, router: Router) -> Infallible {
    let places = Arc::new(Semaphore::new(CONNECTIONS));
    for listener in listeners {
        let (places, router) = (places.clone(), router.clone());
        tokio::spawn(async move {
            while let Ok(place) = places.clone().acquire_owned().await {
                let router = router.clone();
                match listener.accept().await {
                    Ok((stream, _)) => drop(tokio::spawn(async move {
                        connection(stream, router).await;
                        drop(place);
                    })),
                    // No file descriptor is left, for example.
                    Err(_) => tokio::time::sleep(Duration::from_millis(100)).await,
                }
            }
        });
    }
    std::future::pending().await
}

/// Answers the requests of a connection. Heads must arrive within 30 s.
async fn connection(stream: TcpStream, router: Router) {
    drop(stream.set_nodelay(true));
    let mut server = Builder::new();
    server.timer(TokioTimer::new()).max_headers(HEADERS).max_buf_size(HEADER_BYTES);
    // A client that goes is no error.
    drop(server.serve_connection(TokioIo::new(stream), TowerToHyperService::new(router)).await);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn a_port_in_use_is_an_error_that_says_what_to_do() {
        let (taken, port) = bind(0).await.unwrap();
        assert!(!taken.is_empty());
        let told = bind(port).await.unwrap_err().to_string();
        assert!(told.starts_with(&format!("port {port} is in use")) && told.contains("--port 0"), "{told}");
    }
}
