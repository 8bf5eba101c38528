"""Where the frames of a cell lie, and what in them is probably not meant, as the page says it."""

from collections.abc import Sequence
from html import escape

from robotcell.diagnosis.frame_table import Frame
from specs.finding import Finding, worst_first
from webui.theme.palette import INK, QUIET, to_hex
from webui.theme.verdict_colours import SEVERITY_COLOURS

_BOX = f"margin:0 12px;font-size:12px;line-height:1.4;color:{to_hex(INK)}"


def mistakes_html(findings: Sequence[Finding]) -> str:
    """Say what in a cell is probably not meant; nothing where all is well."""
    items = "".join(_mistake_html(finding) for finding in worst_first(findings))
    return f'<div style="{_BOX}">{items}</div>' if items else ""


def frames_html(frames: Sequence[Frame]) -> str:
    """List frames with their places and directions, to be compared with the real cell."""
    rows = "".join(_row_html(frame) for frame in frames)
    return (
        f'<div style="{_BOX}"><div style="color:{to_hex(QUIET)};margin-bottom:4px">'
        "x, y, z (mm) in the cell; its z is up.</div>"
        f'<table style="width:100%;border-collapse:collapse;font-variant-numeric:tabular-nums">{rows}</table></div>'
    )


def _row_html(frame: Frame) -> str:
    places = "".join(
        f'<td style="text-align:right;padding:1px 0 1px 8px;white-space:nowrap">{_number(value)}</td>'
        for value in frame.place_mm
    )
    looks = (
        f'<tr><td colspan="4" style="color:{to_hex(QUIET)};font-size:11px;padding:0 0 4px">{escape(frame.looks)}</td>'
        "</tr>"
        if frame.looks
        else ""
    )
    return f'<tr><td style="padding:1px 0">{escape(frame.what.capitalize())}</td>{places}</tr>{looks}'


def _number(value: float) -> str:
    return f"{value:.1f}".replace("-0.0", "0.0").replace("-", "\N{MINUS SIGN}")


def _mistake_html(finding: Finding) -> str:
    colour = SEVERITY_COLOURS[finding.severity]
    return (
        f'<div style="border-left:3px solid {colour};padding:1px 0 2px 8px;margin-bottom:6px;overflow-wrap:anywhere">'
        f'<span style="color:{colour};font-weight:600">{escape(finding.rule.id)}</span>'
        f"<div>{escape(finding.message)}</div>"
        f'<div style="color:{to_hex(QUIET)};font-size:11px">{escape(finding.made_by)}</div></div>'
    )
