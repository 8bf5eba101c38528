"""What the server adds to the head of viser's page: modes, names and keys of controls, colours, words while it loads.

viser has no place for a script or a style sheet of ours; both stand beside this module as files, and get here what they
share with the server.
"""

import json
from pathlib import Path

from webui.theme.palette import ACCENT, colour_variables, to_hex

MODES: dict[str, tuple[str, ...]] = {
    "Plan": ("Job", "Board", "Components", "Findings", "Recipe", "YAML", "Paths"),
    "Robot": ("Robot", "Findings", "Recipe", "Program", "Live"),
    "Clean": ("Cleaning", "Components", "Findings", "Recipe", "YAML", "Study"),
    "Export": ("Files", "Findings", "Job", "Program", "Compare"),
}
"""Tabs of each mode, the first one of each side first."""
KEYS = (
    ("1 to 4", "Modes: " + ", ".join(MODES)),
    ("Space", "Play, pause"),
    ("Left, Right", "Previous event, next event"),
    ("F", "Fit: the board and all paths"),
    ("Ctrl+Z, Ctrl+Shift+Z", "Undo, redo"),
    ("Ctrl+S", "Save the recipe"),
    ("Ctrl+K", "All commands"),
    ("Enter", "Apply a form"),
    ("Escape", "Close a dialog"),
    ("Tab, Shift+Tab", "Next control, previous control"),
    ("?", "This list"),
)
"""Keys of the page and what they do; letters and arrows act where no text is typed."""
MOST_CHARACTERS, MOST_LINES = 2_000_000, 20_000
"""Of a text that can be pasted: the longest recipe of the library has a few hundred lines."""


def page_head() -> str:
    """Style sheet and script for the head of the page."""
    here = Path(__file__).parent
    given = json.dumps({"modes": MODES, "keys": KEYS, "most": (MOST_CHARACTERS, MOST_LINES)}).replace("<", "\\u003c")
    variables = f":root{{{colour_variables(dark=False)}--wb-brand:{to_hex(ACCENT)};}}"
    variables += f":root[data-mantine-color-scheme=dark]{{{colour_variables(dark=True)}}}"
    hidden = "".join(
        f'html[data-mode="{mode}"] [role=tab][title="{tab}"],'
        for mode in MODES
        for tab in dict.fromkeys(each for tabs in MODES.values() for each in tabs)
        if tab not in MODES[mode]
    )
    style = (here / "page.css").read_text("utf-8")
    script = (here / "page.js").read_text("utf-8")
    return (
        f"<style>{variables}\n{style}\n{hidden.removesuffix(',')}{{display:none !important}}</style>"
        f"<script>window.washboard={{given:{given}}};\n{live_script()}\n{script}</script>"
    )


def live_script() -> str:
    """Script that looks at an operation and draws it: of this page, and of the live view's own."""
    return (Path(__file__).parent / "live.js").read_text("utf-8")
