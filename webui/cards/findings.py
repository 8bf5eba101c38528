"""Findings, filtered, named and listed, and the status of the job in one line along the top."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from html import escape
from pathlib import Path
from typing import Literal, TypeAlias

from boards.board import Workpiece
from cleaning.part_faces import weigh_faces
from cleaning.verdicts.results import count_cleanliness, report_cleanliness
from cleaning.verdicts.rules import Verdict
from recipes.load import LoadedRecipe
from reports.tables.cleaning_tables import wet_count
from reports.tables.wording import SEVERITY_WORDS, amount, clock, shorten
from rulesengine.planning.pipeline import Run
from rulesengine.planning.spray_findings import unsprayed
from rulesengine.strokes.classify import read_masks
from specs.finding import Finding, Severity, worst_first
from specs.source import Source
from webui.page.session import Session
from webui.theme.html import bar_html, box_html, edged_html, grey_html, more_html, small_html
from webui.theme.palette import (
    ACCENT,
    CHOSEN_GROUND,
    ERROR_GROUND,
    GROUND,
    INK,
    QUIET,
    SEVERITY_COLOURS,
    Tint,
    css_colour,
)

ALL: str = "All"
PLANNING, ROBOT, CLEANING = "Planning", "Robot", "Cleaning"
"""Sources of findings."""
_MOST_SHOWN = 60


def findings_of(session: Session, source: str = ALL) -> tuple[Finding, ...]:
    """Findings of planning, and of the check and the analysis of this very program; worst first."""
    found: list[Finding] = []
    if session.run is not None and source in (ALL, PLANNING):
        found += session.run.findings
    if session.check is not None and source in (ALL, ROBOT):
        found += session.check.findings
    if session.analysis is not None and source in (ALL, CLEANING):
        found += session.analysis.report.findings
    return worst_first(found)


def choose_findings(findings: Sequence[Finding], severity: str, rule: str) -> list[Finding]:
    """Findings of a severity (as in ``"Errors"``) and a rule, in their order; ``"All"`` keeps all."""
    return [
        finding
        for finding in findings
        if severity in (ALL, SEVERITY_WORDS[finding.severity]) and rule in (ALL, finding.rule.id)
    ]


def name_findings(findings: Sequence[Finding]) -> dict[str, Finding]:
    """Findings by a short unique name: number in the list, rule, and what caused it."""
    names: dict[str, Finding] = {}
    for number, finding in enumerate(findings, start=1):
        place = judged_of(finding) or shorten(str(replace(finding.made_by, step=None)))
        names[f"{number} {finding.rule.id}{f' {place}' if place else ''}"] = finding
    return names


def judged_of(finding: Finding) -> str:
    """Subject of a judgement of the cleaning model, with which its message begins; empty for other findings."""
    return finding.message.partition(": ")[0] if finding.rule.verdict else ""


def place_of(finding: Finding, workpiece: Workpiece) -> str:
    """Name of the one component or face that a finding is about; empty where there is none, or more."""
    names = [judged_of(finding)] if judged_of(finding) else finding.made_by.components
    return names[0] if len(names) == 1 and names[0] in workpiece.place_names else ""


def findings_html(findings: Sequence[Finding], loaded: LoadedRecipe, chosen: Finding | None) -> str:
    """List of findings in their order, the chosen one marked, cut off after so many."""
    names = tuple(name_findings(findings))
    items = "".join(
        _item(name, finding, loaded, marked=finding is chosen)
        for name, finding in zip(names[:_MOST_SHOWN], findings, strict=False)
    )
    rest = more_html(len(findings) - _MOST_SHOWN, "more; choose a rule to see them")
    return box_html(items + rest if findings else grey_html("Nothing to look at."))


def kinds_html(findings: Sequence[Finding], loaded: LoadedRecipe, chosen: Finding | None) -> str:
    """List of the first finding of each rule, the number of others of it, and the chosen one, marked."""
    counts = Counter((finding.severity, finding.rule.id) for finding in findings)
    firsts: dict[tuple[Severity, str], int] = {}
    for index, finding in enumerate(findings):
        firsts.setdefault((finding.severity, finding.rule.id), index)
    shown = [index for index, each in enumerate(findings) if each is chosen or index in firsts.values()]
    names = tuple(name_findings(findings))
    items = "".join(_item(names[at], findings[at], loaded, marked=findings[at] is chosen) for at in shown)
    more = [f"{count - 1} more {rule}" for (_, rule), count in counts.items() if count > 1]
    return box_html(items + grey_html(f"and {escape(', '.join(more))}" if more else ""))


def mistakes_html(findings: Sequence[Finding]) -> str:
    """List of probable mistakes in a cell or a program, worst first; nothing where there are none."""
    items = [
        _finding_html(each, each.rule.id, each.message, escape(str(each.made_by))) for each in worst_first(findings)
    ]
    return box_html("".join(items)) if items else ""


def _item(name: str, finding: Finding, loaded: LoadedRecipe, *, marked: bool) -> str:
    """One finding; a click on it chooses it by its name in the stepper."""
    number = name.partition(" ")[0]
    places = [source_words(finding.made_by), recipe_line(loaded, finding.made_by)]
    if finding.where is not None:
        places.append(", ".join(f"{value:z.1f}" for value in finding.where) + " mm")
    place = " \N{MIDDLE DOT} ".join(escape(text) for text in places if text)
    title = f"{number} {finding.rule.id}"
    html = _finding_html(finding, title, shorten(finding.message), place, marked=marked)
    return f'<div data-row="{escape(name)}">{html}</div>'


def _finding_html(finding: Finding, title: str, message: str, place: str, *, marked: bool = False) -> str:
    colour = css_colour(SEVERITY_COLOURS[finding.severity])
    return edged_html(
        f'<span style="color:{colour};font-weight:600">{escape(title)}</span><div>{escape(message)}</div>'
        f"{small_html(place)}",
        css_colour(ACCENT) if marked else colour,
        f"background:{css_colour(CHOSEN_GROUND) if marked else 'transparent'};padding:2px 0 3px 8px;margin-bottom:8px",
    )


def source_words(made_by: Source) -> str:
    """Name a source by its step's number in the job: ``step 4, around, U12``; other entries as the recipe has them."""
    if made_by.step is None:
        return made_by.entry
    names = [f"step {made_by.step + 1}", made_by.template, "+".join(made_by.components), made_by.motion]
    return shorten(", ".join(filter(None, names)))


