//! Modules of Rust, built by the compiler that is here: for every operator, in both precisions, with and without `std`.

use crate::bench::{Bench, skipped};
use piezoid::Model;
use piezoid::creep::{Creep, Lag};
use piezoid::export::{Wanted, target};
use piezoid::hysteresis::OPERATORS;
use piezoid::linear::Arx;
use std::process::Command;

/// A model of every operator that has a program, by a name that every language takes.
pub(crate) fn models() -> Vec<(String, Model)> {
    let ts = 5e-4;
    let model = |operator: &piezoid::hysteresis::Operator| {
        let linear = Arx::new(ts, vec![1.7424, -0.9453], vec![0.0, 3.0, 2.8]).unwrap();
        let lag = |tau, gain| Lag { tau_s: tau, gain };
        let creep = Creep::new(ts, vec![lag(0.1, 0.01), lag(1.0, 0.01)]).unwrap();
        Model::new((operator.example)(ts).unwrap(), linear, 2.0).unwrap().with_creep(creep).unwrap()
    };
    let named = OPERATORS.iter().map(|operator| (format!("of_{}", operator.name.replace('-', "_")), model(operator)));
    named.filter(|(name, model)| (target("rust").unwrap().make)(&Wanted::new(model, name)).is_ok()).collect()
}

/// A crate of all modules, each in both precisions, and its root.
fn bench() -> Bench {
    let bench = Bench::new();
    let mut modules = Vec::new();
    for (name, model) in models() {
        for single in [false, true] {
            let name = if single { format!("{name}_single") } else { name.clone() };
            let made = (target("rust").unwrap().make)(&Wanted { single, ..Wanted::new(&model, &name) }).unwrap();
            bench.write(&format!("{name}.rs"), &made.files[0].bytes);
            modules.push(format!("pub mod {name};\n"));
        }
    }
    modules.sort();
    bench.write("all.rs", format!("#![no_std]\n{}", modules.concat()));
    bench
}

/// Runs a tool that comes with Rust; whether it is there.
fn run(bench: &Bench, tool: &str, arguments: &str) -> bool {
    let output = Command::new(tool).args(arguments.split_whitespace()).current_dir(bench.path("")).output();
    let Ok(output) = output else {
        assert!(std::env::var_os("CI").is_none(), "no {tool}");
        skipped(&format!("no {tool}"));
        return false;
    };
    let said = String::from_utf8_lossy(&[output.stdout, output.stderr].concat()).into_owned();
    assert!(output.status.success(), "{tool} {arguments}\n{said}");
    true
}

#[test]
fn modules_give_the_bits_of_piezoid_optimised_or_not() {
    let bench = bench();
    for level in [0, 3] {
        if run(&bench, "rustc", &format!("-D warnings --edition 2021 --test -C opt-level={level} all.rs -o all")) {
            run(&bench, bench.path("all").to_str().unwrap(), "--quiet");
        }
    }
}

#[test]
fn modules_are_free_of_warnings_in_every_edition_and_as_rustfmt_has_them() {
    let bench = bench();
    for edition in [2018, 2021, 2024] {
        let how = format!("-D warnings --edition {edition} --crate-type lib --emit metadata all.rs");
        run(&bench, "rustc", &how);
        run(&bench, "clippy-driver", &how);
        run(&bench, "clippy-driver", &format!("--test {how}"));
        run(&bench, "rustfmt", &format!("--check --edition {edition} all.rs"));
    }
    let name = models()[0].0.clone();
    bench.write("main.rs", format!("mod {name};\nfn main() {{\n    {name}::State::new().step(0.0);\n}}\n"));
    run(&bench, "rustc", "-D warnings --edition 2024 main.rs");
}

#[test]
fn modules_are_built_for_a_machine_without_std() {
    let installed = Command::new("rustc").args(["--print", "sysroot"]).output().map(|o| o.stdout).unwrap_or_default();
    let installed = String::from_utf8(installed).unwrap();
    let there = std::path::Path::new(installed.trim()).join("lib/rustlib/thumbv7em-none-eabihf").is_dir();
    if !there {
        return skipped("no target thumbv7em-none-eabihf: rustup target add thumbv7em-none-eabihf");
    }
    run(&bench(), "rustc", "-D warnings --edition 2024 --crate-type lib --target thumbv7em-none-eabihf -O all.rs");
}
