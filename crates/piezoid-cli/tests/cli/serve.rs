//! `piezoid serve`: the real server, as a browser and its user see it.
#![cfg(unix)]

use crate::bench::Bench;
use serde_json::{Value, json};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A server at work. It is ended with the test.
struct Server {
    child: Child,
    port: u16,
    key: String,
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Server {
    fn start(bench: &Bench) -> Self {
        Self::of(bench.command("serve project --port 0"))
    }

    fn of(mut command: Command) -> Self {
        let mut child = command.stdout(Stdio::piped()).spawn().unwrap();
        let mut lines = BufReader::new(child.stdout.take().unwrap()).lines().map(Result::unwrap);
        let folder = lines.next().unwrap();
        assert!(folder.ends_with("project at"), "{folder}");
        let address = lines.next().unwrap();
        assert_eq!(lines.next().unwrap(), "Ctrl-C ends");
        let (port, key) = address.trim().strip_prefix("http://127.0.0.1:").unwrap().split_once("/?key=").unwrap();
        Server { child, port: port.parse().unwrap(), key: key.into() }
    }

    /// A connection on which the request was sent.
    fn sent(&self, line: &str, body: &[u8]) -> TcpStream {
        let mut stream = TcpStream::connect(("127.0.0.1", self.port)).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(120))).unwrap();
        let Server { port, key, .. } = self;
        let kind = "Content-Type: application/octet-stream";
        let (host, length) = (format!("Host: 127.0.0.1:{port}"), format!("Content-Length: {}", body.len()));
        // Answers to this version are not cut into chunks, and end with the connection.
        let head = format!("{line} HTTP/1.0\r\n{host}\r\n{kind}\r\n{length}\r\nAuthorization: Bearer {key}\r\n\r\n");
        stream.write_all(&[head.as_bytes(), body].concat()).unwrap();
        stream
    }

    /// Status and body of the answer.
    fn ask(&self, line: &str, body: &[u8]) -> (u16, Vec<u8>) {
        let mut answer = Vec::new();
        self.sent(line, body).read_to_end(&mut answer).unwrap();
        let end = answer.windows(4).position(|four| four == b"\r\n\r\n").unwrap();
        let head = String::from_utf8_lossy(&answer[..end]);
        (head.split(' ').nth(1).unwrap().parse().unwrap(), answer[end + 4..].to_vec())
    }

    /// The lines of progress, and the packed answer.
    fn call(&self, request: &[u8]) -> (Vec<Value>, Vec<u8>) {
        let (status, body) = self.ask("POST /api/call", request);
        assert_eq!(status, 200, "{}", String::from_utf8_lossy(&body));
        let end = if body[0] == b'\n' { 0 } else { body.windows(2).position(|two| two == b"\n\n").unwrap() + 1 };
        let lines = String::from_utf8_lossy(&body[..end]);
        (lines.lines().map(|line| serde_json::from_str(line).unwrap()).collect(), body[end + 1..].to_vec())
    }

    /// Processes that the server started.
    #[cfg(target_os = "linux")]
    fn workers(&self) -> usize {
        let id = self.child.id();
        let children = std::fs::read_to_string(format!("/proc/{id}/task/{id}/children")).unwrap_or_default();
        children.split_whitespace().count()
    }
}

/// A packed request.
fn packed(mut request: Value, files: &[(&str, Vec<u8>)]) -> Vec<u8> {
    request["bytes"] = files.iter().map(|(name, bytes)| json!([name, bytes.len()])).collect();
    let mut head = request.to_string();
    head += &" ".repeat((head.len() + 4).next_multiple_of(8) - head.len() - 4);
    let mut packed = [&(head.len() as u32).to_le_bytes(), head.as_bytes()].concat();
    for (_, bytes) in files {
        packed.extend(bytes);
        packed.resize(packed.len().next_multiple_of(8), 0);
    }
    packed
}

fn identify(bench: &Bench, iterations: usize) -> Vec<u8> {
    let options = json!({"method": "paper", "iterations": iterations});
    let roles = json!({"small_signal": ["prbs.csv"], "large_signal": ["sine5.csv"]});
    let files = ["prbs.csv", "sine5.csv"].map(|name| (name, bench.bytes(name)));
    packed(json!({"call": "identify", "options": options, "files": roles}), &files)
}

