"""What a page gives away: the bytes that the command line would write, under names that any system takes."""

import re
import threading
from collections import Counter
from collections.abc import Collection, Sequence
from dataclasses import dataclass
from hashlib import sha256

from programs.errors import ProgramError
from reports.files.write_run import cleaning_bytes, program_bytes, report_bytes
from reports.tables.wording import amount, shorten
from rulesengine.planning.pipeline import Run
from specs.finding import Finding, blocking
from specs.progress import Progress
from webui.page.session import Session

_ODD = re.compile(r"[^\w.+-]+")
KINDS: dict[str, str] = {
    "Program (.wash)": ".wash",
    "Picture (PNG)": ".png",
    "Picture (SVG)": ".svg",
    "Report (JSON)": ".json",
    "Playback (HTML)": ".html",
    "Recipe (YAML)": ".yaml",
    "Cleaning report (HTML)": "-cleaning.html",
    "Cleaning report (JSON)": "-cleaning.json",
}
"""What can be downloaded, as it is called on the page, and how the file's name ends."""
_ONE_DRAWS = threading.Lock()
"""Matplotlib is made for one thread."""


@dataclass(frozen=True, slots=True)
class Download:
    """A file for the browser to keep."""

    name: str
    content: bytes


def make_download(kind: str, session: Session, allowed: Collection[str], rate: float, progress: Progress) -> Download:
    """Make a file of a session.

    Args:
        kind: One of ``KINDS``.
        session: What is shown.
        allowed: Rules whose errors do not forbid a program.
        rate: How many times faster than the robot a playback runs.
        progress: Receives the stage and the share done.

    Raises:
        ProgramError: there is no program of the recipe as it is now, or a finding forbids it.
    """
    suffix = KINDS[kind]
    if suffix == ".yaml":
        return Download(f"{plain_name(session.document.file.stem)}.yaml", session.document.text.encode())
    run = session.run
    if run is None or not session.planned:
        raise ProgramError("the recipe as it is now is not planned yet; wait until it is, or mend what stops it.")
    progress(f"making {kind}", 0.0)
    if suffix.startswith("-cleaning"):
        content = _cleaning(session, suffix)
    else:
        content = _playback(session, run, rate, progress) if suffix == ".html" else _content(suffix, run, allowed)
    return Download(f"{plain_name(run.board.name)}-{plain_name(run.recipe.recipe)}{suffix}", content)


def forbidding(run: Run | None) -> dict[str, int]:
    """Rules whose errors forbid a program, and how often each was broken; in the order of the findings."""
    return dict(Counter(finding.rule.id for finding in blocking(run.findings, ()))) if run is not None else {}


def _playback(session: Session, run: Run, rate: float, progress: Progress) -> bytes:
    from webui.downloads.recording import record

    return record(session.played or run, rate, progress, session.check).encode()


def _cleaning(session: Session, suffix: str) -> bytes:
    """Write the report of the analysis as ``washboard analyse`` does.

    Raises:
        ProgramError: the program was not analysed.
    """
    from reports.html.cleaning_page import Traceability, cleaning_page
    from reports.tables.report_header import this_producer

    analysis, run = session.analysis, session.run
    if analysis is None or run is None:
        raise ProgramError("this program was not analysed with these parameters; press Analyse in the tab Cleaning.")
    producer = this_producer(analysis.effort)
    trace = Traceability(program_sha256=sha256(program_bytes(run)).hexdigest())
    if suffix.endswith(".json"):
        return cleaning_bytes(analysis.report, producer, trace)
    with _ONE_DRAWS:
        return cleaning_page(analysis.report, trace, producer=producer).encode()


def _content(suffix: str, run: Run, allowed: Collection[str]) -> bytes:
    match suffix:
        case ".wash":
            refuse_errors(run.findings, allowed)
            return program_bytes(run)
        case ".json":
            return report_bytes(run)
        case _:
            from reports.pictures.plan_picture import draw_plan

            with _ONE_DRAWS:
                return draw_plan(run.board, run.program, suffix)


def refuse_errors(findings: Sequence[Finding], allowed: Collection[str]) -> None:
    """Refuse a program whose findings forbid it.

    Args:
        findings: All of them.
        allowed: Rules whose errors do not forbid a program.

    Raises:
        ProgramError: an error is left.
    """
    stops = blocking(findings, tuple(allowed))
    if stops:
        first = stops[0]
        raise ProgramError(
            f"{amount(len(stops), 'finding')} of severity error forbid{'s' if len(stops) == 1 else ''} the program. "
            f"First {first.rule.id} at {shorten(str(first.made_by)) or 'the board'}: {shorten(first.message)} "
            "Mend it, or tick its rule below the button to write the program in spite of it."
        )


def plain_name(name: str) -> str:
    """Leave of a name what can stand in a file's name everywhere."""
    return _ODD.sub("-", name).strip("-.")[:80] or "board"
