//! A survey for machines. Units are the last word of a key.

use serde_json::{Value, json};

use super::Survey;
use super::message::Message;
use crate::time::{Duration, Instant};
use crate::traffic::Buses;

impl Survey {
    /// All of it.
    pub fn json(&self, buses: &Buses) -> Value {
        json!({
            "records": self.records,
            "first_s": self.first.map(seconds),
            "last_s": self.last.map(seconds),
            "span_s": self.span_s(),
            "stamps": {
                "resolution_s": self.stamps.resolution_ns().map(|ns| ns as f64 / 1e9),
                "backwards": self.stamps.backwards,
                "furthest_back_s": self.stamps.furthest_back.as_secs_f64(),
                "repeated": self.stamps.repeated,
                "longest_gap": gap(self.stamps.longest_gap),
            },
            "buses": self.buses_json(buses),
            "messages": self.messages.iter().map(|((bus, _), message)| message_json(buses.name(*bus), message)).collect::<Vec<_>>(),
        })
    }

    fn buses_json(&self, buses: &Buses) -> Vec<Value> {
        let span_s = self.span_s();
        let known = self.rates.is_some() && span_s > 0.0;
        let bus = |(index, bus): (u16, &super::Bus)| {
            json!({
                "name": buses.name(index),
                "frames": bus.frames,
                "sent": bus.sent,
                "fd": bus.fd,
                "errors": bus.errors,
                "lost": bus.lost,
                "load": known.then(|| bus.busy_s / span_s),
                "load_of_busiest_second": known.then(|| bus.busiest()),
            })
        };
        (0..).zip(&self.buses).map(bus).collect()
    }
}

fn message_json(bus: &str, message: &Message) -> Value {
    let periods = message.periods();
    json!({
        "bus": bus,
        "id": message.id.raw(),
        "is_extended": message.id.is_extended(),
        "kind": message.kind(),
        "count": message.count,
        "sent": message.sent,
        "remote": message.remote,
        "fd": message.fd,
        "shortest_bytes": message.lengths.0,
        "longest_bytes": message.lengths.1,
        "period_s": periods.map(|periods| periods.median_s),
        "jitter_s": periods.map(|periods| periods.jitter_s),
        "longest_gap": gap(message.longest_gap),
    })
}

fn gap(gap: Option<(Duration, Instant)>) -> Option<Value> {
    gap.map(|(span, at)| json!({ "span_s": span.as_secs_f64(), "begins_s": seconds(at) }))
}

fn seconds(at: Instant) -> f64 {
    at.as_secs_f64()
}
