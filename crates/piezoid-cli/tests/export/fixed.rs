//! C in fixed point by two compilers: the counts that are computed here, for every operator that can be exported so.

use crate::{exported, models, run, there};
use piezoid::export::{Wanted, target};

const STRICT: &str = "-std=c99 -pedantic -Wall -Wextra -Werror -Wconversion -Wshadow";
const WATCHED: &str = "-fsanitize=address,undefined -fno-sanitize-recover=all";

#[test]
fn every_operator_counts_the_same_from_both_compilers_at_any_level_and_no_sanitizer_speaks() {
    let builds = [
        ("gcc", format!("-O0 {WATCHED}")),
        ("gcc", "-O3".into()),
        ("clang", "-O0".into()),
        ("clang", format!("-O3 {WATCHED}")),
    ];
    let builds: Vec<_> = builds.into_iter().filter(|(compiler, _)| there(compiler)).collect();
    for (name, model) in models() {
        let wanted = Wanted::new(&model, &name);
        let made = match (target("fixed").unwrap().make)(&wanted) {
            Ok(made) => made,
            Err(error) => {
                println!("{name}: {error}");
                continue;
            }
        };
        let readme = String::from_utf8(made.files[3].bytes.clone()).unwrap();
        readme.lines().filter(|l| l.contains("_step` | ")).for_each(|l| println!("{name}: {l}"));
        made.notes.iter().for_each(|note| println!("{name}: {note}"));
        let folder = tempfile::tempdir().unwrap();
        exported("fixed", &wanted, folder.path());
        for (compiler, flags) in &builds {
            run(folder.path(), &format!("{compiler} {STRICT} {flags} {name}.c {name}_test.c -o self_test"));
            let said = run(folder.path(), "./self_test");
            assert!(said.contains(": 0 of 400 differ"), "{said}");
        }
    }
}
