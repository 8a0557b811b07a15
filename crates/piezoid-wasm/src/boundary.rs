//! The functions that JavaScript calls. An address is one that `reserve` or `answer` gave, with its length.

use piezoid::progress::Stage;
use serde_json::json;
use std::alloc::{Layout, alloc, dealloc};
use std::cell::Cell;
use std::ops::ControlFlow;

/// What memory begins at a multiple of: doubles are read in place.
const ALIGN: usize = 8;

unsafe extern "C" {
    fn progress(stage: *const u8, length: usize) -> i32;
}

thread_local! {
    /// Length of the last answer.
    static LENGTH: Cell<usize> = const { Cell::new(0) };
}

fn layout(length: usize) -> Option<Layout> {
    Layout::from_size_align(length.max(1), ALIGN).ok()
}

/// Memory for a request; 0 if there is not so much.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn reserve(length: usize) -> *mut u8 {
    // SAFETY: the layout has at least one byte.
    layout(length).map_or(std::ptr::null_mut(), |layout| unsafe { alloc(layout) })
}

/// Gives back what `reserve` or `answer` gave.
///
/// # Safety
/// The address is one of theirs, with its length, and is not used afterwards.
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn release(address: *mut u8, length: usize) {
    if let Some(layout) = layout(length) {
        // SAFETY: the caller promises that the address was reserved with this layout.
        unsafe { dealloc(address, layout) };
    }
}

/// Answers the request at an address, and releases the request. 0 if the memory does not suffice for the answer.
///
/// # Safety
/// As [`release`].
#[unsafe(no_mangle)]
pub(crate) unsafe extern "C" fn answer(address: *mut u8, length: usize) -> *mut u8 {
    // SAFETY: the caller promises that this memory was reserved and written.
    let request = unsafe { std::slice::from_raw_parts(address, length) };
    let mut tell = |stage: Stage| {
        let stage = json!(stage).to_string();
        // SAFETY: JavaScript reads the text during the call alone.
        let goes_on = unsafe { progress(stage.as_ptr(), stage.len()) };
        if goes_on == 0 { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    let answer = piezoid_operations::answered(request, &mut tell);
    // SAFETY: as above; the request is not used any more.
    unsafe { release(address, length) };
    arguments(&answer)
}

/// Length of the last answer.
#[unsafe(no_mangle)]
pub(crate) extern "C" fn length() -> usize {
    LENGTH.get()
}

fn arguments(bytes: &[u8]) -> *mut u8 {
    LENGTH.set(bytes.len());
    let address = reserve(bytes.len());
    if !address.is_null() {
        // SAFETY: the memory was just reserved with this length.
        unsafe { std::ptr::copy_nonoverlapping(bytes.as_ptr(), address, bytes.len()) };
    }
    address
}
