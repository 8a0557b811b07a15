//! The arguments of commands.

use super::Device;
use super::errors::{AXIS, CHANNEL, COUNT, NUMBER, RANGE, TWICE, refused};

use std::collections::BTreeSet;

impl Device {
    /// The place of the axis of this name.
    pub(super) fn axis(&self, name: &str) -> Result<usize, i32> {
        self.axes.iter().position(|axis| axis.name == name).ok_or(AXIS)
    }

    /// The axes of these names, or all.
    pub(super) fn axes_of(&self, names: &[&str]) -> Result<Vec<usize>, i32> {
        if names.is_empty() {
            return Ok((0..self.axes.len()).collect());
        }
        once(names.iter().map(|name| self.axis(name)).collect::<Result<_, _>>()?)
    }

    /// Places of output channels or generators by their numbers, or of all.
    pub(super) fn channels(&self, numbers: &[&str]) -> Result<Vec<usize>, i32> {
        if numbers.is_empty() {
            return Ok((0..self.axes.len()).collect());
        }
        once(numbers.iter().map(|number| self.channel(number)).collect::<Result<_, _>>()?)
    }

    pub(super) fn channel(&self, number: &str) -> Result<usize, i32> {
        whole(number)?.checked_sub(1).filter(|k| *k < self.axes.len()).ok_or(CHANNEL)
    }

    /// Axes, each with an argument.
    pub(super) fn with_axes<'a>(&self, arguments: &[&'a str]) -> Result<Vec<(usize, &'a str)>, i32> {
        pairs(arguments, |name| self.axis(name))
    }

    /// Axes, each with a number.
    pub(super) fn of_axes(&self, arguments: &[&str]) -> Result<Vec<(usize, f64)>, i32> {
        self.with_axes(arguments)?.into_iter().map(|(k, value)| Ok((k, real(value)?))).collect()
    }

    /// Generators or channels, each with an argument.
    pub(super) fn of_channels<'a>(&self, arguments: &[&'a str]) -> Result<Vec<(usize, &'a str)>, i32> {
        pairs(arguments, |number| self.channel(number))
    }
}

/// Arguments in pairs, whose first ones are different places.
fn pairs<'a>(arguments: &[&'a str], place: impl Fn(&str) -> Result<usize, i32>) -> Result<Vec<(usize, &'a str)>, i32> {
    refused(&[(arguments.is_empty() || arguments.len() % 2 == 1, COUNT)])?;
    let places = once(arguments.iter().step_by(2).map(|name| place(name)).collect::<Result<_, _>>()?)?;
    Ok(places.into_iter().zip(arguments.iter().skip(1).step_by(2).copied()).collect())
}

/// Arguments in threes.
pub(super) fn triples<'a, 'b>(arguments: &'b [&'a str]) -> Result<std::slice::Chunks<'b, &'a str>, i32> {
    refused(&[(arguments.is_empty() || !arguments.len().is_multiple_of(3), COUNT)])?;
    Ok(arguments.chunks(3))
}

/// Returns an error if one of these comes twice.
pub(super) fn once(places: Vec<usize>) -> Result<Vec<usize>, i32> {
    let different: BTreeSet<&usize> = places.iter().collect();
    refused(&[(different.len() < places.len(), TWICE)])?;
    Ok(places)
}

pub(super) fn real(word: &str) -> Result<f64, i32> {
    word.parse().ok().filter(|x: &f64| x.is_finite()).ok_or(NUMBER)
}

pub(super) fn whole(word: &str) -> Result<usize, i32> {
    let number: i64 = word.parse().map_err(|_| NUMBER)?;
    usize::try_from(number).map_err(|_| RANGE)
}

pub(super) fn positive(word: &str) -> Result<u64, i32> {
    word.parse().ok().filter(|n| *n > 0).ok_or(RANGE)
}

/// 0 or 1.
pub(super) fn flag(word: &str) -> Result<bool, i32> {
    match word {
        "0" => Ok(false),
        "1" => Ok(true),
        _ => Err(RANGE),
    }
}

/// A whole number, perhaps hexadecimal.
pub(super) fn code(word: &str) -> Result<u32, i32> {
    let hex = word.strip_prefix("0x").or_else(|| word.strip_prefix("0X"));
    hex.map_or_else(|| word.parse(), |hex| u32::from_str_radix(hex, 16)).map_err(|_| NUMBER)
}
