//! Both ends of a bus as processes that are waited for, and ended whatever
//! happens.

#![allow(dead_code, reason = "every test program uses a part of it")]
#![allow(clippy::disallowed_methods, reason = "other programs are waited for")]

use std::fs::File;
use std::net::TcpListener;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

use crate::rig::{Rig, Run, finish};

/// The environment variable that names the Python interpreter.
pub const PYTHON: &str = "CANLOOP_TEST_PYTHON";

/// Longer than anything here takes on a busy machine with an emulated one in it.
const PATIENCE: Duration = Duration::from_secs(400);

/// A folder, and a bus with two ends.
pub struct Bench {
    pub rig: Rig,
    /// The shipped scenario that both ends run.
    scenario: &'static str,
    serve_bus: String,
    drive_bus: String,
}

/// A program that runs. It is killed when it is dropped.
pub struct Running {
    name: &'static str,
    child: Child,
    stdout: PathBuf,
    stderr: PathBuf,
}

impl Bench {
    /// A bus that `hil-sim serve` hosts.
    pub fn over_tcp() -> Self {
        let port = free_port();
        Self::between(format!("tcp-listen://127.0.0.1:{port}/can0"), format!("tcp://127.0.0.1:{port}/can0"))
    }

    /// The kernel's virtual bus.
    pub fn over_vcan() -> Self {
        Self::between("vcan0".to_owned(), "vcan0".to_owned())
    }

    /// Two cards on one bus.
    pub fn over_two_cards() -> Self {
        Self::between("can1".to_owned(), "can0".to_owned())
    }

    /// A bus whose ends have these addresses.
    pub fn between(serve_bus: String, drive_bus: String) -> Self {
        // Built before anything waits for it.
        canloop();
        Self { rig: Rig::new(), scenario: "dac-friction", serve_bus, drive_bus }
    }

    /// The same bus for another shipped scenario.
    pub fn of(self, scenario: &'static str) -> Self {
        Self { scenario, ..self }
    }

    /// The shipped scenario that both ends run.
    pub fn scenario(&self) -> &'static str {
        self.scenario
    }

    /// The address for others than `hil-sim serve`.
    pub fn address(&self) -> &str {
        &self.drive_bus
    }

    /// `hil-sim serve` of the shipped scenario, once it is on the bus.
    pub fn serve(&self, args: &[&str]) -> Running {
        let mut command = self.rig.command(&["serve", self.scenario, "--bus", &self.serve_bus]);
        command.args(args);
        let mut serve = self.start("serve", &mut command);
        serve.wait_until("it serves", |serve| serve.told().contains("serving"));
        serve
    }

    /// `canloop drive` of the shipped robot, in lock-step.
    pub fn drive(&self, args: &[&str]) -> Running {
        self.drive_in_real_time(&[["--pace", "lockstep"].as_slice(), args].concat())
    }

    /// `canloop drive` of the shipped robot.
    pub fn drive_in_real_time(&self, args: &[&str]) -> Running {
        let config = self.robot_file();
        let mut command = Command::new(canloop());
        command.args(["drive", "--bus", &self.drive_bus, "--config", &config]).args(args);
        self.start("drive", &mut command)
    }

    /// The scenario as a robot file.
    fn robot_file(&self) -> String {
        let printed = self.rig.hil_sim(&["scenario", self.scenario]).expect_status(0);
        self.rig.write("robot.toml", &printed.stdout);
        "robot.toml".to_owned()
    }

    /// Any program, in the folder.
    pub fn start(&self, name: &'static str, command: &mut Command) -> Running {
        let (stdout, stderr) = (self.rig.path(&format!("{name}.out")), self.rig.path(&format!("{name}.err")));
        let create = |path: &Path| File::create(path).expect("the folder is writable");
        let child = command
            .current_dir(self.rig.path(""))
            .stdin(Stdio::null())
            .stdout(create(&stdout))
            .stderr(create(&stderr))
            .spawn()
            .unwrap_or_else(|error| panic!("{name}: {error}"));
        Running { name, child, stdout, stderr }
    }
}

