//! Clients of the controller over TCP.

use crate::measuring::served;
use crate::simulated::{Model, Simulation};
use std::io::{BufRead, BufReader, Read, Write};
use std::net::{Shutdown, TcpStream};
use std::time::{Duration, Instant};

/// So long must nothing take, even on a machine that is busy.
const GENEROUS: Duration = Duration::from_secs(30);

fn connected(port: u16) -> TcpStream {
    let stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
    stream.set_read_timeout(Some(GENEROUS)).unwrap();
    stream
}

fn line(stream: &TcpStream) -> String {
    let mut line = String::new();
    BufReader::new(stream).read_line(&mut line).unwrap();
    line
}

#[test]
fn sixty_four_clients_are_served_at_once_and_the_next_one_is_refused_with_a_word() {
    let port = served(&Simulation::default());
    let begin = Instant::now();
    let clients: Vec<TcpStream> = (0..64).map(|_| connected(port)).collect();
    for mut client in &clients {
        client.write_all(b"CSV?\n").unwrap();
    }
    assert!(clients.iter().all(|client| line(client) == "2.0\n"));
    let (mut refused, mut text) = (connected(port), String::new());
    refused.write_all(b"CSV?\n").unwrap();
    refused.read_to_string(&mut text).unwrap();
    assert_eq!(text, "the controller serves 64 at a time: end the other program, then connect again\n");
    drop(clients);
    let mut again = connected(port);
    again.write_all(b"CSV?\n").unwrap();
    assert_eq!(line(&again), "2.0\n");
    assert!(begin.elapsed() < GENEROUS);
}

#[test]
fn a_serial_line_serves_one_client_at_a_time() {
    let port = served(&Simulation { model: Model::E709, ..Simulation::default() });
    for _ in 0..20 {
        // One after the other, as fast as they can.
        let mut client = connected(port);
        client.write_all(b"CSV?\n").unwrap();
        assert_eq!(line(&client), "2.0\n");
        client.shutdown(Shutdown::Both).unwrap();
    }
    let mut first = connected(port);
    first.write_all(b"CSV?\n").unwrap();
    assert_eq!(line(&first), "2.0\n");
    let begin = Instant::now();
    assert!(line(&connected(port)).starts_with("the controller serves 1 at a time"));
    assert!(begin.elapsed() < GENEROUS);
    first.write_all(b"CSV?\n").unwrap();
    assert_eq!(line(&first), "2.0\n");
}

#[test]
fn clients_that_are_idle_never_read_or_send_no_end_of_line_hold_no_others() {
    let port = served(&Simulation::default());
    let idle = connected(port);
    let never = connected(port);
    never.set_write_timeout(Some(Duration::from_millis(200))).unwrap();
    // Until the controller takes no more, because its answers are not read.
    let question = "HLP?\n".repeat(1000);
    while (&never).write_all(question.as_bytes()).is_ok() {}
    let mut endless = connected(port);
    for _ in 0..64 {
        endless.write_all(&[b'7'; 1 << 20]).unwrap();
    }
    let begin = Instant::now();
    let mut client = connected(port);
    client.write_all(b"CSV?\n").unwrap();
    assert_eq!(line(&client), "2.0\n");
    assert!(begin.elapsed() < Duration::from_secs(3), "{:?}", begin.elapsed());
    // The rest of a long line is no command, and its error is that of a long line.
    endless.write_all(b" SVA 1 3\nERR?\nERR?\nVOL?\n").unwrap();
    let mut reader = BufReader::new(&endless);
    let mut lines = String::new();
    for _ in 0..3 {
        reader.read_line(&mut lines).unwrap();
    }
    assert_eq!(lines, "3\n0\n1=0.000000\n");
    drop((idle, never));
}

#[test]
fn a_wave_goes_on_with_the_clock_while_nobody_asks() {
    let port = served(&Simulation { plant: "paper".into(), ..Simulation::default() });
    let mut client = connected(port);
    let begin = Instant::now();
    client.write_all(b"WAV 1 X LIN 1001 20 0 1001 0 0\nWSL 1 1\nWGC 1 1\nWTR 1 20 0\nWGO 1 1\n").unwrap();
    client.write_all(b"ERR?\n").unwrap();
    assert_eq!(line(&client), "0\n");
    drop(client);
    std::thread::sleep(Duration::from_millis(300));
    let mut client = connected(port);
    client.write_all(b"VOL?\n\x18ERR?\n").unwrap();
    let volts: f64 = line(&client).trim().strip_prefix("1=").unwrap().parse().unwrap();
    let share = volts / 20.0;
    // 1 s for the whole line; the clock of a busy machine may stand still.
    assert!(share <= begin.elapsed().as_secs_f64() + 0.01 && share > 0.1, "{volts} V");
}