#[test]
fn files_of_the_project_outlive_the_server() {
    let bench = Bench::new();
    {
        let server = Server::start(&bench);
        let (status, page) = server.ask("GET /", b"");
        assert!(status == 200 && String::from_utf8_lossy(&page).contains("data-library=\"server\""));
        assert_eq!(server.ask("PUT /api/files/log.csv", b"t_s,u_V,y_um\n0,0,0\n1,1,1\n").0, 201);
    }
    bench.write("project/.piezoid-upload-a1b2c3d4e5f6", "half of a fi");
    let server = Server::start(&bench);
    assert_eq!(server.ask("GET /api/files/log.csv", b""), (200, bench.bytes("project/log.csv")));
    assert_eq!(bench.names(), ["project/.piezoid-key", "project/.piezoid-lock", "project/log.csv"]);
    let port = server.port;
    let other = "another `piezoid serve` has the project folder";
    bench.run("serve project --port 0").exits(1).says(&[other, &format!(" at http://127.0.0.1:{port}/: use that one")]);
    bench.run(&format!("serve other --port {port}")).exits(1).says(&[&format!("port {port} is in use"), "--port 0"]);
    bench.write("file", "");
    bench.run("serve file --port 0").exits(1).says(&["the project folder", "cannot be used"]);
}

#[test]
fn answers_are_those_of_the_library_to_the_bit() {
    let (bench, library) = (Bench::stocked(), |request: &[u8]| {
        piezoid_operations::answered(request, &mut piezoid::progress::Stage::ignore)
    });
    let server = Server::start(&bench);
    let drive = ("drive5.csv", bench.bytes("drive5.csv"));
    let simulate = packed(json!({"call": "simulate", "files": {"input": ["drive5.csv"]}}), &[drive]);
    assert!(server.call(&simulate).1 == library(&simulate));
    let inspect =
        packed(json!({"call": "inspect", "files": {"data": ["a.csv"]}}), &[("a.csv", b"t_s,u_V,y_um\n0,0,1\n".into())]);
    assert!(server.call(&inspect).1 == library(&inspect));
    let identify = identify(&bench, 30);
    let (progress, answer) = server.call(&identify);
    assert!(answer == library(&identify));
    assert!(progress.iter().all(|stage| stage["done"].as_u64() <= stage["total"].as_u64() && stage["what"] != ""));
    assert!(!progress.is_empty());
    assert!(server.call(b"nonsense").1 == library(b"nonsense"));
}

#[test]
fn two_hundred_requests_at_once_are_answered() {
    let (bench, log) = (Bench::new(), b"t_s,u_V,y_um\n0,0,0.5\n1,1,2\n2,0,0.25\n".to_vec());
    let server = Server::start(&bench);
    let request = packed(json!({"call": "inspect", "files": {"data": ["a.csv"]}}), &[("a.csv", log)]);
    let expected = server.call(&request).1;
    let calls = |k: usize| loop {
        let (status, body) = match k % 2 {
            0 => server.ask("POST /api/call", &request),
            _ => server.ask(&format!("PUT /api/files/{k}.csv"), &request),
        };
        match status {
            // As a client does that reads Retry-After.
            503 => std::thread::sleep(Duration::from_millis(100)),
            200 => return assert!(body.ends_with(&expected)),
            status => return assert_eq!(status, 201),
        }
    };
    std::thread::scope(|scope| (0..200).for_each(|k| drop(scope.spawn(move || calls(k)))));
    let records = bench.names().into_iter().filter(|name| name.ends_with(".csv"));
    assert_eq!(records.count(), 100);
}

