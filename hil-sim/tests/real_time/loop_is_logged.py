"""Checks with a reader that we did not write that a log has a timing for each
period of a loop.

usage: loop_is_logged.py LOG.mcap
"""

import math
import sys

from mcap.reader import make_reader
from mcap_protobuf.decoder import DecoderFactory

with open(sys.argv[1], "rb") as log:
    reader = make_reader(log, validate_crcs=True, decoder_factories=[DecoderFactory()])
    timings = [timing for *_, timing in reader.iter_decoded_messages(topics=["/canloop/loop"])]
assert len(timings) >= 1900, len(timings)
assert all(timing.period_s > 0 and timing.lateness_s >= 0 for timing in timings)
answered = [timing for timing in timings if not math.isnan(timing.round_trip_s)]
assert len(answered) > len(timings) / 2, len(answered)
assert all(timing.round_trip_s > 0 and timing.compute_s > 0 for timing in answered)
