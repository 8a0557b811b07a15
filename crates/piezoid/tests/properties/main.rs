//! What holds for every block, record and cost, tried on random ones through the public interface.

#![allow(clippy::expect_used)] // a test may stop at what must not happen

#[path = "../common/close.rs"]
mod close;
#[path = "../common/fused.rs"]
mod fused;
mod linear;
mod models;
mod operators;
mod strategies;
mod systems;
