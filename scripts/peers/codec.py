"""cantools itself, as scripts/bench measures it: codec.py WORK SECONDS prints
millions of frames a second."""

import pathlib
import sys
import time

import cantools

FRAMES = 256


def feedback(index):
    low = index & 15
    torque_nm = 0.1 * index
    return {"Position": 1000 * index, "TorqueApplied": torque_nm, "State": low, "Counter": low, "Temperature": 20.0}


def measured(index):
    rest = [{"Speed": 0.1 * index}, {"Current": 0.01 * index, "Voltage": 48.0}, {"Energy": 100.0 * index}]
    return {"Kind": index % 3, "Always": 20.0, **rest[index % 3]}


work, limit_s = sys.argv[1], float(sys.argv[2])
database = cantools.database.load_file(pathlib.Path(__file__).parent / "bench.dbc")
name = "Feedback" if work.endswith("feedback") else "Measured"
values = [(feedback if name == "Feedback" else measured)(index) for index in range(FRAMES)]
message = database.get_message_by_name(name)
frames = [message.encode(value) for value in values]
done, begun_s = 0, time.perf_counter()
while time.perf_counter() - begun_s < limit_s:
    if work.startswith("decode"):
        for frame in frames:
            message.decode(frame, decode_choices=False)
    else:
        for value in values:
            message.encode(value)  # which refuses values out of range, as canloop does
    done += FRAMES
print(f"{1e-6 * done / (time.perf_counter() - begun_s):.6f}")