#[test]
#[cfg(target_os = "linux")]
fn work_ends_when_its_client_goes_and_when_the_server_is_killed() {
    let bench = Bench::stocked();
    let mut server = Server::start(&bench);
    let begun = |server: &Server| {
        let mut stream = server.sent("POST /api/call", &identify(&bench, 2_000_000));
        let mut text = Vec::new();
        while !text.windows(6).any(|part| part == b"\"what\"") {
            let mut piece = [0; 1000];
            let count = stream.read(&mut piece).unwrap();
            assert!(count > 0, "{}", String::from_utf8_lossy(&text));
            text.extend(&piece[..count]);
        }
        stream
    };
    let stream = begun(&server);
    assert_eq!(server.workers(), 1);
    drop(stream);
    let gone = Instant::now();
    while server.workers() > 0 {
        assert!(gone.elapsed() < Duration::from_secs(1));
        std::thread::sleep(Duration::from_millis(5));
    }
    let _stream = begun(&server);
    let id = server.child.id();
    let worker = std::fs::read_to_string(format!("/proc/{id}/task/{id}/children")).unwrap();
    server.child.kill().unwrap();
    server.child.wait().unwrap();
    let killed = Instant::now();
    while std::fs::read(format!("/proc/{}/cmdline", worker.trim())).is_ok_and(|line| !line.is_empty()) {
        assert!(killed.elapsed() < Duration::from_secs(1));
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn signals_end_the_server_and_its_work() {
    let bench = Bench::stocked();
    for signal in ["-INT", "-TERM", "-HUP"] {
        let mut server = Server::start(&bench);
        let mut stream = server.sent("POST /api/call", &identify(&bench, 2_000_000));
        stream.read_exact(&mut [0; 20]).unwrap();
        let _upload = half_sent(&server, &bench);
        let interrupted = Instant::now();
        assert!(Command::new("kill").args([signal, &server.child.id().to_string()]).status().unwrap().success());
        assert_eq!(server.child.wait().unwrap().code(), Some(0), "{signal}");
        assert!(interrupted.elapsed() < Duration::from_secs(1), "{:?}", interrupted.elapsed());
        let left: Vec<String> = bench.names().into_iter().filter(|name| name.starts_with("project/")).collect();
        assert_eq!(left, ["project/.piezoid-key", "project/.piezoid-lock"], "{signal}");
    }
}

/// An upload of which a part has arrived in the folder.
fn half_sent(server: &Server, bench: &Bench) -> TcpStream {
    let mut upload = TcpStream::connect(("127.0.0.1", server.port)).unwrap();
    let head = format!(
        "PUT /api/files/half.csv HTTP/1.1\r\nHost: 127.0.0.1:{}\r\nAuthorization: Bearer {}\r\n\
         Content-Type: application/octet-stream\r\nContent-Length: 1000\r\n\r\nhalf",
        server.port, server.key
    );
    upload.write_all(head.as_bytes()).unwrap();
    let arrives = || bench.names().iter().any(|name| name.starts_with("project/.piezoid-upload-"));
    (0..200).take_while(|_| !arrives()).for_each(|_| std::thread::sleep(Duration::from_millis(10)));
    assert!(arrives());
    upload
}

#[test]
fn what_a_killed_server_left_is_removed_at_the_next_start_and_no_other_file() {
    let bench = Bench::new();
    let mut server = Server::start(&bench);
    let _upload = half_sent(&server, &bench);
    server.child.kill().unwrap();
    server.child.wait().unwrap();
    bench.write("project/.piezoid-upload-notes", "a user's");
    let _next = Server::start(&bench);
    let uploads = |name: &String| name.starts_with("project/.piezoid-upload-");
    assert_eq!(bench.names().into_iter().filter(uploads).collect::<Vec<_>>(), ["project/.piezoid-upload-notes"]);
}

/// Only Linux shows what is ignored.
#[test]
#[cfg(target_os = "linux")]
fn a_server_that_was_started_by_nohup_outlasts_its_terminal() {
    let bench = Bench::new();
    let serve = bench.command("serve project --port 0");
    let mut shell = Command::new("sh");
    shell.args(["-c", "trap '' HUP; exec \"$0\" \"$@\""]).arg(serve.get_program()).args(serve.get_args());
    shell.current_dir(serve.get_current_dir().unwrap());
    let mut server = Server::of(shell);
    let kill = |signal: &str| Command::new("kill").args([signal, &server.child.id().to_string()]).status().unwrap();
    assert!(kill("-HUP").success());
    std::thread::sleep(Duration::from_millis(300));
    assert_eq!(server.ask("GET /api/health", b"").0, 200);
    assert!(kill("-TERM").success());
    assert_eq!(server.child.wait().unwrap().code(), Some(0));
}

#[test]
fn idle_connections_leave_room_for_who_has_the_key() {
    let bench = Bench::new();
    let server = Server::start(&bench);
    let idle: Vec<TcpStream> = (0..320).map(|_| TcpStream::connect(("127.0.0.1", server.port)).unwrap()).collect();
    let requested = Instant::now();
    assert_eq!(server.ask("GET /api/files", b"").0, 200);
    assert!(requested.elapsed() < Duration::from_secs(2), "{:?}", requested.elapsed());
    drop(idle);
}
