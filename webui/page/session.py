"""Everything one page shows, as one frozen value: an edit makes the next one."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

from boards.board import Board
from programs.plan import Plan
from recipes import rewrite
from recipes.load import LoadedRecipe
from recipes.recipe import Recipe
from robotcell.cell.load import LoadedCell
from rulesengine.planning.pipeline import Run
from specs.yaml.located import YamlPath
from specs.yaml.tree import Tree
from webui.page.analysed import Analysed
from webui.page.checked import Checked
from webui.page.document import Document
from webui.page.proposal import Proposal


@dataclass(frozen=True, slots=True)
class Selection:
    """What the engineer points at; empty text points at nothing."""

    component: str = ""
    made_by: str = ""
    """Recipe path of a stroke, such as ``"sequence[0]/around/U12"``."""


@dataclass(frozen=True, slots=True, eq=False)
class Session:
    """A board, a recipe that is being edited, and the newest run of them."""

    board_name: str
    """As the project lists it."""
    board: Board
    document: Document
    loaded: LoadedRecipe
    """What the document says."""
    run: Run | None = None
    """Newest run; ``run.recipe`` may be older than the document while the next one is planned."""
    sketch: Plan | None = None
    """A first plan of the recipe as it is edited now, while the best order of its strokes is searched for."""
    compared: Run | None = None
    """A run of another recipe on the same board, to compare with."""
    selection: Selection = Selection()
    cell_name: str = ""
    """As the project lists it; empty while no robot is looked at."""
    cell: LoadedCell | None = None
    checked: Checked | None = None
    """What came of the newest check in a cell; it may be of an older run or of another cell."""

    parameters_name: str = "default"
    """Parameter set of the cleaning model, as the project lists it."""
    analysed: Analysed | None = None
    """What came of the newest analysis; it may be of an older program or with other parameters."""
    proposal: Proposal | None = None
    """What tuning proposes and nobody has taken or left yet; it may be of an older text."""

    @property
    def recipe(self) -> Recipe:
        """The recipe as it is edited now."""
        return self.loaded.recipe

    @property
    def plan(self) -> Plan | None:
        """The newest plan: a sketch is newer than the run."""
        return self.run.plan if self.sketch is None and self.run is not None else self.sketch

    @property
    def planned(self) -> bool:
        """Say whether the run shows the recipe as it is edited now, on this board."""
        return self.run is not None and self.run.recipe == self.recipe and self.run.board is self.board

    @property
    def check(self) -> Checked | None:
        """What came of the check of just this program in just this cell, if it was checked."""
        checked = self.checked
        same = checked is not None and checked.run is self.run and checked.cell is self.cell
        return checked if same and self.planned else None

    @property
    def played(self) -> Run | None:
        """The run as it is played: as the robot does it, where that was checked."""
        check = self.check
        if check is None or check.motion is None:
            return self.run
        return replace(check.run, program=check.program)

    @property
    def analysis(self) -> Analysed | None:
        """What came of the analysis of just this program with just these parameters, if it was analysed."""
        analysed, played = self.analysed, self.played
        if analysed is None or played is None or not self.planned:
            return None
        same = analysed.program is played.program and analysed.parameters_name == self.parameters_name
        return analysed if same else None

    @property
    def lit(self) -> frozenset[str]:
        """Makers of the strokes that stand out: the one that is selected, else those that spray the selected part."""
        if self.selection.made_by or self.analysis is None:
            return frozenset({self.selection.made_by}) - {""}
        return self.analysis.makers_of(self.selection.component)

    def with_document(self, document: Document) -> "Session":
        """Edit another text.

        Raises:
            RecipeError: the text cannot be read.
        """
        if document.text == self.document.text and document.file == self.document.file:
            return replace(self, document=document)
        return replace(self, document=document, loaded=document.read())

    def with_board(self, name: str, board: Board) -> "Session":
        """Look at another board; runs on the old one are gone."""
        return replace(
            self,
            board_name=name,
            board=board,
            run=None,
            sketch=None,
            compared=None,
            checked=None,
            analysed=None,
            proposal=None,
            selection=Selection(),
        )

    def with_cell(self, name: str, cell: LoadedCell | None) -> "Session":
        """Look at another robot, or at none."""
        return replace(self, cell_name=name, cell=cell)

    def with_check(self, checked: Checked) -> "Session":
        """Remember what came of a check; of which run and cell it is, it says itself."""
        return replace(self, checked=checked)

    def with_parameters(self, name: str) -> "Session":
        """Analyse with another parameter set."""
        return replace(self, parameters_name=name)

    def with_analysis(self, analysed: Analysed) -> "Session":
        """Remember what came of an analysis; of which program and parameters it is, it says itself."""
        return replace(self, analysed=analysed)

    def with_proposal(self, proposal: Proposal | None) -> "Session":
        """Keep what tuning proposes until somebody decides; nothing where it was taken or left."""
        return replace(self, proposal=proposal)

    def edited(self, text: str) -> "Session":
        """Give the recipe another text.

        Raises:
            RecipeError: the text is no recipe.
        """
        return self.with_document(self.document.edited(text))

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
        """Take something out of the recipe, also where it is only inherited.

        Raises:
            RecipeError: the recipe would not be one without it.
        """
        return self.edited(rewrite.remove(self.document.text, self.document.file, path))


Change = Callable[[Session], Session]
"""An edit: takes the session as it is and returns the next one, or raises a JobError."""
