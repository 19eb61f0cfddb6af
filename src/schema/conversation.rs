//! The states of a drive, what can be said to it, and what it does then: the
//! stack walks this table from the one side, an impersonator from the other.

use super::message::{DriveState, FaultCode, Request};

/// A state of the drive's own, as an index into the profile's list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StateId(pub(super) u8);

/// Something that the stack can say to a drive besides a torque, as an index
/// into the profile's list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct WordId(pub(super) u8);

/// States and words.
#[derive(Clone, Debug, Default)]
pub struct Conversation {
    pub(super) states: Vec<State>,
    pub(super) words: Vec<Word>,
}

/// One state of a drive.
#[derive(Clone, Debug)]
pub(super) struct State {
    pub name: String,
    pub means: DriveState,
    /// Words that lead to what the stack wants, one list a [`Request`].
    pub says: [Vec<WordId>; 3],
    /// Where a word leads, the first that fits.
    pub hears: Vec<(WordId, StateId)>,
    /// Where a command of a torque leads by itself.
    pub commanded: Option<StateId>,
    /// Whether the drive gives no feedback.
    pub is_silent: bool,
    /// Where time leads, s.
    pub after: Option<(f64, StateId)>,
}

/// One word.
#[derive(Clone, Debug)]
pub(super) struct Word {
    pub name: String,
    /// Whether it acts only when the command before did not say it.
    pub is_edge: bool,
    /// The fault that it raises where it leads to a fault.
    pub raises: FaultCode,
    /// Whether it stands in the command itself.
    pub is_in_command: bool,
}

/// What makes a drive stop that hears nothing any more.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Watchdog {
    /// For how long it is patient.
    pub patience: Patience,
    /// Where it leads.
    pub leads_to: StateId,
    /// The fault that it raises, if it does.
    pub fault: FaultCode,
}

/// How long a watchdog waits.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Patience {
    /// So many periods may pass without a command.
    Periods(u32),
    /// So long, s.
    Seconds(f64),
}

impl Conversation {
    /// The state that a drive is in when it is switched on.
    pub const FIRST: StateId = StateId(0);

    /// The state of this name.
    pub fn state(&self, name: &str) -> Option<StateId> {
        self.states.iter().position(|state| state.name == name).map(|index| StateId(index as u8))
    }

    /// The first state that means this.
    pub fn state_meaning(&self, means: DriveState) -> Option<StateId> {
        self.states.iter().position(|state| state.means == means).map(|index| StateId(index as u8))
    }

    /// The word of this name.
    pub fn word(&self, name: &str) -> Option<WordId> {
        self.words.iter().position(|word| word.name == name).map(|index| WordId(index as u8))
    }

    /// What a state is called.
    pub fn name(&self, state: StateId) -> &str {
        &self.at(state).name
    }

    /// What a state means.
    pub fn meaning(&self, state: StateId) -> DriveState {
        self.at(state).means
    }

    /// The word that a command to a drive in this state should carry, if any.
    pub fn word_in_command(&self, state: StateId, request: Request) -> Option<WordId> {
        self.says(state, request).iter().copied().find(|&word| self.words[usize::from(word.0)].is_in_command)
    }

    /// The words with messages of their own to be said to a drive in this state.
    pub fn words_beside(&self, state: StateId, request: Request) -> impl Iterator<Item = WordId> {
        self.says(state, request).iter().copied().filter(|&word| !self.words[usize::from(word.0)].is_in_command)
    }

    /// Where a word leads a drive in this state, if anywhere.
    pub fn hears(&self, state: StateId, word: WordId) -> Option<StateId> {
        self.at(state).hears.iter().find(|(heard, _)| *heard == word).map(|&(_, to)| to)
    }

    /// Whether a word counts only when it was not said just before.
    pub fn is_edge(&self, word: WordId) -> bool {
        self.words[usize::from(word.0)].is_edge
    }

    /// The fault that a word raises where it leads to a fault.
    pub fn raises(&self, word: WordId) -> FaultCode {
        self.words[usize::from(word.0)].raises
    }

    /// Where a command of a torque leads a drive in this state, if anywhere.
    pub fn commanded(&self, state: StateId) -> Option<StateId> {
        self.at(state).commanded
    }

    /// Whether a drive in this state gives no feedback.
    pub fn is_silent(&self, state: StateId) -> bool {
        self.at(state).is_silent
    }

    /// After how many seconds a drive leaves this state by itself, and for
    /// which.
    pub fn after(&self, state: StateId) -> Option<(f64, StateId)> {
        self.at(state).after
    }

    fn says(&self, state: StateId, request: Request) -> &[WordId] {
        &self.at(state).says[request as usize]
    }

    fn at(&self, state: StateId) -> &State {
        &self.states[usize::from(state.0)]
    }
}
