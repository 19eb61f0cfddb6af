"""A real bus, here the one over TCP, which every machine has: round trips,
throughput, and what the loop costs."""

import json
import os
import pathlib
import subprocess
import tempfile

from . import common
from .figures import Row, Section, ratios

PERIOD_US = 5000
SECONDS = 4
FRAMES = 200_000
# Nothing here may trip on a busy machine.
PATIENT = [
    "--set", "safety.overrun_periods=1000",
    "--set", "safety.feedback_timeout_periods=1000",
    "--set", "safety.heartbeat_timeout_s=10",
]
SCENARIO = common.ROOT / "hil-sim/scenarios/dac-friction.toml"


def start(command):
    """Starts a program and waits for its first line."""
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    process.stdout.readline()
    return process


def end(process):
    process.kill()
    process.wait()


def bare_round_trip_us():
    address = f"127.0.0.1:{common.free_port()}/can0"
    bench = common.TARGET / "examples/bus_bench"
    answering = start([bench, "answer", f"tcp-listen://{address}"])
    count = str(SECONDS * 1_000_000 // PERIOD_US)
    asked = subprocess.run([bench, "ask", f"tcp://{address}", str(PERIOD_US), count], check=True, capture_output=True)
    end(answering)
    return float(asked.stdout.split()[0])


def patient_profile(folder):
    """Drives that wait for their commands as long as it takes."""
    text = (common.ROOT / "dbc/wheel_drive.toml").read_text().replace("\nperiods = 4\n", "\nperiods = 1000\n")
    path = pathlib.Path(folder) / "patient.toml"
    path.write_text(text)
    (path.parent / "wheel_drive.dbc").write_text((common.ROOT / "dbc/wheel_drive.dbc").read_text())
    return ["--set", f'drive.profile="{path}"']


def drive(period_s):
    """The figures of a drive against impersonated drives by the clock, and the
    CPU time of a second of it."""
    address = f"127.0.0.1:{common.free_port()}/can0"
    with tempfile.TemporaryDirectory() as folder:
        common_arguments = [*patient_profile(folder), "--set", f"period_s={period_s}", "--set", "bus.bitrate_bit_s=1000000"]
        serving = start(
            [common.HIL_SIM, "serve", "dac-friction", "--bus", f"tcp-listen://{address}", "--time", "wall"]
            + ["--no-log", "--out", folder, *common_arguments]
        )
        summary = pathlib.Path(folder) / "drive.json"
        command = [common.CANLOOP, "drive", "--bus", f"tcp://{address}", "--config", SCENARIO]
        command += ["--duration-s", str(SECONDS), "--summary", summary, *PATIENT, *common_arguments]
        driving = subprocess.Popen(command, stdout=subprocess.DEVNULL)
        _, status, usage = os.wait4(driving.pid, 0)
        driving.returncode = os.waitstatus_to_exitcode(status)
        end(serving)
        if driving.returncode != 0:
            raise SystemExit(f"canloop drive ended with {driving.returncode}")
        return json.loads(summary.read_text()), (usage.ru_utime + usage.ru_stime) / SECONDS


def flood_frames_s():
    return float(common.told([common.TARGET / "examples/bus_bench", "flood", str(common.free_port()), str(FRAMES)]))


def python_can_frames_s():
    return float(common.told([common.PYTHON, common.ROOT / "scripts/peers/virtual_bus.py", str(FRAMES // 10)]))


def run(turns, _is_quick):
    bare, whole, missed, cpu, ours, theirs = [], [], [], [], [], []
    for turn in range(turns):
        common.progress(f"bus: turn {turn + 1} of {turns}")
        bare.append(bare_round_trip_us())
        summary, _ = drive(PERIOD_US / 1e6)
        whole.append(summary["loop"]["round_trip"]["p50_us"])
        missed.append(summary["loop"]["missed"])
        cpu.append(drive(0.001)[1])
        ours.append(flood_frames_s())
        theirs.append(python_can_frames_s())
    common.progress("")
    rows = [
        Row("round trip, times that of a bare echo", ratios(whole, bare), at_most=1.3),
        Row("frames a second, times python-can's virtual bus", ratios(ours, theirs)),
    ]
    figures = [
        Row("round trip p50 of a bare echo", bare, "us"),
        Row("round trip p50 through stack and simulated drives", whole, "us"),
        Row(f"periods missed in {SECONDS} s", missed),
        Row("TCP bus, client to client", ours, "frames/s"),
        Row("python-can's virtual bus, in one process", theirs, "frames/s"),
        Row("CPU time of a second of the loop at 1 kHz", cpu, "s"),
    ]
    how = (
        f"The TCP bus on loopback; round trips from SYNC to the last feedback at T = {PERIOD_US / 1000:.0f} ms, {SECONDS} s a"
        " turn, between `canloop drive` and `hil-sim serve` by the clock."
    )
    return Section("bus", how, rows, figures)
