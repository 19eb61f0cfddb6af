"""Compares a log with what was written to it, using readers that we did not write.

usage: mcap_log_reads_back.py LOG.mcap FILE.dbc EXPECTED.jsonl
"""

import json
import math
import sys

import cantools
from mcap.reader import NonSeekingReader, make_reader
from mcap.records import Attachment, Chunk, Metadata
from mcap.stream_reader import StreamReader
from mcap_protobuf.decoder import DecoderFactory as ProtobufFactory
from mcap_ros2.decoder import DecoderFactory as Ros2Factory

FACTORIES = [ProtobufFactory(), Ros2Factory()]


def main(log_path, dbc_path, expected_path):
    dbc = cantools.database.load_file(dbc_path)
    expected = [json.loads(line) for line in open(expected_path, encoding="utf-8")]
    with open(log_path, "rb") as log:
        what_comes_before_the_messages(log, open(dbc_path, "rb").read())
        messages = every_message_is_as_expected(log, expected, dbc)
        the_summary_counts(log, messages)
        seeking_finds_the_same(log, messages)
    print(f"{len(messages)} messages")


def what_comes_before_the_messages(log, dbc_text):
    log.seek(0)
    found = []
    for record in StreamReader(log, emit_chunks=True, validate_crcs=True).records:
        if isinstance(record, Chunk):
            break
        found.append(record)
    metadata = [r for r in found if isinstance(r, Metadata)]
    attachments = [r for r in found if isinstance(r, Attachment)]
    assert [(m.name, m.metadata) for m in metadata] == [("canloop", {"version": "1.2.3"})], metadata
    assert [(a.name, a.media_type, a.data) for a in attachments] == [("made_up.dbc", "text/plain", dbc_text)]


def every_message_is_as_expected(log, expected, dbc):
    """Reads from beginning to end, without the index."""
    log.seek(0)
    reader = NonSeekingReader(log, validate_crcs=True, decoder_factories=FACTORIES)
    messages = list(reader.iter_decoded_messages(log_time_order=False))
    waiting = iter(messages)
    for want in expected:
        schema, channel, message, decoded = next(waiting)
        value = want["value"]
        assert channel.topic == want["topic"], (channel.topic, want)
        assert message.log_time == message.publish_time == max(want["at"], 0), (message, want)
        if "id" not in value:
            found = {name: getattr(decoded, name) for name in value}
            assert found == value, (found, value)
            continue
        frame_is_as_expected(channel, decoded, want["at"], value)
        layout = layout_of(dbc, value)
        if layout and not value["is_rtr"]:
            _, decoded_channel, decoded_message, signals = next(waiting)
            name = layout.name + ("_" if layout.name == "fd" else "")
            assert decoded_channel.topic == f"/can/{value['bus']}/{name}", decoded_channel
            assert decoded_message.log_time == message.log_time
            signals_are_as_cantools_decodes_them(layout, bytes(value["data"]), signals)
    assert next(waiting, None) is None, "more messages than events"
    return messages


def frame_is_as_expected(channel, frame, at, value):
    assert (frame.id, frame.is_extended) == (value["id"], value["is_extended"]), (frame, value)
    if channel.topic.endswith("/fd"):
        assert frame.data == bytes(value["data"])
        assert (frame.bit_rate_switch, frame.sent_by_stack) == (value["bit_rate_switch"], value["sent"])
        return
    stamp = frame.header.stamp
    assert stamp.sec * 1_000_000_000 + stamp.nanosec == at, (stamp, at)
    assert frame.header.frame_id == value["bus"]
    assert (frame.is_rtr, frame.is_error, frame.dlc) == (value["is_rtr"], False, len(value["data"]))
    assert bytes(frame.data) == bytes(value["data"]).ljust(8, b"\0")
    assert channel.metadata["direction"] == ("sent by the stack" if value["sent"] else "received by the stack")


def layout_of(dbc, value):
    key = (value["id"], value["is_extended"])
    return next((m for m in dbc.messages if (m.frame_id, m.is_extended_frame) == key), None)


def signals_are_as_cantools_decodes_them(layout, data, signals):
    wanted = layout.decode(data, decode_choices=False, allow_truncated=True)
    assert {field.name for field in signals.DESCRIPTOR.fields} == {signal.name for signal in layout.signals}
    assert {field.name for field, _ in signals.ListFields()} == set(wanted), (layout.name, data)
    for name, want in wanted.items():
        assert signals.HasField(name), f"{layout.name}.{name} was not written"
        found = getattr(signals, name)
        signal = layout.get_signal_by_name(name)
        whole = signal.scale == 1 and signal.offset == 0 and not signal.is_float
        assert isinstance(found, int if whole else float), (name, found)
        assert found == want or (math.isnan(found) and math.isnan(want)), (layout.name, name, found, want)


def indexed_reader(log):
    log.seek(0)
    return make_reader(log, validate_crcs=True)


def the_summary_counts(log, messages):
    statistics = indexed_reader(log).get_summary().statistics
    counts = {}
    for _, channel, _, _ in messages:
        counts[channel.id] = counts.get(channel.id, 0) + 1
    assert statistics.message_count == len(messages)
    assert statistics.channel_message_counts == counts
    assert statistics.channel_count == len(counts)
    assert statistics.schema_count == len({schema.id for schema, _, _, _ in messages})
    assert statistics.attachment_count == 1
    times = [message.log_time for _, _, message, _ in messages]
    assert (statistics.message_start_time, statistics.message_end_time) == (min(times), max(times))
    end = [record for record in indexed_reader(log).iter_metadata() if record.name == "canloop.log"]
    assert [r.metadata for r in end] == [{"messages": str(len(messages)), "events_lost": "0"}], end


def seeking_finds_the_same(log, messages):
    start, end = 1_100_000_000, 1_900_000_001
    for topics in (["/can/can 1"], ["/canloop/truth", "/can/can0/Feedback"], None):
        wanted = [
            (channel.topic, message.log_time, message.data)
            for _, channel, message, _ in messages
            if start <= message.log_time < end and (topics is None or channel.topic in topics)
        ]
        reader = indexed_reader(log)
        found = [
            (channel.topic, message.log_time, message.data)
            for _, channel, message in reader.iter_messages(topics=topics, start_time=start, end_time=end)
        ]
        assert len(wanted) > 100 and sorted(found) == sorted(wanted), (topics, len(found), len(wanted))


main(*sys.argv[1:])
