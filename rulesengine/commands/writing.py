"""Writing what a run made: all of it or none of it."""

import json
from collections.abc import Sequence
from pathlib import Path

from programs.errors import ProgramError
from programs.posts import native
from rulesengine.drawing import check_suffix
from rulesengine.output import write_bytes_atomically, write_text_atomically
from rulesengine.picture import draw_plan
from rulesengine.pipeline import Run
from rulesengine.report import blocking, report


def write_run(
    run: Run, *, output: Path | None, picture: Path | None, report_file: Path | None, allowed: Sequence[str]
) -> None:
    """Write program, picture and report, each to a temporary file that is then renamed.

    Raises:
        ProgramError: a finding forbids the export; nothing is written but the report, which says why.
    """
    if picture is not None:
        check_suffix(picture.suffix)
    if report_file is not None:
        write_text_atomically(report_file, json.dumps(report(run), indent=2, ensure_ascii=False) + "\n")
    stops = blocking(run.findings, allowed)
    if output is not None and stops:
        first = stops[0]
        raise ProgramError(
            f"not written: {len(stops)} finding(s) forbid it, first {first.rule} ({first.made_by or 'board'}): "
            f"{first.message} Mend it, or override with --allow {first.rule}.",
            file=output,
        )
    if output is not None:
        write_text_atomically(output, native.render(run.program))
    if picture is not None:
        write_bytes_atomically(picture, draw_plan(run.board, run.program, picture.suffix))
