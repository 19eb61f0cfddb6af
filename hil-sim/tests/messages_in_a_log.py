"""Prints which messages are in the log of a run, by the DBC attached to it, and
what they say of nodes and modes.

usage: messages_in_a_log.py RUN_FOLDER DBC
"""

import sys
from pathlib import Path

import cantools
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

SHOWN = ["Node", "Mode_Of_Operation", "Mode_Display"]


def main(folder, dbc_name):
    with open(folder / "run.mcap", "rb") as log:
        reader = make_reader(log, validate_crcs=True, decoder_factories=[DecoderFactory()])
        [text] = [a.data.decode() for a in reader.iter_attachments() if a.name == dbc_name]
        dbc = cantools.database.load_string(text)
        said = {}
        for _, _, _, frame in reader.iter_decoded_messages(topics=["/can/can0"]):
            message = dbc.get_message_by_frame_id(frame.id)
            signals = message.decode(bytes(frame.data[: frame.dlc]), decode_choices=False)
            values = said.setdefault(frame.id, (message.name, {}))[1]
            for name in SHOWN:
                if name in signals:
                    values.setdefault(name, set()).add(signals[name])
        topics = {channel.topic for channel in reader.get_summary().channels.values()}
    for arbitration_id, (name, values) in sorted(said.items()):
        assert f"/can/can0/{name}" in topics, name
        shown = [f" {key}: {' '.join(map(str, sorted(found)))}" for key, found in values.items()]
        print(f"{arbitration_id:03X} {name}{''.join(shown)}")


main(Path(sys.argv[1]), sys.argv[2])
