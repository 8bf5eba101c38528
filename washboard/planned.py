"""Planning a recipe on a workpiece, for a robot cell if one is named."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from boards.board import Workpiece
from boards.parts_table.read import Tables
from programs.plan import Plan
from programs.program import TimedProgram
from recipes.errors import RecipeError
from recipes.load import locate_error
from recipes.recipe import Recipe, has_film
from rulesengine.planning.pipeline import Run, run
from specs.errors import JobError
from specs.finding import Finding
from specs.output_file import OutputFile
from specs.progress import Progress, no_progress, subprogress
from specs.rows import Rows
from washboard.inputs import OpenedProgram, OpenedRecipe, open_cell, open_recipe, open_workpiece

if TYPE_CHECKING:
    from robotcell.cell.load import LoadedCell
    from rulesengine.levelling.report import Goal, LevelReport

_FOR_CELL = 0.3
"""Share of the work before a program is timed for a robot."""


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Planned:
    """A recipe planned on a workpiece: its timed program, and what was found."""

    run: Run
    opened: OpenedRecipe
    """The recipe, with its text."""

    @property
    def workpiece(self) -> Workpiece:
        """The board, panel or part."""
        return self.run.workpiece

    @property
    def recipe(self) -> Recipe:
        """The recipe's values."""
        return self.run.recipe

    @property
    def program(self) -> TimedProgram:
        """Moves, switches of the valve, waits and commands, each with its time."""
        return self.run.program

    @property
    def duration_s(self) -> float:
        """Of the whole program, s."""
        return self.program.totals.duration_s

    @property
    def litres(self) -> dict[str, float]:
        """Liquid by function."""
        return dict(self.program.totals.liquid_l)

    @property
    def findings(self) -> Rows[Finding]:
        """Of the workpiece, the recipe, the plan and the timing; worst first."""
        return Rows(self.run.findings)

    def picture(self, suffix: str = ".png") -> bytes:
        """Draw the paths over the workpiece.

        Raises:
            JobError: the suffix is neither ``.png`` nor ``.svg``.
        """
        from reports.files.write_run import picture_bytes

        return picture_bytes(self.run, suffix)

    def save(
        self,
        program: str | Path | None = None,
        *,
        picture: str | Path | None = None,
        report: str | Path | None = None,
        allowed: Sequence[str] = (),
    ) -> None:
        """Write the program, a picture and a report as JSON; nothing is written before everything is rendered.

        Args:
            program: Native program, ``.wash``.
            picture: ``.png`` or ``.svg``.
            report: ``.json``
            allowed: Rules whose errors do not forbid the program.

        Raises:
            ProgramError: a finding forbids the program.
            OutputError: a place cannot be written.
        """
        from reports.files.write_run import check_places, write_run

        named = (program, "a program"), (picture, "a picture"), (report, "a report")
        output, drawn, data = (None if each is None else OutputFile(Path(each), kind) for each, kind in named)
        check_places((), (output, drawn, data))
        write_run(self.run, output=output, picture=drawn, report_file=data, allowed=allowed)

    def __repr__(self) -> str:
        return f"<plan of {self.recipe.recipe} on {self.workpiece.name}, {self.duration_s:.1f} s>"

    def _repr_html_(self) -> str:
        from base64 import b64encode
        from html import escape

        from reports.tables.wording import clock

        litres = ", ".join(f"{name} {each:.2f} l" for name, each in self.litres.items())
        head = f"{self.workpiece.name} with {self.recipe.recipe}: {clock(self.duration_s)}" + f"; {litres}" * bool(
            litres
        )
        drawn = b64encode(self.picture()).decode("ascii")
        picture = f'<img alt="paths over the workpiece" style="max-width:60em" src="data:image/png;base64,{drawn}">'
        return f"<p><b>{escape(head)}</b></p>{picture}{self.findings.html()}"

    def _repr_png_(self) -> bytes:
        return self.picture()


Subject: TypeAlias = Planned | OpenedProgram | Run
"""A program with the workpiece and the recipe that it was planned for."""


