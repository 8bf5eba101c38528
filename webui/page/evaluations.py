"""Evaluations: a program analysed, measured, checked in a cell; a tuning and its proposal; a study."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from math import degrees, isfinite
from pathlib import Path
from typing import TYPE_CHECKING

from boards.board import Board, Workpiece
from boards.load import board_library
from boards.workpiece import load_workpiece
from cleaning.parameters.load import parameter_library
from cleaning.parameters.model import Parameters
from cleaning.uncertainty.measured_table import MeasuredTable, read_measured
from cleaning.verdicts.results import CleaningReport, Part
from programs.program import TimedProgram
from recipes.load import recipe_library
from recipes.rewrite import write_values
from robotcell.cell.load import LoadedCell
from rulesengine.planning.pipeline import Run
from rulesengine.tuning.trial.request import AllowedChanges, ProgramLimits, TuningRequest, TuningResult, Worth
from rulesengine.tuning.trial.requirements import Goal
from rulesengine.tuning.variables import CHANGE_KINDS, ChangeKind, read_path
from specs.errors import JobError
from specs.finding import Finding
from specs.progress import Progress
from specs.source import Source
from specs.yaml.located import YamlPath
from specs.yaml.tree import Tree
from studies.results.read_tables import Combination, StudyTables, read_tables
from webui.layers.robot.robot import JointMotion, joint_motion
from webui.page.document import Document
from webui.page.project import Project, uploaded_table

if TYPE_CHECKING:
    from cleaning.analyse import Effort
    from cleaning.prepared_board import PreparedBoard
    from robotcell.track import CellReport
    from washboard.driven import DrivenVerdict


_LEAST_SHARE = 0.1
"""Share of the volume on a part: strokes with less are left out."""


@dataclass(frozen=True, slots=True, eq=False)
class Analysed:
    """A program and its cleaning report."""

    program: TimedProgram
    """Compared by identity."""
    parameters_name: str
    """Name in the project's list."""
    report: CleaningReport
    prepared: "PreparedBoard | None" = None
    """The prepared board, reused for the next program on it."""
    effort: "Effort" = "fast"

    def part(self, component: str) -> Part | None:
        """The report's part of a component, if there is one."""
        return next((each for each in self.report.parts if each.component == component), None)

    def makers_of(self, component: str) -> frozenset[Source]:
        """Strokes with a considerable share of the volume on a component."""
        part = self.part(component)
        return frozenset() if part is None else frozenset(name for name, share in part.makers if share >= _LEAST_SHARE)


@dataclass(frozen=True, slots=True)
class AnalysisSettings:
    """Parameters and effort of an analysis."""

    parameters_name: str
    """Name in the project's list."""
    parameters: Parameters
    effort: "Effort"
    capability: bool = False
    """Whether how sure the verdicts are is worked out too, which takes longer."""


def analyse_run(run: Run, settings: AnalysisSettings, before: Analysed | None, progress: Progress) -> Analysed:
    """Analyse a program, as the command line does.

    Args:
        run: Its program, board and recipe.
        settings: Parameters and effort.
        before: An analysis that may be of the same board.
        progress: Receives the stage and the share done.

    Raises:
        JobError: the program cannot be analysed with these parameters.
    """
    from washboard.cleaned import analyse

    known = None if before is None else before.prepared
    done = analyse(run, settings.parameters, settings.effort, progress, capability=settings.capability, before=known)
    return Analysed(run.program, settings.parameters_name, done.board_report, done.prepared, settings.effort)


@dataclass(frozen=True, slots=True, eq=False)
class Checked:
    """A run in a cell."""

    run: Run
    cell: LoadedCell
    report: "CellReport"
    motion: JointMotion | None
    """``None`` where the robot cannot execute the program."""

    @property
    def program(self) -> TimedProgram:
        """As the robot executes it; as planned where it cannot."""
        return self.report.program

    @property
    def findings(self) -> tuple[Finding, ...]:
        """Obstacles to the program, and deviations from the plan; worst first."""
        return self.report.findings


