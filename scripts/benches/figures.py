"""What a benchmark finds, as data: rows of values, a value a turn."""

import dataclasses
import statistics


@dataclasses.dataclass
class Row:
    """One figure. A row that is `guarded` is a ratio of two things that one machine
    did in one turn, so that another machine gives about the same: a gross fall
    of it fails scripts/bench --quick: to half of what it was, or to another share
    where less is a gross fall, as of two threads that wait for each other."""

    what: str
    values: list
    unit: str = ""
    at_least: float = None
    at_most: float = None
    guarded: bool = False
    fallen_below: float = 0.5

    @property
    def median(self):
        return statistics.median(self.values)

    @property
    def aim(self):
        if self.at_least is not None:
            return f"at least {self.at_least:g}"
        return "" if self.at_most is None else f"at most {self.at_most:g}"

    @property
    def verdict(self):
        if not self.aim:
            return ""
        is_met = self.median >= self.at_least if self.at_least is not None else self.median <= self.at_most
        return "met" if is_met else "MISSED"

    def has_fallen_from(self, reference):
        share = reference / self.median if self.at_most is not None else self.median / reference
        return share < self.fallen_below


@dataclasses.dataclass
class Section:
    """What one benchmark finds: ratios, what they were made from, and one sentence
    that says how it is measured."""

    name: str
    how: str
    ratios: list
    figures: list = dataclasses.field(default_factory=list)


def ratios(over, under):
    """Turn by turn: both of a turn had the same minute of the machine."""
    return [a / b for a, b in zip(over, under, strict=True)]
