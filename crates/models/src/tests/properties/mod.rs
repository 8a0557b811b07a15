//! Properties of models, their blocks and their costs, tested on random ones.

mod linear;
mod models;
mod operators;
mod strategies;
mod systems;
