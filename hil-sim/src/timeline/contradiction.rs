//! Events that cannot both be: found before the run, where their moments are
//! known.

use canloop::wheels::Wheels;

use super::what::What;
use super::{Planned, Start};

/// What is wrong with `later` beside `earlier`, which stands before it in the
/// scenario, if anything is: what was found and what was expected.
pub(super) fn between(earlier: &Planned, later: &Planned) -> Option<String> {
    let (one, other) = (span(earlier)?, span(later)?);
    let are_together = one.0 < other.1 && other.0 < one.1;
    let name = &earlier.name;
    match (&earlier.what, &later.what) {
        (What::Load(_), What::Load(_)) if are_together => Some(format!(
            "found a load while another is on, that of `{name}`, expected one at a time: give the first an end, `until_s`"
        )),
        (What::PowerLoss(off), What::DriveFault(raising, _)) | (What::DriveFault(raising, _), What::PowerLoss(off))
            if are_together && have_one_in_common(off, raising) =>
        {
            Some(format!("found it together with `{name}`, expected a drive with power: without, it raises no fault"))
        }
        (one_wish, other_wish) if is_operator(one_wish) && is_operator(other_wish) && one.0 == other.0 => {
            Some(format!("found two wishes of the operator at one moment, this and `{name}`, expected one"))
        }
        _ => None,
    }
}

/// From when to when, s, it goes on or may come again; a moment, where it
/// happens once.
fn span(event: &Planned) -> Option<(f64, f64)> {
    let Start::At(at_s) = event.start else { return None };
    let lasts_s = match event.what {
        _ if event.every_s.is_some() => f64::INFINITY,
        What::DriveFault(..) => f64::MIN_POSITIVE,
        _ => event.lasts_s.unwrap_or(f64::INFINITY),
    };
    // The moment itself is in it.
    Some((at_s, (at_s + lasts_s).max(at_s.next_up())))
}

const fn is_operator(what: &What) -> bool {
    matches!(what, What::Operator(_) | What::NewPath(_))
}

fn have_one_in_common(one: &Wheels<bool>, other: &Wheels<bool>) -> bool {
    one.right && other.right || one.left && other.left
}
