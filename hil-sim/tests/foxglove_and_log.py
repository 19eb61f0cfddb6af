"""Compares what an app was told of a run with the run's log.

usage: foxglove_and_log.py SEEN.json RUN.mcap
"""

import base64
import json
import sys

from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory


def main(seen_path, log_path):
    with open(seen_path) as file:
        seen = json.load(file)
    with open(log_path, "rb") as log:
        reader = make_reader(log, validate_crcs=True)
        the_channels_are_the_same(seen["channels"], reader.get_summary())
        the_messages_are_the_same(seen, reader)


def the_channels_are_the_same(channels, summary):
    # MCAP keeps what this channel says of itself as metadata; the app's protocol, version 1, leaves that out.
    logged = []
    for channel in summary.channels.values():
        schema = summary.schemas[channel.schema_id]
        logged.append((channel.topic, channel.message_encoding, schema.name, schema.encoding, schema.data))
    # What has a message only later is not advertised yet.
    told = []
    for channel in channels:
        schema = channel["schema"]
        is_binary = channel["schemaEncoding"] == "protobuf"
        data = base64.b64decode(schema) if is_binary else schema.encode()
        told.append((channel["topic"], channel["encoding"], channel["schemaName"], channel["schemaEncoding"], data))
    assert sorted(told) == sorted(logged), (topics(told), topics(logged))
    names = topics(told)
    assert {"/can/can0", "/can/can0/Sync", "/canloop/stack", "/canloop/truth", "/canloop/notices"} <= set(names), names


def topics(channels):
    return [topic for topic, *_ in sorted(channels)]


def the_messages_are_the_same(seen, reader):
    topic_of = {channel["id"]: channel["topic"] for channel in seen["channels"]}
    logged, decoded = {}, {}
    decoders = DecoderFactory()
    for schema, channel, message in reader.iter_messages():
        logged.setdefault((channel.topic, message.log_time), []).append(message.data)
        decoded.setdefault(channel.topic, (schema, channel))
    values = 0
    for message in seen["messages"]:
        topic, data = topic_of[message["channel"]], base64.b64decode(message["data"])
        assert data in logged[topic, message["log_time"]], (topic, message["log_time"])
        schema, channel = decoded[topic]
        if topic == "/canloop/stack":
            stack = decoders.decoder_for(channel.message_encoding, schema)(data)
            assert stack.odometry_x_m > 1, stack
            values += 1
    assert values > 0, "the stack told nothing"
    print(f"{len(seen['messages'])} messages are the same")


main(*sys.argv[1:])
