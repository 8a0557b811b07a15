//! Which fault comes when, by chance.

use crate::kills::Dice;
use rustix::process::Signal;
use std::time::Duration;

/// A kind of fault.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Kind {
    /// The line ends.
    Cut,
    Reset,
    /// Nothing passes any more.
    Stall(Stall),
    /// Answers pass with one byte a second.
    Drip,
    /// Noise between answers, or in place of one.
    Garbage {
        replaces: bool,
    },
    /// A signal for the client.
    Signal(Signal),
    /// Ctrl-C, and once more after this time, perhaps while the line stalls.
    Twice(Duration, bool),
    KillController,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Stall {
    /// For ever; the controller does not notice that the client goes.
    Silent,
    /// The controller notices that the client goes.
    Closes,
    /// What waits on the line arrives after this time, unless the client has withdrawn it.
    Late(Duration),
}

impl Kind {
    fn of(k: usize, dice: &mut Dice) -> Self {
        match k % 12 {
            0 => Kind::Cut,
            1 => Kind::Reset,
            2 => Kind::Stall(match dice.roll(3) {
                0 => Stall::Silent,
                1 => Stall::Closes,
                _ => Stall::Late(Duration::from_millis(1500 + dice.roll(2500))),
            }),
            3 => Kind::Drip,
            4 => Kind::Garbage { replaces: true },
            5 => Kind::Garbage { replaces: false },
            6 => Kind::Signal(Signal::KILL),
            7 => Kind::KillController,
            8 => Kind::Signal(Signal::INT),
            9 => Kind::Signal(Signal::TERM),
            10 => Kind::Signal(Signal::HUP),
            _ => Kind::Twice(Duration::from_millis(dice.roll(700)), dice.roll(2) == 0),
        }
    }

    pub(super) fn title(self) -> &'static str {
        match self {
            Kind::Cut => "cut",
            Kind::Reset => "reset",
            Kind::Stall(Stall::Silent) => "stall",
            Kind::Stall(Stall::Closes) => "stall, the client's end passes",
            Kind::Stall(Stall::Late(_)) => "stall, delivered later",
            Kind::Drip => "drip of one byte a second",
            Kind::Garbage { replaces: true } => "garbage for an answer",
            Kind::Garbage { replaces: false } => "garbage between answers",
            Kind::Signal(Signal::KILL) => "`kill -9` of the program",
            Kind::Signal(Signal::TERM) => "SIGTERM",
            Kind::Signal(Signal::HUP) => "SIGHUP",
            Kind::Signal(_) => "Ctrl-C",
            Kind::Twice(_, false) => "Ctrl-C twice",
            Kind::Twice(_, true) => "Ctrl-C twice, the line stalls",
            Kind::KillController => "`kill -9` of the controller",
        }
    }

    /// True if it is a fault of the line, which then is lost.
    pub(super) fn is_of_the_line(self) -> bool {
        matches!(self, Kind::Cut | Kind::Reset | Kind::Stall(_) | Kind::Drip)
    }

    pub(super) fn kills(self) -> bool {
        self == Kind::Signal(Signal::KILL)
    }

    /// True for a signal that the client can handle.
    pub(super) fn is_signal(self) -> bool {
        matches!(self, Kind::Signal(_) | Kind::Twice(..)) && !self.kills()
    }
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Moment {
    Never,
    After(Duration),
    /// At a command when it comes for the nth time.
    Command(String, usize, Place),
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Place {
    Before,
    /// Within the command.
    Torn,
    /// After so many bytes of the next answer.
    Answer(usize),
}

/// New connections after a fault of the line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum After {
    Back,
    Later(Duration),
    /// They end at once.
    Closed,
    /// They are never answered.
    Silent,
}

#[derive(Debug, Clone)]
pub(super) struct Plan {
    pub(super) kind: Kind,
    pub(super) moment: Moment,
    pub(super) after: After,
    pub(super) garbage: Vec<u8>,
}

impl Plan {
    /// Without a fault.
    pub(super) fn none() -> Self {
        Plan { kind: Kind::Cut, moment: Moment::Never, after: After::Back, garbage: Vec::new() }
    }

    /// The fault of case k, at this command, which comes so often, or at a moment of a measurement of this length.
    pub(super) fn of(k: usize, command: Option<(&str, usize)>, length: Duration, dice: &mut Dice) -> Self {
        let kind = Kind::of(k, dice);
        let moment = match command {
            Some((name, most)) => {
                let place = match dice.roll(4) {
                    0 => Place::Before,
                    1 => Place::Torn,
                    _ => Place::Answer(dice.roll(4) as usize),
                };
                Moment::Command(name.into(), 1 + dice.roll(most as u64) as usize, place)
            }
            None => Moment::After(length.mul_f64(dice.roll(9500) as f64 / 10_000.0)),
        };
        let after = match dice.roll(10) {
            0..6 => After::Back,
            6..8 => After::Later(Duration::from_millis(300 + dice.roll(1700))),
            8 => After::Closed,
            _ => After::Silent,
        };
        // It begins with a byte that no answer has.
        let mut garbage = vec![0x80 | dice.roll(128) as u8];
        garbage.extend((0..1 + dice.roll(40)).map(|_| dice.roll(256) as u8));
        if dice.roll(2) == 0 {
            garbage.push(b'\n');
        }
        Plan { kind, moment, after, garbage }
    }
}