def plan(
    workpiece: Workpiece | str | Path,
    recipe: OpenedRecipe | str | Path,
    cell: "LoadedCell | str | Path | None" = None,
    progress: Progress = no_progress,
    *,
    parts: Tables = None,
    sketched: Callable[[Plan], None] | None = None,
    before: Planned | None = None,
) -> Planned:
    """Plan and time a recipe on a workpiece.

    Args:
        workpiece: One that is open, the name of a sample, or a file.
        recipe: One that is open, the name of one of the library, or a file.
        cell: Cell whose robot's limits the times keep to besides those of the recipe.
        progress: Receives the stage and the share done.
        parts: Placement and BOM tables to join to a board that is opened here.
        sketched: Receives a first plan, before its strokes are in the shortest order.
        before: A plan on the same workpiece whose strokes are taken where nothing changed that they depend on.

    Raises:
        JobError: one of them cannot be used, or there is nothing to plan; with file and line where the recipe has them.
    """
    opened = recipe if isinstance(recipe, OpenedRecipe) else open_recipe(recipe)
    loaded = None if cell is None else open_cell(cell)
    share = 1.0 if loaded is None else _FOR_CELL
    if not isinstance(workpiece, Workpiece):
        workpiece = open_workpiece(workpiece, opened, parts, subprogress(progress, 0.0, 0.4 * share))
    try:
        known = None if before is None else before.run
        if has_film(opened.recipe):
            from rulesengine.levelling.film_run import run_levelled as run_all  # late: few need it
        else:
            run_all = run
        done = run_all(opened.recipe, workpiece, subprogress(progress, 0.4 * share, share), sketched, known)
        if loaded is not None:
            from robotcell.cell.load import hold_board
            from rulesengine.planning.cell_plan import plan_for_cell

            done = plan_for_cell(done, hold_board(loaded, workpiece), subprogress(progress, share, 1.0))
    except RecipeError as error:
        raise locate_error(error, opened.loaded) from None
    return Planned(done, opened)


def level(
    workpiece: Workpiece | str | Path,
    recipe: OpenedRecipe | str | Path,
    goal: "Goal | None" = None,
    film_um: float | None = None,
    progress: Progress = no_progress,
    *,
    parts: Tables = None,
) -> "tuple[Planned, LevelReport]":
    """Plan a recipe and level its speeds: on a board as ``goal`` states, on a part to the films of its templates.

    Args:
        workpiece: One that is open, the name of a sample, or a file.
        recipe: One that is open, the name of one of the library, or a file.
        goal: Left out, ``least-time`` on a board and ``even-film`` on a part.
        film_um: Film to reach on a board; left out, as for ``level_plan``.
        progress: Receives the stage and the share done.
        parts: Placement and BOM tables to join to a board that is opened here.

    Returns:
        The levelled plan, and what was changed.

    Raises:
        JobError: there is nothing to level, or something is requested that a part has no results for.
    """
    from rulesengine.levelling.film_run import lay_films, level_run

    opened = recipe if isinstance(recipe, OpenedRecipe) else open_recipe(recipe)
    if not isinstance(workpiece, Workpiece):
        workpiece = open_workpiece(workpiece, opened, parts, subprogress(progress, 0.0, 0.1))
    if workpiece.faces:
        if goal == "least-time" or film_um is not None:
            what = "a film to reach is" if film_um is not None else "the least time is"
            raise JobError(
                f"{what} for boards, and {workpiece.name} is a part: its films are stated by the templates "
                "(film: thickness_um). Leave it out."
            )
        if not has_film(opened.recipe):
            raise JobError(
                f"{workpiece.name} is a part, and no path of {opened.recipe.recipe} states a film "
                "(film: thickness_um): there is nothing to level."
            )
    try:
        laid = lay_films(opened.recipe, workpiece, subprogress(progress, 0.1, 0.3))
        chosen = goal or ("even-film" if workpiece.faces else "least-time")
        done, report = level_run(laid, chosen, film_um, subprogress(progress, 0.3, 1.0))
    except RecipeError as error:
        raise locate_error(error, opened.loaded) from None
    return Planned(done, opened), report
