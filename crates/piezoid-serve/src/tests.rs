//! Tests of the router: who may ask, the page, the project folder, calls.

use crate::{Settings, router};
use axum::Router;
use axum::body::{Body, to_bytes};
use axum::http::{HeaderMap, Request, StatusCode};
use serde_json::Value;
use tempfile::TempDir;
use tower::ServiceExt;

const HOST: &str = "127.0.0.1:8642";

/// A server in a folder of its own; its work is that of a shell script.
struct Site {
    folder: TempDir,
    router: Router,
}

struct Answer {
    status: StatusCode,
    headers: HeaderMap,
    body: Vec<u8>,
}

impl Answer {
    fn header(&self, name: &str) -> &str {
        self.headers.get(name).map_or("", |value| value.to_str().unwrap())
    }

    fn json(&self) -> Value {
        assert_eq!(self.header("content-type"), "application/json");
        serde_json::from_slice(&self.body).unwrap()
    }

    /// Asserts that the request was refused, and the reason.
    fn refused(&self, status: u16, why: &str) {
        let message = self.json()["error"].as_str().unwrap().to_string();
        assert!(self.status == status && message.contains(why), "{} {message}", self.status);
    }
}

impl Site {
    fn new() -> Self {
        Site::working("exit 3")
    }

    fn working(script: &str) -> Self {
        let folder = tempfile::tempdir().unwrap();
        let worker = ("/bin/sh".into(), vec!["-c".into(), script.into()]);
        let settings = Settings { folder: folder.path().into(), port: 8642, limit: 1 << 20, worker };
        Site { folder, router: router(&settings, 8642, "key".into()) }
    }

    async fn send(&self, request: Request<Body>) -> Answer {
        let (parts, body) = self.router.clone().oneshot(request).await.unwrap().into_parts();
        let body = to_bytes(body, usize::MAX).await.unwrap().to_vec();
        Answer { status: parts.status, headers: parts.headers, body }
    }

    /// The answer to a request of the page, with other headers in place of its own; an empty one is left out.
    async fn ask(&self, line: &str, headers: &[(&str, &str)], body: impl Into<Vec<u8>>) -> Answer {
        let ((method, path), body) = (line.split_once(' ').unwrap(), body.into());
        let length = body.len().to_string();
        let usual = [
            ("host", HOST),
            ("authorization", "Bearer key"),
            ("content-type", if ["POST", "PUT"].contains(&method) { "application/octet-stream" } else { "" }),
            ("content-length", if ["POST", "PUT"].contains(&method) { &*length } else { "" }),
        ];
        let usual = usual.into_iter().filter(|(name, _)| headers.iter().all(|(other, _)| other != name));
        let mut request = Request::builder().method(method).uri(path);
        for (name, value) in usual.chain(headers.iter().copied()).filter(|(_, value)| !value.is_empty()) {
            request = request.header(name, value);
        }
        self.send(request.body(body.into()).unwrap()).await
    }

    async fn get(&self, path: &str, headers: &[(&str, &str)]) -> Answer {
        self.ask(&format!("GET {path}"), headers, "").await
    }

    fn names(&self) -> Vec<String> {
        let mut names: Vec<_> =
            self.folder.path().read_dir().unwrap().map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }
}

#[tokio::test]
async fn a_host_that_is_not_this_machine_is_refused() {
    let site = Site::new();
    for host in [HOST, "localhost:8642", "LOCALHOST:8642", "[::1]:8642"] {
        assert_eq!(site.get("/", &[("host", host)]).await.status, 200, "{host}");
    }
    for host in
        ["evil.example:8642", "127.0.0.1", "localhost:8643", "127.0.0.1.evil.example:8642", "x@localhost:8642", ""]
    {
        for path in ["/", "/api/health", "/api/files"] {
            site.get(path, &[("host", host)]).await.refused(421, "open http://127.0.0.1:8642/");
        }
    }
    let twice = Request::get("/").header("host", HOST).header("host", "evil.example").body(Body::empty()).unwrap();
    assert_eq!(site.send(twice).await.status, 421);
}