def recipe_line(loaded: LoadedRecipe, made_by: Source) -> str:
    """File and line of the entry of a source, such as ``smt-aqueous.yaml, line 104``; empty where there is none."""
    node = loaded.root
    for key in made_by.recipe_path:
        inner = node.get(key)
        if inner is None:
            break
        node = inner
    return "" if node is loaded.root else f"{Path(node.mark.file).name}, line {node.mark.line}"


Tone: TypeAlias = Literal["good", "unknown", "old", "warning", "error"]
_TONES: dict[Tone, Tint] = {
    "good": INK,
    "unknown": QUIET,
    "old": QUIET,
    "warning": SEVERITY_COLOURS["warning"],
    "error": SEVERITY_COLOURS["error"],
}
_MARKS: dict[Tone, str] = {
    "good": "\N{CHECK MARK}",
    "unknown": "?",
    "old": "\N{ANTICLOCKWISE OPEN CIRCLE ARROW}",
    "warning": "!",
    "error": "!!",
}
"""A state is known by its mark and its words, not by its colour alone."""
_SEVERITIES: tuple[Severity, ...] = ("error", "warning")
_STOPPED = ("cancelled", "not planned")
_OLD, _OLDER = "older", "before the edit"
"""What is of an older program: in the strip, which is narrow, and where the pointer rests on it."""
_BAD: dict[str, Tone] = {"dirty": "error", "marginal": "warning"}


@dataclass(frozen=True, slots=True)
class Cell:
    """One statement of the strip."""

    title: str
    """Which tab it leads to; empty for none."""
    text: str
    tone: Tone
    note: str = ""
    """Second line."""


def status_cells(session: Session) -> tuple[Cell, ...]:
    """What is known of the program that is shown: sprayed components or faces, robot, cleaning, findings.

    What was found for an older program, or in another cell or with other parameters, is marked as older.
    """
    if session.shown is not None or session.run is None:
        return ()
    cells = (_sprayed(session), _robot(session), _cleaning(session), _findings(session))
    if session.planned:
        return cells
    return tuple(cell if cell.tone == "unknown" else replace(cell, tone="old", note=_OLD) for cell in cells)


