"""Checks in a controller's log that it ran, tripped and sent no torque after
the next command.

usage: stays_tripped.py LOG.mcap
"""

import sys

from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

TRIPPED = 10

with open(sys.argv[1], "rb") as log:
    reader = make_reader(log, validate_crcs=True, decoder_factories=[DecoderFactory()])
    notices = [value.message for _, _, _, value in reader.iter_decoded_messages(topics=["/canloop/notices"])]
    ticks = [value for _, _, _, value in reader.iter_decoded_messages(topics=["/canloop/stack"])]

assert any("tripped: " in notice for notice in notices), notices
tripped_at = next(index for index, tick in enumerate(ticks) if tick.state >= TRIPPED)
before, after = ticks[:tripped_at], ticks[tripped_at:]
assert any(tick.torque_sent_right_nm for tick in before), "it drove"
assert all(tick.state >= TRIPPED for tick in after), "it stayed tripped"
assert not any(tick.torque_sent_right_nm or tick.torque_sent_left_nm for tick in after), "it let go"
