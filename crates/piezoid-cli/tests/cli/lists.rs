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
    bench.run("man identify").ok().prints(&[".TH ", "piezoid\\-identify", "large\\-signal", "Examples"]);
    bench.run("--version").ok().prints(&["piezoid ", env!("CARGO_PKG_VERSION")]);
}
