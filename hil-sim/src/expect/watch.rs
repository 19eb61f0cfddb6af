//! Follows one expectation through a run.

use canloop::event::{Event, Notice};
use canloop::safety::Reason;
use canloop::time::Instant;

use super::always::Always;
use super::around::Around;
use super::count::Count;
use super::subject::{Said, Subject};
use super::verdict::{Finding, NOT_REACHED, UNSEEN, Verdict, Words, next_to};
use super::within::Within;
use super::{Demand, Expectation};

/// Something that happened and has a name, from which spans can be counted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Occurrence<'n> {
    /// Its name.
    pub name: &'n str,
    /// When it happened, s.
    pub at_s: f64,
}

/// Watches one expectation while the run goes on.
#[derive(Clone, Debug)]
pub struct Watch {
    expectation: Expectation,
    period_s: f64,
    /// The span, once it is known: where it begins and ends, s.
    span_s: Option<(f64, f64)>,
    judge: Judge,
    /// The last sample, of which rates are made.
    before: Option<(f64, f64)>,
    around: Around,
    last_s: f64,
    /// Whether only the stack could judge it, and is not there to.
    is_unseen: bool,
}

#[derive(Clone, Debug)]
enum Judge {
    Always(Always),
    Within(Within),
    Count(Count),
}

impl Watch {
    pub(super) fn new(expectation: Expectation, period_s: f64) -> Self {
        let judge = match expectation.demand {
            Demand::Always => Judge::Always(Always::default()),
            Demand::Within { within_s, for_s } => Judge::Within(Within::new(within_s, for_s)),
            Demand::Count => Judge::Count(Count::default()),
        };
        let mut watch = Self {
            expectation,
            period_s,
            span_s: None,
            judge,
            before: None,
            around: Around::default(),
            last_s: f64::NEG_INFINITY,
            is_unseen: false,
        };
        if watch.expectation.span.after.is_none() {
            watch.begin(0.0);
        }
        watch
    }

    /// The same where the stack is another program: what it tells nobody hears.
    /// `planned` are the names of what the scenario itself lets happen.
    pub fn without_the_stack(self, planned: &[String]) -> Self {
        let Expectation { subject, span, .. } = &self.expectation;
        let waits_for_the_stack = span.after.as_ref().is_some_and(|after| !planned.contains(after));
        Self { is_unseen: subject.is_of_the_stack() || waits_for_the_stack, ..self }
    }

    /// Takes an event.
    pub fn event(&mut self, at: Instant, event: &Event) {
        match event {
            Event::Notice(notice) => self.notice(notice, at.as_secs_f64()),
            Event::Tick(tick) => self.last_s = self.last_s.max(tick.tick as f64 * self.period_s),
            Event::Truth(truth) => self.last_s = self.last_s.max(truth.tick as f64 * self.period_s),
            Event::Frame(_) | Event::Sync(_) | Event::Timing(_) | Event::Mark(_) | Event::Exchange(_) => {}
        }
        match self.expectation.subject.said(at, event, self.period_s) {
            Some(Said::Value(at_s, value)) => self.sample(at_s, value),
            Some(Said::Happened(at_s)) => self.count(at_s),
            None => {}
        }
    }

    /// Takes note of something that happened and has a name; the first of a
    /// name is what spans are counted from.
    pub fn take(&mut self, occurrence: Occurrence<'_>) {
        if self.span_s.is_none() && self.expectation.span.after.as_deref() == Some(occurrence.name) {
            self.begin(occurrence.at_s);
        }
    }

    /// The verdict, once the run is over.
    pub fn verdict(&self) -> Verdict {
        let Expectation { name, subject, bounds, place, .. } = &self.expectation;
        let finding = self.finding();
        let curve = self.around.clone().samples();
        let around = match finding.worst {
            Some((at_s, _)) if !finding.passed => next_to(&curve, at_s),
            _ => Vec::new(),
        };
        Verdict {
            name: name.clone(),
            claim: self.expectation.claim(),
            signal: subject.name().to_owned(),
            from_s: self.span_s.map(|(from_s, _)| from_s),
            until_s: self.span_s.map(|(_, until_s)| until_s),
            min: bounds.min,
            max: bounds.max,
            passed: finding.passed,
            result: finding.text,
            worst: finding.worst.map(|(_, value)| value),
            worst_at_s: finding.worst.map(|(at_s, _)| at_s),
            around,
            file: place.0.clone(),
            line: place.1,
            curve,
        }
    }

