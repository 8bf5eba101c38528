"""Where the panels of a page stand."""

from webui.page.page import Page, Panel
from webui.panels.board.board import BoardPanel
from webui.panels.board.components import ComponentsPanel
from webui.panels.board.paths import PathsPanel
from webui.panels.cleaning.analysis import CleaningPanel
from webui.panels.recipe.recipe import RecipePanel
from webui.panels.recipe.text import TextPanel
from webui.panels.results.compare import ComparePanel
from webui.panels.results.findings import FindingsPanel
from webui.panels.results.output import OutputPanel
from webui.panels.results.playback import PlaybackPanel
from webui.panels.results.status import StatusPanel
from webui.panels.robot.program import ProgramPanel
from webui.panels.robot.robot import RobotPanel
from webui.scene.scene import Scene
from webui.theme.palette import ACCENT

_SIDE_PX = 360
_STATUS_PX = 300
_LEFT = (
    ("Board", BoardPanel),
    ("Components", ComponentsPanel),
    ("Findings", FindingsPanel),
    ("Robot", RobotPanel),
    ("Cleaning", CleaningPanel),
)
_RIGHT = (
    ("Recipe", RecipePanel),
    ("YAML", TextPanel),
    ("Paths", PathsPanel),
    ("Compare", ComparePanel),
    ("Out", OutputPanel),
    ("Program", ProgramPanel),
)

_NARROW_TABS = "<style>[data-dock-strip] > [data-dock-tab]{padding:0 0.6em !important}</style>"
"""Six of them stand in a line."""


def lay_out(page: Page) -> list[Panel]:
    """Build a page: what is looked at on the left, what is edited on the right, results and playback over the scene."""
    gui = page.client.gui
    gui.configure_theme(control_width="large", show_logo=False, show_share_button=False, brand_color=ACCENT)
    scene = Scene(page)
    panels: list[Panel] = [scene]
    panels.append(StatusPanel(page, scene))
    gui.add_html(_NARROW_TABS)
    left, right = gui.add_panel(), gui.add_panel()
    for side, kinds in ((left, _LEFT), (right, _RIGHT)):
        for label, kind in kinds:
            with side.add_tab(label):
                panels.append(kind(page, scene))
        side.set_width(_SIDE_PX)
    left.dock_left()
    right.dock_right()
    gui.main_panel.float(x=-20, y=20, width=_STATUS_PX)
    below = gui.add_panel()
    with below.add_tab("Playback"):
        panels.append(PlaybackPanel(page, scene))
    below.float(x=20, y=-20, width=620)
    return panels
