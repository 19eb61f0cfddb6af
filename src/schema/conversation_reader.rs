//! From a profile's TOML to the drive's states and to what can be said to it.

use super::conversation::{Conversation, Patience, State, StateId, Watchdog, Word, WordId};
use super::linker::{Linked, Linker, nearest};
use super::message::{DriveState, FaultCode};
use super::pattern::Field;
use super::profile::words::FAULTS;
use super::quantities::{FaultField, StateField};
use super::roles::{WordContent, WordRole};
use super::signal::Signal;
use crate::config::{Bound, Item, Section};
use crate::wheels::Wheel;

const MEANINGS: [(&str, DriveState); 4] = [
    ("boot", DriveState::Boot),
    ("ready", DriveState::Ready),
    ("enabled", DriveState::Enabled),
    ("fault", DriveState::Fault),
];

/// In the order of [`super::message::Request`].
const WISHES: [&str; 3] = ["disable", "enable", "clear_fault"];

/// Keys of a word that are no signals.
const WORD_KEYS: [&str; 5] = ["message", "shortest", "bytes", "edge", "raises"];

/// `[words]`, `[says]`, `[[state]]`, `[watchdog]` and `[faults]`, opened.
pub(super) struct ConversationReader<'r> {
    words: Vec<(&'r str, Section<'r>)>,
    states: Vec<Section<'r>>,
    names: Vec<String>,
    meanings: Vec<DriveState>,
    says: Section<'r>,
    /// What is heard in every state.
    hears: Section<'r>,
    watchdog: Section<'r>,
    faults: Section<'r>,
}

impl<'r> ConversationReader<'r> {
    pub fn new(root: &Section<'r>) -> Self {
        let words = root.section("words");
        let words: Vec<_> = words.keys().into_iter().map(|name| (name, words.section(name))).collect();
        let states = root.sections("state");
        if states.is_empty() {
            root.text("state");
        }
        // What cannot be linked for another reason is not unknown.
        words.iter().for_each(|(_, word)| word.allow(&word.keys()));
        let shown_as = root.section("heartbeat").text_or_none("shown_as");
        states.iter().for_each(|state| state.allow(&["shows", shown_as.as_deref().unwrap_or("shows")]));
        let watchdog = root.section("watchdog");
        watchdog.allow(&["periods", "after_s", "leads_to", "fault"]);
        let reader = Self {
            names: states.iter().map(|state| state.text("name")).collect(),
            meanings: states.iter().map(|state| state.choice("means", &MEANINGS, true)).collect(),
            words,
            states,
            says: root.section("says"),
            hears: root.section("hears"),
            watchdog,
            faults: root.section("faults"),
        };
        reader.says.allow(&WISHES);
        reader.faults.allow(&FAULTS.map(|(key, _)| key));
        if reader.states.len() > 64 || reader.words.len() > 64 {
            root.complain("state", "found more than 64 states or words, expected at most that");
        }
        reader
    }

    /// States and words; what is wrong with them is reported.
    pub fn conversation(&self) -> Conversation {
        let words = self.words.iter().map(|(name, section)| Word {
            name: (*name).to_owned(),
            is_edge: section.boolean_or("edge", false),
            raises: if section.has("raises") { section.choice("raises", &FAULTS, true) } else { FaultCode::None },
            is_in_command: !section.has("message"),
        });
        Conversation { words: words.collect(), states: (0..self.states.len()).map(|index| self.state(index)).collect() }
    }

    fn state(&self, index: usize) -> State {
        let section = &self.states[index];
        let says = WISHES.map(|wish| {
            let source = if section.has(wish) { section } else { &self.says };
            self.words_under(source, wish)
        });
        let mut hears = self.heard_under(&section.section("hears"));
        hears.extend(self.heard_under(&self.hears));
        let next = section.has("next").then(|| self.state_named(section, "next")).flatten();
        let after_s = section.number_or("after_s", 0.0, Bound::Within(0.0, 1e3));
        State {
            name: self.names[index].clone(),
            means: self.meanings[index],
            says,
            hears,
            commanded: section.has("commanded").then(|| self.state_named(section, "commanded")).flatten(),
            is_silent: section.boolean_or("silent", false),
            after: next.map(|next| (after_s, next)),
        }
    }

    /// How long a drive waits for commands, if it does not do so for ever.
    pub fn watchdog(&self, root: &Section<'_>) -> Option<Watchdog> {
        if !root.has("watchdog") {
            return None;
        }
        let section = &self.watchdog;
        let patience = if section.has("periods") {
            Patience::Periods(section.integer("periods", 1, 1000) as u32)
        } else {
            Patience::Seconds(section.number("after_s", Bound::Within(1e-4, 1e3)))
        };
        let fault = if section.has("fault") { section.choice("fault", &FAULTS, true) } else { FaultCode::None };
        Some(Watchdog { patience, leads_to: self.state_named(section, "leads_to")?, fault })
    }

    /// The words that stand in this wheel's command.
    pub fn in_command(&self, linker: &Linker<'_>, command: Linked<'_>) -> Option<Vec<(WordId, Vec<Field>)>> {
        let words = self.words.iter().enumerate().filter(|(_, (_, section))| !section.has("message"));
        words.map(|(index, (_, section))| Some((WordId(index as u8), fields(section, linker, command)?))).collect()
    }

