"""A program's text page by page, beside the picture: a line of it is marked there, a stroke there is found here."""

import viser

from webui.downloads.program_text import PAGE_LINES, TextFile, find_text, next_move, page_html
from webui.glb.ribbons import board_size_mm, line_width_mm
from webui.layers.robot.motion_mark import motion_glb
from webui.page.page import Page
from webui.scene.scene import Scene

_BACK, _ON = "Previous", "Next"
_NOTHING: tuple[str, ...] = ("",)
_LAYER = "/motion"


class TextPreview:
    """A program's text page by page, beside the picture: a line of it is marked there, a stroke there is found here."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open; nothing is seen before there is a text."""
        self._page, self._scene = page, scene
        self._files: tuple[TextFile, ...] = ()
        self._number = 1
        gui = page.client.gui
        self._folder = gui.add_folder("Text", visible=False)
        with self._folder:
            self._file: viser.GuiDropdownHandle[str] = gui.add_dropdown(
                "File", _NOTHING, visible=False, hint="The first one starts the program."
            )
            self._line = gui.add_number("Line", 1, min=1, step=1, hint="Where it moves to is marked in the picture.")
            self._moves = gui.add_button_group("Motion", (_BACK, _ON), hint="The motion before this line, or after it.")
            self._pages = gui.add_button_group("Page", (_BACK, _ON), hint=f"Of {PAGE_LINES} lines.")
            self._text = gui.add_html("")
        self._file.on_update(lambda event: self._choose(by_hand=event.client is not None))
        self._line.on_update(lambda event: self._type(event.target.value, by_hand=event.client is not None))
        self._moves.on_click(lambda event: self._step(1 if event.target.value == _ON else -1))
        self._pages.on_click(lambda event: self._turn(1 if event.target.value == _ON else -1))

    def open(self, files: tuple[TextFile, ...], made_by: str) -> None:
        """Show a text where a stroke is told, from its beginning if it is not.

        Args:
            files: The text; none to show nothing.
            made_by: The stroke; empty for none.
        """
        self._files, self._number = files, 1
        self._folder.visible = bool(files)
        if not files:
            self._scene.draw_over(_LAYER, b"")
            return
        names = tuple(file.name for file in files)
        if tuple(self._file.options) != names:
            self._file.options = names
        self._file.value, self._file.visible = names[0], len(names) > 1
        if not self.find(made_by):
            self._go(1)

    def find(self, made_by: str) -> bool:
        """Go where a stroke is told, unless it is told in the line that is shown; say whether there is such a place."""
        if not self._files:
            return False
        if made_by and self._shown.makers[self._number - 1] == made_by:
            self._go(self._number)
            return True
        place = find_text(self._files, made_by)
        if place is None:
            self._show_text()
            return False
        self._file.value = self._files[place[0]].name
        self._go(place[1])
        return True

    @property
    def _shown(self) -> TextFile:
        return next((file for file in self._files if file.name == self._file.value), self._files[0])

    def _choose(self, *, by_hand: bool) -> None:
        if by_hand and self._files:
            self._go_and_select(1)

    def _type(self, number: float, *, by_hand: bool) -> None:
        if by_hand and self._files:
            self._go_and_select(round(number))

    def _step(self, steps: int) -> None:
        self._go_and_select(next_move(self._shown, self._number, steps))

    def _turn(self, steps: int) -> None:
        self._go_and_select(self._number + steps * PAGE_LINES)

    def _go_and_select(self, number: int) -> None:
        """Go to a line; the stroke that it is a part of is selected everywhere."""
        with self._page.client.atomic():
            self._go(number)
        maker = self._shown.makers[self._number - 1]
        if any(stroke.made_by == maker for stroke in self._scene.strokes):
            self._page.select(made_by=maker)

    def _go(self, number: int) -> None:
        file = self._shown
        self._number = min(max(number, 1), len(file.lines))
        self._line.max = float(len(file.lines))
        if self._line.value != self._number:
            self._line.value = self._number
        self._show_text()
        width = line_width_mm(board_size_mm(self._page.session.board))
        self._scene.draw_over(_LAYER, motion_glb(file.moves[self._number - 1], width))

    def _show_text(self) -> None:
        self._text.content = page_html(self._shown, self._number, self._page.session.selection.made_by)
