"""What the demonstration says of what its program cleans."""

from pathlib import Path
from time import perf_counter
from typing import TYPE_CHECKING

from rich.console import Console
from rich.markup import escape

from cleaning.results import CleaningReport

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
    from cleaning.report import Traceability
    from rulesengine.cleaning_made import made_here
    from rulesengine.cleaning_page import cleaning_page
    from rulesengine.commands.loading import progress_bar
    from rulesengine.commands.terminal import open_console, print_files
    from rulesengine.commands.writing import cleaning_bytes
    from rulesengine.output import write_bytes_atomically, write_text_atomically

    begun = perf_counter()
    with progress_bar() as tell:
        report = analyse(run.program, run.board, run.recipe, load_parameters(), "fast", tell)
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
    from cleaning.cleanliness import count_cleanliness, outcome, unclean_parts
    from rulesengine.cleaning_groups import deciding, group_alike, name_some
    from rulesengine.cleaning_page import headline, honesty
    from rulesengine.summary import clock, print_facts

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