    /// The words that have messages of their own.
    pub fn beside(&self, linker: &Linker<'_>, wheel: Wheel) -> Option<Vec<WordRole>> {
        let words = self.words.iter().enumerate().filter(|(_, (_, section))| section.has("message"));
        words.map(|(index, (_, section))| word_role(WordId(index as u8), section, linker, wheel)).collect()
    }

    /// How the states show in `signal`: by the key of each that `shown_as` names.
    pub fn state_field(
        &self,
        section: &Section<'_>,
        linker: &Linker<'_>,
        message: Linked<'_>,
    ) -> Option<Option<StateField>> {
        if !section.has("state") {
            return Some(None);
        }
        let signal = linker.signal(section, "state", message)?;
        let key = section.text_or_none("shown_as").unwrap_or_else(|| "shows".to_owned());
        let elsewhere = match section.has("state_elsewhere") {
            true => Some(linker.pattern(section, "state_elsewhere", message, &signal)?),
            false => None,
        };
        let showing = self.states.iter().enumerate().filter(|(_, state)| state.has(&key));
        let shows = showing
            .map(|(index, state)| {
                let pattern = linker.pattern(state, &key, message, &signal)?;
                Some((StateId(index as u8), self.meanings[index], pattern))
            })
            .collect::<Option<Vec<_>>>()?;
        if shows.is_empty() {
            section.complain("state", &format!("found a signal for the state, expected `{key}` in some [[state]]"));
            return None;
        }
        Some(Some(StateField { signal, shows, elsewhere }))
    }

    /// How faults show in a signal.
    pub fn fault_field(
        &self,
        section: &Section<'_>,
        linker: &Linker<'_>,
        message: Linked<'_>,
    ) -> Option<Option<FaultField>> {
        if !section.has("fault") {
            return Some(None);
        }
        let signal = linker.signal(section, "fault", message)?;
        let shares_state = section.has("state") && section.text("fault") == section.text("state");
        let faults = self.faults(linker, message, &signal)?;
        Some(Some(FaultField { signal, faults, shares_state }))
    }

    fn faults(
        &self,
        linker: &Linker<'_>,
        message: Linked<'_>,
        signal: &Signal,
    ) -> Option<Vec<(FaultCode, super::pattern::Pattern)>> {
        let named = FAULTS.iter().filter(|(key, _)| *key == "none" || self.faults.has(key));
        named.map(|&(key, fault)| Some((fault, linker.pattern(&self.faults, key, message, signal)?))).collect()
    }

    fn heard_under(&self, section: &Section<'_>) -> Vec<(WordId, StateId)> {
        let heard = section.keys().into_iter().filter_map(|name| {
            section.allow(&[name]);
            let word = self.word(section, name, name)?;
            Some((word, self.state_named(section, name)?))
        });
        heard.collect()
    }

    fn words_under(&self, section: &Section<'_>, key: &str) -> Vec<WordId> {
        section.texts(key).iter().filter_map(|name| self.word(section, key, name)).collect()
    }

    fn word(&self, section: &Section<'_>, key: &str, name: &str) -> Option<WordId> {
        let found = self.words.iter().position(|(known, _)| *known == name);
        if found.is_none() {
            let names = self.words.iter().map(|(name, _)| *name);
            section.complain(key, &format!("found `{name}`, which is not in [words]; {}", nearest(name, names)));
        }
        found.map(|index| WordId(index as u8))
    }

    fn state_named(&self, section: &Section<'_>, key: &str) -> Option<StateId> {
        let name = section.text(key);
        let found = self.names.iter().position(|known| *known == name);
        if found.is_none() && section.has(key) {
            let names = self.names.iter().map(String::as_str);
            section.complain(key, &format!("found `{name}`, which is no [[state]]; {}", nearest(&name, names)));
        }
        found.map(|index| StateId(index as u8))
    }
}

/// The signals of a word and what they hold.
fn fields(section: &Section<'_>, linker: &Linker<'_>, message: Linked<'_>) -> Option<Vec<Field>> {
    let keys = section.keys().into_iter().filter(|key| !WORD_KEYS.contains(key));
    let fields = keys.map(|key| {
        let signal = linker.signal_named(section, key, key, message)?;
        Some(Field { pattern: linker.pattern(section, key, message, &signal)?, signal })
    });
    fields.collect()
}

fn word_role(word: WordId, section: &Section<'_>, linker: &Linker<'_>, wheel: Wheel) -> Option<WordRole> {
    let message = linker.message(section, Some(wheel))?;
    let envelope = linker.envelope(section, message)?;
    if !section.has("bytes") {
        return Some(WordRole { word, envelope, content: WordContent::Fields(fields(section, linker, message)?) });
    }
    let bytes = section.items("bytes").into_iter().map(|item| match item {
        Item::Integer(byte @ 0..=0xFF) => Some(byte as u8),
        _ => None,
    });
    let bytes: Option<Vec<u8>> = bytes.collect();
    let Some(bytes) = bytes.filter(|bytes| bytes.len() == envelope.len) else {
        section.complain("bytes", &format!("expected {} whole numbers from 0 to 255", envelope.len));
        return None;
    };
    Some(WordRole { word, envelope, content: WordContent::Bytes(bytes) })
}
