"""A study of the project folder: its tables, and the board and recipe of one of its combinations."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from boards.board import Workpiece
from boards.load import board_library
from boards.workpiece import load_workpiece
from cleaning.parameters.load import parameter_library
from recipes.load import recipe_library
from recipes.rewrite import write_values
from rulesengine.tuning.variables import read_path
from specs.progress import Progress
from specs.yaml.located import YamlPath
from specs.yaml.tree import Tree
from studies.results.read_tables import Combination, StudyTables, read_tables
from webui.page.document import Document
from webui.page.project import Project


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