def _sprayed(session: Session) -> Cell:
    run = session.run
    assert run is not None
    if run.workpiece.faces:
        faces = {piece.face for covering in run.coverings for piece in covering.pieces}
        served = [face.name for face in run.workpiece.faces if face.serve]
        missed = [name for name in served if name not in faces]
        return Cell("Sprayed", f"{len(served) - len(missed)} of {len(served)}", "error" if missed else "good", "faces")
    avoided = dict(read_masks(run.recipe, run.board)[0].avoided)
    missed, count = (
        [name for name in unsprayed(run.board, run.plan.items) if name not in avoided],
        len(run.board.components),
    )
    sides = {each.side for each in run.board.components if each.name in {*missed}}
    notes = [f"not on the {' and '.join(sorted(sides))}"] if sides else []
    notes += [f"{len(avoided)} avoided"] if avoided else []
    sprayed = count - len(missed) - len(avoided)
    return Cell("Sprayed", f"{sprayed} of {count}", "error" if missed else "good", ", ".join(notes))


def _robot(session: Session) -> Cell:
    if session.cell is None:
        return Cell("Robot", "no cell", "unknown")
    check = session.check
    if check is None:
        return Cell("Robot", "not checked", "unknown") if session.checked is None else Cell("Robot", "older", "old")
    if check.motion is None:
        return Cell("Robot", "cannot", "error", session.cell_name)
    return Cell("Robot", "can", "good", session.cell_name)


def _cleaning(session: Session) -> Cell:
    if session.analysis is not None:
        report = session.analysis.report
        return _cleaning_cell(report_cleanliness(report), count_cleanliness(report.parts), wet_count(report))
    if session.face_analysis is not None:
        verdicts = session.face_analysis.verdicts
        return _cleaning_cell(weigh_faces(verdicts).verdict, Counter(each.verdict for each in verdicts))
    known = session.analysed is not None
    return Cell("Cleaning", "older", "old") if known else Cell("Cleaning", "not analysed", "unknown")


def _cleaning_cell(worst: Verdict, counts: Mapping[Verdict, int], wet: int = 0) -> Cell:
    """Count as the tab does: components, or faces; the bare board and the process only where they alone are worse."""
    if worst in ("clean", "avoided"):
        return Cell("Cleaning", "all clean", "good", f"predicted, {wet} wet" if wet else "predicted")
    text = f"{counts[worst]} {worst}" if counts.get(worst) else f"board {worst}"
    return Cell("Cleaning", text, _BAD.get(worst, "unknown"), f"{counts.get('clean', 0)} clean")


def _findings(session: Session) -> Cell:
    counts = Counter(finding.severity for finding in findings_of(session))
    texts = [amount(counts[severity], severity) for severity in _SEVERITIES if counts[severity]]
    tone: Tone = "error" if counts["error"] else "warning" if counts["warning"] else "good"
    texts += [] if texts or not counts["info"] else ["no warnings", amount(counts["info"], "note")]
    return Cell("Findings", texts[0] if texts else "none", tone, ", ".join(texts[1:]))


def totals_words(run: Run) -> str:
    """Time and liquid of a program, such as ``6 min 34 s, 13.0 l``."""
    return f"{clock(run.program.totals.duration_s)}, {_liquid_words(run)}"


def _liquid_words(run: Run) -> str:
    return f"{sum(litres for _, litres in run.program.totals.liquid_l):.1f} l"


def status_html(session: Session, planned_s: float | None, what: str, share: float, was: str = "") -> str:
    """Names, duration and liquid of the program, and the cells of its status; each leads to its tab.

    Args:
        session: What is shown.
        planned_s: How long the newest planning took, s; ``None`` where there was none.
        what: Stage of planning, ``"cancelled"`` or ``"not planned"``.
        share: Of it that is done.
        was: Time and liquid before the edit; empty where nothing was edited.
    """
    blocks = [_job_html(session, planned_s, what, share, was), _totals_html(session)]
    blocks += [_cell_html(cell) for cell in status_cells(session)]
    return f'<div data-job style="line-height:1.35;color:{css_colour(INK)}">{"".join(blocks)}</div>'


