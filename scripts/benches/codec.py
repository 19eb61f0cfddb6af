"""The codec against the C that cantools generates, the Rust that dbc-codegen
generates, and cantools itself."""

import os
import subprocess

from . import common
from .figures import Row, Section, ratios

PEERS = common.ROOT / "scripts/peers"
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
    target = common.TARGET.parent / "bench-peers"
    cargo = ["cargo", "build", "--release", "--locked", "--manifest-path", PEERS / "Cargo.toml"]
    subprocess.run(cargo, env=os.environ | {"CARGO_TARGET_DIR": str(target)}, check=True)
    generate = [common.PYTHON, "-m", "cantools", "generate_c_source", "--database-name", "bench", "-o", target / "c"]
    subprocess.run([*generate, PEERS / "bench.dbc"], check=True, stdout=subprocess.DEVNULL)
    compile_c = ["cc", "-O2", "-I", target / "c", "-o", target / "codec", PEERS / "codec.c", target / "c" / "bench.c"]
    subprocess.run(compile_c, check=True)
    programs = {
        OURS: [target / "release" / "bench-peers", OURS],
        CODEGEN: [target / "release" / "bench-peers", CODEGEN],
        C: [target / "codec"],
        CANTOOLS: [common.PYTHON, PEERS / "codec.py"],
    }
    return lambda who, work: [*programs[who], work, SECONDS]


def measure(command, turns):
    """Millions of frames a second by work and who, a number a turn."""
    rates = {(name, who): [] for name, (_, peers) in WORKS.items() for who in peers}
    for turn in range(turns):
        common.progress(f"codec: turn {turn + 1} of {turns}")
        for name, who in rates:
            rates[name, who].append(float(common.told(command(who, WORKS[name][0]))))
    common.progress("")
    return rates


def run(turns, _is_quick):
    rates = measure(build(), turns)
    rows = [
        Row(f"{name}, times {who}", ratios(rates[name, OURS], rates[name, who]), at_least=AIMS.get(who))
        for name, who in rates
        if who != OURS
    ]
    figures = [Row(f"{name}, {who}", values, "million frames/s") for (name, who), values in rates.items()]
    how = (
        f"Whole messages of 8 bytes on one core, {SECONDS} s a candidate and turn: 5 signals, or 3 or 4 of 6 multiplexed ones;"
        " canloop makes its codec from the DBC at run time, and unlike the generated C it rounds to the nearest and refuses what"
        " is out of range."
    )
    return Section("codec", how, rows, figures)
