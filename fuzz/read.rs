//! Reads any bytes as a file of one format, the one that the target is named after, and makes a record of it.
//!
//! `cargo xtask fuzz` runs every target for a minute. What fails is a panic, a run of more than 10 s, and memory beyond
//! ten times the file. Files that are compressed may unpack to a thousand times their size.

#![no_main]

use libfuzzer_sys::fuzz_target;
use piezoid::formats::{ColumnSelection, FORMATS, Format};
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::LazyLock;
use std::sync::atomic::{AtomicUsize, Ordering::Relaxed};

/// The system's allocator, which keeps count of the bytes in use and of their maximum.
struct Counting;

static USED: AtomicUsize = AtomicUsize::new(0);
static MOST: AtomicUsize = AtomicUsize::new(0);

unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        let used = USED.fetch_add(layout.size(), Relaxed) + layout.size();
        MOST.fetch_max(used, Relaxed);
        unsafe { System.alloc(layout) }
    }

    unsafe fn dealloc(&self, memory: *mut u8, layout: Layout) {
        USED.fetch_sub(layout.size(), Relaxed);
        unsafe { System.dealloc(memory, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// The format of this target, and the bytes that it may use beside ten times the file.
static TARGET: LazyLock<(&Format, usize)> = LazyLock::new(|| {
    let name = env!("CARGO_BIN_NAME");
    let format = FORMATS.iter().find(|row| row.name == name).expect("the targets have the names of the formats");
    (format, if ["numpy", "matlab", "hdf5"].contains(&name) { 1 << 28 } else { 1 << 20 })
});

fuzz_target!(|bytes: &[u8]| {
    let (format, beside) = *TARGET;
    if !(format.matches)(bytes) {
        return;
    }
    let before = USED.load(Relaxed);
    MOST.store(before, Relaxed);
    if let Ok(table) = (format.read)(bytes) {
        let selection = ColumnSelection::default();
        let _ = (table.record(&selection), table.input(&selection), table.reference(&selection));
    }
    let most = MOST.load(Relaxed) - before;
    assert!(most <= 10 * bytes.len() + beside, "{most} bytes in use for a file of {} bytes", bytes.len());
});
