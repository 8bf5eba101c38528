"""``washboard classify`` and ``plan``."""

from typing import Annotated

from commandline.arguments import (
    Allow,
    BoardSource,
    CellOption,
    Parts,
    Picture,
    ProgramOutput,
    RecipeSource,
    output_option,
)
from specs.output_file import OutputFile


def classify(board: BoardSource, recipe: RecipeSource = "smt-aqueous", parts: Parts = None) -> None:
    """Show which class takes each component, and the rule that put it there.

    [dim]washboard classify smt-demo smt-aqueous[/dim]
    """
    from boards.workpiece import load_workpiece
    from commandline.loading import progress_bar
    from recipes.load import load_recipe
    from reports.cards.workpiece import classes_card
    from reports.terminal.console import open_console, print_card
    from rulesengine.strokes import classify as rules

    loaded_recipe = load_recipe(recipe)
    with progress_bar() as progress:
        loaded = load_workpiece(board, parts, progress).require_board("classify")
    classified, findings = rules.classify(loaded_recipe, loaded)
    _, mask_findings = rules.read_masks(loaded_recipe, loaded)
    print_card(open_console(), classes_card(loaded.components, classified, (*findings, *mask_findings)))


def plan(
    board: BoardSource,
    recipe: RecipeSource = "smt-aqueous",
    cell: CellOption = None,
    output: ProgramOutput = None,
    picture: Picture = None,
    report: Annotated[
        OutputFile | None, output_option("--report", "JSON", "All of the summary, and more, as data.")
    ] = None,
    parts: Parts = None,
    allow: Allow = None,
) -> None:
    """Plan a board, or a part: follow the recipe over it, write the timed program, print a summary.

    [dim]washboard plan smt-demo
    washboard plan smt-demo smt-aqueous -o demo.wash --picture demo.png
    washboard plan smt-demo --cell ur5e-bench -o demo.wash
    washboard plan board.step my-recipe.yaml --parts placement.csv -o board.wash --report board.json
    washboard plan f-bracket part-degrease -o f-bracket.wash --picture f-bracket.png[/dim]
    """
    from commandline.loading import plan_on
    from reports.cards.program import part_run_card, run_card
    from reports.files.write_run import write_run
    from reports.terminal.console import open_console, print_card, print_files, print_note
    from specs.finding_rules import check_allowed

    allowed = check_allowed(allow or [])
    done = plan_on(board, recipe, parts, cell).run
    console = open_console()
    try:  # files first: who reads the summary may close the pipe after one line
        write_run(done, output=output, picture=picture, report_file=report, allowed=allowed)
    finally:
        print_card(console, (part_run_card if done.coverings else run_card)(done))
    print_files(console, program=output, picture=picture, report=report)
    if output is None:
        print_note(console, "No program was written; -o OUT.wash writes it.")
