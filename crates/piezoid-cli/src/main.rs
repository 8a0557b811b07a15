//! The `piezoid` command.
fn main() {}
