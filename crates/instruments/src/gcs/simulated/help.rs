//! Which commands the models know, as `help.txt` lists them.
//!
//! What a model knows is what public drivers send to it without a guard; no real controller was asked.

use crate::simulated::Model;

/// Each line: the models that know a command, the command, what it does.
const HELP: &str = include_str!("help.txt");

impl Model {
    /// Its letter in the help.
    fn letter(self) -> char {
        match self {
            Model::E727 => '7',
            Model::E754 => '5',
            Model::E709 => '9',
            Model::OpenLoop => 'o',
            // It has commands of its own.
            Model::Nv200 | Model::Scpi => '-',
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
