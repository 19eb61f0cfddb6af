"""Reads the log of a run that was interrupted, to its end.

usage: interrupted_run.py RUN_FOLDER
"""

import json
import sys
from pathlib import Path

from mcap.reader import make_reader

folder = Path(sys.argv[1])
summary = json.loads((folder / "summary.json").read_text())
with open(folder / "run.mcap", "rb") as log:
    reader = make_reader(log, validate_crcs=True)
    statistics = reader.get_summary().statistics
    count, truths, last = 0, 0, 0
    for _, channel, message in reader.iter_messages():
        count += 1
        truths += channel.topic == "/canloop/truth"
        last = message.log_time
assert count == statistics.message_count == summary["log"]["messages"], (count, statistics, summary["log"])
assert truths == summary["ticks"] + 1, (truths, summary["ticks"])
assert abs(last * 1e-9 - summary["simulated_s"]) < 2 * summary["period_s"], (last, summary["simulated_s"])
print(f"{count} messages")
