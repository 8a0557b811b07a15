//! What holds for every block, record and cost, tried on random ones through the public interface.

mod linear;
mod models;
mod operators;
mod strategies;
mod systems;
