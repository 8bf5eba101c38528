"""A study with all that it names: its files found and read once, its combinations and their jobs in order."""

from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from itertools import chain, product
from pathlib import Path
from typing import Any

from boards.load import board_library, find_board_file
from boards.part.sources import part_library
from boards.workpiece import is_part, load_workpiece
from cleaning.parameters.load import PARAMETERS, load_parameters, parameters_sha256
from recipes.load import RECIPE, LoadedRecipe, read_recipe, recipe_sha256
from rulesengine.tuning.variables import read_path
from specs.errors import JobError
from specs.progress import Progress
from specs.spec import Spec
from specs.yaml.file_kind import FileKind
from specs.yaml.load import find_file, is_bare
from specs.yaml.located import Located, YamlPath, spell_path
from specs.yaml.schema import known_keys, name_nearest
from studies.errors import StudyError
from studies.job import Input, Job
from studies.study import Deviation, Point, Study, design_points, draw_deviations, load_study


@dataclass(frozen=True, slots=True)
class Case:
    """One combination: a board, a recipe, a parameter set and a point of the design."""

    number: int
    """From 1, in the order of the table."""
    board: Input
    recipe: Input
    parameters: Input
    point: Point


@dataclass(frozen=True, slots=True)
class PlannedStudy:
    """A study whose files were found and read once."""

    study: Study
    boards: tuple[Input, ...]
    recipes: tuple[Input, ...]
    parameters: tuple[Input, ...]
    cell: Input | None
    paths: tuple[YamlPath, ...]
    """Of the variables."""
    own: tuple[tuple[Any, ...], ...]
    """Of each recipe: the value that each variable has in it."""
    points: tuple[Point, ...]
    deviations: tuple[Deviation, ...]
    """Drawn; the program as planned is not among them."""

    def cases(self) -> Iterator[Case]:
        """Give the combinations in order."""
        for board in range(len(self.boards)):
            yield from self._cases_on(board)

    def _cases_on(self, board: int) -> Iterator[Case]:
        combined = product(self.recipes, self.parameters, self.points)
        first = 1 + board * len(self.recipes) * len(self.parameters) * len(self.points)
        for number, (recipe, parameters, point) in enumerate(combined, first):
            yield Case(number, self.boards[board], recipe, parameters, point)

    def jobs_of(self, case: Case) -> Iterator[Job]:
        """Give the jobs of a combination: first as planned, then with each deviation."""
        own = self.own[self.recipes.index(case.recipe)]
        edits = tuple(
            (path, value) for path, value, before in zip(self.paths, case.point, own, strict=True) if value != before
        )
        for deviation in ((), *self.deviations):
            cell = None if deviation else self.cell
            yield Job(case.board, case.recipe, case.parameters, cell, edits, self.study.effort, deviation)

    def jobs(self) -> Iterator[Job]:
        """Give all jobs in order; equal ones as often as they occur."""
        return chain.from_iterable(map(self.jobs_of, self.cases()))

    def queues(self) -> list[Callable[[], Iterator[Job]]]:
        """Give for each board what gives its jobs in order, as often as it is called."""

        def jobs(board: int) -> Iterator[Job]:
            return chain.from_iterable(map(self.jobs_of, self._cases_on(board)))

        return [partial(jobs, board) for board in range(len(self.boards))]


def plan_study(file: Path, progress: Progress) -> PlannedStudy:
    """Read a study and each of its files once.

    Raises:
        StudyError: the study cannot be used, or a file that it names; the message has file, line and YAML path.
    """
    study, root = load_study(file)
    reader = _Reader(file, root, progress)
    paths = tuple(reader.path(at, each.path) for at, each in enumerate(study.variables))
    recipes = [reader.recipe(at, name, paths) for at, name in enumerate(study.recipes)]
    over_faces = all(each for *_, each in recipes)
    boards = tuple(
        reader.board(at, each.board, each.parts, over_faces=over_faces) for at, each in enumerate(study.boards)
    )
    parameters = tuple(reader.parameters(at, name) for at, name in enumerate(study.parameters))
    return PlannedStudy(
        study,
        boards,
        tuple(found for found, *_ in recipes),
        parameters,
        None if study.cell is None else reader.cell(study.cell),
        paths,
        tuple(own for _, own, _ in recipes),
        tuple(design_points(study)),
        tuple(draw_deviations(study.tolerances)),
    )


