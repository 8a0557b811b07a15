//! Which fault comes when, by chance.

use crate::kills::Dice;
use std::time::Duration;

/// A kind of fault.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Kind {
    /// The line ends.
    Cut,
    /// The line is reset.
    Reset,
    /// Nothing passes any more.
    Stall(Stall),
    /// Answers pass with one byte a second.
    Drip,
    Garbage(Garbage),
    KillClient,
    KillController,
    Interrupt,
    /// Ctrl-C, and once more after this time, perhaps while the line stalls.
    Twice(Duration, bool),
    Terminate,
    Hangup,
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Stall {
    /// For ever; the controller does not notice that the client goes.
    Silent,
    /// The controller notices that the client goes.
    Closes,
    /// What waits on the line arrives after this time.
    Late(Duration),
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Garbage {
    InPlace,
    Between,
}

pub(super) const KINDS: usize = 12;

impl Kind {
    fn of(k: usize, dice: &mut Dice) -> Self {
        let mut time = |from: u64, to: u64| Duration::from_millis(from + dice.roll(to - from));
        match k % KINDS {
            0 => Kind::Cut,
            1 => Kind::Reset,
            2 => match time(0, 3).as_millis() {
                0 => Kind::Stall(Stall::Silent),
                1 => Kind::Stall(Stall::Closes),
                _ => Kind::Stall(Stall::Late(time(1500, 4000))),
            },
            3 => Kind::Drip,
            4 => Kind::Garbage(Garbage::InPlace),
            5 => Kind::Garbage(Garbage::Between),
            6 => Kind::KillClient,
            7 => Kind::KillController,
            8 => Kind::Interrupt,
            9 => Kind::Terminate,
            10 => Kind::Hangup,
            _ => Kind::Twice(time(0, 700), time(0, 2).as_millis() == 1),
        }
    }

    pub(super) fn title(self) -> &'static str {
        match self {
            Kind::Cut => "cut",
            Kind::Reset => "reset",
            Kind::Stall(Stall::Silent) => "stall",
            Kind::Stall(Stall::Closes) => "stall, client's end passes",
            Kind::Stall(Stall::Late(_)) => "stall, delivered later",
            Kind::Drip => "drip",
            Kind::Garbage(Garbage::InPlace) => "garbage for an answer",
            Kind::Garbage(Garbage::Between) => "garbage between",
            Kind::KillClient => "kill -9 of the client",
            Kind::KillController => "kill -9 of the controller",
            Kind::Interrupt => "Ctrl-C",
            Kind::Twice(_, false) => "Ctrl-C twice",
            Kind::Twice(_, true) => "Ctrl-C twice, line stalls",
            Kind::Terminate => "SIGTERM",
            Kind::Hangup => "SIGHUP",
        }
    }

    /// True if it is a fault of the line, which then is lost.
    pub(super) fn is_of_the_line(self) -> bool {
        matches!(self, Kind::Cut | Kind::Reset | Kind::Stall(_) | Kind::Drip)
    }

    /// True for a signal that the client can handle.
    pub(super) fn is_signal(self) -> bool {
        matches!(self, Kind::Interrupt | Kind::Twice(..) | Kind::Terminate | Kind::Hangup)
    }
}

#[derive(Debug, Clone, PartialEq)]
pub(super) enum Moment {
    /// Never, to count the commands.
    Never,
    After(Duration),
    /// At a command when it comes for the nth time.
    Command {
        name: String,
        nth: usize,
        place: Place,
    },
}

#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Place {
    Before,
    Torn,
    Between,
    /// After so many bytes of the next answer.
    Within(usize),
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

    /// The fault of case k, at this command, or at a moment of a measurement of this length.
    pub(super) fn of(k: usize, command: Option<(&str, usize)>, length: Duration, dice: &mut Dice) -> Self {
        let kind = Kind::of(k, dice);
        let moment = match command {
            Some((name, most)) => {
                let place = match dice.roll(4) {
                    0 => Place::Before,
                    1 => Place::Torn,
                    2 => Place::Between,
                    _ => Place::Within(1 + dice.roll(3) as usize),
                };
                Moment::Command { name: name.into(), nth: 1 + dice.roll(most as u64) as usize, place }
            }
            None => Moment::After(length.mul_f64(dice.roll(10_000) as f64 / 10_000.0)),
        };
        let after = match dice.roll(10) {
            0..6 => After::Back,
            6..8 => After::Later(Duration::from_millis(300 + dice.roll(1700))),
            8 => After::Closed,
            _ => After::Silent,
        };
        // Noise has bytes that no answer has.
        let mut garbage: Vec<u8> = (0..1 + dice.roll(40)).map(|_| dice.roll(256) as u8).collect();
        garbage.insert(0, 0x80 | dice.roll(128) as u8);
        if dice.roll(2) == 0 {
            garbage.push(b'\n');
        }
        Plan { kind, moment, after, garbage }
    }
}