def check_program(run: Run, cell: LoadedCell, progress: Progress, lean: float = 0.0) -> Checked:
    """Check a program in a cell, as the command line does.

    Args:
        run: Its program, and the workpiece for collisions.
        cell: The cell.
        progress: Receives the stage and the share done.
        lean: Largest tilt that the robot may add to avoid collisions or limits, rad.

    Raises:
        JobError: the cell cannot be used with this program, or what ``washboard[robot]`` installs is missing.
    """
    from washboard.checked import check_in

    report = check_in(run.program, run.workpiece, cell, progress, tilt_band_deg=degrees(lean)).report
    report.nearness.find()  # by this thread, not by the one that draws the panel
    return Checked(run, cell, report, joint_motion(report.program, report.joints) if report.possible else None)


@dataclass(frozen=True, slots=True, eq=False)
class Judged:
    """The verdict on a program as it was planned and as the controller drives it."""

    checked: Checked
    """The program in its cell; compared by identity."""
    parameters_name: str
    """Name in the project's list."""
    verdict: "DrivenVerdict"


def plan_at_pace(run: Run, cell: LoadedCell, progress: Progress) -> Run:
    """Time a program for the robot of a cell, as ``washboard plan --cell`` does.

    Args:
        run: Its plan, board and recipe.
        cell: The cell, which holds the board.
        progress: Receives the stage and the share done.

    Raises:
        JobError: the cell cannot be used with this program, or what ``washboard[robot]`` installs is missing.
    """
    from rulesengine.planning.cell_plan import plan_for_cell

    return plan_for_cell(run, cell, progress)


def read_uploaded(name: str, content: bytes, board: Board) -> MeasuredTable:
    """Read an uploaded table of measured cleanliness, which is not stored.

    Raises:
        ProjectError: it is too large.
        CleaningError: it cannot be used; the message names the line.
    """
    with uploaded_table(name, content, "measured.csv", "a table of measurements") as table:
        read = read_measured(table, [*(each.name for each in board.components), "board"])
    return replace(read, file=name)


KIND_WORDS: dict[ChangeKind, tuple[str, str]] = {
    "speeds": ("Speeds", "How fast the nozzle goes along a path."),
    "tilts": ("Tilts", "Tilt of the jet."),
    "passes": ("Passes", "Repeats of a path, by class of parts where that is enough."),
    "dwells": ("Dwells", "How long the nozzle waits at edges and corners."),
    "heights": ("Heights", "How high the nozzle is above the board."),
    "sides": ("New paths", "Paths that a step does not have yet: around parts, around the rim, across."),
    "wash_time": ("Washing time", "How often a whole step is done, or its least time."),
    "pressure": ("Pressure", "Of the liquids; the pump has to give it."),
    "temperature": ("Temperature", "Of the liquids, within their windows."),
}
"""Label and hint of each group of numbers that tuning may change."""
GOALS: dict[str, Goal] = {"Clean": "clean", "Clean and dry": "clean-and-dry"}
_ALL_PERCENT = 100.0
_GIVEN = frozenset(CHANGE_KINDS) - {"pressure", "temperature"}


class TuningError(JobError):
    """Tuning cannot be done, or its proposal cannot be used."""


