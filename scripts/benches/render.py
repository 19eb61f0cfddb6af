"""The report: in the terminal, and as BENCHMARKS.md."""

HEAD = ["", "median", "least", "most", "unit", "aim", ""]


def number(value):
    is_whole = value == int(value) or abs(value) >= 100
    return f"{value:,.0f}".replace(",", " ") if is_whole else f"{value:.3g}"


def cells(row):
    figures = [row.median, min(row.values), max(row.values)]
    return [row.what, *map(number, figures), row.unit, row.aim, row.verdict]


def in_terminal(section):
    lines = [f"== {section.name}"]
    for what, rows in (("ratios", section.ratios), ("what they are made from", section.figures)):
        if rows:
            lines.append(f"{what:<56} {'median':>10} {'least':>10} {'most':>10}  {'unit':<17} {'aim':<13}")
            lines.extend("{:<56} {:>10} {:>10} {:>10}  {:<17} {:<13} {}".format(*cells(row)).rstrip() for row in rows)
    return "\n".join(lines) + "\n"


def table(head, rows):
    lines = [[head, *HEAD[1:]], ["---", "---:", "---:", "---:", "---", "---", "---"], *map(cells, rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def aims(sections):
    """How many there are, and lines about those missed."""
    aimed = [(section.name, row) for section in sections for row in section.ratios + section.figures if row.aim]
    missed = [
        " ".join(f"- {name}: {row.what}: {number(row.median)} {row.unit}".split()) + f", aim {row.aim}"
        for name, row in aimed
        if row.verdict != "met"
    ]
    met = f"Of {len(aimed)} aims {len(aimed) - len(missed)} are met"
    return [f"{met}; missed are:", "\n".join(missed)] if missed else [f"{met}."]


def markdown(machine, turns, is_trial, sections):
    parts = ["# Benchmarks", INTRODUCTION.format(turns=turns, s="" if turns == 1 else "s")]
    if is_trial:
        parts.append(TRIAL)
    parts.append("\n".join(["| | |", "|---|---|", *(f"| {what} | {which} |" for what, which in machine.items())]))
    parts += aims(sections)
    for section in sections:
        parts += [f"## {section.name}", f"{section.how} Again with `scripts/bench {section.name}`."]
        parts.append(table("ratio", section.ratios))
        if section.figures:
            parts.append(table("made from", section.figures))
    return "\n\n".join(parts) + "\n"


INTRODUCTION = """\
Written by `scripts/bench`, which measures everything again and writes this file and what `scripts/bench --quick` compares
with. All candidates of a section take turns, {turns} turn{s} each. A ratio is that of two of them in the same turn; shown is the
median of the turns, with the least and the most. Only ratios mean something on another machine, or in another hour of
this one."""

TRIAL = "**A trial with too few turns, to try the benchmarks themselves: do not quote these figures.**"
