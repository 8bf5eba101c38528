"""Why something was not done, in the words of the one who has to change it."""

import re
from html import escape

from specs.errors import JobError, LocatedError
from webui.theme.palette import ACCENT, INK, to_hex


def reason_of(error: JobError, at: str = "") -> str:
    """Give the reason alone: the page shows the file, and the input at a path needs no path.

    Args:
        error: What was raised.
        at: Path of the input beside which the reason is shown.
    """
    text = str(error)
    if not isinstance(error, LocatedError):
        return text
    if error.file is not None:
        text = re.sub(re.escape(str(error.file)) + r":(\d+: )?\s*", "", text)
    return text.removeprefix(f"{at}: ") if at else text


def remark_html(reason: str) -> str:
    """Write why something was refused, aligned with the inputs."""
    lines = "<br>".join(escape(line) for line in reason.splitlines())
    colour = to_hex(ACCENT)
    return (
        f'<div role="alert" style="margin:-2px 10px 8px 10px;padding:4px 8px;font-size:12px;line-height:1.4;'
        f'color:{colour};border-left:3px solid {colour};overflow-wrap:anywhere">{lines}</div>'
    )


def note_html(text: str) -> str:
    """Write what somebody should know, quietly, aligned with the inputs; it stays in sight where there are many."""
    return (
        "<style>div:has(> .washboard-note) { position: sticky; bottom: 0; z-index: 3; background: #fff; }</style>"
        '<div class="washboard-note" style="margin:0 10px;padding:4px 0 6px;font-size:12px;line-height:1.4;'
        f'color:{to_hex(INK)}">{escape(text)}</div>'
    )
