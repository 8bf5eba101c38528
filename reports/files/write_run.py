"""Files of a command: their places are checked before the work begins, and written when all of them are rendered."""

import json
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from boards.board import Workpiece
from boards.load import SUFFIXES
from programs import native
from programs.errors import ProgramError
from reports.files.atomic_write import OutputError, output_errors, write_outputs
from reports.pictures.sheet import check_suffix
from reports.tables.wording import amount
from specs.errors import JobError, printable
from specs.finding import Finding, blocking

if TYPE_CHECKING:
    from cleaning.report import Traceability
    from cleaning.uncertainty.comparison import Comparison
    from cleaning.verdicts.results import CleaningReport
    from cleaning.verify import Verified
    from programs.program import TimedProgram
    from reports.tables.cleaning_tables import Producer
    from rulesengine.planning.pipeline import Run
    from rulesengine.surface.part_job import Covering

_KINDS = {
    ".wash": "a program", ".json": "a report", ".png": "a picture", ".svg": "a picture",
    ".yaml": "a YAML file", ".yml": "a YAML file", ".csv": "a table", ".gz": "a board",
    ".html": "a page", ".htm": "a page",
} | dict.fromkeys(SUFFIXES, "a board")  # fmt: skip


def check_places(read: Sequence[str | Path | None], written: Mapping[str, Path | None]) -> None:
    """Refuse places that cannot be meant or written, before the long work begins.

    Args:
        read: What the command reads; names of samples do no harm here.
        written: Where each kind is to be written: ``"a program"``, ``"a picture"``, ``"a report"``, ``"a page"``,
            ``"a YAML file"``.

    Raises:
        JobError: a place is read from, used twice, in no folder, not writable, or bears the name of another kind.
    """
    picture = written.get("a picture")
    if picture is not None:
        try:
            check_suffix(picture.suffix)
        except JobError as error:
            raise JobError(f"{printable(str(picture))}: {error}") from None
    check_apart(read, written.values())
    for kind, path in written.items():
        named = kind if path is None else _KINDS.get(path.suffix.lower(), kind)
        if path is not None and named != kind:
            reason = f"its name is that of {named}, and {kind} is to be written"
            raise OutputError(path, reason, "Name another file.")


def check_apart(read: Sequence[str | Path | None], written: Iterable[Path | None]) -> None:
    """Refuse places where no file can be written, and files that are read or written by the same command.

    Raises:
        OutputError: a place is read from, used twice, a folder or in none, not writable, or stands for stdout.
    """
    taken = {os.path.realpath(each): "it is read by this command" for each in read if each is not None}
    for path in written:
        if path is None:
            continue
        if path == Path("-"):
            raise OutputError(path, "stdout has the summary", "Name a file.")
        with output_errors(path):
            real = Path(os.path.realpath(path))
            if real.is_dir():
                raise OutputError(path, "it is a folder", "Name a file in it.")
            if not real.parent.is_dir():
                raise OutputError(path, f"there is no folder {path.parent}", "Make it, or name another place.")
            if not os.access(real if real.exists() and not real.is_file() else real.parent, os.W_OK):
                raise OutputError(path, "permission denied")
        if str(real) in taken:
            raise OutputError(path, taken[str(real)], "Name another file.")
        taken[str(real)] = "it is to be written twice"


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


def write_run(
    run: "Run", *, output: Path | None, picture: Path | None, report_file: Path | None, allowed: Sequence[str]
) -> None:
    """Write program, picture and report; nothing is written before everything is rendered.

    Raises:
        ProgramError: a finding forbids the export; nothing is written but the report, which states why.
    """
    stops = blocking(run.findings, allowed) if output is not None else ()
    drawn = None if picture is None or stops else picture_bytes(run, picture.suffix)
    write_outputs({
        output: None if output is None or stops else program_bytes(run),
        picture: drawn,
        report_file: None if report_file is None else report_bytes(run),
    })  # fmt: skip
    if stops:
        raise ProgramError(export_refusal(stops), file=output)


def program_bytes(run: "Run") -> bytes:
    """Write the program as a native file."""
    return native.render(run.program).encode("utf-8", errors="replace")


def picture_bytes(run: "Run", suffix: str) -> bytes:
    """Draw the program of a run over its workpiece.

    Raises:
        JobError: the suffix is neither ``.png`` nor ``.svg``.
    """
    return draw_program(run.workpiece, run.program, suffix, run.coverings)


def draw_program(
    workpiece: Workpiece, program: "TimedProgram", suffix: str, coverings: "Sequence[Covering]" = ()
) -> bytes:
    """Draw a program over its board; or over its part, with what its templates do to the faces where that is known.

    Raises:
        JobError: the suffix is neither ``.png`` nor ``.svg``.
    """
    if workpiece.faces:
        from reports.pictures.part_picture import draw_part_plan

        return draw_part_plan(workpiece.require_part("a picture of faces"), program, coverings, suffix)
    from reports.pictures.board_picture import draw_plan

    return draw_plan(workpiece.require_board("a picture of a board"), program, suffix)


def report_bytes(run: "Run") -> bytes:
    """Write the report as JSON."""
    if run.workpiece.faces:
        from reports.tables.run_report import part_report

        return json_bytes(part_report(run))
    from reports.tables.run_report import report

    return json_bytes(report(run))


def cleaning_bytes(
    found: "CleaningReport",
    producer: "Producer",
    trace: "Traceability",
    verified: "Sequence[Verified]" = (),
    measured: "tuple[Comparison, Sequence[str]] | None" = None,
) -> bytes:
    """Write an analysis as JSON: producer, entries, results, what was worked out exactly, and what was measured."""
    from cleaning.report import cleaning_report
    from cleaning.uncertainty.comparison import comparison_data

    data = cleaning_report(found, verified, trace)
    data["measured"] = None if measured is None else comparison_data(*measured)
    return json_bytes(producer.add_to(data))


def json_bytes(data: Mapping[str, object]) -> bytes:
    """Write plain data as JSON."""
    text = json.dumps(data, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    return text.encode("utf-8", errors="replace")


def export_refusal(stops: Sequence[Finding]) -> str:
    """Message that names the findings which forbid an export, and how to override them."""
    rules = list(dict.fromkeys(finding.rule.id for finding in stops))
    first = stops[0]
    return (
        f"not written: {amount(len(stops), 'finding')} of severity error forbid{'s' if len(stops) == 1 else ''} it. "
        f"First {first.rule.id} at {first.made_by or 'the board'}: {first.message} "
        f"Correct it, or override with {' '.join(f'--allow {rule}' for rule in rules)}."
    )
