//! Errors as answers: a status, and `{"error": "..."}` in the style of the library.

use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde_json::{Value, json};
use std::io::{Error, ErrorKind};

/// Why a request is refused.
#[derive(Debug)]
pub(crate) struct Failure(pub(crate) StatusCode, pub(crate) String);

impl Failure {
    pub(crate) fn new(status: StatusCode, why: impl Into<String>) -> Self {
        Failure(status, why.into())
    }

    /// An error of the file system about a file or folder.
    pub(crate) fn of(what: &str, error: &Error) -> Self {
        let (status, why) = match error.kind() {
            ErrorKind::NotFound => (StatusCode::NOT_FOUND, "there is no such file".to_string()),
            ErrorKind::StorageFull | ErrorKind::QuotaExceeded | ErrorKind::FileTooLarge => (
                StatusCode::INSUFFICIENT_STORAGE,
                format!("{error}: nothing was changed; free some space, then try again"),
            ),
            ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
                (StatusCode::FORBIDDEN, format!("{error}: check the permissions of the project folder"))
            }
            _ => (StatusCode::INTERNAL_SERVER_ERROR, error.to_string()),
        };
        Failure(status, format!("{what}: {why}"))
    }
}

impl IntoResponse for Failure {
    fn into_response(self) -> Response {
        let mut response = (self.0, document(&json!({"error": self.1}))).into_response();
        let headers = response.headers_mut();
        if self.0 == StatusCode::SERVICE_UNAVAILABLE {
            headers.insert(header::RETRY_AFTER, HeaderValue::from_static("1"));
        }
        if self.0 == StatusCode::UNAUTHORIZED {
            headers.insert(header::WWW_AUTHENTICATE, HeaderValue::from_static("Bearer"));
        }
        response
    }
}

/// A JSON document as an answer.
pub(crate) fn document(value: &Value) -> Response {
    ([(header::CONTENT_TYPE, "application/json")], value.to_string()).into_response()
}
