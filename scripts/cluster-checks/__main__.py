"""See scripts/test-cluster, which calls this with the path of hil-sim."""

import functools
import os
import pathlib
import shutil
import signal
import sys
import tempfile
import time

import kubernetes
from bench import KILLED, OUT_OF_ORDER, PLAN, Failed, Sweep, output
from machine import run_apart
from parallel import Parallel
from ray_cluster import Ray
from slurm import Slurm


class Tally:
    def __init__(self):
        self.passed = self.failed = self.skipped = 0

    def skip(self, name, why):
        self.skipped += 1
        print(f"left out {name}: {why}", flush=True)

    def holds(self, name, check, *of):
        began = time.monotonic()
        try:
            check(*of)
        except Exception as error:
            self.failed += 1
            print(f"FAILED {name}: {error if isinstance(error, Failed) else repr(error)}", flush=True)
            return False
        self.passed += 1
        print(f"ok     {name}, {time.monotonic() - began:.1f} s", flush=True)
        return True


def as_it_is(engine, new):
    sweep = new("as-it-is")
    engine.sweep(sweep)
    sweep.is_whole()


def out_of_order(engine, new):
    sweep = new("out-of-order", OUT_OF_ORDER)
    engine.sweep(sweep)
    sweep.ended_out_of_order()
    sweep.is_whole()


def killed(engine, new):
    sweep = new("killed", KILLED)
    sweep.went_on(engine.sweep(sweep))
    sweep.is_whole()


def one_process(folder, hil_sim, plan):
    folder.mkdir()
    (folder / "plan.toml").write_text(plan)
    output([hil_sim, "sweep", "plan.toml", "--out", "whole"], cwd=folder)
    return (folder / "whole/results.csv").read_bytes()


def run_checks(folder, hil_sim, is_root):
    tally = Tally()
    # It takes seconds to start, most of which it waits.
    ray = Ray(folder / "ray")
    small = PLAN, one_process(folder / "small", hil_sim, PLAN)
    shipped = kubernetes.plan(), one_process(folder / "shipped", hil_sim, kubernetes.plan())

    tally.holds("Kubernetes: the manifest is valid", kubernetes.is_valid)
    tally.holds("Kubernetes: mistakes in a manifest are found", kubernetes.mistakes_are_found)
    engines = [
        ("Kubernetes", kubernetes.Pods(), shipped),
        ("GNU parallel", Parallel(), small),
        ("Slurm", Slurm(folder / "slurm") if is_root else None, small),
        ("Ray", ray, small),
    ]
    for name, engine, (plan, whole) in engines:
        if engine is None:
            tally.skip(name, "it needs root")
            continue
        if hasattr(engine, "start") and not tally.holds(f"{name}: one node starts", engine.start):
            continue
        here = folder / "sweeps" / name.split()[-1]
        new = functools.partial(Sweep, here, hil_sim, plan, whole)
        tally.holds(f"{name}: the parts make the whole", as_it_is, engine, new)
        tally.holds(f"{name}: parts that end in another order do", out_of_order, engine, new)
        tally.holds(f"{name}: parts of which one was killed do", killed, engine, new)
    skipped = f", {tally.skipped} skipped" if tally.skipped else ""
    print(f"\n{tally.passed} passed, {tally.failed} failed{skipped}", flush=True)
    return 1 if tally.failed else 0


def main():
    hil_sim = pathlib.Path(sys.argv[1])
    for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
        signal.signal(number, lambda number, _: sys.exit(128 + number))
    # Asked here, for apart everybody is root.
    is_root = os.geteuid() == 0
    # Not in TMPDIR: paths of sockets must be short.
    folder = pathlib.Path(tempfile.mkdtemp(prefix="test-cluster.", dir="/tmp"))
    try:
        sys.exit(run_apart(lambda: run_checks(folder, hil_sim, is_root)))
    finally:
        shutil.rmtree(folder)


if __name__ == "__main__":
    main()