def _job_html(session: Session, planned_s: float | None, what: str, share: float, was: str) -> str:
    star = " \N{BULLET}" if session.document.dirty else ""
    names = f"{session.workpiece.name} \N{MULTIPLICATION SIGN} {session.document.file.stem}{star}"
    progress: float | None = None
    mark, tone = "data-progress", QUIET
    if session.shown is not None:
        names = f"{session.workpiece.name} \N{MULTIPLICATION SIGN} {session.shown.name}"
        state = f"Read from {session.shown.language}. Nothing can be edited."
    elif session.run is not None and session.planned:
        state = f"Planned in {planned_s:.2f} s." if planned_s is not None else "Planned."
        state += f" Before: {was}." if was else ""
    elif what in _STOPPED:
        older = " The paths are those of the recipe before." if session.run is not None else ""
        state, tone = f"{what.capitalize()}.{older}", SEVERITY_COLOURS["error"]
    elif session.sketch is not None:
        state, progress, mark = f"Refining the order\N{HORIZONTAL ELLIPSIS} {share:.0%}", share, "data-sketch"
    else:
        state, progress = f"{what.capitalize() or 'Planning'}\N{HORIZONTAL ELLIPSIS} {share:.0%}", share
    cut = "white-space:nowrap;overflow:hidden;text-overflow:ellipsis"
    return (
        '<div data-names style="padding:2px 8px;overflow:hidden">'
        '<div style="display:flex;gap:10px;align-items:baseline">'
        f'<div style="flex:0 1 auto;font-size:14px;font-weight:600;{cut}" title="{escape(names)}">{escape(names)}</div>'
        f'<div {mark} title="{escape(state)}" style="flex:1 3 0;min-width:70px;font-size:12px;'
        f'color:{css_colour(tone)};{cut}">{escape(state)}</div></div>{bar_html(progress)}</div>'
    )


def _totals_html(session: Session) -> str:
    """Time and liquid; of the robot's motion where it was checked, with the planned time if that is another one."""
    run, planned = session.played, session.timed
    if run is None or planned is None:
        return ""
    old = session.shown is None and not session.planned
    time, as_planned = clock(run.program.totals.duration_s), clock(planned.program.totals.duration_s)
    second, hint = "" if session.shown is not None else _liquid_words(run), ""
    if old:
        second, hint = f"{second}, {_OLD}", _OLDER
    elif time != as_planned:
        second, hint = f"{second}, robot", f"As the robot moves; planned {as_planned}"
    return (
        '<div style="flex:none;padding:3px 8px;font-variant-numeric:tabular-nums;'
        f'color:{css_colour(QUIET if old else INK)}">'
        f'<div data-total title="{hint}" style="font-size:17px;line-height:22px;font-weight:600">'
        f"{time}</div>"
        f'<div style="font-size:13px">{second}</div></div>'
    )


def _cell_html(cell: Cell) -> str:
    """A button that opens the cell's tab: the browser's own, as the server cannot choose among tabs."""
    tab = {"Sprayed": "Findings"}.get(cell.title, cell.title)
    tint = css_colour(_TONES[cell.tone])
    hint = f"Open {tab}" + (f"; {_OLDER}" if cell.note == _OLD else "")
    ground = f"background:{ERROR_GROUND if cell.tone == 'error' else GROUND};"
    return (
        f'<button type="button" data-status="{cell.title.lower()}" data-tone="{cell.tone}" data-opens="{tab}" '
        f'title="{hint}" style="flex:0 1 auto;min-width:0;overflow:hidden;white-space:nowrap;'
        f"border:0;border-radius:4px;{ground}padding:3px 9px;text-align:left;"
        f'font:inherit;line-height:1.35;cursor:pointer;border-bottom:3px solid {tint}">'
        f'<span style="display:block;font-size:12px;color:{css_colour(QUIET)}">{cell.title}'
        f"{f' {escape(cell.note)}' if cell.note else ''}</span>"
        f'<span style="display:block;font-size:14px;font-weight:600;color:{tint}">{_MARKS[cell.tone]} '
        f"{escape(cell.text)}</span></button>"
    )
