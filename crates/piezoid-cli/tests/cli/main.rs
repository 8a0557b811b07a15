//! Tests of the real binary in a temporary directory, as a user runs it.

// Helpers of tests may panic like the tests.
#![allow(clippy::unwrap_used, clippy::panic)]

mod bad_input;
mod bench;
mod bytes;
mod certificate;
mod compare;
mod compatibility;
mod compensate;
mod contribute;
mod control;
mod drive;
mod exports;
mod faults;
mod files;
mod fmu;
mod hostile;
mod inspect;
mod instrument;
mod joint;
mod kills;
mod lists;
mod measured;
mod online;
mod plan;
mod prepare;
mod process;
mod proof;
mod serve;
mod stand_in;
mod strangers;
mod study;
mod timing;
mod tour;
mod twins;
mod usage;
mod waveform;
mod workflow;
