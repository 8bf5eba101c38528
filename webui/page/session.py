"""The state of one page as one frozen value: an edit makes the next one."""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from boards.board import Board, Component, Workpiece
from cleaning.uncertainty.comparison import Comparison, calibrate_command, compare_measured
from cleaning.uncertainty.measured_table import MeasuredTable
from programs.errors import ProgramError
from programs.plan import Plan
from recipes import rewrite
from recipes.load import LoadedRecipe
from recipes.recipe import Recipe
from robotcell.cell.cell_edits import CellEdit
from robotcell.cell.load import LoadedCell, hold_board
from rulesengine.planning.pipeline import Run
from rulesengine.surface.part_job import Covering
from specs.source import NO_SOURCE, Source
from specs.yaml.located import YamlPath
from specs.yaml.tree import Tree
from washboard.cleaned import FaceReport
from webui.live.live import Running
from webui.page.document import CellChange, Document, NamedCell, plan_change
from webui.page.evaluations import Analysed, Checked, Judged, OpenedStudy, Proposal
from webui.page.project import Project

READ_ONLY = "A robot's program is shown, which cannot be edited; press Close the program in the tab Program first."


@dataclass(frozen=True, slots=True)
class Selection:
    """The selected component, face or stroke; empty for none."""

    component: str = ""
    """Name of a component of a board, or of a face of a part."""
    made_by: Source = NO_SOURCE
    """Recipe path of a stroke, such as ``"sequence[0]/around/U12"``."""


@dataclass(frozen=True, slots=True, eq=False)
class ReadBack:
    """A program in a robot's language as a timed program, on its board or part."""

    name: str
    """Of the file or folder."""
    language: str
    cell: str
    workpiece_name: str
    """Name in the project's list."""
    note: str
    """Whether the board is another than that of the program; empty if not."""
    run: Run
    """The program; its plan has the paths that were read, its recipe draws the jets."""


