"""Logs: how fast frames get into a file and out of it, and how large it is."""

import os
import pathlib
import subprocess
import tempfile

from . import common
from .figures import Row, Section, ratios

FRAMES = 500_000
# python-can takes so much longer that fewer do.
FRAMES_FOR_PYTHON = 50_000
SIMULATED_S = 150.0
CAPTURED = 20_000
BENCH = common.TARGET / "examples/log_bench"
READ_BY_PYTHON_CAN = (
    "import sys, time, can\nbefore = time.perf_counter()\n"
    "count = sum(1 for _ in can.LogReader(sys.argv[1]))\nprint(count / (time.perf_counter() - before))"
)


def written_frames_s(kind, path, *more):
    return float(common.told([BENCH, kind, path, str(FRAMES), *more]))


def converted_s(folder, to):
    return common.spend([common.CANLOOP, "convert", folder / "frames.log", folder / to])[0]


def python_can_reads_frames_s(folder):
    return float(common.told([common.PYTHON, "-c", READ_BY_PYTHON_CAN, folder / "few.log"]))


def captured():
    """CPU seconds a million frames of each logger on a kernel's virtual bus, and
    what share of the frames it kept."""
    script = common.ROOT / "scripts/benches/capture.py"
    python = common.told([common.PYTHON, "-c", "import sys; print(sys.executable)"]).strip()
    ran = subprocess.run(
        [common.ROOT / "scripts/with-vcan", "--", "python3", script, common.CANLOOP, str(CAPTURED)],
        check=True, capture_output=True, text=True, env={**os.environ, "PYTHON_CAN": python},
    )
    return {row[0]: tuple(map(float, row[1:])) for row in map(str.split, ran.stdout.splitlines()) if len(row) == 3}


def run(turns, is_quick):
    ours, bare, imported, theirs = [], [], [], []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        common.told([BENCH, "candump", folder / "frames.log", str(FRAMES)])
        common.told([BENCH, "candump", folder / "few.log", str(FRAMES_FOR_PYTHON)])
        for turn in range(turns):
            common.progress(f"logs: turn {turn + 1} of {turns}")
            ours.append(written_frames_s("ours", folder / "ours.mcap"))
            bare.append(written_frames_s("bare", folder / "bare.mcap"))
            imported.append(FRAMES / converted_s(folder, "frames.mcap"))
            theirs.append(python_can_reads_frames_s(folder))
        more = [] if is_quick else others(folder, turns)
    common.progress("")
    rows = [
        Row("raw frames into MCAP, times the bare `mcap` writer", ratios(ours, bare), at_least=0.8, guarded=True),
        Row("candump log to MCAP, times python-can reads it", ratios(imported, theirs), at_least=20, guarded=True),
    ]
    figures = [
        Row("into MCAP, raw", ours, "frames/s"),
        Row("the `mcap` crate, the same raw messages", bare, "frames/s"),
        Row("candump log to MCAP, whole process", imported, "frames/s"),
        Row("candump log, read by python-can", theirs, "frames/s"),
    ]
    if is_quick:
        return Section("logs", "", rows)
    on_a_bus, rest = more
    how = (
        f"{FRAMES} classic frames of 8 bytes, {FRAMES_FOR_PYTHON} for python-can; loggers log {CAPTURED} frames on a kernel's"
        " virtual bus, where need be inside user-mode Linux, in which every look at a clock is a system call."
    )
    return Section("logs", how, rows + on_a_bus, figures + rest)


def others(folder, turns):
    """What has no yardstick, or is measured once: ratios and figures."""
    common.spend([common.HIL_SIM, "run", "dac-friction", "--no-report", "--out", folder / "runs"])
    replay = [common.CANLOOP, "replay", folder / "runs/run.mcap"]
    replayed = [SIMULATED_S / common.spend(replay)[0] for _ in range(turns)]
    decoded = [written_frames_s("ours", folder / "decoded.mcap", common.ROOT / "dbc/wheel_drive.dbc") for _ in range(turns)]
    converted_s(folder, "frames.blf")
    kept = {"MCAP": "ours.mcap", "MCAP, raw and decoded": "decoded.mcap", "candump's text": "frames.log", "BLF": "frames.blf"}
    sizes = [Row(f"a frame in {name}", [(folder / file).stat().st_size / FRAMES], "bytes") for name, file in kept.items()]
    captures = [captured() for _ in range(turns)]
    cpu_s = {name: [capture[name][0] for capture in captures] for name in captures[0]}
    shares = {name: [100.0 * capture[name][1] for capture in captures] for name in captures[0]}
    on_a_bus = [
        Row("logging a bus, CPU time, times candump's", ratios(cpu_s["canloop"], cpu_s["candump"])),
        Row("logging a bus, CPU time, times python-can's", ratios(cpu_s["canloop"], cpu_s["python-can"])),
    ]
    figures = [
        Row("into MCAP, raw and decoded", decoded, "frames/s"),
        Row("replay of a run at T = 5 ms", replayed, "times real time"),
        *sizes,
        *(Row(f"CPU time of {name} for a million frames", spent_s, "s") for name, spent_s in cpu_s.items()),
        *(Row(f"share that {name} kept", kept_percent, "%") for name, kept_percent in shares.items()),
    ]
    return on_a_bus, figures
