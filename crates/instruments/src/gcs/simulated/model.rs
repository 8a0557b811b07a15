//! The models of controllers: their names, and which commands they know, as `help.txt` lists them.
//!
//! What a model knows is what public drivers send to it without a guard; no real controller was asked.

use piezoid_numerics::options::OptionKind;
use serde::{Deserialize, Serialize};

/// The model of a simulated controller.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Model {
    /// Several axes, over Ethernet.
    #[default]
    #[serde(rename = "e-727")]
    E727,
    /// Over Ethernet.
    #[serde(rename = "e-754")]
    E754,
    /// Over a serial line, so it serves one client at a time.
    #[serde(rename = "e-709")]
    E709,
    /// An amplifier without a servo.
    #[serde(rename = "open-loop")]
    OpenLoop,
}

pub(super) const MODELS: OptionKind = OptionKind::Choice(&[
    ("e-727", "Over Ethernet: several clients at once"),
    ("e-754", "Over Ethernet: several clients at once"),
    ("e-709", "Over a serial line: one client at a time, others are refused"),
    ("open-loop", "An amplifier with a sensor, but without a servo"),
]);

/// Each line: the models that know a command, the command, what it does.
const HELP: &str = include_str!("help.txt");

impl Model {
    /// Its name in `*IDN?`.
    pub(super) fn title(self) -> &'static str {
        match self {
            Model::E727 => "E-727",
            Model::E754 => "E-754",
            Model::E709 => "E-709",
            Model::OpenLoop => "open-loop",
        }
    }

    /// Clients that it serves at once.
    pub(super) fn clients(self) -> usize {
        if self == Model::E709 { 1 } else { 64 }
    }

    /// Its letter in the help.
    fn letter(self) -> char {
        match self {
            Model::E727 => '7',
            Model::E754 => '5',
            Model::E709 => '9',
            Model::OpenLoop => 'o',
        }
    }

    /// The commands that it knows, each with what it does.
    pub(super) fn help(self) -> impl Iterator<Item = &'static str> {
        let known = move |line: &&str| line.split(' ').next().is_some_and(|models| models.contains(self.letter()));
        HELP.lines().filter(known).filter_map(|line| line.split_once(' ').map(|(_, rest)| rest))
    }

    /// True if it knows a command.
    pub(super) fn knows(self, name: &str) -> bool {
        self.help().any(|line| line.split(' ').next() == Some(name))
    }
}
