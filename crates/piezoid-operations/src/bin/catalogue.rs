//! Prints the catalogue, which the page loads.

fn main() {
    println!("{}", serde_json::json!(piezoid_operations::catalogue()));
}
