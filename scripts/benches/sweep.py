"""Sweeps: two threads against one, and ten thousand runs."""

import csv
import os
import pathlib
import tempfile

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
        plan = folder / "bench.toml"
        plan.write_text(PLAN.format(loads=runs // 100, beliefs=100))
        command = [common.HIL_SIM, "sweep", plan, "--threads", str(threads), "--out", folder / "out"]
        elapsed_s, usage = common.spend(command)
        with open(folder / "out/results.csv", newline="") as results:
            outcomes = [row["outcome"] for row in csv.DictReader(results)]
    if outcomes != ["finished"] * runs:
        raise SystemExit(f"scripts/bench: of {runs} runs {outcomes.count('finished')} finished")
    # What the kernel counts, KiB, is never less than what this process had when it began that one.
    return elapsed_s, usage.ru_maxrss * 1024 / 1e6


def run(turns, is_quick):
    runs = RUNS_QUICK if is_quick else RUNS
    one_s, two_s, many_s, many_mb = [], [], [], []
    for turn in range(turns):
        common.progress(f"sweep: turn {turn + 1} of {turns}")
        one_s.append(sweep(runs, 1)[0])
        two_s.append(sweep(runs, 2)[0])
        if not is_quick and turn < MANY_TURNS:
            elapsed_s, peak_mb = sweep(MANY, os.cpu_count())
            many_s.append(elapsed_s)
            many_mb.append(peak_mb)
    common.progress("")
    # Whoever else is busy for a moment takes a core from two threads, but none from one: half of this ratio is
    # what no threads at all would give, so that a short look takes the best of its turns.
    times_as_fast = [min(one_s) / min(two_s)] if is_quick else ratios(one_s, two_s)
    rows = [Row("two threads, times as fast as one", times_as_fast, at_least=1.9, guarded=True)]
    how = (
        f"Whole processes of `hil-sim sweep` over loads and believed loads of `dac-friction`, each run 20 s at T = 5 ms over"
        f" CAN; {runs} runs for the ratio, {MANY} on all cores for the rest, at most {MANY_TURNS} times."
    )
    return Section("sweep", how, rows, [] if is_quick else figures(one_s, two_s, many_s, many_mb))


def figures(one_s, two_s, many_s, many_mb):
    return [
        Row(f"{RUNS} runs on one thread", one_s, "s"),
        Row(f"{RUNS} runs on two threads", two_s, "s"),
        Row(f"{MANY} runs", many_s, "s", at_most=120),
        Row(f"peak memory of {MANY} runs", many_mb, "MB", at_most=200),
    ]
