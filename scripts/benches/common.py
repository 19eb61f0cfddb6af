"""What all benchmarks share: builds, processes and their cost, free ports."""

import os
import pathlib
import socket
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
TARGET = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "release"
HIL_SIM, CANLOOP = TARGET / "hil-sim", TARGET / "canloop"
PYTHON = ROOT / "scripts/python"


def build():
    """The programs as they are shipped, and the examples that measure parts of them."""
    # One after the other: tests' dependencies, which examples have, would make other programs.
    for what in ([], ["--example", "bus_bench", "--example", "log_bench"]):
        subprocess.run(["cargo", "build", "--release", "--locked", "--workspace", *what], cwd=ROOT, check=True)


def spend(command, core=None):
    """Runs a program to its end, on this core alone if one is given: seconds that
    passed, and what it used."""
    pinned = None if core is None else lambda: os.sched_setaffinity(0, {core})
    before = time.perf_counter()
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, preexec_fn=pinned)
    _, status, usage = os.wait4(process.pid, 0)
    elapsed_s = time.perf_counter() - before
    process.returncode = os.waitstatus_to_exitcode(status)
    if process.returncode != 0:
        raise SystemExit(f"scripts/bench: {' '.join(map(str, command))} ended with {process.returncode}")
    return elapsed_s, usage


def told(command, core=None):
    """What a program prints."""
    pinned = None if core is None else lambda: os.sched_setaffinity(0, {core})
    return subprocess.run(command, check=True, stdout=subprocess.PIPE, text=True, preexec_fn=pinned).stdout


def last_core():
    return max(os.sched_getaffinity(0))


def free_port():
    with socket.create_server(("127.0.0.1", 0)) as server:
        return server.getsockname()[1]


def progress(text):
    if sys.stderr.isatty():
        print(f"\r{text:<60}", end="" if text else "\r", file=sys.stderr)
