//! What a robot says of its own drives otherwise than their profile: the node
//! ids that they were given, and which of the values that the profile lists for
//! a constant of their commands is sent.
//!
//! Ids move in the DBC's text and the rest in the profile's, and both are then
//! read as any others. So whatever comes of a profile goes by the robot's own
//! ids: codec, filters, message tables, what is attached to a log.

use std::collections::BTreeMap;
use std::sync::Arc;

use super::Profile;
use crate::config::{Document, Item, Problems, Reader, Section, Source};
use crate::frame::CanId;
use crate::schema::dbc::MessageLayout;
use crate::schema::step_end::StepEndCodec;
use crate::wheels::{Wheel, Wheels};

impl Profile {
    /// The profile with `node_ids` and `constants` of a robot's `[drive]` laid
    /// over it. What will not do is reported to the section's reader; the
    /// profile then stays as it is.
    pub fn overridden(self, drive: &Section<'_>) -> Self {
        let (has_ids, has_constants) = (drive.has("node_ids"), drive.has("constants"));
        if !has_ids && !has_constants {
            return self;
        }
        let overridden = Document::parse(format!("{}.toml", self.name), self.toml_text.as_str())
            .map_err(Problems::from)
            .and_then(|toml| Overrides { profile: &self, toml, drive }.apply());
        match overridden {
            Ok(Some(profile)) => return profile,
            Ok(None) => {}
            Err(problems) => problems.0.into_iter().for_each(|problem| drive.report(problem)),
        }
        self
    }
}

/// A profile and what is to be laid over it.
struct Overrides<'p> {
    profile: &'p Profile,
    toml: Document,
    drive: &'p Section<'p>,
}

