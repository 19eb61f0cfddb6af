"""Simulated seconds a second: whole processes of hil-sim."""

import statistics
import subprocess
import tempfile
import time

from . import common

SIMULATED_S = 150.0
FAST_BUS = ["--set", "period_s=0.001", "--set", "bus.bitrate_bit_s=1000000"]
IDEAL = ["--set", 'bus.link="ideal"', "--set", "period_s=0.001"]

# Name, arguments of `hil-sim run dac-friction`, least times real time aimed at.
CANDIDATES = [
    ("over CAN, no log", [*FAST_BUS, "--no-log", "--no-report"], 1000),
    ("over CAN, logged", [*FAST_BUS, "--no-report"], 400),
    ("plant and law only, no log", [*IDEAL, "--no-log", "--no-report"], None),
]


def wall_s(arguments, folder):
    command = [common.TARGET / "hil-sim", "run", "dac-friction", "--out", folder, *arguments]
    before = time.perf_counter()
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return time.perf_counter() - before


def run(turns):
    common.build("-p", "hil-sim")
    times = {name: [] for name, *_ in CANDIDATES}
    with tempfile.TemporaryDirectory() as folder:
        for turn in range(turns + 1):
            common.progress(f"lock-step: turn {turn} of {turns}")
            for name, arguments, _ in CANDIDATES:
                elapsed_s = wall_s(arguments, folder)
                if turn > 0:  # the first turn warms up
                    times[name].append(elapsed_s)
    common.progress("")
    print(f"{SIMULATED_S:.0f} s of dac-friction, T = 1 ms, 1 Mbit/s, whole process, s\n")
    print(f"{'':<28} {'median':>10} {'least':>10} {'most':>10} {'times real time':>17} {'aim':>6}")
    for name, _, aim in CANDIDATES:
        speed = SIMULATED_S / statistics.median(times[name])
        print(f"{name:<28} {common.spread(times[name])} {speed:>17.0f} {aim or '':>6}")
    bare = CANDIDATES[-1][0]
    print()
    for name, *_ in CANDIDATES[:-1]:
        print(f"{name} costs {common.ratio(times[name], times[bare]):.2f} times {bare}")