    /// What came of it. What a run that was made shorter did not reach is not
    /// held against it.
    fn finding(&self) -> Finding {
        let Expectation { subject, bounds, span, demand, .. } = &self.expectation;
        if self.is_unseen {
            return Finding { passed: true, text: UNSEEN.to_owned(), worst: None };
        }
        let out_of_reach = || Finding { passed: true, text: NOT_REACHED.to_owned(), worst: None };
        let Some((from_s, until_s)) = self.span_s else {
            let mark = span.after.as_deref().unwrap_or_default();
            let text = format!("`{mark}` never happened");
            return if span.shortened { out_of_reach() } else { Finding { passed: false, text, worst: None } };
        };
        if span.shortened && from_s >= until_s {
            return out_of_reach();
        }
        // The last tick of a run has no period of its own, so allow for one.
        let seen_to_the_end = self.last_s >= until_s - 1.5 * self.period_s;
        let words = Words::of(subject);
        let finding = match &self.judge {
            Judge::Always(always) => always.finding(bounds, seen_to_the_end, &words),
            Judge::Within(within) => within.finding(bounds, self.last_s + 1.5 * self.period_s, &words),
            Judge::Count(count) => count.finding(bounds, seen_to_the_end),
        };
        let beyond_the_end = matches!(demand, Demand::Within { within_s, for_s }
            if from_s + within_s + for_s > span.duration_s);
        if !finding.passed && span.shortened && beyond_the_end { out_of_reach() } else { finding }
    }

    fn begin(&mut self, origin_s: f64) {
        let (from_s, until_s) = self.expectation.span.around(origin_s);
        self.span_s = Some((from_s, until_s));
        if let Demand::Within { within_s, for_s } = self.expectation.demand {
            self.judge = Judge::Within(Within::new(from_s + within_s, for_s));
        }
    }

    fn notice(&mut self, notice: &Notice, at_s: f64) {
        self.take(Occurrence { name: notice.kind, at_s });
        let reason = Reason::ALL.iter().find(|reason| notice.kind == "tripped" && reason.text() == notice.text);
        if let Some(reason) = reason {
            self.take(Occurrence { name: reason.name(), at_s });
        }
    }

    fn sample(&mut self, at_s: f64, value: f64) {
        let bounds = self.expectation.bounds;
        let is_in_span = self.is_in_span(at_s);
        let value = match &self.expectation.subject {
            Subject::Rate(_) => {
                // Both samples must be of the span, or its first rate would be of before.
                let Some((before_s, before)) = self.before.replace((at_s, value)).filter(|_| is_in_span) else {
                    return;
                };
                if at_s <= before_s || !self.is_in_span(before_s) {
                    return;
                }
                (value - before) / (at_s - before_s)
            }
            _ => value,
        };
        let margin = self.expectation.subject.margin(value, &bounds);
        let matters = is_in_span
            && match &mut self.judge {
                Judge::Always(always) => always.take(at_s, value, margin),
                Judge::Within(within) => within.take(at_s, value, margin),
                Judge::Count(count) => self.expectation.subject.counts(value) && count.take(at_s, &bounds),
            };
        self.around.take((at_s, value), matters);
    }

    fn count(&mut self, at_s: f64) {
        let is_in_span = self.is_in_span(at_s);
        if let Judge::Count(count) = &mut self.judge
            && is_in_span
        {
            count.take(at_s, &self.expectation.bounds);
        }
    }

    fn is_in_span(&self, at_s: f64) -> bool {
        let grace_s = self.expectation.span.grace_s(self.period_s);
        self.span_s.is_some_and(|(from_s, until_s)| (from_s - grace_s..=until_s + grace_s).contains(&at_s))
    }
}

#[cfg(test)]
mod tests {
    use canloop::event::Truth;

    use super::super::{Bounds, Signal, Span};
    use super::*;