impl Running {
    /// What it has written to standard output so far.
    pub fn told(&self) -> String {
        std::fs::read_to_string(&self.stdout).expect("it writes UTF-8")
    }

    /// Waits until something is so; the program must still run.
    pub fn wait_until(&mut self, what: &str, mut is_so: impl FnMut(&Self) -> bool) {
        let start = Instant::now();
        while !is_so(self) {
            let ended = self.child.try_wait().expect("it is our child");
            assert_eq!(ended, None, "{} ended before {what}: {}", self.name, self.read().stderr);
            assert!(start.elapsed() < PATIENCE, "{} runs, and {what} never", self.name);
            std::thread::sleep(Duration::from_millis(10));
        }
    }

    /// Waits until a file that it writes has so many bytes.
    pub fn wait_for_bytes(&mut self, file: &Path, bytes: u64) {
        self.wait_until("it wrote enough", |_| file.metadata().is_ok_and(|found| found.len() >= bytes));
    }

    /// Sends it a signal, by the name that kill(1) knows.
    pub fn signal(&self, name: &str) {
        let sent = Command::new("sh").args(["-c", &format!("kill -{name} {}", self.child.id())]).status();
        assert!(sent.expect("there is a shell").success());
    }

    /// Waits until it has ended by itself.
    pub fn finish(mut self) -> Run {
        let start = Instant::now();
        let status = loop {
            if let Some(status) = self.child.try_wait().expect("it is our child") {
                break status;
            }
            assert!(start.elapsed() < PATIENCE, "{} does not end:\n{}", self.name, self.told());
            std::thread::sleep(Duration::from_millis(10));
        };
        Run { status: status.code(), ..self.read() }
    }

    fn read(&self) -> Run {
        let stderr = std::fs::read_to_string(&self.stderr).expect("it writes UTF-8");
        Run { status: None, stdout: self.told(), stderr }
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        // It may have ended long ago.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The interpreter itself, which a virtual machine finds faster than its
/// wrappers.
pub fn python() -> String {
    std::env::var(PYTHON).unwrap_or_else(|_| {
        let wrapper = Path::new(env!("CARGO_MANIFEST_DIR")).join("../scripts/python");
        let asked = finish(Command::new(wrapper).args(["-c", "import sys; print(sys.executable)"]));
        asked.expect_status(0).stdout.trim().to_owned()
    })
}

/// The program `canloop`. Cargo builds it for the tests of its own package, not
/// for those of this one.
pub fn canloop() -> PathBuf {
    static BUILT: OnceLock<PathBuf> = OnceLock::new();
    let built = BUILT.get_or_init(|| {
        // In a virtual machine it has been built outside.
        if std::env::var_os(PYTHON).is_none() {
            let mut cargo = Command::new(env!("CARGO"));
            // The program that canloop's own tests have: without tests its dependencies have other features, and
            // would all be built again.
            cargo.args(["test", "--no-run", "--quiet", "--workspace", "--test", "check_command"]);
            cargo.current_dir(env!("CARGO_MANIFEST_DIR"));
            if !cfg!(debug_assertions) {
                cargo.arg("--release");
            }
            // Built with others, it would have to be built again each time.
            let features = [("live", cfg!(feature = "live")), ("foxglove", cfg!(feature = "foxglove"))];
            cargo.args(features.iter().filter(|(_, is_on)| *is_on).map(|(name, _)| format!("--features={name}")));
            finish(&mut cargo).expect_status(0);
        }
        let path = Path::new(env!("CARGO_BIN_EXE_hil-sim")).with_file_name("canloop");
        assert!(path.is_file(), "{} is missing: run `cargo test --workspace`, which builds it", path.display());
        path
    });
    built.clone()
}

/// A port that nobody uses.
pub fn free_port() -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").expect("there are free ports");
    listener.local_addr().expect("it is bound").port()
}
