//! Prints the lists for menus and forms, which the page loads.

fn main() {
    println!("{}", piezoid_calls::lists());
}