    const PERIOD_S: f64 = 0.01;
    const X_M: Signal = Signal::Truth(1);

    /// What becomes of `x_m <= 1` in a run of 1 s, pushed at 0.105 s.
    fn pushed(after: &str, demand: Demand, x_m: impl Fn(f64) -> f64) -> Verdict {
        let expectation = Expectation {
            name: None,
            subject: Subject::Value(X_M),
            bounds: Bounds { min: None, max: Some(1.0) },
            span: Span { from_s: 0.0, until_s: None, after: Some(after.to_owned()), duration_s: 1.0, shortened: false },
            demand,
            place: (String::new(), 1),
        };
        let mut watch = expectation.watch(PERIOD_S);
        for tick in 0..=100 {
            let at_s = tick as f64 * PERIOD_S;
            let mut truth = Truth { tick, ..Truth::default() };
            truth.pose.x_m = x_m(at_s);
            watch.event(Instant::from_nanos(tick as i64 * 10_000_000), &Event::Truth(truth));
            if tick == 10 || tick == 50 {
                watch.take(Occurrence { name: "push", at_s: at_s + 0.005 });
            }
        }
        watch.verdict()
    }

    #[test]
    fn a_span_is_counted_from_the_first_mark_of_its_name() {
        let verdict = pushed("push", Demand::Always, |at_s| if at_s < 0.105 { 9.0 } else { 0.5 });
        assert!(verdict.passed && verdict.worst_at_s == Some(0.11), "{verdict:?}");
        assert!(!pushed("push", Demand::Always, |at_s| if at_s < 0.115 { 9.0 } else { 0.5 }).passed);
        let never = pushed("pull", Demand::Always, |_| 0.0);
        assert!(!never.passed && never.result == "`pull` never happened", "{never:?}");
    }

    #[test]
    fn a_stay_must_begin_in_time_and_may_end_later() {
        let demand = Demand::Within { within_s: 0.1, for_s: 0.5 };
        let from = |begin_s: f64, end_s: f64| {
            pushed("push", demand, move |at_s| if (begin_s..end_s).contains(&at_s) { 0.0 } else { 2.0 })
        };
        assert!(from(0.195, 0.705).passed);
        assert!(!from(0.215, 0.9).passed, "it began too late");
        let short = from(0.195, 0.695);
        assert!(
            !short.passed && short.result.contains("within bounds for 0.490 s at most, from 0.200 s on"),
            "{short:?}"
        );
    }

    #[test]
    fn a_stay_that_the_end_of_the_run_cuts_off_is_said_to_be() {
        let verdict = pushed("push", Demand::Within { within_s: 0.5, for_s: 0.95 }, |_| 0.0);
        assert!(!verdict.passed && verdict.result.starts_with("the run ended before"), "{verdict:?}");
    }

    #[test]
    fn what_only_the_stack_could_tell_is_not_judged_without_it() {
        let unseen = |subject: Subject, after: Option<&str>| {
            let after = after.map(str::to_owned);
            let expectation = Expectation {
                name: None,
                subject,
                bounds: Bounds { min: None, max: Some(1.0) },
                span: Span { from_s: 0.0, until_s: None, after, duration_s: 1.0, shortened: false },
                demand: Demand::Always,
                place: (String::new(), 1),
            };
            let watch = expectation.watch(PERIOD_S).without_the_stack(&["push".to_owned()]);
            watch.verdict().result == UNSEEN
        };
        assert!(unseen(Subject::Value(Signal::Tick(1)), None));
        assert!(unseen(Subject::Notices("tripped".to_owned()), None));
        assert!(unseen(Subject::Value(X_M), Some("tripped")));
        assert!(!unseen(Subject::Value(X_M), Some("push")));
        assert!(!unseen(Subject::Value(X_M), None));
    }

    #[test]
    fn a_value_that_is_no_number_is_outside_of_every_bound() {
        let verdict = pushed("push", Demand::Always, |at_s| if at_s == 0.5 { f64::NAN } else { 0.0 });
        assert!(!verdict.passed && verdict.result.contains("worst NaN at 0.500 s, no finite number"), "{verdict:?}");
    }
}
