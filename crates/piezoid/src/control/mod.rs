//! Feedback control of the Hammerstein model.

pub mod predictive;
