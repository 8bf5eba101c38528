"""What the demonstration says of what its program cleans."""

import json
from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

from rich.console import Console
from rich.markup import escape

from cleaning.results import VERDICTS, CleaningReport

if TYPE_CHECKING:
    from rulesengine.pipeline import Run

_WORST = 3


def clean_for_demo(run: "Run", folder: Path) -> None:
    """Predict what was planned cleans, with the parameter set that comes along; write the page and its data.

    Raises:
        JobError: it cannot be done, or not be written.
    """
    from cleaning.analyse import analyse
    from cleaning.load import load_parameters
    from cleaning.report import cleaning_report
    from rulesengine.cleaning_page import Traceability, cleaning_page
    from rulesengine.commands.loading import progress_bar
    from rulesengine.commands.terminal import open_console, print_files
    from rulesengine.output import write_text_atomically

    begun = perf_counter()
    with progress_bar() as tell:
        report = analyse(run.program, run.board, run.recipe, load_parameters(), "fast", tell)
    seconds = perf_counter() - begun
    page, data = (folder / f"{run.board.name}-cleaning{end}" for end in (".html", ".json"))
    told = cleaning_page(report, Traceability())
    found = json.dumps(cleaning_report(report), indent=2, ensure_ascii=False, allow_nan=False)
    write_text_atomically(page, told)
    write_text_atomically(data, found + "\n")
    console = open_console()
    print_worst(console, report, seconds)
    print_files(console, cleaning=page, data=data)


def print_worst(console: Console, report: CleaningReport, seconds: float) -> None:
    """Headline and what it is worth, how many have which verdict, the worst few with the reason, how long it took."""
    from rulesengine.cleaning_page import headline, honesty
    from rulesengine.summary import clock, print_facts

    console.print(f"[bold]{escape(report.origin.board)}[/bold], what comes out clean. {escape(headline(report))}")
    console.print(escape(honesty(report)), style="dim")
    counts = {verdict: sum(part.verdict == verdict for part in report.parts) for verdict in VERDICTS}
    wanting = [part for part in report.worst_first() if part.verdict != "clean"][:_WORST]
    print_facts(
        console,
        [
            ("verdicts", ", ".join(f"{count} {verdict}" for verdict, count in counts.items() if count) or "none"),
            *((part.component, f"{part.verdict}: {part.judgements[0].because}") for part in wanting),
            ("analysed", f"in {clock(seconds)}"),
        ],
    )
