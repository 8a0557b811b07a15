//! Written files are complete or absent, and only at the requested places.

use crate::bench::Bench;

#[test]
fn a_result_replaces_an_older_file_whole() {
    let bench = Bench::stocked();
    bench.write("y.csv", "old ".repeat(1_000_000));
    bench.run("simulate --plant paper --input drive5.csv -o y.csv").ok();
    assert_eq!(bench.text("y.csv"), bench.text("sine5.csv"));
}

#[test]
fn the_extension_selects_the_format_and_every_format_holds_the_same_record() {
    let bench = Bench::stocked();
    for (extension, begin) in [("npz", "PK"), ("mat", "MATLAB 5.0")] {
        let simulate = |from: &str, to: &str| bench.run(&format!("simulate --plant paper --input {from} -o {to}")).ok();
        let (drive, record) = (format!("drive.{extension}"), format!("y.{extension}"));
        bench.run(&format!("excite sine --ts 5e-4 --duration 1 --amplitude 30 --frequency 5 -o {drive}")).ok();
        simulate(&drive, &record);
        for name in [&drive, &record] {
            assert!(bench.bytes(name).starts_with(begin.as_bytes()), "{name}");
        }
        simulate(&record, "again.csv");
        assert_eq!(bench.text("again.csv"), bench.text("sine5.csv"));
    }
    bench.write("y.csv", bench.text("sine5.csv").replace("y_um", "y_a.u."));
    bench.run("identify y.csv --operator stop -o m.json").ok();
    bench
        .refused("simulate --model m.json --input drive.npz -o y.mat")
        .says(&["y.mat: column name = \"y_a.u.\": is no name of a variable of MATLAB"]);
}

#[test]
fn a_failing_run_leaves_the_older_file_as_it_was() {
    let bench = Bench::stocked();
    for (name, line) in [
        ("old.json", "identify --small-signal sine5.csv -o old.json --json old.json.txt"),
        ("old.csv", "simulate --plant paper --input none.csv -o old.csv"),
        ("old.html", "report none.csv --model model.json -o old.html"),
        ("old.csv", "excite sine --ts 5e-4 --duration 1 --amplitude 99 --frequency 5 --driver pl140 -o old.csv"),
    ] {
        bench.write(name, "precious");
        bench.refused(line);
        assert_eq!(bench.text(name), "precious");
    }
}

#[test]
fn a_place_that_cannot_be_written_to_is_named_with_what_to_do() {
    let bench = Bench::stocked();
    std::fs::create_dir(bench.path("folder")).unwrap();
    for (place, says) in [
        ("nowhere/y", "there is no folder nowhere: make it first"),
        ("folder", "this is a folder: name a file in it"),
        ("drive5.csv/y", "drive5.csv is not a folder"),
    ] {
        for line in [
            format!("simulate --plant paper --input drive5.csv -o {place}"),
            format!("excite sine --ts 5e-4 --duration 1 --amplitude 1 --frequency 5 -o {place}"),
            format!("report sine5.csv --model model.json -o {place}"),
            format!("plants --json {place}"),
        ] {
            let before = bench.names();
            let run = bench.run(&line).exits(1).says(&["error: cannot write", place, says]);
            assert!(!run.err.contains(".piezoid-"), "{run:?}");
            assert_eq!(bench.names(), before);
        }
    }
}

#[cfg(unix)]
mod unix {
    use super::*;
    use std::os::unix::fs::PermissionsExt;
    use std::process::Command;

    #[test]
    fn written_files_have_the_permissions_that_the_umask_leaves() {
        let bench = Bench::stocked();
        for (mask, mode) in [("022", 0o644), ("027", 0o640), ("077", 0o600)] {
            let script = format!("umask {mask} && exec \"$0\" simulate --plant paper --input drive5.csv -o y.csv");
            let mut sh = Command::new("sh");
            sh.args(["-c", &script, env!("CARGO_BIN_EXE_piezoid")]).current_dir(bench.path(""));
            assert!(sh.status().unwrap().success());
            let got = std::fs::metadata(bench.path("y.csv")).unwrap().permissions().mode() & 0o777;
            assert_eq!(got, mode, "umask {mask}: {got:o}");
        }
    }

    #[test]
    fn a_link_stays_a_link_and_its_end_is_replaced() {
        let bench = Bench::stocked();
        bench.write("run7.csv", "old");
        std::os::unix::fs::symlink("run7.csv", bench.path("latest.csv")).unwrap();
        bench.run("simulate --plant paper --input drive5.csv -o latest.csv").ok();
        assert!(bench.path("latest.csv").symlink_metadata().unwrap().is_symlink());
        assert_eq!(bench.text("run7.csv"), bench.text("sine5.csv"));
    }

    /// A rename would replace the pipe. Run as root, `-o /dev/null` would replace the device by an ordinary file.
    #[test]
    fn a_pipe_with_a_name_is_written_to_and_not_replaced() {
        let bench = Bench::stocked();
        assert!(Command::new("mkfifo").arg(bench.path("pipe")).status().unwrap().success());
        let reader = std::thread::spawn({
            let path = bench.path("pipe");
            move || std::fs::read_to_string(path).unwrap()
        });
        bench.run("simulate --plant paper --input drive5.csv -o pipe").ok();
        assert_eq!(reader.join().unwrap(), bench.text("sine5.csv"));
    }

    #[test]
    fn a_record_is_read_from_a_pipe_and_hashed_as_read() {
        let bench = Bench::stocked();
        bench.run("identify sine5.csv --operator stop -o file.json").ok();
        let script = "cat sine5.csv | \"$0\" identify /dev/stdin --operator stop -o pipe.json";
        let mut sh = Command::new("sh");
        assert!(
            sh.args(["-c", script, env!("CARGO_BIN_EXE_piezoid")])
                .current_dir(bench.path(""))
                .output()
                .unwrap()
                .status
                .success()
        );
        let hash = |name: &str| bench.json(name)["fit"]["files"][0]["sha256"].clone();
        assert_eq!(hash("pipe.json"), hash("file.json"));
    }

    #[test]
    fn names_that_are_not_unicode_are_names_too() {
        use std::os::unix::ffi::OsStrExt;
        let bench = Bench::stocked();
        let name = std::ffi::OsStr::from_bytes(b"sine\xff.csv");
        std::fs::write(bench.path("").join(name), bench.bytes("sine5.csv")).unwrap();
        let output = bench.command("identify -o m.json").arg(name).output().unwrap();
        assert!(output.status.success(), "{output:?}");
    }
}
