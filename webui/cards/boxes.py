"""Text as the page writes it between its inputs."""

from html import escape

from webui.theme.palette import INK, QUIET, to_hex


def box_html(inner: str) -> str:
    """Write HTML aligned with the inputs."""
    return f'<div style="margin:2px 12px 4px;font-size:12px;line-height:1.45;color:{to_hex(INK)}">{inner}</div>'


def quiet_html(text: str) -> str:
    """Write a quiet line."""
    return f'<div style="margin:2px 12px;font-size:12px;color:{to_hex(QUIET)}">{escape(text)}</div>'
