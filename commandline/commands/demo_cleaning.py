"""What the demonstration says of what its program cleans."""

from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

from rich.console import Console
from rich.markup import escape

from cleaning.verdicts.results import CleaningReport

if TYPE_CHECKING:
    from rulesengine.planning.pipeline import Run

_WORST = 3


def clean_for_demo(run: "Run", folder: Path) -> None:
    """Predict what was planned cleans, with the parameter set that comes along; write the page and its data.

    Raises:
        JobError: it cannot be done, or not be written.
    """
    from cleaning.analyse import analyse
    from cleaning.parameters.load import load_parameters
    from cleaning.report import Traceability
    from commandline.loading import progress_bar
    from reports.files.atomic_write import write_bytes_atomically, write_text_atomically
    from reports.files.write_run import cleaning_bytes
    from reports.html.cleaning_page import cleaning_page
    from reports.tables.report_header import made_here
    from reports.terminal.console import open_console, print_files

    begun = perf_counter()
    with progress_bar() as progress:
        report = analyse(run.program, run.board, run.recipe, load_parameters(), "fast", progress)
    seconds = perf_counter() - begun
    page, data = (folder / f"{run.board.name}-cleaning{end}" for end in (".html", ".json"))
    made = made_here("fast")
    told = cleaning_page(report, Traceability(), made=made)
    found = cleaning_bytes(report, made, Traceability())
    write_text_atomically(page, told)
    write_bytes_atomically(data, found)
    console = open_console()
    print_worst(console, report, seconds)
    print_files(console, cleaning=page, data=data)


def print_worst(console: Console, report: CleaningReport, seconds: float) -> None:
    """Headline and what it is worth, how many have which verdict, the worst few with the reason, how long it took."""
    from cleaning.verdicts.cleanliness import count_cleanliness, outcome, unclean_parts
    from reports.html.cleaning_page import headline, honesty
    from reports.tables.similar_components import deciding, group_alike, name_some
    from reports.tables.summary import clock, print_facts

    console.print(f"[bold]{escape(report.origin.board)}[/bold], what comes out clean. {escape(headline(report))}")
    console.print(escape(honesty(report)), style="dim")
    counts = count_cleanliness(report.parts)
    worst = group_alike(unclean_parts(report), deciding)[:_WORST]
    print_facts(
        console,
        [
            ("verdicts", ", ".join(f"{count} {verdict}" for verdict, count in counts.items()) or "none"),
            *((name_some(each.names, 1), f"{outcome(each.parts[0])}: {each.told[0].because}") for each in worst),
            ("analysed", f"in {clock(seconds)}"),
        ],
    )
