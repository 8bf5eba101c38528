"""Files of a command: their places are checked before the work begins, and written when all of them are rendered."""

import io
import json
import os
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from boards.board import Workpiece
from boards.load import SUFFIXES
from programs import native
from programs.errors import ProgramError
from reports.pictures.sheet import check_suffix
from reports.tables.wording import amount
from specs.errors import JobError, printable
from specs.finding import Finding, blocking
from specs.output_file import OutputError, OutputFile, OutputFolder, OutputPlace, write_outputs

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


def check_places(
    read: Iterable[str | Path | None], written: Iterable[OutputPlace | None], edited: str | Path | None = None
) -> None:
    """Refuse places that cannot be meant or written, before the long work begins.

    Args:
        read: What the command reads; names of samples do no harm here.
        written: What it writes.
        edited: What of it an output that is ``in_place`` may take the place of.

    Raises:
        JobError: a place cannot be written, is read from or written twice, also by a link, or bears the name of
            another kind.
    """
    inputs, outputs = [each for each in read if each is not None], [each for each in written if each is not None]
    taken = {_identity(each): "it is read by this command" for each in inputs}
    for place in (
        each for output in outputs for each in (output.all_written if isinstance(output, OutputFile) else [output])
    ):
        place.check()
        identity = _identity(place.path)
        is_file = isinstance(place, OutputFile)
        may_be_read = is_file and place.in_place and edited is not None and identity == _identity(edited)
        if identity in taken and not may_be_read:
            raise OutputError(place.path, taken[identity], f"Name another {'file' if is_file else 'folder'}.")
        taken[identity] = "it is to be written twice"
        if is_file:
            _check_ending(place)
        elif isinstance(place, OutputFolder) and place.only:
            _check_alone(place, [*inputs, *(each.path for each in outputs if isinstance(each, OutputFile))])


def _check_alone(folder: OutputFolder, others: Iterable[str | Path]) -> None:
    """Refuse a folder that is replaced as a whole and would take other files with it.

    Raises:
        OutputError: it would.
    """
    for other in others:
        if Path(os.path.realpath(other)).parent == folder.real:
            reason = f"it is replaced as a whole, and {printable(str(other))} is in it"
            raise OutputError(folder.path, reason, "Name a folder of its own.")


def _identity(path: str | Path) -> object:
    """What two names of one file have in common."""
    try:
        found = Path(path).stat()
    except (OSError, ValueError):
        return os.path.realpath(path)
    return found.st_dev, found.st_ino


def _check_ending(file: OutputFile) -> None:
    """Refuse a name that is one of another kind.

    Raises:
        JobError: it is.
    """
    if file.kind == "a picture":
        try:
            check_suffix(file.path.suffix)
        except JobError as error:
            raise JobError(f"{printable(str(file.path))}: {error}") from None
    named = _KINDS.get(file.path.suffix.lower(), file.kind)
    if file.kind and named != file.kind:
        reason = f"its name is that of {named}, and {file.kind} is to be written"
        raise OutputError(file.path, reason, "Name another file.")


def write_run(
    run: "Run",
    *,
    output: OutputFile | None,
    picture: OutputFile | None,
    report_file: OutputFile | None,
    allowed: Sequence[str],
) -> None:
    """Write program, picture and report; nothing is written before everything is rendered.

    Raises:
        ProgramError: a finding forbids the export; nothing is written but the report, which states why.
    """
    stops = blocking(run.findings, allowed) if output is not None else ()
    drawn = None if picture is None or stops else picture_bytes(run, picture.path.suffix)
    write_outputs({
        output: None if output is None or stops else program_bytes(run),
        picture: drawn,
        report_file: None if report_file is None else report_bytes(run),
    })  # fmt: skip
    if stops:
        raise ProgramError(export_refusal(stops), file=output and output.path)


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
    """Write plain data as JSON, piece by piece: all pieces of a large report take ten times the memory of its text."""
    found = io.BytesIO()
    text = io.TextIOWrapper(found, encoding="utf-8", errors="replace", newline="\n")
    json.dump(data, text, indent=2, ensure_ascii=False, allow_nan=False)
    text.write("\n")
    text.flush()
    return found.getvalue()


def export_refusal(stops: Sequence[Finding]) -> str:
    """Message that names the findings which forbid an export, and how to override them."""
    rules = list(dict.fromkeys(finding.rule.id for finding in stops))
    first = stops[0]
    return (
        f"not written: {amount(len(stops), 'finding')} of severity error forbid{'s' if len(stops) == 1 else ''} it. "
        f"First {first.rule.id} at {first.made_by or 'the board'}: {first.message} "
        f"Correct it, or override with {' '.join(f'--allow {rule}' for rule in rules)}."
    )
