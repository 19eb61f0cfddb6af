"""Compares a run's log with what candump -L wrote beside it, with readers that
we did not write.

usage: same_as_candump.py LOG.mcap CANDUMP.log
"""

import sys
from collections import defaultdict

import can
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

logged = defaultdict(list)
with open(sys.argv[1], "rb") as log:
    reader = make_reader(log, validate_crcs=True, decoder_factories=[DecoderFactory()])
    for _, _, _, frame in reader.iter_decoded_messages(topics=["/can/vcan0"]):
        logged[frame.id].append(bytes(frame.data[: frame.dlc]))

dumped = defaultdict(list)
with can.CanutilsLogReader(sys.argv[2]) as reader:
    for message in reader:
        dumped[message.arbitration_id].append(bytes(message.data))

# The drives' order among each other is theirs: a sender knows its own frame
# sooner than those that others send at the same time.
for ids in (logged, dumped):
    assert sum(map(len, ids.values())) > 5000
# Saying goodbye is the last thing in both; the log has it too.
assert logged.keys() == dumped.keys(), (sorted(logged), sorted(dumped))
for arbitration_id in sorted(logged):
    ours, theirs = logged[arbitration_id], dumped[arbitration_id]
    assert ours == theirs, f"id {arbitration_id:#x}: {len(ours)} in the log, {len(theirs)} from candump"
