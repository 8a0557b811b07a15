//! The page, which is part of the program.

use crate::failure::Failure;
use crate::tags;
use axum::body::{Body, Bytes};
use axum::http::{HeaderMap, StatusCode, Uri, header};
use axum::response::{IntoResponse, Response};
use std::sync::LazyLock;

/// Name and content of each file of `page/`.
static FILES: &[(&str, &[u8])] = include!(concat!(env!("OUT_DIR"), "/page.rs"));

/// Types of contents by the ends of names.
const TYPES: [(&str, &str); 9] = [
    (".html", "text/html; charset=utf-8"),
    (".js", "text/javascript; charset=utf-8"),
    (".css", "text/css; charset=utf-8"),
    (".json", "application/json"),
    (".svg", "image/svg+xml"),
    (".png", "image/png"),
    (".ico", "image/x-icon"),
    (".woff2", "font/woff2"),
    (".webmanifest", "application/manifest+json"),
];

struct Content {
    name: &'static str,
    kind: &'static str,
    bytes: Bytes,
    tag: String,
}

static PAGE: LazyLock<Vec<Content>> = LazyLock::new(|| FILES.iter().map(content).collect());

/// A file as it is given: the page learns here that the library is that of the server.
fn content(&(name, bytes): &(&'static str, &'static [u8])) -> Content {
    let bytes = match std::str::from_utf8(bytes) {
        Ok(text) if name == "index.html" => {
            text.replace("data-library=\"browser\"", "data-library=\"server\"").into_bytes().into()
        }
        _ => Bytes::from_static(bytes),
    };
    let kind = TYPES.iter().find(|(end, _)| name.ends_with(end)).map_or("application/octet-stream", |(_, kind)| kind);
    Content { name, kind, tag: tags::tag_of(&bytes), bytes }
}

/// The file at a path of the page.
pub(crate) async fn page(uri: Uri, headers: HeaderMap) -> Result<Response, Failure> {
    let name = match uri.path().strip_prefix('/') {
        None | Some("") => "index.html",
        Some(name) => name,
    };
    let none = || Failure::new(StatusCode::NOT_FOUND, format!("the page has no `{name}`: open /"));
    let Content { kind, bytes, tag, .. } = PAGE.iter().find(|content| content.name == name).ok_or_else(none)?;
    let headers_of = [(header::CONTENT_TYPE, *kind), (header::ETAG, tag)];
    match tags::has(&headers, tag) {
        true => Ok((StatusCode::NOT_MODIFIED, [(header::ETAG, tag)]).into_response()),
        false => Ok((headers_of, Body::from(bytes.clone())).into_response()),
    }
}
