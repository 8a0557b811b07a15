//! Properties of all blocks, records and costs, tested on random ones.

mod linear;
mod models;
mod operators;
mod strategies;
mod systems;
