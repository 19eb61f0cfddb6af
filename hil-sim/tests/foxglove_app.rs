//! `--foxglove`: the Foxglove app looks on, and finds what the log has: the
//! same channels, schemas and bytes.

mod rig;

use rig::{Rig, finish, python};
use std::net::TcpListener;
use std::process::{Child, Command, Stdio};

/// A program that is ended with the test.
struct Ends(Child);

impl Drop for Ends {
    fn drop(&mut self) {
        // It may have ended long ago.
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn an_app_finds_the_channels_and_messages_of_the_log() {
    let rig = Rig::new();
    let port = free_port();
    let address = format!("127.0.0.1:{port}");
    let mut command = rig.command(&["run", "guarded", "--foxglove", &address, "--real-time-factor", "2"]);
    command.args(["--set", "duration_s=1e5"]).stdout(Stdio::null());
    let mut run = Ends(command.spawn().expect("it starts"));
    let told = python("foxglove_app.py", &[address.as_ref(), &rig.path("seen.json")]);
    assert!(told.contains("seen"), "{told}");
    let stopped = finish(Command::new("sh").args(["-c", &format!("kill -INT {}", run.0.id())]));
    stopped.expect_status(0);
    assert_eq!(run.0.wait().expect("it ends").code(), Some(130));
    let told = python("foxglove_and_log.py", &[&rig.path("seen.json"), &rig.path("runs/run.mcap")]);
    assert!(told.contains("the same"), "{told}");
}

#[test]
fn a_port_that_is_taken_is_refused_with_another_one() {
    let taken = TcpListener::bind("127.0.0.1:0").expect("there are free ports");
    let address = taken.local_addr().expect("it is bound").to_string();
    let rig = Rig::new();
    let run = rig.hil_sim(&["run", "dac-friction", "--foxglove", &address]).expect_status(2);
    assert!(run.stderr.contains(&format!("cannot serve the Foxglove app at {address}")), "{}", run.stderr);
    assert!(run.stderr.contains("choose another address"), "{}", run.stderr);
    assert_eq!(rig.files(), [""; 0]);
}

/// A port that nobody uses.
fn free_port() -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").expect("there are free ports");
    listener.local_addr().expect("it is bound").port()
}
