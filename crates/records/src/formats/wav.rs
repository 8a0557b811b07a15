//! WAV: the channels of a sound card or a recorder, as they are stored. They have neither names nor units.

use super::bytes::{Unpacking, damaged};
use super::{Channel, Format, Table};
use hound::{SampleFormat, WavReader};
use piezoid_numerics::error::Error;
use std::io::Cursor;

/// The row of WAV.
pub(super) const ROW: Format = Format {
    name: "wav",
    extensions: &["wav"],
    summary: "channels of a sound card, in counts",
    reference: "https://learn.microsoft.com/en-us/windows/win32/medfound/tutorial--decoding-audio",
    matches: |bytes| bytes.starts_with(b"RIFF") && bytes.get(8..12) == Some(b"WAVE"),
    read,
    in_pieces: false,
    write: None,
};

fn read(bytes: &[u8]) -> Result<Table, Error> {
    let mut reader = WavReader::new(Cursor::new(bytes)).map_err(damaged)?;
    let spec = reader.spec();
    // A damaged head may state tens of thousands of channels.
    if u32::from(spec.channels) > reader.len() {
        return Err(damaged(format!("its {} channels have {} samples in all", spec.channels, reader.len())));
    }
    Unpacking::of(bytes).count(8 * reader.len() as usize)?;
    let values: Vec<f64> = match spec.sample_format {
        SampleFormat::Float => reader.samples::<f32>().map(|v| v.map(f64::from)).collect::<Result<_, _>>(),
        SampleFormat::Int => reader.samples::<i32>().map(|v| v.map(f64::from)).collect::<Result<_, _>>(),
    }
    .map_err(damaged)?;
    let count = usize::from(spec.channels).max(1);
    let channel = |k: usize| {
        let samples = values.iter().skip(k).step_by(count).copied().collect();
        Channel { unit: Some("counts".into()), ..Channel::new(format!("channel {}", k + 1), samples) }
    };
    let ts = Some(1.0 / f64::from(spec.sample_rate)).filter(|ts| ts.is_finite());
    Ok(Table { ts, ..Table::of((0..count).map(channel)) })
}
