"""Reads a log to its end with a reader that we did not write, and prints how
many frames it holds and what the last six say but for heartbeats, which come when
they come.

usage: end_of_a_log.py LOG.mcap
"""

import sys
from pathlib import Path

import cantools
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

dbc = cantools.database.Database()
for name in ("wheel_drive", "sim"):
    dbc.add_dbc_file(Path(__file__).parents[3] / f"dbc/{name}.dbc")
said = []
with open(sys.argv[1], "rb") as log:
    reader = make_reader(log, validate_crcs=True, decoder_factories=[DecoderFactory()])
    assert reader.get_summary().statistics.message_count > 0, "it was closed as it should"
    for _, _, _, frame in reader.iter_decoded_messages(topics=["/can/can0"]):
        message = dbc.get_message_by_frame_id(frame.id)
        said.append((message.name, message.decode(bytes(frame.data[: frame.dlc]))))
print(len(said))
for name, signals in [(name, signals) for name, signals in said if not name.endswith("Heartbeat")][-6:]:
    print(name, signals.get("Torque", "-"), signals.get("Request", "-"))
