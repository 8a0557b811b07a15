//! The lists, completions and manual pages.

use crate::bench::Bench;

#[test]
fn every_list_prints_its_rows_and_gives_them_as_json() {
    let bench = Bench::new();
    for (list, member) in [
        ("operators", "two-branch"),
        ("operators", "prandtl-ishlinskii"),
        ("operators", "tellinen"),
        ("plants", "paper"),
        ("excitations", "prbs"),
        ("estimators", "swarm"),
        ("drivers", "pl140"),
        ("actuators", "p-885.51"),
    ] {
        let rows = bench.run(&format!("{list} --json -")).ok().out_json();
        let text = bench.run(list).ok().prints(&[member]).out;
        assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
        for row in rows.as_array().unwrap() {
            for key in ["name", "summary", "reference"] {
                assert!(row[key].as_str().is_some_and(|s| !s.is_empty()), "{list}: {row}");
            }
            let name = row["name"].as_str().unwrap();
            assert!(text.lines().any(|line| line.starts_with(&format!("{name} "))), "{name}");
        }
        assert!(rows.as_array().unwrap().iter().any(|row| row["name"] == member));
        bench.run(&format!("{list} --json {list}.json")).ok();
        assert_eq!(bench.json(&format!("{list}.json")), rows);
    }
}

#[test]
fn operators_are_named_as_the_field_names_them() {
    let bench = Bench::stocked();
    bench.run("operators").ok().prints(&["(or PI,", "(or RDPI)"]);
    let rows = bench.run("operators --json -").ok().out_json();
    let row = rows.as_array().unwrap().iter().find(|row| row["name"] == "prandtl-ishlinskii").unwrap();
    assert_eq!(row["aliases"][0], "PI");
    for name in ["PI", "prandtl_ishlinskii", "Prandtl-Ishlinskii"] {
        bench
            .run(&format!("identify sine5.csv --operator {name} -o {name}.json"))
            .ok()
            .prints(&["prandtl-ishlinskii, gain"]);
    }
}

#[test]
fn drivers_and_actuators_give_their_figures() {
    let bench = Bench::new();
    let find = |list: &str, name: &str| {
        let rows = bench.run(&format!("{list} --json -")).ok().out_json();
        rows.as_array().unwrap().iter().find(|row| row["name"] == name).unwrap().clone()
    };
    let driver = find("drivers", "e-610");
    assert_eq!((&driver["high"], &driver["current"], &driver["slew"]), (&130.0.into(), &0.18.into(), &().into()));
    let stage = find("actuators", "p-611.1s");
    assert_eq!((&stage["kind"], &stage["stroke"], &stage["unit"]), (&"stage".into(), &120.0.into(), &"um".into()));
    bench.run("actuators").ok().prints(&["8.2 uF", "70 kHz", "(allowed: -20 to 120 V)"]);
}

#[test]
fn every_shell_has_its_completions() {
    let bench = Bench::new();
    for (shell, mark) in [
        ("bash", "complete -F _piezoid"),
        ("zsh", "#compdef piezoid"),
        ("fish", "complete -c piezoid"),
        ("powershell", "Register-ArgumentCompleter"),
        ("elvish", "edit:completion"),
    ] {
        bench.run(&format!("completions {shell}")).ok().prints(&[mark, "identify", "rising-sine"]);
    }
}

#[test]
fn the_manual_has_a_page_for_the_command_and_for_each_verb() {
    let bench = Bench::new();
    bench.run("man").ok().prints(&[".TH piezoid 1", "identify", "excite"]);
    bench.run("man identify").ok().prints(&[".TH ", "piezoid\\-identify", "small\\-signal", "Examples"]);
    bench.run("man -o pages").ok();
    for (page, verb) in [("piezoid.1", "man"), ("piezoid-identify.1", "man identify")] {
        assert_eq!(bench.text(&format!("pages/{page}")), bench.run(verb).ok().out, "{page}");
    }
    bench.run("--version").ok().prints(&["piezoid ", env!("CARGO_PKG_VERSION")]);
}
