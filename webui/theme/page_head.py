"""What the server adds to viser's page: modes, names, keys, colours, scripts, and the regions of the panels."""

import json

from specs.input_file import own_text
from webui.theme.palette import ACCENT, CHOSEN_GROUND, INK, LINE_COLOUR, colour_variables, css_colour, to_hex

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
    given = json.dumps({"modes": MODES, "keys": KEYS, "most": (MOST_CHARACTERS, MOST_LINES)}).replace("<", "\\u003c")
    variables = f":root{{{colour_variables(dark=False)}--wb-brand:{to_hex(ACCENT)};}}"
    variables += f":root[data-mantine-color-scheme=dark]{{{colour_variables(dark=True)}}}"
    hidden = "".join(
        f'html[data-mode="{mode}"] [role=tab][title="{tab}"],'
        for mode in MODES
        for tab in dict.fromkeys(each for tabs in MODES.values() for each in tabs)
        if tab not in MODES[mode]
    )
    style, script = (own_text("webui.theme", f"page.{each}") for each in ("css", "js"))
    return (
        f"<style>{variables}\n{style}\n{hidden.removesuffix(',')}{{display:none !important}}</style>"
        f"<script>window.washboard={{given:{given}}};\n{live_script()}\n{script}</script>"
    )


def live_script() -> str:
    """Script that looks at an operation and draws it: of this page, and of the live view's own."""
    return own_text("webui.theme", "live.js")


STRIP_PX = 56
FOOT_PX = 124
_NARROW_PX, _WIDE_PX = 300, 360
_WIDE_WINDOW_PX = 1600
_NARROWEST_WINDOW_PX = 1000
"""Below it viser shows a sheet of panels."""
_FRAME_PX = 4
"""Of a docked panel, beside its content."""
_STRIP, _FOOT, _JOB = "washboard-strip", "washboard-foot", "washboard-job"


def side_px(window_px: int) -> int:
    """Width of the panels on each side of a window, so that the scene keeps most of it."""
    return _WIDE_PX if window_px >= _WIDE_WINDOW_PX else _NARROW_PX


def scene_px(window_px: tuple[int, int]) -> tuple[int, int]:
    """Width and height of the scene in a window; in a narrow one it is what the browser reports."""
    width, height = window_px
    if width < _NARROWEST_WINDOW_PX:
        return window_px
    return width - 2 * (side_px(width) + _FRAME_PX), height - STRIP_PX - FOOT_PX


def _pinned(mark: str, height_px: int, edge: str) -> str:
    window = f"[data-dock-root] > [data-floating-window]:has(.{mark})"
    return f"""
{window} {{ left: 0 !important; width: 100% !important; height: {height_px}px !important; border-radius: 0 !important;
  top: auto !important; {edge}: 0 !important; z-index: 20 !important; box-shadow: none !important;
  border-{"bottom" if edge == "top" else "top"}: 1px solid {LINE_COLOUR}; }}
{window} :is([data-dock-resize], [data-dock-minimize], [data-dock-griphandle], .mantine-ScrollArea-scrollbar) {{
  display: none !important; }}
{window} [data-dock-group] {{ height: {height_px}px; }}
{window} .mantine-ScrollArea-viewport {{ overflow: hidden !important; }}
div:has(> div > .{mark}) {{ padding-top: 0 !important; }}
"""


