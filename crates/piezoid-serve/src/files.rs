//! The project folder: ordinary files, whole or absent. Versions keep two pages from overwriting each other's changes.

use crate::failure::{Failure, document};
use crate::{Server, Shared, body, names, tags};
use axum::body::Body;
use axum::extract::rejection::PathRejection;
use axum::extract::{Path as Segment, Request, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use futures_util::stream::unfold;
use piezoid_host::temporary;
use serde_json::{Value, json};
use sha2::{Digest, Sha256};
use std::fs::File;
use std::io::{Error, Read, Seek};
use std::path::{Path, PathBuf};
use std::time::UNIX_EPOCH;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::sync::Mutex;

/// Bytes of a piece.
const PIECE: usize = 1 << 16;

/// The project folder.
pub(crate) struct Folder {
    path: PathBuf,
    /// Held while a version is compared and the file replaced.
    change: Mutex<()>,
}

impl Folder {
    pub(crate) fn new(path: PathBuf) -> Self {
        Folder { path, change: Mutex::new(()) }
    }
}

type Name = Result<Segment<String>, PathRejection>;

/// Name and path of a file that may be in the folder.
fn named(server: &Server, name: Name) -> Result<(String, PathBuf), Failure> {
    let bad = |why: String| Failure::new(StatusCode::BAD_REQUEST, why);
    let Segment(name) = name.map_err(|e| bad(format!("this cannot be the name of a file: {e}")))?;
    match names::fault(&name) {
        Some(why) => Err(bad(why)),
        None => Ok((name.clone(), server.folder.path.join(name))),
    }
}

/// Runs work that waits for the disk.
async fn blocking<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> Result<T, Failure> {
    let ended = |e| Failure::new(StatusCode::INTERNAL_SERVER_ERROR, format!("the server failed: {e}"));
    tokio::task::spawn_blocking(work).await.map_err(ended)
}

/// The file, with its length and tag; `None` if there is none. A link is none of the folder.
fn opened(path: &Path, name: &str) -> Result<Option<(File, u64, String)>, Failure> {
    match std::fs::symlink_metadata(path) {
        Ok(what) if !what.is_file() => {
            let why = format!("{name} is not an ordinary file: choose another name");
            return Err(Failure::new(StatusCode::CONFLICT, why));
        }
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        _ => {}
    }
    let hashed = || -> Result<_, Error> {
        let (mut file, mut hash, mut length, mut piece) = (File::open(path)?, Sha256::new(), 0, vec![0; PIECE]);
        loop {
            match file.read(&mut piece)? {
                0 => break,
                count => {
                    hash.update(&piece[..count]);
                    length += count as u64;
                }
            }
        }
        file.rewind()?;
        Ok((file, length, tags::tag(hash)))
    };
    hashed().map(Some).map_err(|e| Failure::of(name, &e))
}

/// Compares the version that is there with the one that the sender knows. True if there is one.
fn permitted(path: &Path, name: &str, headers: &HeaderMap) -> Result<bool, Failure> {
    let present = opened(path, name)?.map(|(.., tag)| tag);
    if !tags::permits(headers, present.as_deref()) {
        let why = match present {
            Some(_) => format!("the project folder has another version of {name}, not overwritten: read it again"),
            None => format!("{name} was deleted elsewhere: write it as a new file"),
        };
        return Err(Failure::new(StatusCode::PRECONDITION_FAILED, why));
    }
    Ok(present.is_some())
}

fn tagged(status: StatusCode, tag: &str) -> Response {
    (status, [(header::ETAG, tag)]).into_response()
}

/// The ordinary files of the folder, by name.
pub(crate) async fn list(State(server): Shared) -> Result<Response, Failure> {
    let listed = move || -> Result<Vec<Value>, Error> {
        let mut rows = Vec::new();
        for entry in std::fs::read_dir(&server.folder.path)? {
            let entry = entry?;
            // Files that go while they are listed are not listed.
            let (Ok(name), Ok(what)) = (entry.file_name().into_string(), entry.metadata()) else { continue };
            if !what.is_file() || names::fault(&name).is_some() {
                continue;
            }
            let changed = what.modified().ok().and_then(|time| time.duration_since(UNIX_EPOCH).ok());
            rows.push((name, what.len(), changed.map_or(0, |since| since.as_millis() as u64)));
        }
        rows.sort();
        Ok(rows.iter().map(|(name, size, changed)| json!({"name": name, "size": size, "changed": changed})).collect())
    };
    let rows = blocking(listed).await?.map_err(|e| Failure::of("the project folder cannot be listed", &e))?;
    Ok(document(&rows.into()))
}

/// A file of the folder. It is never shown in the page's place: it may be a page itself.
pub(crate) async fn read(State(server): Shared, name: Name, headers: HeaderMap) -> Result<Response, Failure> {
    let (name, path) = named(&server, name)?;
    let none = Failure::new(StatusCode::NOT_FOUND, format!("the project folder has no file {name}"));
    let (file, length, tag) = blocking(move || opened(&path, &name)).await??.ok_or(none)?;
    if tags::has(&headers, &tag) {
        return Ok(tagged(StatusCode::NOT_MODIFIED, &tag));
    }
    let file = tokio::fs::File::from_std(file).take(length);
    let pieces = unfold(file, async |mut file| {
        let mut piece = Vec::with_capacity(PIECE);
        let read = file.read_buf(&mut piece).await;
        (!matches!(read, Ok(0))).then(|| (read.map(|_| piece), file))
    });
    let mut response = (tagged(StatusCode::OK, &tag).into_parts().0, Body::from_stream(pieces)).into_response();
    let own = [
        (header::CONTENT_TYPE, "application/octet-stream"),
        (header::CONTENT_DISPOSITION, "attachment"),
        (header::CONTENT_SECURITY_POLICY, "default-src 'none'; sandbox"),
    ];
    response.headers_mut().extend(own.map(|(name, value)| (name, HeaderValue::from_static(value))));
    response.headers_mut().insert(header::CONTENT_LENGTH, length.into());
    Ok(response)
}

/// Writes a file beside its place, and then renames it.
pub(crate) async fn write(State(server): Shared, name: Name, request: Request) -> Result<Response, Failure> {
    let (name, path) = named(&server, name)?;
    let (parts, mut body) = request.into_parts();
    let stated = body::length(&parts.headers, &mut body, server.limit).await?;
    let failed = |e: Error| Failure::of(&name, &e);
    let (folder, message) = (server.folder.path.clone(), name.clone());
    let staged = blocking(move || {
        let staged = temporary::upload(&folder)?;
        Ok::<_, Error>((staged.as_file().try_clone()?, staged))
    });
    let (file, staged) = staged.await?.map_err(failed)?;
    let (mut file, mut hash, mut received) = (tokio::fs::File::from_std(file), Sha256::new(), 0);
    while let Some(piece) = body::piece(&mut body).await? {
        hash.update(&piece);
        received += piece.len() as u64;
        file.write_all(&piece).await.map_err(failed)?;
    }
    body::whole(stated, received)?;
    file.flush().await.map_err(failed)?;
    file.sync_all().await.map_err(failed)?;
    drop(file);
    let changing = server.folder.change.lock().await;
    let placed = move || {
        let there = permitted(&path, &message, &parts.headers)?;
        staged.persist(&path).map_err(|e| Failure::of(&message, &e.error))?;
        // The new name is on disk too.
        #[cfg(unix)]
        if let Some(folder) = path.parent() {
            File::open(folder).and_then(|folder| folder.sync_all()).map_err(|e| Failure::of(&message, &e))?;
        }
        Ok::<_, Failure>(if there { StatusCode::NO_CONTENT } else { StatusCode::CREATED })
    };
    let status = blocking(placed).await??;
    drop(changing);
    Ok(tagged(status, &tags::tag(hash)))
}

/// Deletes a file.
pub(crate) async fn remove(State(server): Shared, name: Name, headers: HeaderMap) -> Result<Response, Failure> {
    let (name, path) = named(&server, name)?;
    let changing = server.folder.change.lock().await;
    let removed = move || {
        if !permitted(&path, &name, &headers)? {
            return Err(Failure::new(StatusCode::NOT_FOUND, format!("the project folder has no file {name}")));
        }
        std::fs::remove_file(&path).map_err(|e| Failure::of(&name, &e))
    };
    blocking(removed).await??;
    drop(changing);
    Ok(StatusCode::NO_CONTENT.into_response())
}
