//! Who may ask: pages and programs of this machine, no page of another site.
//!
//! - `Host` must name this machine and port: a name of another site that leads here (DNS rebinding) is refused.
//! - `Origin` must be the page itself, and `Sec-Fetch-Site` must not be another site, except for a link to the page.
//! - A body must be `application/octet-stream`, which no form can send (`body.rs`); no answer permits other sites to
//!   read it (CORS).
//! - What is under `/api` needs the key, which other users of this machine do not know.

use crate::Shared;
use crate::failure::Failure;
use crate::listen::Place;
use axum::extract::{Request, State};
use axum::http::{HeaderMap, HeaderValue, Method, StatusCode, header};
use axum::middleware::Next;
use axum::response::{IntoResponse, Response};
use std::sync::Arc;

/// Headers of every answer. The page loads nothing from elsewhere, and is part of no other page.
const HEADERS: [(&str, &str); 6] = [
    (
        "content-security-policy",
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data: blob:; font-src 'self'; \
         connect-src 'self'; worker-src 'self'; frame-src 'self' blob:; base-uri 'none'; form-action 'none'; \
         frame-ancestors 'none'",
    ),
    ("x-content-type-options", "nosniff"),
    ("referrer-policy", "no-referrer"),
    ("cross-origin-opener-policy", "same-origin"),
    ("cross-origin-resource-policy", "same-origin"),
    ("cache-control", "no-cache"),
];

/// Refuses requests of other sites, and adds [`HEADERS`] to answers.
pub(crate) async fn guard(State(server): Shared, request: Request, next: Next) -> Response {
    let mut response = match allowed(server.port, &request) {
        Ok(()) => next.run(request).await,
        Err(failure) => failure.into_response(),
    };
    for (name, value) in HEADERS {
        response.headers_mut().entry(name).or_insert(HeaderValue::from_static(value));
    }
    response
}

/// Refuses requests without the key.
pub(crate) async fn locked(State(server): Shared, request: Request, next: Next) -> Response {
    let arguments = text(request.headers(), "authorization").and_then(|value| value.strip_prefix("Bearer "));
    // Compared to the end: the time must not tell where they differ.
    let same = |arguments: &str| {
        let differ = arguments.bytes().zip(server.key.bytes()).fold(0, |differ, (a, b)| differ | (a ^ b));
        arguments.len() == server.key.len() && differ == 0
    };
    if arguments.is_some_and(same) {
        if let Some(place) = request.extensions().get::<Arc<Place>>() {
            place.shown();
        }
        return next.run(request).await;
    }
    let why = "the key is missing or wrong: open the address that `piezoid serve` printed; programs send its key as \
               `Authorization: Bearer KEY`";
    Failure::new(StatusCode::UNAUTHORIZED, why).into_response()
}

fn text<'a>(headers: &'a HeaderMap, name: &str) -> Option<&'a str> {
    headers.get(name).and_then(|value| value.to_str().ok())
}

fn allowed(port: u16, request: &Request) -> Result<(), Failure> {
    let (method, headers) = (request.method(), request.headers());
    let host = text(headers, "host").unwrap_or_default().to_ascii_lowercase();
    let name = host.strip_suffix(&format!(":{port}")).or((port == 80).then_some(&*host));
    let ours = ["localhost", "127.0.0.1", "[::1]"];
    if !name.is_some_and(|name| ours.contains(&name)) || headers.get_all(header::HOST).iter().count() != 1 {
        let why = format!("this is not the host `{host}`: open http://127.0.0.1:{port}/");
        return Err(Failure::new(StatusCode::MISDIRECTED_REQUEST, why));
    }
    let page = format!("http://{host}");
    let foreign = headers.get_all(header::ORIGIN).iter().any(|origin| origin.as_bytes() != page.as_bytes());
    let site = text(headers, "sec-fetch-site").unwrap_or("none");
    let link = *method == Method::GET
        && text(headers, "sec-fetch-mode") == Some("navigate")
        && !request.uri().path().starts_with("/api");
    if foreign || !(["none", "same-origin"].contains(&site) || link) {
        let why = format!("another site may not use piezoid: open http://127.0.0.1:{port}/ itself");
        return Err(Failure::new(StatusCode::FORBIDDEN, why));
    }
    Ok(())
}