#[tokio::test]
async fn another_site_may_link_to_the_page_and_do_nothing_else() {
    let site = Site::new();
    for origin in
        ["http://evil.example", "http://127.0.0.1:3000", "https://127.0.0.1:8642", "http://localhost:8642", "null"]
    {
        for line in ["GET /api/files", "POST /api/call", "PUT /api/files/a.csv", "GET /"] {
            site.ask(line, &[("origin", origin)], "").await.refused(403, "another site");
        }
    }
    assert_eq!(site.get("/api/files", &[("origin", "http://127.0.0.1:8642")]).await.status, 200);
    for from in ["cross-site", "same-site"] {
        let link = [("sec-fetch-site", from), ("sec-fetch-mode", "navigate")];
        assert_eq!(site.get("/", &link).await.status, 200);
        site.get("/api/lists", &link).await.refused(403, "another site");
        site.ask("POST /", &link, "").await.refused(403, "another site");
        site.get("/", &[("sec-fetch-site", from), ("sec-fetch-mode", "no-cors")]).await.refused(403, "another site");
    }
    for from in ["same-origin", "none"] {
        assert_eq!(site.get("/api/lists", &[("sec-fetch-site", from)]).await.status, 200);
    }
    let requested = site.ask("OPTIONS /api/call", &[("origin", "http://127.0.0.1:8642")], "").await;
    requested.refused(405, "method");
    assert!(!requested.headers.keys().any(|name| name.as_str().starts_with("access-control")));
}

#[tokio::test]
async fn what_forms_can_send_is_refused() {
    let site = Site::new();
    for kind in ["text/plain", "application/x-www-form-urlencoded", "multipart/form-data", ""] {
        for line in ["POST /api/call", "PUT /api/files/a.csv"] {
            site.ask(line, &[("content-type", kind)], "x").await.refused(415, "send `application/octet-stream`");
        }
    }
    assert!(site.names().is_empty());
}

#[tokio::test]
async fn only_who_knows_the_key_may_use_the_interface() {
    let site = Site::new();
    for line in [
        "GET /api/files",
        "GET /api/lists",
        "POST /api/call",
        "DELETE /api/calls/a",
        "DELETE /api/files/a",
        "GET /api/openapi.json",
        "GET /api/x",
    ] {
        for key in ["", "Bearer ", "Bearer kez", "Bearer keyy", "Bearer ke", "Basic key", "key"] {
            let answer = site.ask(line, &[("authorization", key)], "").await;
            answer.refused(401, "open the address");
            assert_eq!(answer.header("www-authenticate"), "Bearer");
        }
    }
    for path in ["/", "/api/health"] {
        assert_eq!(site.get(path, &[("authorization", "")]).await.status, 200);
    }
}

#[tokio::test]
async fn the_page_is_safe_and_knows_who_serves_it() {
    let site = Site::new();
    let page = site.get("/", &[("authorization", "")]).await;
    assert_eq!(page.header("content-type"), "text/html; charset=utf-8");
    assert!(String::from_utf8(page.body.clone()).unwrap().contains("data-library=\"server\""));
    let policy = page.header("content-security-policy");
    assert!(policy.contains("default-src 'none'; script-src 'self'") && policy.contains("frame-ancestors 'none'"));
    for (name, value) in [
        ("x-content-type-options", "nosniff"),
        ("referrer-policy", "no-referrer"),
        ("cross-origin-opener-policy", "same-origin"),
        ("cross-origin-resource-policy", "same-origin"),
        ("cache-control", "no-cache"),
    ] {
        assert_eq!(page.header(name), value);
        assert_eq!(site.get("/api/lists", &[]).await.header(name), value);
    }
    let again = site.get("/index.html", &[("if-none-match", page.header("etag"))]).await;
    assert_eq!((again.status.as_u16(), again.body.len()), (304, 0));
    let head = site.ask("HEAD /", &[], "").await;
    assert_eq!((head.status.as_u16(), head.body.len(), head.header("etag")), (200, 0, page.header("etag")));
}

