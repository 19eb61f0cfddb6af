"""Logs: how fast frames get into a file and out of it, and how large it is."""

import os
import pathlib
import subprocess
import tempfile
import time

from . import common

FRAMES = 500_000
# python-can takes so much longer that fewer do.
FRAMES_FOR_PYTHON = 50_000
SIMULATED_S = 150.0
CAPTURED = 20_000


def written_frames_s(kind, path, *more):
    bench = common.TARGET / "examples/log_bench"
    ran = subprocess.run([bench, kind, path, str(FRAMES), *more], check=True, capture_output=True)
    return float(ran.stdout)


def imported_frames_s(folder):
    before = time.perf_counter()
    command = [common.TARGET / "canloop", "convert", folder / "frames.log", folder / "frames.mcap"]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return FRAMES / (time.perf_counter() - before)


def python_can_reads_frames_s(folder):
    script = "import sys, time, can\nbefore = time.perf_counter()\n" \
        "count = sum(1 for _ in can.LogReader(sys.argv[1]))\nprint(count / (time.perf_counter() - before))"
    ran = subprocess.run(
        [common.ROOT / "scripts/python", "-c", script, folder / "few.log"], check=True, capture_output=True
    )
    return float(ran.stdout)


def replayed_s(folder):
    before = time.perf_counter()
    command = [common.TARGET / "canloop", "replay", folder / "runs/run.mcap"]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return SIMULATED_S / (time.perf_counter() - before)


def captured():
    """CPU seconds a million frames of each logger on a kernel's virtual bus, and
    what share of the frames it kept."""
    script = common.ROOT / "scripts/benches/capture.py"
    ran = subprocess.run(
        [common.ROOT / "scripts/with-vcan", "--", "python3", script, common.TARGET / "canloop", str(CAPTURED)],
        check=True, capture_output=True, text=True, env={**os.environ, "PYTHON_CAN": str(python_path())},
    )
    return {row[0]: tuple(map(float, row[1:])) for row in map(str.split, ran.stdout.splitlines()) if len(row) == 3}


def python_path():
    asked = [common.ROOT / "scripts/python", "-c", "import sys; print(sys.executable)"]
    return subprocess.run(asked, check=True, capture_output=True, text=True).stdout.strip()


def run(turns):
    common.build("--workspace")
    common.build("--example", "log_bench")
    ours, decoded, bare, imported, theirs, replayed = [], [], [], [], [], []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        bench = common.TARGET / "examples/log_bench"
        subprocess.run([bench, "candump", folder / "frames.log", str(FRAMES)], check=True)
        subprocess.run([bench, "candump", folder / "few.log", str(FRAMES_FOR_PYTHON)], check=True)
        command = [common.TARGET / "hil-sim", "run", "dac-friction", "--no-report", "--out", folder / "runs"]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        for turn in range(turns):
            common.progress(f"logs: turn {turn + 1} of {turns}")
            ours.append(written_frames_s("ours", folder / "ours.mcap"))
            decoded.append(written_frames_s("ours", folder / "decoded.mcap", common.ROOT / "dbc/wheel_drive.dbc"))
            bare.append(written_frames_s("bare", folder / "bare.mcap"))
            imported.append(imported_frames_s(folder))
            theirs.append(python_can_reads_frames_s(folder))
            replayed.append(replayed_s(folder))
        common.progress("")
        subprocess.run(
            [common.TARGET / "canloop", "convert", folder / "frames.log", folder / "frames.blf"],
            check=True, stdout=subprocess.DEVNULL,
        )
        sizes = {name: (folder / name).stat().st_size / FRAMES for name in
                 ("ours.mcap", "decoded.mcap", "bare.mcap", "frames.log", "frames.blf")}
    print(f"{FRAMES} classic frames of 8 bytes; frames a second\n")
    print(f"{'':<44} {'median':>10} {'least':>10} {'most':>10}")
    print(f"{'into MCAP, raw':<44} {common.spread(ours)}")
    print(f"{'into MCAP, raw and decoded':<44} {common.spread(decoded)}")
    print(f"{'the mcap crate, the same raw messages':<44} {common.spread(bare)}")
    print(f"{'candump log to MCAP, whole process':<44} {common.spread(imported)}")
    print(f"{'candump log, read by python-can':<44} {common.spread(theirs)}")
    print(f"{'replay, times real time, T = 5 ms':<44} {common.spread(replayed)}")
    print()
    print(f"raw frames go into MCAP {common.ratio(ours, bare):.2f} times as fast as through the bare writer (aim: at least 0.8)")
    print(f"candump logs are read and converted {common.ratio(imported, theirs):.0f} times as fast as python-can reads them (aim: at least 20)")
    print("bytes a frame: " + ", ".join(f"{name} {size:.1f}" for name, size in sizes.items()))
    rows = captured()
    print(f"\n{CAPTURED} frames over the kernel's virtual bus, CPU seconds a million frames and share kept:")
    for logger, (cpu_s, kept) in rows.items():
        print(f"{logger:<20} {cpu_s:>8.1f} s {100 * kept:>6.1f} %")
    print(f"canloop takes {rows['python-can'][0] / rows['canloop'][0]:.0f} times less than python-can's logger")
