"""Reads the log of a run with readers that we did not write, and compares it
with the run's summary.

usage: log_of_a_run.py RUN_FOLDER
"""

import json
import math
import sys
import tomllib
from pathlib import Path

import cantools
from blake3 import blake3
from mcap.reader import make_reader
from mcap.records import Attachment, Chunk, Message, Metadata
from mcap.stream_reader import StreamReader
from mcap_protobuf.decoder import DecoderFactory as ProtobufFactory
from mcap_ros2.decoder import DecoderFactory as Ros2Factory


def main(folder):
    summary = json.loads((folder / "summary.json").read_text())
    with open(folder / "run.mcap", "rb") as log:
        attachments = what_comes_before_the_messages(log, summary)
        dbc = cantools.database.load_string(attachments["wheel_drive.dbc"])
        frames = every_decoded_value_is_as_cantools_decodes_it(log, dbc)
        the_frames_are_those_of_the_summary(frames, summary)
        stack_and_truth_have_a_message_a_tick(log, summary)
    print(f"{len(frames)} frames")


def what_comes_before_the_messages(log, summary):
    log.seek(0)
    found = []
    for record in StreamReader(log, emit_chunks=True, validate_crcs=True).records:
        if isinstance(record, (Chunk, Message)):
            break
        found.append(record)
    [metadata] = [record.metadata for record in found if isinstance(record, Metadata)]
    assert metadata["program"] == "hil-sim", metadata
    assert metadata["version"] == summary["version"], metadata
    assert metadata["scenario"] == summary["scenario"], metadata
    assert metadata["seed"] == str(summary["seed"]), metadata
    attachments = {a.name: a.data.decode() for a in found if isinstance(a, Attachment)}
    assert sorted(attachments) == ["scenario.toml", "wheel_drive.dbc", "wheel_drive.toml"], sorted(attachments)
    scenario = tomllib.loads(attachments["scenario.toml"])
    assert scenario["seed"] == summary["seed"], "overrides belong to the scenario"
    assert scenario["robot"]["load"]["mass_kg"] == 81, "overrides belong to the scenario"
    assert tomllib.loads(attachments["wheel_drive.toml"])["dbc"] == "wheel_drive.dbc"
    return attachments


def every_decoded_value_is_as_cantools_decodes_it(log, dbc):
    """Each frame is followed by its decoded message at the same time."""
    log.seek(0)
    reader = make_reader(log, validate_crcs=True, decoder_factories=[ProtobufFactory(), Ros2Factory()])
    frames, decoded = [], []
    for _, channel, message, value in reader.iter_decoded_messages():
        if channel.topic == "/can/can0":
            frames.append((message.log_time, value))
        elif channel.topic.startswith("/can/can0/"):
            decoded.append((message.log_time, channel.topic.removeprefix("/can/can0/"), value))
    assert len(frames) == len(decoded), "every frame of this bus is in the DBC"
    for (at, frame), (decoded_at, name, signals) in zip(frames, decoded):
        stamp = frame.header.stamp
        assert at == decoded_at == stamp.sec * 1_000_000_000 + stamp.nanosec
        layout = dbc.get_message_by_frame_id(frame.id)
        assert (layout.name, layout.length) == (name, frame.dlc)
        wanted = layout.decode(bytes(frame.data[: frame.dlc]), decode_choices=False)
        assert {field.name for field in signals.DESCRIPTOR.fields} == set(wanted)
        for signal, want in wanted.items():
            assert getattr(signals, signal) == want, (name, signal, getattr(signals, signal), want)
    assert {name for _, name, _ in decoded} >= {"Sync", "RightCommand", "LeftFeedback", "RightHeartbeat"}
    assert any(name == "RightCommand" and signals.Torque != 0 for _, name, signals in decoded)
    return frames


def the_frames_are_those_of_the_summary(frames, summary):
    assert len(frames) == summary["bus"]["frames"]
    hasher = blake3()
    for at, frame in frames:
        marked_id = frame.id | int(frame.is_extended) << 31
        hasher.update(at.to_bytes(8, "little") + marked_id.to_bytes(4, "little") + bytes(frame.data[: frame.dlc]))
    assert hasher.hexdigest() == summary["frames_blake3"], hasher.hexdigest()


def stack_and_truth_have_a_message_a_tick(log, summary):
    log.seek(0)
    reader = make_reader(log, decoder_factories=[ProtobufFactory()])
    topics = {"/canloop/stack": [], "/canloop/truth": []}
    for _, channel, _, value in reader.iter_decoded_messages(topics=list(topics)):
        topics[channel.topic].append(value)
    ticks = summary["ticks"]
    # The end of the last period counts, too.
    for messages in topics.values():
        assert [message.tick for message in messages] == list(range(ticks + 1))
    truths = topics["/canloop/truth"]
    errors = [truth.position_error_m for truth in truths]
    tracking = summary["tracking"]
    assert errors[-1] == tracking["final_m"]
    assert max(errors) == tracking["max_m"]
    rms = math.sqrt(sum(error * error for error in errors) / len(errors))
    assert math.isclose(rms, tracking["rms_m"], rel_tol=1e-12), (rms, tracking)
    sent = [abs(torque) for s in topics["/canloop/stack"] for torque in (s.torque_sent_right_nm, s.torque_sent_left_nm)]
    assert max(sent) == summary["torque"]["max_nm"]
    messages = reader.get_summary().statistics.message_count
    assert messages == summary["log"]["messages"]


main(Path(sys.argv[1]))