@dataclass(frozen=True, slots=True)
class TuningSettings:
    """Settings of the form; ``0`` is no limit."""

    kinds: frozenset[ChangeKind] = _GIVEN
    """Pressure and temperature change only where they are ticked."""
    goal: Goal = "clean"
    seconds: float = 0.0
    litres: float = 0.0
    analyses: float = 40.0
    saving: float = 1.0
    """Percent of time and liquid that an analysis has to promise."""
    for_robot: bool = False
    """Whether times are those of the cell's robot."""

    def request(self) -> TuningRequest:
        """Convert to a request.

        Raises:
            TuningError: it leaves nothing to do, or a number cannot be.
        """
        if not self.kinds:
            raise TuningError("Nothing may be changed; tick at least one group of numbers.")
        for name, value in (("Time at most", self.seconds), ("Liquid at most", self.litres)):
            if not isfinite(value) or value < 0:
                raise TuningError(f"{name}: {value:g} is no limit; give a number above 0, or 0 for none.")
        if not isfinite(self.analyses) or self.analyses < 2:
            raise TuningError(f"Analyses: {self.analyses:g} are too few; allow at least 2.")
        if not (isfinite(self.saving) and 0 <= self.saving < _ALL_PERCENT):
            raise TuningError(f"Worth an analysis: {self.saving:g} is no percentage; give one from 0 on below 100.")
        limits = ProgramLimits(self.seconds or None, self.litres or None)
        worth = Worth(saving=self.saving / _ALL_PERCENT)
        return TuningRequest(self.goal, limits, AllowedChanges(self.kinds), round(self.analyses), worth)


@dataclass(frozen=True, slots=True, eq=False)
class Proposal:
    """A recipe that tuning found, until it is applied or discarded."""

    document: Document
    """The recipe before tuning."""
    board: Board
    parameters_name: str
    """As the project lists it."""
    tuned: TuningResult
    chosen: str = ""
    """Text of the recipe that was chosen of the Pareto front; empty for the one that tuning found."""
    interrupted: bool = False
    """Whether tuning was cancelled: it is the best until then."""

    @property
    def text(self) -> str:
        """The recipe that is proposed."""
        return self.chosen or self.tuned.last.text

    @property
    def changes(self) -> bool:
        """Whether it is another recipe at all."""
        return self.text != self.document.text

    def fits(self, document: Document) -> bool:
        """Whether a document still has the text that was tuned."""
        return document.file == self.document.file and document.text == self.document.text


@dataclass(frozen=True, slots=True, eq=False)
class OpenedStudy:
    """The tables of a study."""

    name: str
    """Of its table of runs, in the project's list."""
    tables: StudyTables


@dataclass(frozen=True, slots=True, eq=False)
class OpenedCombination:
    """What a combination was planned from."""

    board_name: str
    board: Workpiece
    document: Document
    """The recipe with the values of the combination as one edit."""
    parameters_name: str


def open_study(project: Project, name: str, progress: Progress) -> OpenedStudy:
    """Read the tables of a study by a name that a browser sent.

    Raises:
        ProjectError: it is outside the folder.
        StudyError: it cannot be used.
    """
    return OpenedStudy(name, read_tables(project.locate(name), progress))


def open_combination(
    project: Project, study: OpenedStudy, combination: Combination, progress: Progress
) -> OpenedCombination:
    """Read the board and the recipe of a combination, and write its values into the recipe.

    Raises:
        ProjectError: one of them is not in the folder.
        JobError: one of them cannot be used, or has no place for a value.
    """

    def find(name: str, library: Mapping[str, Path]) -> str:
        return name if name in library else project.find_named(name, study.name)

    recipe = find(combination.recipe, recipe_library())
    document = project.open_recipe(recipe)
    root = document.read().root
    values: dict[YamlPath, Tree] = {}
    for path, text in zip(map(read_path, study.tables.paths), combination.point, strict=True):
        node, value = root.find(path), value_of(text)
        if node is None or node.plain() != value:
            values[path] = value
    document = document.edited(write_values(document.text, document.file, values))
    board = find(combination.board, board_library())
    workpiece = load_workpiece(
        project.workpiece_source(board), None, progress, over_faces=document.read().recipe.over_faces
    )
    return OpenedCombination(board, workpiece, document, find(combination.parameters, parameter_library()))


def value_of(text: str) -> float | int | str:
    """A value of a recipe as a table has it."""
    for kind in (int, float):
        try:
            return kind(text)
        except ValueError:
            continue
    return text
