"""The codec against the C that cantools generates, the Rust that dbc-codegen
generates, and cantools itself: rows of scripts/bench."""

import os
import pathlib
import subprocess

from benches import common

HERE = pathlib.Path(__file__).resolve().parent
ROOT = common.ROOT
OURS, C, CODEGEN, CANTOOLS = "canloop", "generated C", "dbc-codegen", "cantools"
SECONDS = "0.3"
# Work, and who does it. dbc-codegen has another shape of multiplexed messages.
WORKS = {
    "decode, plain": ("decode-feedback", [OURS, C, CODEGEN, CANTOOLS]),
    "decode, multiplexed": ("decode-measured", [OURS, C, CANTOOLS]),
    "encode, plain": ("encode-feedback", [OURS, C, CODEGEN, CANTOOLS]),
    "encode, multiplexed": ("encode-measured", [OURS, C, CANTOOLS]),
    "encode by names": ("encode-by-name-feedback", [OURS]),
}
# Least times the peer's speed aimed at.
AIMS = {C: 0.5, CANTOOLS: 100}


def build():
    """Builds the peers; a function that gives the command for who and what."""
    target = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")) / "bench-peers"
    cargo = ["cargo", "build", "--release", "--locked", "--manifest-path", HERE / "Cargo.toml"]
    subprocess.run(cargo, env=os.environ | {"CARGO_TARGET_DIR": str(target)}, check=True)
    python = ROOT / "scripts" / "python"
    generate = [python, "-m", "cantools", "generate_c_source", "--database-name", "bench", "-o", target / "c"]
    subprocess.run([*generate, HERE / "bench.dbc"], check=True, stdout=subprocess.DEVNULL)
    compile_c = ["cc", "-O2", "-I", target / "c", "-o", target / "codec", HERE / "codec.c", target / "c" / "bench.c"]
    subprocess.run(compile_c, check=True)
    programs = {
        OURS: [target / "release" / "bench-peers", OURS],
        CODEGEN: [target / "release" / "bench-peers", CODEGEN],
        C: [target / "codec"],
        CANTOOLS: [python, HERE / "codec.py"],
    }
    return lambda who, work: [*programs[who], work, SECONDS]


def measure(command, turns):
    """Millions of frames a second by work and who, a number a turn."""
    rates = {(name, who): [] for name, (_, peers) in WORKS.items() for who in peers}
    for turn in range(turns):
        for name, who in rates:
            run = subprocess.run(command(who, WORKS[name][0]), check=True, capture_output=True, text=True)
            rates[name, who].append(float(run.stdout))
        common.progress(f"codec: turn {turn + 1} of {turns}")
    common.progress("")
    return rates


def report(rates):
    print("\nwhole messages on one core, million frames a second: 5 signals, or 3 or 4 of 6 multiplexed ones\n")
    print(f"{'':<22} {'':<12} {'median':>10} {'least':>10} {'most':>10} {'canloop is':>11} {'aim':>6}")
    for name, (_, peers) in WORKS.items():
        for who in peers:
            numbers = rates[name, who]
            row = common.spread(numbers)
            if who != OURS:
                ratio = common.ratio(rates[name, OURS], numbers)
                aim = f"{AIMS[who]:>5g}x" if who in AIMS else ""
                row += f" {ratio:>10.2f}x {aim:>6}"
            print(f"{name if who == OURS else '':<22} {who:<12} {row}")


def run(turns):
    report(measure(build(), turns))
