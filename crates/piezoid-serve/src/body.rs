//! Bodies of requests, which come in pieces.

use crate::failure::Failure;
use axum::body::{Body, Bytes};
use axum::http::{HeaderMap, StatusCode};
use http_body_util::BodyExt;
use std::time::Duration;
use tokio::time::timeout;

/// How long is waited for a piece, and for a client to take one.
pub(crate) const PATIENCE: Duration = Duration::from_secs(30);

/// The length of the body, which the request must state; an error if it is larger than the limit, or of another type
/// than `application/octet-stream`: forms can send others.
pub(crate) async fn length(headers: &HeaderMap, body: &mut Body, limit: u64) -> Result<u64, Failure> {
    let kind = headers.get("content-type").map_or(&[][..], |value| value.as_bytes());
    if kind != b"application/octet-stream" {
        let why = format!("the content type is `{}`: send `application/octet-stream`", String::from_utf8_lossy(kind));
        return Err(Failure::new(StatusCode::UNSUPPORTED_MEDIA_TYPE, why));
    }
    let stated = headers.get("content-length").and_then(|value| value.to_str().ok()?.parse().ok());
    let unknown = "the length of the body is not stated: send `Content-Length`";
    let stated = stated.ok_or_else(|| Failure::new(StatusCode::LENGTH_REQUIRED, unknown))?;
    if stated <= limit {
        return Ok(stated);
    }
    // A browser reads the answer only when it has sent everything.
    while matches!(piece(body).await, Ok(Some(_))) {}
    let [stated, limit] = [stated, limit].map(|bytes| format!("{:.1} MiB", bytes as f64 / (1 << 20) as f64));
    let why = format!("{stated} are more than the limit of {limit}: start `piezoid serve` with a larger --limit");
    Err(Failure::new(StatusCode::PAYLOAD_TOO_LARGE, why))
}

/// The next piece; `None` at the end.
pub(crate) async fn piece(body: &mut Body) -> Result<Option<Bytes>, Failure> {
    within(PATIENCE, body).await
}

async fn within(patience: Duration, body: &mut Body) -> Result<Option<Bytes>, Failure> {
    loop {
        let frame = timeout(patience, body.frame()).await.map_err(|_| {
            let why = format!("nothing was sent for {} s: send the request again", patience.as_secs_f64());
            Failure::new(StatusCode::REQUEST_TIMEOUT, why)
        })?;
        let Some(frame) = frame else { return Ok(None) };
        let frame = frame.map_err(|e| Failure::new(StatusCode::BAD_REQUEST, format!("the request ends early: {e}")))?;
        // Trailers are of no interest.
        if let Ok(piece) = frame.into_data() {
            return Ok(Some(piece));
        }
    }
}

/// The error if a body has another length than it states.
pub(crate) fn whole(stated: u64, received: u64) -> Result<(), Failure> {
    let why = || format!("the request has {received} bytes, but states {stated}: send it again");
    if stated == received { Ok(()) } else { Err(Failure::new(StatusCode::BAD_REQUEST, why())) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn an_upload_that_pauses_for_too_long_is_ended() {
        let never = futures_util::stream::pending::<Result<Bytes, std::io::Error>>();
        let Failure(status, why) = within(Duration::from_millis(10), &mut Body::from_stream(never)).await.unwrap_err();
        assert_eq!((status.as_u16(), &*why), (408, "nothing was sent for 0.01 s: send the request again"));
        assert_eq!(within(PATIENCE, &mut Body::from("abc")).await.unwrap().unwrap(), "abc");
        assert_eq!(within(PATIENCE, &mut Body::empty()).await.unwrap(), None);
    }
}