@dataclass(frozen=True, slots=True)
class _Reader:
    """Reads what a study names, and blames the line that names it."""

    file: Path
    root: Located
    progress: Progress

    @contextmanager
    def _blaming(self, path: YamlPath) -> Generator[None]:
        """Make what is refused in the block an error of the study, at a path of its file."""
        try:
            yield
        except (JobError, OSError) as error:
            line, reason = self.root.at(path).mark.line, getattr(error, "strerror", None) or str(error)
            raise StudyError(reason, path=spell_path(path), file=self.file, line=line) from None

    def _find(self, name: str, kind: FileKind[Spec]) -> Path:
        """Find a file: a name of the library, or a path that starts at the study's folder."""
        beside = self.file.parent / name
        return find_file(name if name in kind.library() or (is_bare(name) and not beside.exists()) else beside, kind)

    def board(self, at: int, name: str, parts: str | None, *, over_faces: bool) -> Input:
        """Read a workpiece; a mesh is a part where all recipes follow the faces of parts."""
        self.progress(f"reading {name}", 0.0)
        with self._blaming(("boards", at)):
            beside = self.file.parent / name
            known = {**part_library(), **board_library()}
            source = Path(name) if name in known or (is_bare(name) and not beside.exists()) else beside
            part = is_part(name if source == Path(name) else source, over_faces=over_faces)
            source = part_library().get(name, source) if part and source == Path(name) else source
            source = source if part else find_board_file(source)
            table = None if parts is None else (self.file.parent / parts).resolve()
            read = load_workpiece(str(source), table, over_faces=part)
        return Input(name, str(source.resolve()), read.sha256, "" if table is None else str(table), part)

    def path(self, at: int, text: str) -> YamlPath:
        with self._blaming(("variables", at, "path")):
            return read_path(text)

    def recipe(self, at: int, name: str, paths: tuple[YamlPath, ...]) -> tuple[Input, tuple[Any, ...], bool]:
        """Read a recipe, the value that it has at each path, and whether it follows the faces of parts.

        Raises:
            StudyError: it cannot be used, or has no place for a value.
        """
        with self._blaming(("recipes", at)):
            source = self._find(name, RECIPE)
            loaded = read_recipe(source)
        own: list[Any] = []
        for number, path in enumerate(paths):
            with self._blaming(("variables", number, "path")):
                if problem := _no_place(loaded, path):
                    raise JobError(f"the recipe {name} has no such value: {problem}")
            node = loaded.root.find(path)
            own.append(None if node is None else node.plain())
        return Input(name, str(source.resolve()), recipe_sha256(loaded.recipe)), tuple(own), loaded.recipe.over_faces

    def parameters(self, at: int, name: str) -> Input:
        with self._blaming(("parameters", at)):
            source = self._find(name, PARAMETERS)
            return Input(name, str(source.resolve()), parameters_sha256(load_parameters(source)))

    def cell(self, name: str) -> Input:
        from robotcell.cell.load import CELL, cell_sha256, read_cell  # a study without a cell needs no robot

        with self._blaming(("cell",)):
            source = self._find(name, CELL)
            return Input(name, str(source.resolve()), cell_sha256(read_cell(source)))


def _no_place(loaded: LoadedRecipe, path: YamlPath) -> str:
    """Why a value cannot stand at a path of a recipe; empty where it can."""
    parent = loaded.root
    for length, key in enumerate(path[:-1], start=1):
        inner = parent.get(key)
        if inner is None:
            names = list(parent.value) if isinstance(parent.value, dict) else []
            return f"nothing is at {spell_path(path[:length])}; {name_nearest(str(key), names)}"
        parent = inner
    last, known = path[-1], known_keys(path[:-1], loaded.root.plain(), RECIPE)
    if last in known or parent.get(last) is not None:
        return ""
    names = list(known) or (list(parent.value) if isinstance(parent.value, dict) else [])
    return f"{name_nearest(str(last), names)}"
