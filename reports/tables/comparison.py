"""Two runs on the same board, quantity by quantity; and what each of them cleans."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass

from cleaning.report import summarise_part, summarise_report
from cleaning.verdicts.cleanliness import cleanliness, count_cleanliness, report_cleanliness, stays_wet
from cleaning.verdicts.results import CleaningReport, Part
from cleaning.verdicts.rules import VERDICTS
from programs.program import TimedProgram
from reports.tables.summary import clock
from rulesengine.planning.pipeline import Run
from rulesengine.planning.spray_runs import sprayed_in
from specs.finding import Severity
from specs.json import Json

SEVERITY_WORDS: dict[Severity, str] = {"error": "Errors", "warning": "Warnings", "info": "Notes"}
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
        """Say whether the runs differ in it."""
        return self.here != self.there


def compare(here: Run, there: Run) -> list[Row]:
    """Compare totals, litres by function, strokes by template, and findings by severity."""
    return [*compare_programs(here.program, there.program), *_templates(here, there), *_findings(here, there)]


def compare_programs(here: TimedProgram, there: TimedProgram) -> list[Row]:
    """Compare totals, and litres by function: what a program itself says."""
    return [*_totals(here, there), *_litres(here, there)]


def compare_cleaning(here: CleaningReport, there: CleaningReport) -> list[Row]:
    """Compare verdicts, the worst residue, and every component of which the verdicts differ, the worst first."""
    return [*_verdicts(here, there), _residue(here, there), *_components(here, there)]


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


def _totals(here: TimedProgram, there: TimedProgram) -> list[Row]:
    one, other = here.totals, there.totals
    group = "Program"
    return [
        Row(
            group, "Total time", clock(one.duration_s), clock(other.duration_s), _part(one.duration_s, other.duration_s)
        ),
        Row(group, "Spraying", clock(one.spray_s), clock(other.spray_s), _part(one.spray_s, other.spray_s)),
        Row(group, "Travel", _metres(one.travel_mm), _metres(other.travel_mm), _part(one.travel_mm, other.travel_mm)),
        Row(group, "Moves", f"{one.moves:,}", f"{other.moves:,}", _part(one.moves, other.moves)),
    ]


def _litres(here: TimedProgram, there: TimedProgram) -> list[Row]:
    one, other = dict(here.totals.liquid_l), dict(there.totals.liquid_l)
    return [
        Row(
            "Liquid",
            name,
            _litre(one.get(name)),
            _litre(other.get(name)),
            _part(one.get(name), other.get(name)),
        )
        for name in dict.fromkeys([*one, *other])
    ]


def _templates(here: Run, there: Run) -> list[Row]:
    one, other = _strokes_by_template(here), _strokes_by_template(there)
    return [
        Row("Strokes", name, *_stroke_values(one.get(name), other.get(name))) for name in dict.fromkeys([*one, *other])
    ]


def _stroke_values(one: "_Strokes | None", other: "_Strokes | None") -> tuple[str, str, str]:
    change = _part(one.way_mm, other.way_mm) if one is not None and other is not None else ""
    return str(one or _NONE), str(other or _NONE), change


@dataclass(slots=True)
class _Strokes:
    """What one template sprays in one step."""

    count: int = 0
    way_mm: float = 0.0

    def __str__(self) -> str:
        return f"{self.count}, {_metres(self.way_mm)}"


def _strokes_by_template(run: Run) -> dict[str, _Strokes]:
    found: dict[str, _Strokes] = {}
    for sprayed in sprayed_in(run.plan):
        strokes = found.setdefault(_place_name(run, sprayed.place), _Strokes())
        strokes.count += 1
        strokes.way_mm += sprayed.way_mm
    return found


def _place_name(run: Run, place: str) -> str:
    """Name a template in its step as the paths panel does: its function and itself."""
    step, _, template = place.partition("/")
    number = int(step.removeprefix("sequence[").removesuffix("]"))
    return f"{run.recipe.sequence[number].function} {template}"


def _findings(here: Run, there: Run) -> list[Row]:
    one, other = (Counter(finding.severity for finding in run.findings) for run in (here, there))
    return [
        Row("Findings", word, str(one[severity]), str(other[severity])) for severity, word in SEVERITY_WORDS.items()
    ]


def _verdicts(here: CleaningReport, there: CleaningReport) -> list[Row]:
    one, other = (count_cleanliness(report.parts) for report in (here, there))
    wet, others_wet = (str(sum(map(stays_wet, report.parts))) for report in (here, there))
    return [
        Row("Cleaning", "Predicted verdict", report_cleanliness(here), report_cleanliness(there)),
        *(Row("Cleaning", f"Components {each}", str(one.get(each, 0)), str(other.get(each, 0))) for each in VERDICTS),
        Row("Cleaning", "Components that stay wet underneath", wet, others_wet),
        Row("Cleaning", "Bare board", cleanliness(here.bare), cleanliness(there.bare)),
    ]


def _residue(here: CleaningReport, there: CleaningReport) -> Row:
    one, other = (_worst_residue(report) for report in (here, there))
    return Row("Cleaning", "Worst residue under a part", one, other)


def _worst_residue(report: CleaningReport) -> str:
    """Write the highest residue and where it is; what has no gap has none."""
    known = [(part.residue, part.component) for part in report.parts if part.residue is not None]
    residue, component = max(known, key=lambda each: each[0], default=(0.0, ""))
    percent = "under 0.01" if 0 < residue < 1e-4 else f"{100 * residue:.3g}"
    return f"{percent} % ({component})" if component else _NONE


def _components(here: CleaningReport, there: CleaningReport) -> list[Row]:
    told = {
        name: [_NONE if part is None else _outcome(part) for part in both]
        for name, both in _by_component(here, there).items()
    }
    return [Row("Verdicts that differ", name, one, other) for name, (one, other) in told.items() if one != other]


def _outcome(part: Part) -> str:
    """Write how clean a component comes out, and whether it stays wet."""
    return f"{cleanliness(part)}, wet" if stays_wet(part) else cleanliness(part)


def _part(one: float | None, other: float | None) -> str:
    """Write a change in percent; nothing where there is none, or nothing to take it of."""
    if one is None or other is None or one == 0:
        return ""
    change = 100 * (other - one) / one
    return "" if abs(change) < 0.05 else f"{change:+.0f} %" if abs(change) >= 10 else f"{change:+.1f} %"


def _litre(value: float | None) -> str:
    return _NONE if value is None else f"{value:.2f} l"


def _metres(travel_mm: float) -> str:
    return f"{travel_mm / 1000:.2f} m"
