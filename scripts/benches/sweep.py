"""Sweeps: two threads against one and against two processes, and ten thousand runs."""

import csv
import os
import pathlib
import subprocess
import tempfile
import time

from . import common
from .figures import Row, Section, ratios

RUNS, RUNS_QUICK = 400, 200
# So many in two dimensions.
MANY = 100 * 100
MANY_TURNS = 3
PLAN = """\
name = "bench"
scenario = "dac-friction"
set = ["duration_s=20", "period_s=0.005", "expect=[]"]
[[vary]]
key = "robot.load.mass_kg"
from = 0
to = 160
count = {loads}
[[vary]]
key = "controller.model.load.mass_kg"
from = 40
to = 120
count = {beliefs}
"""


def sweep(runs, threads):
    """Seconds and peak memory, MB, of so many runs, every one of which must end well."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        command = [common.HIL_SIM, "sweep", planned(folder, runs), "--threads", str(threads), "--out", folder / "out"]
        elapsed_s, usage = common.spend(command)
        with open(folder / "out/results.csv", newline="") as results:
            outcomes = [row["outcome"] for row in csv.DictReader(results)]
    if outcomes != ["finished"] * runs:
        raise SystemExit(f"scripts/bench: of {runs} runs {outcomes.count('finished')} finished")
    # What the kernel counts, KiB, is never less than what this process had when it began that one.
    return elapsed_s, usage.ru_maxrss * 1024 / 1e6


def two_processes_s(runs):
    """Seconds that two processes of one thread take, half of the runs each."""
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        command = [common.HIL_SIM, "sweep", planned(folder, runs), "--threads", "1"]
        before = time.perf_counter()
        halves = [
            subprocess.Popen([*command, "--shard", f"{half}/2", "--out", folder / str(half)], stdout=subprocess.DEVNULL)
            for half in (1, 2)
        ]
        if any([half.wait() for half in halves]):
            raise SystemExit("scripts/bench: a part of a sweep failed")
        return time.perf_counter() - before


def planned(folder, runs):
    path = folder / "bench.toml"
    path.write_text(PLAN.format(loads=runs // 100, beliefs=100))
    return path


def run(turns, is_quick):
    runs = RUNS_QUICK if is_quick else RUNS
    one_s, two_s, apart_s, many_s, many_mb = [], [], [], [], []
    for turn in range(turns):
        common.progress(f"sweep: turn {turn + 1} of {turns}")
        two_s.append(sweep(runs, 2)[0])
        apart_s.append(two_processes_s(runs))
        if not is_quick:
            one_s.append(sweep(runs, 1)[0])
        if not is_quick and turn < MANY_TURNS:
            elapsed_s, peak_mb = sweep(MANY, os.cpu_count())
            many_s.append(elapsed_s)
            many_mb.append(peak_mb)
    common.progress("")
    # Who else is busy takes as much from two processes as from two threads, but less from one: a ratio to one
    # says little on a shared machine.
    rows = [Row("two threads, times as fast as two processes", ratios(apart_s, two_s), guarded=True, fallen_below=0.7)]
    if is_quick:
        return Section("sweep", "", rows)
    rows.append(Row("two threads, times as fast as one", ratios(one_s, two_s), at_least=1.9))
    rows.append(Row("two processes, times as fast as one: what the machine gives", ratios(one_s, apart_s)))
    how = (
        f"Whole processes of `hil-sim sweep` over loads and believed loads of `dac-friction`, each run 20 s at T = 5 ms over"
        f" CAN; {runs} runs for the ratios, of which two processes of one thread do half each, {MANY} on all cores for the"
        f" rest, at most {MANY_TURNS} times."
    )
    return Section("sweep", how, rows, figures(one_s, two_s, apart_s, many_s, many_mb))


def figures(one_s, two_s, apart_s, many_s, many_mb):
    return [
        Row(f"{RUNS} runs on one thread", one_s, "s"),
        Row(f"{RUNS} runs on two threads", two_s, "s"),
        Row(f"{RUNS} runs in two processes", apart_s, "s"),
        Row(f"{MANY} runs", many_s, "s", at_most=120),
        Row(f"peak memory of {MANY} runs", many_mb, "MB", at_most=200),
    ]