STRIP_STYLE = f"""<style>
@media (min-width: 1000px) {{
[data-dock-root] > div:has(> canvas) {{ top: {STRIP_PX}px !important; bottom: {FOOT_PX}px !important; }}
[data-dock-root] > [data-dock-region] {{ top: {STRIP_PX}px !important; bottom: {FOOT_PX}px !important; }}
[data-dock-region] :is([data-dock-region-handle], [data-dock-griphandle]), [data-dock-region-handle] {{
  display: none !important; }}
[data-dock-region] [data-dock-tab] {{ padding: 0 6px !important; font-size: 13px; letter-spacing: 0; }}
.mantine-Notifications-root {{ top: {STRIP_PX + 12}px !important; }}
{_pinned(_STRIP, STRIP_PX, "top")}
[data-floating-window]:has(.{_STRIP}) [data-dock-group] {{ flex-direction: row-reverse !important; }}
[data-floating-window]:has(.{_STRIP}) [data-dock-strip] {{ height: {STRIP_PX}px !important; width: 70px; flex: none;
  cursor: default; border: 0 !important; }}
[data-floating-window]:has(.{_STRIP}) [data-dock-strip] > div > div:nth-last-child(2) {{ visibility: hidden; }}
[data-floating-window]:has(.{_STRIP}) [data-dock-group] > div:last-child {{ flex: 1 1 auto; min-width: 0; }}
div:has(> div > .{_STRIP}) {{ display: flex; flex-direction: row; align-items: center; height: {STRIP_PX}px; }}
div:has(> div > .{_STRIP}) > div:has([data-job]) {{ flex: 1 1 auto; min-width: 0; }}
div:has(> div > .{_STRIP}) > div:has(> button, > .mantine-Button-root, > .mantine-Flex-root) {{ flex: none;
  padding-bottom: 0 !important; }}
div:has(> div > .{_STRIP}) > div > .mantine-Flex-root {{ width: 190px; }}
div:has(> div > .{_STRIP}) > div > .mantine-Flex-root > div:first-child {{ display: none; }}
}}
</style><div class="{_STRIP}"></div>"""
"""Pins the panel that it is in along the top, and keeps the scene and the sides between strip and foot."""

_IN_FOOT = f"div:has(> div > .{_FOOT})"
FOOT_STYLE = f"""<style>
@media (min-width: 1000px) {{
{_pinned(_FOOT, FOOT_PX, "bottom")}
[data-floating-window]:has(.{_FOOT}) [data-dock-strip] {{ display: none !important; }}
{_IN_FOOT} {{ position: relative; padding-top: 36px !important; }}
{_IN_FOOT} > div:has([data-now]) {{ position: absolute; top: 8px; left: 556px; right: 0; }}
{_IN_FOOT} > div:has(.mantine-Slider-root) {{ height: 0; padding: 0; }}
{_IN_FOOT} > div:has(.mantine-Slider-root) .mantine-NumberInput-root {{ position: absolute; top: -95px; left: 436px;
  width: 108px !important; }}
{_IN_FOOT} > div:has(.mantine-Button-root):not(:has(.mantine-Slider-root)) {{ position: absolute; top: 8px; left: 4px;
  width: 270px; }}
{_IN_FOOT} > div:has(input):not(:has(.mantine-Slider-root)) {{ position: absolute; top: 6px; left: 278px;
  width: 150px; }}
{_IN_FOOT} > div > .mantine-Flex-root:has(.mantine-Button-root, .mantine-Slider-root) > div:first-child {{
  display: none; }}
{_IN_FOOT} > div:has(input) > .mantine-Flex-root > div:first-child {{ width: 70px !important; }}
}}
</style><div class="{_FOOT}"></div>"""
"""Pins the panel that it is in along the bottom: controls and time in one line, the timeline below."""
_ROWS = f"div:has(> .{_JOB}) ~ div:not(:has(> .mantine-Flex-root)) .mantine-Button-root"
JOB_STYLE = f"""<style>
{_ROWS} {{ background: transparent !important; color: {css_colour(INK)} !important; height: 24px !important;
  padding: 0 4px !important; margin-bottom: -5px; text-align: left; }}
{_ROWS} .mantine-Button-inner {{ justify-content: flex-start; }}
{_ROWS} .mantine-Button-label {{ white-space: pre; }}
{_ROWS}:hover {{ background: {css_colour(CHOSEN_GROUND)} !important; }}
</style><div class="{_JOB}"></div>"""
"""Buttons beside it look like the rows of a tree."""
