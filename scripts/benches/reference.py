"""The guarded ratios of the last full run, and which of today's are far below them."""

import json
import pathlib

FILE = pathlib.Path(__file__).resolve().parent / "reference.json"


def guarded(sections):
    return {section.name: [row for row in section.ratios if row.guarded] for section in sections}


def write(sections):
    medians = {name: {row.what: round(row.median, 3) for row in rows} for name, rows in guarded(sections).items() if rows}
    FILE.write_text(json.dumps(medians, indent=2) + "\n")


def read():
    return json.loads(FILE.read_text())


def complaints(section, reference):
    """What has fallen by more than half, and what has nothing to compare with."""
    kept, found = reference.get(section.name, {}), []
    rows = guarded([section])[section.name]
    for row in rows:
        if row.what not in kept:
            found.append(f"{section.name}: {row.what}: no reference; run scripts/bench")
        elif row.has_fallen_from(kept[row.what]):
            found.append(f"{section.name}: {row.what}: {row.median:.3g}, and it was {kept[row.what]:.3g}")
    return found + [f"{section.name}: {what}: not measured any more" for what in kept.keys() - {row.what for row in rows}]
