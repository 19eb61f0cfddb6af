//! A bus that a socketcand server lends.

use super::Check;
use crate::bus::Socketcand;
use crate::bus::socketcand::Endpoint;
use crate::config::Problem;
use crate::run::Clock;
use crate::time::Duration;

const SERVER: &str = "bus server";

/// Joins the bus, says nothing, and leaves.
pub(super) fn check(endpoint: &Endpoint, clock: Clock) -> Check {
    let start = clock.now();
    let joined = Socketcand::connect(&endpoint.host, endpoint.port, &endpoint.bus_name, clock);
    judge(endpoint, joined.map(|_| clock.now() - start))
}

/// `joined` is how long it took to connect and get three answers.
fn judge(endpoint: &Endpoint, joined: Result<Duration, Problem>) -> Check {
    match joined {
        Ok(span) => {
            let micros = span.as_nanos() / 1_000;
            Check::ok(SERVER, format!("{endpoint} joined in {micros} us: connecting and three answers"))
        }
        Err(problem) => {
            let help = problem.help.map(|help| format!(" # {help}")).unwrap_or_default();
            let mend = format!("nc -v {} {}{help}", endpoint.host, endpoint.port);
            Check::missing(SERVER, problem.title, mend)
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Outcome;
    use super::*;

    #[test]
    fn a_server_is_all_right_or_missing() {
        let endpoint = Endpoint::parse("127.0.0.1:29536/can0").unwrap();
        let check = judge(&endpoint, Ok(Duration::from_micros(1_234)));
        assert_eq!(check.outcome, Outcome::Ok);
        assert!(check.found.contains("tcp://127.0.0.1:29536/can0 joined in 1234 us"), "{}", check.found);
        let check = judge(&endpoint, Err(Problem::bare("nobody listens").help("start it")));
        assert_eq!((check.outcome, check.found.as_str()), (Outcome::Missing, "nobody listens"));
        assert!(check.mend.unwrap().contains("start it"));
    }
}