@dataclass(frozen=True, slots=True, eq=False)
class Session:
    """A board or a part, a recipe that is being edited, and the newest run of them."""

    workpiece_name: str
    """Name in the project's list."""
    workpiece: Workpiece
    document: Document
    loaded: LoadedRecipe
    """The document, parsed."""
    run: Run | None = None
    """Newest run; ``run.recipe`` may be older than the document while the next one is planned."""
    sketch: Plan | None = None
    """First plan of the recipe as it is edited now, while the order of its strokes is optimised."""
    compared: Run | None = None
    """A run of another recipe on the same workpiece, to compare with."""
    selection: Selection = Selection()
    cell_name: str = ""
    """Name in the project's list; empty without a robot."""
    cell: LoadedCell | None = None
    cell_past: tuple[CellChange, ...] = ()
    """Edits of the cell that can be undone, the last one last."""
    cell_future: tuple[CellChange, ...] = ()
    """Edits of the cell that were undone, the last one last."""
    language: str = ""
    """Language of the robot's program that was chosen, by its name in ``DIALECTS``; empty for that of its maker."""
    checked: Checked | None = None
    """Newest check in a cell; it may be of an older run or of another cell."""
    parameters_name: str = "default"
    """Parameter set of the cleaning model; name in the project's list."""
    analysed: Analysed | FaceReport | None = None
    """Newest analysis, of a board or of a part; it may be of an older program or with other parameters."""
    judged: Judged | None = None
    """Newest verdict on a program as its controller drives it; it may be of an older one or with other parameters."""
    measured: MeasuredTable | None = None
    """Measured cleanliness of this board's components."""
    study: OpenedStudy | None = None
    """A study of the project folder that is looked at."""
    proposal: Proposal | None = None
    """Proposal of tuning, neither accepted nor discarded yet; it may be of an older text."""
    shown: ReadBack | None = None
    """A robot's program that was read; it is shown in place of the job, and nothing can be edited."""
    job: "Session | None" = None
    """The session that goes on when the program is closed."""
    watched: Running | None = None
    """The operation that the page shows live."""
    opened: frozenset[Path] = frozenset()
    """Files that were read to open the first session of a page, links resolved; they may be read again."""

    @property
    def recipe(self) -> Recipe:
        """The recipe as it is edited now."""
        return self.loaded.recipe

    @property
    def board(self) -> Board | None:
        """The workpiece where it is a board: what has sides, components and undersides."""
        return None if self.workpiece.faces else self.workpiece.require_board("this")

    @property
    def coverings(self) -> tuple[Covering, ...]:
        """What the newest run does to the faces of a part, unless a program that was read is shown in its place."""
        return () if self.run is None or self.shown is not None else self.run.coverings

    @property
    def component(self) -> Component | None:
        """The selected component of a board."""
        return next((each for each in self.workpiece.components if each.name == self.selection.component), None)

    @property
    def plan(self) -> Plan | None:
        """The newest plan: a sketch is newer than the run."""
        if self.shown is not None:
            return self.shown.run.plan
        return self.run.plan if self.sketch is None and self.run is not None else self.sketch

    @property
    def timed(self) -> Run | None:
        """The run whose program is shown: the newest one, or that of a program that was read."""
        return self.run if self.shown is None else self.shown.run

    @property
    def planned(self) -> bool:
        """Whether the run is of the recipe as it is edited now, on this workpiece."""
        return self.run is not None and self.run.recipe == self.recipe and self.run.workpiece is self.workpiece

    @property
    def planned_run(self) -> Run:
        """The run of the recipe as it is edited now.

        Raises:
            ProgramError: it is not planned yet.
        """
        if self.shown is not None:
            raise ProgramError(READ_ONLY)
        if self.run is None or not self.planned:
            raise ProgramError(
                "the recipe as it is now is not planned yet; wait until it is, or correct what prevents it."
            )
        return self.run

    @property
    def check(self) -> Checked | None:
        """Check of this very program in this very cell, if there is one."""
        checked = self.checked
        same = checked is not None and checked.run is self.run and checked.cell is self.cell
        return checked if same and self.planned else None

    @property
    def played(self) -> Run | None:
        """The run as it is played: as the robot executes it, where that was checked."""
        check = self.check
        if check is None or check.motion is None:
            return self.timed
        return replace(check.run, program=check.program)

    @property
    def current(self) -> Analysed | FaceReport | None:
        """Analysis of this very program with these very parameters, if there is one; on faces none of them acts."""
        analysed, played = self.analysed, self.played
        if analysed is None or played is None or not self.planned or analysed.program is not played.program:
            return None
        other = isinstance(analysed, Analysed) and analysed.parameters_name != self.parameters_name
        return None if other else analysed

    @property
    def judged_now(self) -> Judged | None:
        """Verdict on this very program as it is driven, with these very parameters, if there is one."""
        judged = self.judged
        if judged is None or judged.checked is not self.check:
            return None
        return judged if self.workpiece.faces or judged.parameters_name == self.parameters_name else None

    @property
    def analysed_board(self) -> Analysed | None:
        """Newest analysis where it is of a board; it may be of an older program or with other parameters."""
        return self.analysed if isinstance(self.analysed, Analysed) else None

    @property
    def analysis(self) -> Analysed | None:
        """The current analysis where it is of a board."""
        return self.current if isinstance(self.current, Analysed) else None

    @property
    def face_analysis(self) -> FaceReport | None:
        """The current analysis where it is of a part."""
        return self.current if isinstance(self.current, FaceReport) else None

    @property
    def lit(self) -> frozenset[Source]:
        """Highlighted strokes: the selected one, else those that spray the selected part."""
        if self.selection.made_by or self.analysis is None:
            return frozenset({self.selection.made_by}) - {NO_SOURCE}
        return self.analysis.makers_of(self.selection.component)

    def showing(self, shown: ReadBack) -> "Session":
        """Session that shows a program in place of the job, which is kept."""
        job = self.job or self
        other = replace(job, cell_name="", cell=None).with_workpiece(shown.workpiece_name, shown.run.workpiece)
        return replace(other, shown=shown, job=job)

    def resumed(self) -> "Session":
        """The job as it was when a program was opened."""
        return self.job or self

    def with_document(self, document: Document) -> "Session":
        """Session with another document.

        Raises:
            RecipeError: the text cannot be read.
        """
        if document.text == self.document.text and document.file == self.document.file:
            return replace(self, document=document)
        return replace(self, document=document, loaded=document.read())

    def with_workpiece(self, name: str, workpiece: Workpiece) -> "Session":
        """Session with another board or part, without the runs on the old one."""
        return replace(
            self,
            workpiece_name=name,
            workpiece=workpiece,
            cell=None if self.cell is None else hold_board(self.cell, workpiece),
            run=None,
            sketch=None,
            compared=None,
            checked=None,
            analysed=None,
            judged=None,
            measured=None,
            proposal=None,
            selection=Selection(),
        )

    def with_cell(self, name: str, loaded: LoadedCell | None) -> "Session":
        """Session with another cell, by its name in the project's list; empty and ``None`` for none."""
        held = None if loaded is None else hold_board(loaded, self.workpiece)
        return replace(self, cell_name=name, cell=held, cell_past=(), cell_future=(), language="")

    def edit_cell(self, edits: Iterable[CellEdit], project: Project) -> "Session":
        """Write values into the file of the cell; one of the library or from elsewhere is copied into the project.

        Raises:
            CellError: it is no cell with these values, or its file was changed elsewhere.
            OutputError: it cannot be written.
        """
        if self.cell is None:
            raise ProgramError("no cell is chosen; choose one in the tab Robot.")
        now = NamedCell(self.cell_name, self.cell)
        change = plan_change(now, edits, project.place_of_edited_cell(self.cell), self.document.past)
        change.write()
        return replace(self._with_cell_at(change.after), cell_past=(*self.cell_past, change), cell_future=())

    def undone(self) -> "Session":
        """Session without the last edit, of the recipe or of the cell.

        Raises:
            JobError: the cell's file was changed elsewhere, or cannot be written.
        """
        if not self.cell_past or self.cell_past[-1].recipe_past != self.document.past:
            return self.with_document(self.document.undone())
        *past, change = self.cell_past
        change.take_back()
        future = (*self.cell_future, change)
        return replace(self._with_cell_at(change.before), cell_past=tuple(past), cell_future=future)

    def redone(self) -> "Session":
        """Session with the edit that was undone last.

        Raises:
            JobError: the cell's file was changed elsewhere, or cannot be written.
        """
        if not self.cell_future or self.cell_future[-1].recipe_past != self.document.past:
            return self.with_document(self.document.redone())
        *future, change = self.cell_future
        change.write()
        past = (*self.cell_past, change)
        return replace(self._with_cell_at(change.after), cell_past=past, cell_future=tuple(future))

    def _with_cell_at(self, cell: NamedCell) -> "Session":
        return replace(self, cell_name=cell.name, cell=hold_board(cell.loaded, self.workpiece))

    def edited(self, text: str) -> "Session":
        """Session with another text of the recipe.

        Raises:
            RecipeError: the text is no recipe.
        """
        return replace(self.with_document(self.document.edited(text)), cell_future=())

    def set_value(self, path: YamlPath, value: Tree) -> "Session":
        """Write one value of the recipe.

        Raises:
            RecipeError: the value is refused, or cannot be written there.
        """
        return self.set_values({path: value})

    def set_values(self, values: Mapping[YamlPath, Tree]) -> "Session":
        """Write several values of the recipe as one edit; ``None`` takes out what stands at a path.

        Raises:
            RecipeError: a value is refused, or cannot be written there.
        """
        return self.edited(rewrite.write_values(self.document.text, self.document.file, values))

    def insert(self, path: YamlPath, value: Tree) -> "Session":
        """Insert an item into a list of the recipe.

        Raises:
            RecipeError: the recipe would not be one.
        """
        return self.edited(rewrite.insert(self.document.text, self.document.file, path, value))

    def move(self, path: YamlPath, to: int) -> "Session":
        """Move an item or a named entry to another place among its neighbours.

        Raises:
            RecipeError: the recipe would not be one.
        """
        return self.edited(rewrite.move(self.document.text, self.document.file, path, to))

    def remove(self, path: YamlPath) -> "Session":
        """Remove a part of the recipe, also where it is inherited.

        Raises:
            RecipeError: the recipe would not be one without it.
        """
        return self.edited(rewrite.remove(self.document.text, self.document.file, path))


Change = Callable[[Session], Session]
"""An edit: takes the session and returns the next one, or raises a JobError."""


def comparison_of(session: Session) -> tuple[Comparison, list[str]] | None:
    """Compare the measurements with the analysis, if there are both; with the command for each recalibration."""
    analysis, table = session.analysis, session.measured
    if analysis is None or table is None:
        return None
    found, recipe = compare_measured(analysis.report, table), session.document.file.name
    commands = [
        calibrate_command(each, analysis.report, recipe, analysis.parameters_name) for each in found.recalibrations
    ]
    return found, commands
