//! Lists the files of `page/`, which are part of the program: so that its build needs no Node.js.

use std::fmt::Write;
use std::path::{Path, PathBuf};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    println!("cargo:rerun-if-changed=page");
    let root = PathBuf::from(std::env::var("CARGO_MANIFEST_DIR")?).join("page");
    let mut list = String::from("&[\n");
    for path in files(&root)? {
        let name = path.strip_prefix(&root)?.to_string_lossy().replace('\\', "/");
        // A path in the list would make the program depend on the folder of its build.
        writeln!(list, "({name:?}, include_bytes!(concat!(env!(\"CARGO_MANIFEST_DIR\"), \"/page/\", {name:?}))),")?;
    }
    std::fs::write(PathBuf::from(std::env::var("OUT_DIR")?).join("page.rs"), list + "]")?;
    Ok(())
}

/// The files of a folder and of those in it, in order.
fn files(folder: &Path) -> std::io::Result<Vec<PathBuf>> {
    let mut paths = std::fs::read_dir(folder)?.map(|entry| Ok(entry?.path())).collect::<std::io::Result<Vec<_>>>()?;
    paths.sort();
    let inside = paths.into_iter().map(|path| if path.is_dir() { files(&path) } else { Ok(vec![path]) });
    Ok(inside.collect::<std::io::Result<Vec<_>>>()?.concat())
}
