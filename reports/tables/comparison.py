"""Two runs on the same workpiece, quantity by quantity; and what each of them cleans."""

from collections import Counter
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from cleaning.report import summarise_part, summarise_report
from cleaning.verdicts.results import (
    CleaningReport,
    Part,
    cleanliness,
    count_cleanliness,
    report_cleanliness,
    stays_wet,
)
from cleaning.verdicts.rules import VERDICTS
from programs.program import TimedProgram
from reports.tables.table import Cell, Column, Table, Text
from reports.tables.wording import SEVERITY_WORDS, clock
from rulesengine.planning.pipeline import Run
from rulesengine.planning.spray_runs import sprayed_in
from specs.json import Json

_NONE = "none"


@dataclass(frozen=True, slots=True)
class Row:
    """One quantity of both runs, as it is written."""

    group: str
    name: str
    here: str
    there: str
    change: str = ""
    """Of the second against the first, such as ``"+12 %"``; empty where both are the same."""

    @property
    def differs(self) -> bool:
        """Whether the runs differ in it."""
        return self.here != self.there


def compare(here: Run, there: Run) -> list[Row]:
    """Compare totals, litres by function, strokes by template, and findings by severity."""
    rows = compare_programs(here.program, there.program)
    strokes = _strokes_by_template(here), _strokes_by_template(there)
    for name in dict.fromkeys([*strokes[0], *strokes[1]]):
        ways = strokes[0].get(name), strokes[1].get(name)
        row = _row("Strokes", name, (sum(ways[0]) if ways[0] else None, sum(ways[1]) if ways[1] else None), _metres)
        counts = [f"{len(each)}, " if each else "" for each in ways]
        rows.append(replace(row, here=counts[0] + row.here, there=counts[1] + row.there))
    found, found_there = (Counter(finding.severity for finding in run.findings) for run in (here, there))
    for severity, word in SEVERITY_WORDS.items():
        rows.append(Row("Findings", word, str(found[severity]), str(found_there[severity])))
    return rows


def compare_programs(here: TimedProgram, there: TimedProgram) -> list[Row]:
    """Compare totals, and litres by function: what a program itself states."""
    one, other = here.totals, there.totals
    litres = dict(one.liquid_l), dict(other.liquid_l)
    return [
        _row("Program", "Total time", (one.duration_s, other.duration_s), clock),
        _row("Program", "Spraying", (one.spray_s, other.spray_s), clock),
        _row("Program", "Travel", (one.travel_mm, other.travel_mm), _metres),
        _row("Program", "Moves", (one.moves, other.moves), "{:,}".format),
        *(
            _row("Liquid", name, (litres[0].get(name), litres[1].get(name)), "{:.2f} l".format)
            for name in dict.fromkeys([*litres[0], *litres[1]])
        ),
    ]


def compare_cleaning(here: CleaningReport, there: CleaningReport) -> list[Row]:
    """Compare verdicts, the worst residue, and every component of which the verdicts differ, the worst first."""
    one, other = (count_cleanliness(report.parts) for report in (here, there))
    wet, others_wet = (str(sum(map(stays_wet, report.parts))) for report in (here, there))
    outcomes = {
        name: [_NONE if part is None else cleanliness(part) + ", wet" * stays_wet(part) for part in both]
        for name, both in _by_component(here, there).items()
    }
    return [
        Row("Cleaning", "Predicted verdict", report_cleanliness(here), report_cleanliness(there)),
        *(
            Row("Cleaning", f"Components {each}", str(one.get(each, 0)), str(other.get(each, 0)))
            for each in VERDICTS
            if each != "avoided" or each in one or each in other
        ),
        Row("Cleaning", "Components that stay wet underneath", wet, others_wet),
        Row("Cleaning", "Bare board", cleanliness(here.bare), cleanliness(there.bare)),
        Row("Cleaning", "Worst residue under a part", _worst_residue(here), _worst_residue(there)),
        *(Row("Verdicts that differ", name, one, other) for name, (one, other) in outcomes.items() if one != other),
    ]


def comparison_tables(rows: Sequence[Row], names: tuple[str, str], change: str = "change") -> list[Table]:
    """Lay out rows, a table for each group; values that do not differ are quiet.

    Args:
        rows: What is compared.
        names: Headings of both columns.
        change: Heading of the changes.
    """
    headings = ("", *(Column(name, "right", is_name=True) for name in names), f">{change}")
    groups: dict[str, list[tuple[Cell, ...]]] = {}
    for row in rows:
        values = (Text(text, "" if row.differs else "quiet") for text in (row.here, row.there))
        groups.setdefault(row.group, []).append((row.name, *values, row.change))
    return [Table.of(headings, shown, group) for group, shown in groups.items()]


def comparison_data(rows: Sequence[Row], here: CleaningReport, there: CleaningReport) -> dict[str, Json]:
    """Collect what is compared as plain data, each report as ``cleaning_report`` has it; the same gives the same."""
    both = {
        name: [None if part is None else summarise_part(part) for part in parts]
        for name, parts in _by_component(here, there).items()
    }
    return {
        "washboard_comparison": 1,
        "reports": [summarise_report(here), summarise_report(there)],
        "rows": [
            {"group": row.group, "name": row.name, "values": [row.here, row.there], "change": row.change}
            for row in rows
        ],
        "components": [{"component": name, "reports": list[Json](parts)} for name, parts in both.items()],
    }


def _by_component(here: CleaningReport, there: CleaningReport) -> dict[str, tuple[Part | None, Part | None]]:
    one, other = ({part.component: part for part in report.parts} for report in (here, there))
    worst = dict.fromkeys(part.component for report in (here, there) for part in report.worst_first())
    return {name: (one.get(name), other.get(name)) for name in worst}


def _strokes_by_template(run: Run) -> dict[str, list[float]]:
    """Sprayed ways, mm, by function and template, the name that the paths panel gives them."""
    found: dict[str, list[float]] = {}
    for sprayed in sprayed_in(run.plan):
        source = sprayed.made_by
        function = run.recipe.sequence[source.step or 0].function
        found.setdefault(f"{function} {source.template}", []).append(sprayed.way_mm)
    return found


def _worst_residue(report: CleaningReport) -> str:
    """Write the highest residue and where it is; a part without a gap has none."""
    known = [(part.residue, part.component) for part in report.parts if part.residue is not None]
    residue, component = max(known, key=lambda each: each[0], default=(0.0, ""))
    percent = "under 0.01" if 0 < residue < 1e-4 else f"{100 * residue:.3g}"
    return f"{percent} % ({component})" if component else _NONE


def _row(group: str, name: str, values: tuple[float | None, float | None], write: Callable[[float], str]) -> Row:
    """Write two values, which may be missing, with the change in percent where there is any."""
    one, other = values
    here, there = (_NONE if each is None else write(each) for each in values)
    percent = 100 * (other - one) / one if one and other is not None else 0.0
    change = f"{percent:+z.0f} %" if abs(percent) >= 10 else f"{percent:+z.1f} %" if abs(percent) >= 0.05 else ""
    return Row(group, name, here, there, change)


def _metres(travel_mm: float) -> str:
    return f"{travel_mm / 1000:.2f} m"
