//! The verbs as WebAssembly modules: packed requests in, packed answers out (`piezoid_operations::answered`). A module
//! has the verbs of the features with which it is built.
//!
//! ```text
//! address = reserve(length)            write the request there
//! address = answer(address, length)    takes the request; the answer has `length()` bytes at this address
//! release(address, length)             when the answer is read
//! ```
//! A module imports one function, `progress(stage, length)`: a stage as JSON; it returns 0 to cancel.
#![cfg_attr(target_family = "wasm", allow(unsafe_code))]

#[cfg(target_family = "wasm")]
mod boundary;
