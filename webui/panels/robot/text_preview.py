"""A program's text page by page: the chosen line is marked in the scene, the selected stroke in the text."""

import viser

from specs.source import Source
from webui.downloads.program_text import PAGE_LINES, TextFile, find_text, next_move, page_html
from webui.glb.ribbons import line_width_mm, size_mm
from webui.layers.paths.markers import motion_glb
from webui.page.page import Page
from webui.panels.widgets.choices import offer, on_choice
from webui.scene.scene import Scene

_STEPS = {"Previous": -1, "Next": 1}
_NOTHING: tuple[str, ...] = ("",)
_LAYER = "/motion"


class TextPreview:
    """A program's text page by page: the chosen line is marked in the scene, the selected stroke in the text."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open; nothing is visible before there is a text."""
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
            self._moves = gui.add_button_group(
                "Motion", tuple(_STEPS), hint="The motion before this line, or after it."
            )
            self._pages = gui.add_button_group("Page", tuple(_STEPS), hint=f"Of {PAGE_LINES} lines.")
            self._text = gui.add_html("")
        on_choice(self._file, lambda _: self._go_and_select(1))
        on_choice(self._line, lambda number: self._go_and_select(round(number)))
        self._moves.on_click(
            lambda event: self._go_and_select(next_move(self._shown, self._number, _STEPS[event.target.value]))
        )
        self._pages.on_click(lambda event: self._go_and_select(self._number + _STEPS[event.target.value] * PAGE_LINES))

    def open(self, files: tuple[TextFile, ...], made_by: Source) -> None:
        """Show a text at a stroke, from its beginning if it does not contain it.

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
        offer(self._file, names, names[0])
        self._file.visible = len(names) > 1
        if not self.find(made_by):
            self._go(1)

    def find(self, made_by: Source) -> bool:
        """Go to the line of a stroke, unless the present line is part of it; whether there is such a line."""
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

    def _go_and_select(self, number: int) -> None:
        """Go to a line and select its stroke."""
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
        width = line_width_mm(size_mm(self._page.session.workpiece))
        self._scene.draw_over(_LAYER, motion_glb(file.moves[self._number - 1], width))

    def _show_text(self) -> None:
        self._text.content = page_html(self._shown, self._number, self._page.session.selection.made_by)
