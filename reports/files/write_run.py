"""Writing what a command made: all of it or none of it."""

import json
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from boards.load import SUFFIXES
from programs.errors import ProgramError
from programs.native import write as native
from reports.files.atomic_write import OutputError, write_bytes_atomically
from reports.pictures.sheet import check_suffix
from reports.tables.run_report import report
from reports.tables.summary import amount
from specs.errors import JobError
from specs.finding import Finding, blocking

if TYPE_CHECKING:
    from cleaning.report import Traceability
    from cleaning.verdicts.results import CleaningReport
    from cleaning.verify import Verified
    from reports.tables.report_header import Made
    from rulesengine.planning.pipeline import Run

_KINDS = {
    ".wash": "a program", ".json": "a report", ".png": "a picture", ".svg": "a picture",
    ".yaml": "a YAML file", ".yml": "a YAML file", ".csv": "a table", ".gz": "a board",
    ".html": "a page", ".htm": "a page",
} | dict.fromkeys(SUFFIXES, "a board")  # fmt: skip


def check_places(
    *,
    read: Sequence[str | Path | None],
    program: Path | None = None,
    picture: Path | None = None,
    report_file: Path | None = None,
) -> None:
    """Refuse places that cannot be meant or written, before the long work begins.

    Args:
        read: What the command reads; names of samples do no harm here.
        program: Where the program is to be written.
        picture: Where the picture is to be written.
        report_file: Where the report is to be written.

    Raises:
        JobError: a place is read from, used twice, in no folder, not writable, or bears the name of another thing.
    """
    if picture is not None:
        try:
            check_suffix(picture.suffix)
        except JobError as error:
            raise JobError(f"{picture}: {error}") from None
    wanted = {"a program": program, "a picture": picture, "a report": report_file}
    check_apart(read, [path for path in wanted.values() if path is not None])
    check_named(wanted)


def check_named(wanted: Mapping[str, Path | None]) -> None:
    """Refuse a place that bears the name of another thing than is to be written there.

    Args:
        wanted: Where each kind is to be written: ``"a program"``, ``"a picture"``, ``"a report"``, ``"a page"``,
            ``"a YAML file"``.

    Raises:
        OutputError: its suffix is that of another kind.
    """
    for kind, path in wanted.items():
        named = kind if path is None else _KINDS.get(path.suffix.lower(), kind)
        if path is not None and named != kind:
            reason = f"its name is that of {named}, and {kind} is to be written"
            raise OutputError(path, reason, "Name another file.")


def check_apart(read: Sequence[str | Path | None], written: Iterable[Path]) -> None:
    """Refuse places where no file can be written, and files that are read or written by the same command.

    Raises:
        OutputError: a place is read from, used twice, in no folder or not writable.
    """
    taken = {os.path.realpath(each): "it is read by this command" for each in read if each is not None}
    for path in written:
        _check_place(path)
        real = os.path.realpath(path)
        if real in taken:
            raise OutputError(path, taken[real], "Name another file.")
        taken[real] = "it is to be written twice"


def check_folder(folder: Path) -> None:
    """Refuse a folder that is none and cannot be made, before the long work begins.

    Raises:
        OutputError: it, or what it is to be made in, is no folder or not writable.
    """
    there = next((each for each in (folder, *folder.parents) if each.exists()), Path())
    if not there.is_dir():
        raise OutputError(folder, f"{there} is not a folder")
    if not os.access(there, os.W_OK):
        raise OutputError(folder, "permission denied")


def _check_place(path: Path) -> None:
    """Refuse a place where no file can be written.

    Raises:
        OutputError: it is a folder, in no folder, or not writable, or it is to be no file.
    """
    if path == Path("-"):
        raise OutputError(path, "stdout has the summary", "Name a file.")
    try:
        real = Path(os.path.realpath(path))
        if real.is_dir():
            raise OutputError(path, "it is a folder", "Name a file in it.")
        if not real.parent.is_dir():
            raise OutputError(path, f"there is no folder {path.parent}", "Make it, or name another place.")
        if not os.access(real if real.exists() and not real.is_file() else real.parent, os.W_OK):
            raise OutputError(path, "permission denied")
    except (OSError, ValueError) as error:
        raise OutputError(path, getattr(error, "strerror", None) or str(error)) from None


def write_run(
    run: "Run", *, output: Path | None, picture: Path | None, report_file: Path | None, allowed: Sequence[str]
) -> None:
    """Write program, picture and report; nothing is written before everything is rendered.

    Raises:
        ProgramError: a finding forbids the export; nothing is written but the report, which says why.
    """
    told = report_bytes(run)
    stops = blocking(run.findings, allowed)
    if output is not None and stops:
        if report_file is not None:
            write_bytes_atomically(report_file, told)
        raise ProgramError(reason_not_to(stops), file=output)
    contents: list[tuple[Path, bytes]] = []
    if output is not None:
        contents.append((output, program_bytes(run)))
    if picture is not None:
        from reports.pictures.plan_picture import draw_plan

        contents.append((picture, draw_plan(run.board, run.program, picture.suffix)))
    if report_file is not None:
        contents.append((report_file, told))
    for path, content in contents:
        write_bytes_atomically(path, content)


def program_bytes(run: "Run") -> bytes:
    """Write the program as a native file."""
    return native.render(run.program).encode("utf-8", errors="replace")


def report_bytes(run: "Run") -> bytes:
    """Write the report as JSON."""
    return json_bytes(report(run))


def cleaning_bytes(
    found: "CleaningReport", made: "Made", trace: "Traceability", verified: "Sequence[Verified]" = ()
) -> bytes:
    """Write as JSON what an analysis found and by what, what was entered, and what was worked out exactly besides."""
    from cleaning.report import cleaning_report
    from reports.tables.report_header import tell_made

    return json_bytes(tell_made(cleaning_report(found, verified, trace), made))


def json_bytes(data: Mapping[str, object]) -> bytes:
    """Write plain data as JSON."""
    text = json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    return text.encode("utf-8", errors="replace")


def reason_not_to(stops: Sequence[Finding]) -> str:
    """Say which findings forbid that something is written, and what can be done."""
    rules = list(dict.fromkeys(finding.rule.id for finding in stops))
    first = stops[0]
    return (
        f"not written: {amount(len(stops), 'finding')} of severity error forbid{'s' if len(stops) == 1 else ''} it. "
        f"First {first.rule.id} at {first.made_by or 'the board'}: {first.message} "
        f"Mend it, or override with {' '.join(f'--allow {rule}' for rule in rules)}."
    )