#[tokio::test]
async fn unknown_paths_and_methods_are_told() {
    let site = Site::new();
    for path in ["/x", "/../Cargo.toml", "/%2e%2e/x", "//", "/api/"] {
        site.get(path, &[]).await.refused(404, "the page has no");
    }
    for path in ["/api/x", "/api", "/api/files/", "/api/files/a/b"] {
        site.get(path, &[]).await.refused(404, "see /api/openapi.json");
    }
    for (line, allow) in [
        ("GET /api/call", "POST"),
        ("POST /api/files", "GET,HEAD"),
        ("POST /api/files/a.csv", "GET,HEAD,PUT,DELETE"),
        ("DELETE /api/health", "GET,HEAD"),
        ("POST /", "GET,HEAD"),
    ] {
        let answer = site.ask(line, &[], "").await;
        answer.refused(405, "method");
        assert_eq!(answer.header("allow"), allow, "{line}");
    }
}

#[tokio::test]
async fn the_interface_describes_itself() {
    let site = Site::new();
    let described = site.get("/api/openapi.json", &[]).await.json();
    assert_eq!(described["info"]["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(site.get("/api/lists", &[]).await.json(), serde_json::json!(piezoid_operations::catalogue()));
    assert_eq!(site.get("/api/health", &[]).await.json()["version"], env!("CARGO_PKG_VERSION"));
}

#[tokio::test]
async fn files_are_written_listed_read_and_deleted() {
    let site = Site::new();
    let bytes: Vec<u8> = (0..200_000u32).map(|k| (k % 251) as u8).collect();
    let result = site.ask("PUT /api/files/%C2%B5%20log.csv", &[], bytes.clone()).await;
    assert_eq!((result.status.as_u16(), result.body.len()), (201, 0));
    let listed = site.get("/api/files", &[]).await.json();
    assert_eq!((&listed[0]["name"], &listed[0]["size"]), (&"µ log.csv".into(), &200_000.into()));
    let read = site.get("/api/files/%C2%B5%20log.csv", &[]).await;
    assert!(read.body == bytes && read.header("etag") == result.header("etag"));
    assert_eq!(read.header("content-length"), "200000");
    assert_eq!(
        (read.header("content-type"), read.header("content-disposition")),
        ("application/octet-stream", "attachment")
    );
    assert!(read.header("content-security-policy").contains("sandbox"));
    let known = [("if-none-match", result.header("etag"))];
    assert_eq!(site.get("/api/files/%C2%B5%20log.csv", &known).await.status, 304);
    assert_eq!(site.ask("PUT /api/files/%C2%B5%20log.csv", &[], "new").await.status, 204);
    assert_eq!(site.ask("DELETE /api/files/%C2%B5%20log.csv", &[], "").await.status, 204);
    site.get("/api/files/%C2%B5%20log.csv", &[]).await.refused(404, "no file µ log.csv");
    site.ask("DELETE /api/files/%C2%B5%20log.csv", &[], "").await.refused(404, "no file");
    assert!(site.names().is_empty());
}

#[tokio::test]
async fn two_pages_do_not_overwrite_each_other() {
    let site = Site::new();
    let new = [("if-none-match", "*")];
    let first = site.ask("PUT /api/files/a.csv", &new, "one").await;
    site.ask("PUT /api/files/a.csv", &new, "two").await.refused(412, "another version of a.csv");
    let known = [("if-match", first.header("etag"))];
    assert_eq!(site.ask("PUT /api/files/a.csv", &known, "three").await.status, 204);
    site.ask("PUT /api/files/a.csv", &known, "four").await.refused(412, "another version of a.csv");
    site.ask("DELETE /api/files/a.csv", &known, "").await.refused(412, "another version of a.csv");
    site.ask("PUT /api/files/b.csv", &known, "five").await.refused(412, "deleted elsewhere");
    assert_eq!(
        (site.get("/api/files/a.csv", &[]).await.body, site.names()),
        (b"three".to_vec(), vec!["a.csv".to_string()])
    );
}

#[tokio::test]
async fn names_that_leave_the_folder_are_refused() {
    let site = Site::new();
    std::fs::write(site.folder.path().join(".piezoid-key"), "secret").unwrap();
    for (name, why) in [
        ("..", "begins with a dot"),
        ("%2e%2e", "begins with a dot"),
        ("..%2Fx", "'/'"),
        ("%2Fetc%2Fpasswd", "'/'"),
        ("..%5Cx", "'\\\\'"),
        (".piezoid-key", "begins with a dot"),
        ("a%00", "'\\0'"),
        ("nul.csv", "device"),
        ("%FF", "cannot be the name"),
    ] {
        for method in ["GET", "PUT", "DELETE"] {
            site.ask(&format!("{method} /api/files/{name}"), &[], "x").await.refused(400, why);
        }
    }
    assert_eq!(site.names(), [".piezoid-key"]);
    assert_eq!(site.get("/api/files", &[]).await.json(), serde_json::json!([]));
}

#[tokio::test]
#[cfg(unix)]
async fn links_and_folders_are_no_files_of_the_project() {
    let (site, outside) = (Site::new(), tempfile::tempdir().unwrap());
    let secret = outside.path().join("secret");
    std::fs::write(&secret, "secret").unwrap();
    std::os::unix::fs::symlink(&secret, site.folder.path().join("link")).unwrap();
    std::fs::create_dir(site.folder.path().join("folder")).unwrap();
    for line in ["GET", "PUT", "DELETE"].iter().flat_map(|m| ["link", "folder"].map(|n| format!("{m} /api/files/{n}")))
    {
        site.ask(&line, &[], "x").await.refused(409, "not an ordinary file");
    }
    assert_eq!(site.get("/api/files", &[]).await.json(), serde_json::json!([]));
    assert_eq!(
        (std::fs::read(&secret).unwrap(), site.names()),
        (b"secret".to_vec(), vec!["folder".into(), "link".into()])
    );
}

#[tokio::test]
async fn what_is_too_long_or_broken_off_changes_nothing() {
    let site = Site::new();
    site.ask("PUT /api/files/a.csv", &[], "old").await;
    let big = vec![0; (1 << 20) + 1];
    for line in ["PUT /api/files/a.csv", "POST /api/call"] {
        site.ask(line, &[], big.clone()).await.refused(413, "the limit of 1.0 MiB");
        site.ask(line, &[("content-length", "")], "new").await.refused(411, "Content-Length");
        site.ask(line, &[("content-length", "7")], "new").await.refused(400, "3 bytes, but states 7");
        site.ask(line, &[("content-length", "-7")], "new").await.refused(411, "Content-Length");
    }
    assert_eq!(
        (site.get("/api/files/a.csv", &[]).await.body, site.names()),
        (b"old".to_vec(), vec!["a.csv".to_string()])
    );
}

#[tokio::test]
#[cfg(unix)]
async fn a_call_gives_what_its_process_prints() {
    // The length of the request, the request, and back.
    let site = Site::working("head -c 8 | od -An -tu1 | tr -d '\\n '; printf '{}\\n\\n'; head -c 3");
    let answer = site.ask("POST /api/call", &[], "ABC").await;
    assert_eq!((answer.status.as_u16(), &*answer.body), (200, &b"30000000{}\n\nABC"[..]));
    let site = Site::working("printf '{}\\n\\nanswer'");
    assert_eq!(site.ask("POST /api/call", &[], vec![0; 1 << 20]).await.body, b"{}\n\nanswer");
}

#[tokio::test]
#[cfg(unix)]
async fn a_process_that_dies_is_an_answer_with_an_error() {
    for (script, why) in [("kill -9 $$", "signal: 9"), ("echo '{}'; exit 3", "exit status: 3")] {
        let answer = Site::working(script).ask("POST /api/call", &[], "ABC").await;
        let text = String::from_utf8_lossy(&answer.body);
        assert!(answer.status == 200 && text.contains("{\"error\":\"the work ended without an answer"), "{text}");
        assert!(text.contains(why) && text.contains("\n"), "{text}");
    }
    // An answer that breaks off is no answer.
    let site = Site::working("printf '\\nhalf'; kill -9 $$");
    let answer = site.router.clone().oneshot(call("")).await.unwrap();
    assert!(to_bytes(answer.into_body(), usize::MAX).await.is_err());
}

/// A process that prints its number and then hangs, unless the request is another.
const HANGS: &str = "head -c 8 >/dev/null; [ $(head -c 4) = hang ] && echo $$ && exec sleep 600; printf '\\nok'";

/// Waits until this holds, for so long at most [ms].
async fn until(limit: u64, holds: impl Fn() -> bool) {
    let waits = async {
        while !holds() {
            tokio::time::sleep(std::time::Duration::from_millis(2)).await;
        }
    };
    tokio::time::timeout(std::time::Duration::from_millis(limit), waits).await.unwrap();
}

fn call(body: &'static str) -> Request<Body> {
    let request = Request::post("/api/call").header("host", HOST).header("authorization", "Bearer key");
    let request = request.header("content-type", "application/octet-stream").header("content-length", body.len());
    request.body(body.into()).unwrap()
}

#[tokio::test]
#[cfg(target_os = "linux")]
async fn a_call_that_hangs_ends_when_its_client_goes() {
    let site = Site::working(HANGS);
    let mut body = site.router.clone().oneshot(call("hang")).await.unwrap().into_body();
    let pid = http_body_util::BodyExt::frame(&mut body).await.unwrap().unwrap().into_data().unwrap();
    let process = format!("/proc/{}/cmdline", String::from_utf8_lossy(&pid).trim());
    let runs = || std::fs::read(&process).is_ok_and(|line| !line.is_empty());
    // While the shell becomes another program, its line is empty.
    until(2000, runs).await;
    drop(body);
    until(200, || !runs()).await;
}

#[tokio::test]
#[cfg(unix)]
async fn a_call_that_moves_an_instrument_is_stopped_and_still_answers() {
    // A process that goes on until its input ends.
    let site = Site::working("cat > /dev/null; printf '\\nthe axis is at 3 V'");
    let send = |call: &'static str, id: &'static str| {
        let (head, router) = (format!("{{\"call\":\"{call}\"}}"), site.router.clone());
        let body = [&(head.len() as u32).to_le_bytes()[..], head.as_bytes()].concat();
        let request = Request::post("/api/call").header("host", HOST).header("authorization", "Bearer key");
        let request = request.header("content-type", "application/octet-stream").header("piezoid-call", id);
        let request = request.header("content-length", body.len()).body(Body::from(body)).unwrap();
        tokio::spawn(async move { to_bytes(router.oneshot(request).await.unwrap().into_body(), usize::MAX).await })
    };
    let (moving, other) = (send("acquire", "one"), send("inspect", "two"));
    let stopped = async |id: &str| site.ask(&format!("DELETE /api/calls/{id}"), &[], "").await.status.as_u16();
    let begin = std::time::Instant::now();
    while stopped("one").await != 204 && begin.elapsed().as_secs() < 30 {
        tokio::time::sleep(std::time::Duration::from_millis(5)).await;
    }
    assert_eq!(moving.await.unwrap().unwrap(), &b"\nthe axis is at 3 V"[..]);
    site.ask("DELETE /api/calls/two", &[], "").await.refused(404, "no call of this id");
    assert!(!other.is_finished());
    other.abort();
    assert_eq!(stopped("one").await, 404);
}

#[tokio::test]
#[cfg(unix)]
async fn too_many_calls_are_refused_until_some_end() {
    let site = Site::working(HANGS);
    let cores = std::thread::available_parallelism().unwrap().get();
    let calls: Vec<_> = (0..cores + 32).map(|_| tokio::spawn(site.router.clone().oneshot(call("hang")))).collect();
    until(60_000, || calls.iter().filter(|call| call.is_finished()).count() >= cores).await;
    let refused = site.ask("POST /api/call", &[], "easy").await;
    refused.refused(503, "32 calls wait already");
    assert_eq!(refused.header("retry-after"), "1");
    assert_eq!(site.get("/api/lists", &[]).await.status, 200);
    // The waiting ones go first, because one that ends makes room for one of them.
    for call in calls.into_iter().rev() {
        call.abort();
        drop(call.await);
    }
    let answer = site.ask("POST /api/call", &[], "easy").await;
    assert_eq!((answer.status.as_u16(), &*answer.body), (200, &b"\nok"[..]));
}
