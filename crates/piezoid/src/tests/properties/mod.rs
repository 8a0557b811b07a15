//! Properties of all blocks, records and costs, tested on random ones.

mod hostile;
mod linear;
mod models;
mod operators;
mod strategies;
mod systems;