impl Overrides<'_> {
    /// `None` when a problem was reported to `drive`.
    fn apply(mut self) -> Result<Option<Profile>, Problems> {
        let node_ids = if self.drive.has("node_ids") { self.node_ids() } else { Some(self.profile.node_ids) };
        let (Some(node_ids), Some(constants)) = (node_ids, self.constants()) else { return Ok(None) };
        let Some(dbc) = self.moved(node_ids) else { return Ok(None) };
        for wheel in Wheel::BOTH {
            self.toml.set(&format!("wheels.{}.id = {}", wheel.name(), node_ids[wheel]))?;
        }
        for assignment in constants {
            self.toml.set(&assignment)?;
        }
        let toml = Document::parse(self.toml.name(), self.toml.resolved())?;
        Profile::parse(&toml, &dbc).map(Some)
    }

    fn node_ids(&self) -> Option<Wheels<u8>> {
        let Profile { name, addressing, node_ids: own, .. } = self.profile;
        let section = self.drive.section("node_ids");
        section.allow(&Wheel::BOTH.map(Wheel::name));
        if addressing.mask == 0 {
            let found = format!("found node ids, but the arbitration ids of the profile `{name}` carry none");
            self.drive.complain("node_ids", &found);
            return None;
        }
        let most = i64::from(addressing.most().min(0xFF));
        let ids = Wheels::from_fn(|wheel| {
            if !section.has(wheel.name()) {
                return Some(own[wheel]);
            }
            let id = section.integer_or(wheel.name(), -1, 0, most);
            u8::try_from(id).ok()
        });
        let ids = Wheels { right: ids.right?, left: ids.left? };
        let given = |wheel: &Wheel| section.has(wheel.name());
        let key = |wheel: Wheel| if given(&wheel) { wheel.name() } else { wheel.other().name() };
        if ids.right == ids.left {
            let found = format!("found {}, which the other wheel's drive has too, expected two ids", ids.left);
            section.complain(key(Wheel::Left), &found);
            return None;
        }
        if let Some(wheel) = Wheel::BOTH.into_iter().find(|&wheel| addressing.broadcast == Some(ids[wheel])) {
            section.complain(key(wheel), &format!("found {}, which means all nodes, expected another", ids[wheel]));
            return None;
        }
        Some(ids)
    }

    /// The DBC with the arbitration ids of the nodes' own messages moved.
    fn moved(&self, node_ids: Wheels<u8>) -> Option<Arc<Source>> {
        let Profile { addressing, dbc, .. } = self.profile;
        let names = self.node_names();
        let moved_id = |message: &MessageLayout| {
            let wheel = self.owner(&names, message);
            wheel.map_or(Some(message.id), |wheel| addressing.readdressed(message.id, node_ids[wheel]))
        };
        let end_of_step = StepEndCodec::builtin().id();
        let mut taken = BTreeMap::from([(order(end_of_step), "the marker of lock-step runs")]);
        // Those that stay come first: it is a moved one that takes another's id.
        let (moving, staying): (Vec<_>, Vec<_>) =
            dbc.messages.iter().partition(|message| moved_id(message) != Some(message.id));
        for message in staying.into_iter().chain(moving) {
            let Some(id) = moved_id(message) else {
                self.complain_of(&names, message, node_ids, &format!("is more than the id of {} holds", message.name));
                return None;
            };
            if let Some(other) = taken.insert(order(id), &message.name).filter(|_| id != message.id) {
                let gives = format!("gives {} the id {id}, which is that of {other}", message.name);
                self.complain_of(&names, message, node_ids, &gives);
                return None;
            }
        }
        Some(dbc.renumbered(|message| moved_id(message).unwrap_or(message.id)))
    }

    fn complain_of(&self, names: &Wheels<String>, message: &MessageLayout, node_ids: Wheels<u8>, what: &str) {
        let Some(wheel) = self.owner(names, message) else { return };
        let found = format!("found {}, which {what}, expected another", node_ids[wheel]);
        self.drive.section("node_ids").complain(wheel.name(), &found);
    }

    /// The wheel whose drive a message is of or for: it has the node's name in
    /// its own, and the node's number in its id.
    fn owner(&self, names: &Wheels<String>, message: &MessageLayout) -> Option<Wheel> {
        let Profile { addressing, node_ids, .. } = self.profile;
        let node = addressing.node_in(message.id);
        let is_of = |wheel: &Wheel| {
            addressing.mask != 0 && node == u32::from(node_ids[*wheel]) && message.name.contains(&names[*wheel])
        };
        Wheel::BOTH.into_iter().find(is_of)
    }

    fn node_names(&self) -> Wheels<String> {
        let reader = Reader::new(&self.toml);
        let wheels = reader.root().section("wheels");
        Wheels::from_fn(|wheel| wheels.section(wheel.name()).text("node"))
    }

    /// Assignments that put the chosen value of each constant before the others
    /// that the profile lists.
    fn constants(&self) -> Option<Vec<String>> {
        let reader = Reader::new(&self.toml);
        let listed = reader.root().section("command").section("constants");
        let chosen = self.drive.section("constants");
        chosen.allow(&chosen.keys());
        let assignments: Vec<_> = chosen.keys().into_iter().map(|key| self.constant(&chosen, &listed, key)).collect();
        assignments.into_iter().collect()
    }

    fn constant(&self, chosen: &Section<'_>, listed: &Section<'_>, key: &str) -> Option<String> {
        let name = &self.profile.name;
        if !listed.has(key) {
            let constants = listed.keys().iter().map(|known| format!("`{known}`")).collect::<Vec<_>>().join(", ");
            let of = format!("of the profile `{name}`");
            let found = match constants.as_str() {
                "" => format!("found a constant, but commands {of} have none"),
                known => format!("found no such constant in commands {of}, expected {known}"),
            };
            chosen.complain(key, &found);
            return None;
        }
        let values: Vec<String> = listed.items(key).iter().map(written).collect();
        let wanted = written(&chosen.one_item(key)?);
        if !values.contains(&wanted) {
            let expected = format!("expected {}, as the profile `{name}` lists", values.join(" or "));
            chosen.complain(key, &format!("found {wanted}, {expected}"));
            return None;
        }
        let others = values.into_iter().filter(|value| *value != wanted);
        let values: Vec<String> = [wanted.clone()].into_iter().chain(others).collect();
        Some(format!("command.constants.\"{key}\" = [{}]", values.join(", ")))
    }
}

/// A value as TOML has it.
fn written(item: &Item<'_>) -> String {
    match item {
        Item::Text(text) => toml::Value::from(text.as_str()).to_string(),
        Item::Integer(number) => number.to_string(),
        Item::Number(number) => format!("{number:?}"),
        Item::Table(table) => {
            let bits = |key| table.integer(key, 0, i64::MAX);
            format!("{{ mask = {}, value = {} }}", bits("mask"), bits("value"))
        }
    }
}

/// Tells ids of either width apart.
const fn order(id: CanId) -> (bool, u32) {
    (id.is_extended(), id.raw())
}
