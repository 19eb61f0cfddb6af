//! `canloop log` in a folder of its own, and readers of what it writes.

use std::collections::BTreeMap;
use std::io::{BufRead as _, BufReader, Read as _};
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::Duration;

use canloop::bus::{Bus, BusError};
use canloop::frame::Frame;
use canloop::traffic;

use crate::tcp_bus::RunningHub;

/// The program as it logs.
pub struct Logging {
    folder: tempfile::TempDir,
    child: Child,
    stdout: BufReader<ChildStdout>,
}

/// Frames by the name of their bus.
pub struct Found(BTreeMap<String, Vec<Frame>>);

pub fn canloop(args: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_canloop"));
    command.args(args);
    command
}

impl Logging {
    /// Logs these hubs under these names to `bus.mcap`.
    pub fn start(buses: &[(&RunningHub, &str)], more: &[&str]) -> Self {
        let mut command = canloop(&["log", "-o", "bus.mcap"]);
        command.args(arguments(buses)).args(more);
        Self::started(command)
    }

    /// The same where no file may be longer than so many blocks.
    pub fn start_limited(buses: &[(&RunningHub, &str)], blocks: u32) -> Self {
        let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec \"$0\" log -o bus.mcap \"$@\"");
        let mut command = Command::new("sh");
        command.args(["-c", &script, env!("CARGO_BIN_EXE_canloop")]).args(arguments(buses));
        Self::started(command)
    }

    fn started(mut command: Command) -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        command.current_dir(&folder).stdin(Stdio::null()).stdout(Stdio::piped());
        command.stderr(std::fs::File::create(folder.path().join("stderr")).expect("writable"));
        let mut child = command.spawn().expect("the program");
        let mut stdout = BufReader::new(child.stdout.take().expect("it is piped"));
        let mut line = String::new();
        stdout.read_line(&mut line).expect("it says that it logs");
        assert!(line.starts_with("logging "), "{line:?}");
        Self { folder, child, stdout }
    }

    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// The logs there are, in order.
    pub fn files(&self) -> Vec<PathBuf> {
        let entries = std::fs::read_dir(&self.folder).expect("the folder");
        let paths = entries.map(|entry| entry.expect("an entry").path());
        let mut files: Vec<_> = paths.filter(|path| path.extension().is_some_and(|ending| ending == "mcap")).collect();
        files.sort();
        files
    }

    /// Waits until so many frames are in the files.
    #[allow(clippy::disallowed_methods, reason = "another program is waited for")]
    pub fn wait_for_frames(&self, frames: usize) {
        for _ in 0..600 {
            let found: usize = self.files().iter().map(|file| frames_in(file).len()).sum();
            if found >= frames {
                return;
            }
            std::thread::sleep(Duration::from_millis(100));
        }
        panic!("{frames} frames never came");
    }

    pub fn is_running(&mut self) -> bool {
        self.child.try_wait().expect("a child").is_none()
    }

    /// Whether none of its threads is at work at this moment.
    pub fn is_idle(&self) -> bool {
        let tasks = std::fs::read_dir(format!("/proc/{}/task", self.child.id())).expect("Linux");
        // The state stands behind the name, which is in brackets.
        let state = |stat: &str| stat.rsplit(") ").next().and_then(|rest| rest.chars().next());
        let stats = tasks.filter_map(|task| std::fs::read_to_string(task.ok()?.path().join("stat")).ok());
        stats.into_iter().all(|stat| state(&stat) == Some('S'))
    }

    /// Presses Ctrl-C; gives back what it said.
    pub fn interrupt(&mut self) -> String {
        let pid = self.child.id().to_string();
        assert!(Command::new("kill").args(["-INT", &pid]).status().expect("kill").success());
        let (status, told) = self.end();
        assert_eq!(status, Some(0), "{told}");
        told
    }

    /// `kill -9`.
    pub fn kill(&mut self) {
        self.child.kill().expect("it runs");
        self.child.wait().expect("it is dead");
    }

    /// Waits for its end; its status and what it said.
    pub fn end(&mut self) -> (Option<i32>, String) {
        let mut told = String::new();
        self.stdout.read_to_string(&mut told).expect("text");
        let status = self.child.wait().expect("it ends").code();
        told += &std::fs::read_to_string(self.path("stderr")).expect("text");
        (status, told)
    }

    pub fn repair(&self, name: &str) {
        let run = canloop(&["repair", "--in-place", name]).current_dir(&self.folder).output().expect("the program");
        assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
    }
}

impl Drop for Logging {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

impl Found {
    pub fn of(&self, bus: &str) -> Vec<Frame> {
        self.0.get(bus).cloned().unwrap_or_default()
    }

    /// The numbers with which frames of a bus begin.
    pub fn numbers(&self, bus: &str) -> Vec<u32> {
        let number = |frame: &Frame| u32::from_be_bytes(*frame.payload().first_chunk().expect("a number"));
        self.of(bus).iter().map(number).collect()
    }

    pub fn len(&self) -> usize {
        self.0.values().map(Vec::len).sum()
    }
}

/// The frames in a log, as far as it goes.
pub fn frames_in(path: &Path) -> Found {
    let Ok((_, mut reader)) = traffic::open(path, None) else { return Found(BTreeMap::new()) };
    let mut found: BTreeMap<String, Vec<Frame>> = BTreeMap::new();
    while let Some(item) = reader.next() {
        // A log that is being written has no end yet.
        let Ok(record) = item else { break };
        if let Some(frame) = record.frame() {
            found.entry(reader.buses().name(record.bus).to_owned()).or_default().push(*frame);
        }
    }
    Found(found)
}

/// The topics that the `mcap` package from PyPI finds in a whole log.
pub fn python_reads(path: &Path) -> Vec<String> {
    let script = "import sys\nfrom mcap.reader import make_reader\n\
        reader = make_reader(open(sys.argv[1], 'rb'), validate_crcs=True)\n\
        summary = reader.get_summary()\n\
        assert sum(1 for _ in reader.iter_messages()) == summary.statistics.message_count\n\
        print(*(channel.topic for channel in summary.channels.values()))";
    let python = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts/python");
    let output = Command::new(python).args(["-c", script]).arg(path).output().expect("Python");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).split_whitespace().map(str::to_owned).collect()
}

/// How many messages it finds in a log that is still being written.
pub fn python_reads_so_far(path: &Path) -> usize {
    let script = "import sys\nfrom mcap.exceptions import EndOfFile\nfrom mcap.records import Message\n\
        from mcap.stream_reader import StreamReader\ncount = 0\ntry:\n\
        \x20   for record in StreamReader(open(sys.argv[1], 'rb')).records:\n\
        \x20       count += isinstance(record, Message)\nexcept EndOfFile:\n    pass\nprint(count)";
    let python = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts/python");
    let output = Command::new(python).args(["-c", script]).arg(path).output().expect("Python");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8_lossy(&output.stdout).trim().parse().expect("a number")
}

/// Sends a frame, once there is room.
pub fn send(bus: &mut impl Bus, frame: &Frame) {
    loop {
        match bus.send(frame) {
            Ok(()) => return,
            Err(BusError::Full) => std::thread::yield_now(),
            Err(error) => panic!("{error}"),
        }
    }
}

fn arguments(buses: &[(&RunningHub, &str)]) -> Vec<String> {
    let address = |&(hub, name): &(&RunningHub, &str)| {
        assert!(name.starts_with("can"));
        ["--bus".to_owned(), format!("tcp://{}/{name}", hub.address)]
    };
    buses.iter().flat_map(address).collect()
}
