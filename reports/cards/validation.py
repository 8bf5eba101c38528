"""The model against published references: a card, and the same as a document."""

from collections.abc import Sequence
from math import isnan

from cleaning.validation.compare import Check, Comparison, Standing, mean_ratio
from cleaning.validation.quantities import Rows
from reports.tables.table import Block, Card, Note, Table, Text, Tone
from reports.tables.wording import amount, short_number

TONES: dict[Standing, Tone] = {
    "holds": "clean",
    "expected failure": "marginal",
    "fails": "dirty",
    "holds unexpectedly": "dirty",
}
_HEADINGS = ("reference", "rests on", "standing", "check", ">accepted", ">found", ">mean ratio")
_UNEXPECTED = (
    "What it was expected to fail holds now: take that out of expected_failure, and let the documents be written anew."
)


_INTRODUCTION = """# Validation

The model against what others published, as `washboard validate` finds it, which writes this page. What is accepted was
stated before. A reference of *readings* rests on what was read off an experiment; where no readings can be had it holds
the *law*, order or practice that was published, and is no experiment. An expected failure states its reason, and
becomes an error as soon as it holds. `washboard validate FOLDER` compares a reference of your own, a folder with the
two files that each of `cleaning/library/validation` has.
"""


def validation_card(found: Sequence[Comparison]) -> Card:
    """Show every reference with what was accepted and found; below, why some fail."""
    rows: list[tuple[str | Text, ...]] = []
    for each in found:
        for at, check in enumerate(each.checks):
            head: tuple[str | Text, ...] = ("", "", "")
            if at == 0:
                name, standing = each.reference.reference, each.standing
                head = name, _rests_on(each), Text(standing, tone=TONES[standing])
            rows.append((*head, check.name, check.accepted, _found(check), _mean(each) if at == 0 else ""))
    blocks: list[Block] = [Table.of(_HEADINGS, rows)]
    blocks += [Note(TONES[each.standing], each.reference.reference, _why(each)) for each in found if _why(each)]
    tone: Tone = "clean" if all(each.as_expected for each in found) else "dirty"
    return Card(Text(validation_words(found), tone=tone), tuple(blocks))


def validation_words(found: Sequence[Comparison]) -> str:
    """How many references hold: those of readings by themselves, since a law is no experiment."""
    parts = [
        f"{sum(each.standing == 'holds' for each in group)} of {amount(len(group), *nouns)} hold"
        for nouns, group in (
            (
                ("reference with readings", "references with readings"),
                [each for each in found if each.reference.holds == "readings"],
            ),
            (("law",), [each for each in found if each.reference.holds == "law"]),
        )
        if group
    ]
    expected = sum(each.standing == "expected failure" for each in found)
    wrong = sum(not each.as_expected for each in found)
    parts += [f"{amount(expected, 'expected failure')}"] * bool(expected) + [f"{wrong} not as expected"] * bool(wrong)
    return "; ".join(parts)


def validation_document(found: Sequence[Comparison], picture: str = "") -> str:
    """Write the comparison as a Markdown page.

    Args:
        found: All comparisons.
        picture: Link to the drawing from the page; empty where there is none.
    """
    lines = [
        _INTRODUCTION,
        f"{validation_words(found)}.",
        "",
        *([f"![What was published and what is predicted, by reference]({picture})", ""] if picture else []),
        "| reference | rests on | standing | check | accepted | found | mean ratio |",
        "| --- | --- | --- | --- | ---: | ---: | ---: |",
    ]
    for each in found:
        for at, check in enumerate(each.checks):
            name = f"[{each.reference.reference}](#{each.reference.reference})"
            head = (name, _rests_on(each), each.standing) if at == 0 else ("", "", "")
            cells = (*head, f"`{check.name}`", check.accepted, _found(check), _mean(each) if at == 0 else "")
            lines.append(f"| {' | '.join(cells)} |")
    for each in found:
        reference = each.reference
        lines += ["", f"## {reference.reference}", f"{reference.title}: {each.quantity.words}.", ""]
        lines += [f"- Source: {reference.source}.".replace("..", "."), f"- How it was read: {reference.read}"]
        lines += [f"- {words}" for words in _why(each)]
        lines += ["", "| | published | predicted |", "| --- | ---: | ---: |"]
        rows, predicted, low, high = each.compared
        for at, label in enumerate(row_names(rows)):
            value, ends = _number(predicted[at]), (_number(low[at]), _number(high[at]))
            words = value if ends[0] == ends[1] else f"{value} ({ends[0]} to {ends[1]})"
            lines.append(f"| {label} | {_number(rows.published[at])} | {words} |")
    return "\n".join(lines) + "\n"


def _rests_on(each: Comparison) -> str:
    rows = len(each.compared.rows.labels)
    return amount(rows, "reading") if each.reference.holds == "readings" else "law"


def _found(check: Check) -> str:
    return (check.found or "no prediction") + ("" if check.passed else " ✗")


def _mean(each: Comparison) -> str:
    mean = mean_ratio(each.ratios)
    return "" if mean is None else short_number(mean)


def _why(each: Comparison) -> tuple[str, ...]:
    expected = each.reference.expected_failure
    if expected is None:
        return ()
    if each.standing == "holds unexpectedly":
        return (_UNEXPECTED,)
    return f"Fails because: {expected.reason}", f"Needs: {expected.needs}"


def row_names(rows: Rows) -> list[str]:
    """Labels; where some are alike, each with the conditions in which the rows differ."""
    if len(set(rows.labels)) == len(rows.labels):
        return list(rows.labels)
    differing = {name: column for name, column in rows.columns.items() if len(set(column.tolist())) > 1}
    return [
        f"{label}, {', '.join(f'{name} {column[at]:g}' for name, column in differing.items())}"
        for at, label in enumerate(rows.labels)
    ]


def _number(value: float) -> str:
    return "" if isnan(value) else f"{value:.3g}"
