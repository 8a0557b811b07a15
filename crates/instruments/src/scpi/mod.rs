//! An arbitrary waveform generator, an amplifier, and an oscilloscope, with SCPI over TCP: a client, and both
//! instruments simulated around a plant.
//!
//! ```text
//! generator -> amplifier -> actuator -> sensor -> channel 2 of the oscilloscope
//!     Sync -> EXT TRIG          monitor -> channel 1
//! ```
//! **The output never jumps.** A generator in burst mode holds the first point of its wave before and after a burst.
//! Each wave therefore begins and ends at its offset c, as the DAC value 0, so that the level at rest is c whatever
//! the amplitude A:
//!
//! ```text
//! output = c + A/2 w(t),   w = 0, the drive about c, a slow half cosine back to 0
//! FUNC DC; VOLT:OFFS ...              slow moves: the output is the offset
//! VOLT 0.002; FUNC ARB; BURS:STAT ON  at c: the wave with the least amplitude, which may run for a moment
//! VOLT A; *TRG                        at c: the whole amplitude, then one burst
//! VOLT 0.002; BURS:STAT OFF; FUNC DC  at c again
//! ```
//! c is the first voltage of the drive. If the output cannot reach the drive about it, `|c| + A/2 <= 10 V`, c is the
//! nearest voltage about which it can, and a slow half cosine leads from it to the drive. A drive that is broken off
//! fades to c: A is lowered in small steps while the burst goes on, then `ABOR` ends it.
//!
//! References: Keysight, Trueform Series Operating and Service Guide (33500B, 33600A); for burst phase and idle level
//! also the manuals of 33210A and 33220A; Keysight, InfiniiVision 2000 and 3000 X-Series Programmer's Guides;
//! pymeasure 0.16, `Agilent33500` and `KeysightDSOX1102G`. It does not do: closed loop, several channels at once,
//! sequences, segmented memory, serial ports and USB. Attenuators that switch as the amplitude changes may disturb the
//! output for a moment.

#[cfg(test)]
mod faults;
mod generator;
mod line;
mod options;
mod oscilloscope;
mod session;
mod simulated;
mod stop;
#[cfg(test)]
mod tests;
mod trace;
mod wave;

pub use options::ScpiOptions;
pub(crate) use session::Scpi;
pub(crate) use simulated::simulated;
