"""Copies a log with one bit flipped in a frame that went into the stack, with
readers and writers that we did not write, and prints in which period that was.

usage: flip_a_bit.py LOG COPY NTH_FRAME
"""

import sys

from mcap.reader import make_reader
from mcap.writer import Writer
from mcap_protobuf.decoder import DecoderFactory


def main(log, copy, nth_frame):
    frames, wakeups, flipped_in = 0, 0, None
    with open(log, "rb") as source, open(copy, "wb") as target:
        reader = make_reader(source, decoder_factories=[DecoderFactory()])
        writer = Writer(target)
        writer.start()
        for attachment in reader.iter_attachments():
            writer.add_attachment(
                attachment.create_time, attachment.log_time, attachment.name, attachment.media_type, attachment.data
            )
        channels = {}
        for schema, channel, message in reader.iter_messages():
            if channel.id not in channels:
                schema_id = writer.register_schema(schema.name, schema.encoding, schema.data)
                channels[channel.id] = writer.register_channel(channel.topic, channel.message_encoding, schema_id)
            data = message.data
            if channel.topic == "/canloop/exchange":
                exchange = DecoderFactory().decoder_for(channel.message_encoding, schema)(data)
                wakeups += exchange.what == "wakeup"
                frames += exchange.what == "frame"
                if frames == nth_frame and flipped_in is None and exchange.what == "frame":
                    flipped = bytearray(exchange.data)
                    flipped[0] ^= 1
                    exchange.data = bytes(flipped)
                    data, flipped_in = exchange.SerializeToString(), wakeups - 1
            writer.add_message(channels[channel.id], message.log_time, data, message.publish_time)
        writer.finish()
    print(flipped_in)


main(sys.argv[1], sys.argv[2], int(sys.argv[3]))
