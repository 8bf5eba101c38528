"""The check of the program in the cell: its result, its findings and their places, reach and joints."""

from collections.abc import Sequence
from dataclasses import replace
from html import escape

import numpy as np

from programs.program import MoveTo
from reports.cards.robot import check_card
from reports.pictures.joint_picture import QUANTITIES, Curve, Quantity, envelope, joint_curves
from robotcell.motion.retime import rates_of
from specs.finding import Finding
from specs.finding_rules import COLLISION
from specs.source import NO_SOURCE, Source
from webui.cards.findings import kinds_html
from webui.glb.glb import line_width_mm, size_mm
from webui.layers.robot.robot import Near, near_at, near_glb, nearest_of
from webui.page.evaluations import Checked, check_program
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.widgets.choices import FindingStepper, button, dropdown, folder
from webui.panels.widgets.job import Job, RemedyButton, RunButton
from webui.scene.reach_colours import METRICS, Painted, paint_reach
from webui.scene.scene import Scene
from webui.theme.html import card_html, legend_html, quiet_html
from webui.theme.palette import ACCENT, COLLIDING, GROUND, INK, LINE_COLOUR, NAMED, QUIET, css_colour, to_hex

_HINTS = (
    "Shows the place, the recipe entry that caused it, and the robot at that time.",
    "Through the findings; the smallest clearance.",
)
_LAYER = "/near"
_AROUND_MM = 250.0
"""Half width of the view where bodies touch: enough to recognise them."""


class CheckCard:
    """The check of the program in the cell: its result, its findings and their places."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open; they are visible where there is a cell."""
        self._page, self._scene = page, scene
        gui = page.client.gui
        with folder(page, "Check", lambda now: now.cell is not None):
            hint = "Largest jet tilt the robot may add to avoid collisions or limits."
            self._lean = gui.add_number("Tilt band (\N{DEGREE SIGN})", 0.0, min=0.0, max=45.0, step=1.0, hint=hint)
            hint = "Computes the joint motion, and what prevents it."
            self._run: RunButton[Checked] = RunButton(page, "Check", self._begin, hint)
            RemedyButton(page)
            self._steps = FindingStepper(gui, _HINTS, self._show_finding, {"Nearest": self._show_nearest})
            self._list = gui.add_html("")
        page.check = self._begin

        def show(session: Session) -> None:
            self._steps.chosen = None
            self._unmark()
            self._list_findings(session)

        page.follow(show, lambda now: (now.cell, now.check))
        page.follow(
            lambda now: self._run.show(state_html(now)), lambda now: (now.cell, now.run, now.checked, now.check)
        )

    def _begin(self) -> None:
        run, cell, lean = self._page.session.planned_run, self._page.session.cell, np.radians(self._lean.value)
        if cell is not None:
            self._run.start(
                lambda progress: check_program(run, cell, progress, lean),
                lambda checked: self._page.remember(lambda session: replace(session, checked=checked)),
            )

    def _list_findings(self, session: Session) -> None:
        findings = session.check.findings if session.check is not None else ()
        self._steps.offer_findings(findings)
        self._steps.show(visible=session.check is not None)
        chosen = self._steps.chosen
        self._list.content = kinds_html(findings, session.loaded, chosen) if session.check is not None else ""

    def _show_finding(self, finding: Finding | None) -> None:
        """Show a finding: its place, its origin, the robot at that time, and the body that it touches."""
        session = self._page.session
        with self._page.client.atomic():
            self._list_findings(session)
            self._unmark()
        if finding is not None:
            self._look_at(finding, session.check)

    def _look_at(self, finding: Finding, check: Checked | None) -> None:
        near = None
        if check is not None and check.motion is not None and finding.where is not None:
            time_s = when(finding, check)
            self._scene.seek(time_s)
            if finding.rule == COLLISION:
                near = near_at(check.cell.cell, check.run.workpiece, check.motion, time_s)
        if near is not None:
            self._mark(near, finding.made_by)
            return
        if check is not None and check.motion is None:
            self._scene.look_at_cell()
        elif finding.where is not None:
            self._scene.look_at_place(finding.where)
        self._page.select(made_by=finding.made_by)

    def _show_nearest(self) -> None:
        check = self._page.session.check
        near = None if check is None or check.motion is None else nearest_of(check.report, check.motion)
        if near is None:
            self._page.notify("Nothing is near", "Robot and tool keep clear of workpiece and fixtures all the time.")
            return
        self._scene.seek(near.time_s)
        self._unmark()
        self._mark(near, NO_SOURCE)

    def _mark(self, near: Near, made_by: Source) -> None:
        """Mark two bodies in red, and the line between their nearest points."""
        with self._page.client.atomic():
            self._scene.robot.mark({near.body, near.other})
            self._scene.draw_over(_LAYER, near_glb(near))
        x, y, z = near.points.mean(axis=0).tolist()
        self._scene.look_at_place((x, y, z), _AROUND_MM)
        place = self._page.session.workpiece.find_place(near.other)
        self._page.select(component="" if place is None else place.name, made_by=made_by)

    def _unmark(self) -> None:
        self._scene.robot.mark(())
        self._scene.draw_over(_LAYER, b"")


def when(finding: Finding, check: Checked) -> float:
    """Time at which the robot is nearest to the place of a finding, s: among the moves of its origin if it has any."""
    moves = [item for item in check.program.instructions if isinstance(item, MoveTo)]
    if check.motion is None or finding.where is None:
        return 0.0
    own = np.array([move.made_by == finding.made_by for move in moves], dtype=np.bool_)
    away = np.linalg.norm(np.array([move.position for move in moves]) - np.array(finding.where), axis=1)
    return float(check.motion.times[int(np.argmin(np.where(own | ~own.any(), away, np.inf)))])


def state_html(session: Session) -> str:
    """Result of the check of the program as it is now, else whether an older program was checked."""
    check = session.check
    if check is None:
        older = session.checked is not None and session.checked.run.workpiece is session.workpiece
        text = "The program or the cell changed since it was checked." if older else "Not checked yet."
        return quiet_html(text)
    return card_html(check_card(check.report))


_PLAIN: str = "The recipe"
_REACH_LAYER = "/reach"
_AROUND_WORST_MM = 60.0
_QUANTITIES: dict[str, Quantity] = {quantity.capitalize(): quantity for quantity in QUANTITIES}
_COLUMNS = 400
_HEAD_PX, _PLOT_PX, _FOOT_PX = 16, 40, 6


class ReachCard:
    """How well the robot reaches each part of the paths, as colours along them."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open; they are visible where there is a joint motion."""
        self._page, self._scene = page, scene
        self._painted: Painted | None = None
        gui = page.client.gui

        def start(session: Session) -> None:
            """Draw the chosen metric, computed in the background."""
            self._job.stop()
            self._put(None)
            check, chosen = session.check, METRICS.get(metric.value)
            width = line_width_mm(size_mm(session.workpiece))
            if check is not None and chosen is not None:
                self._job.start(lambda _progress: paint_reach(chosen, check, width), self._put)

        def reset() -> None:
            metric.value = _PLAIN

        with folder(page, "Reach", lambda now: now.check is not None and now.check.motion is not None):
            hint = "Of what is sprayed; dark is worse, light is better."
            metric = gui.add_dropdown("Metric", (_PLAIN, *METRICS), hint=hint)
            self._job: Job[Painted] = Job(page, refuse=page.refuse, cancelled=reset)
            self._legend = gui.add_html("")
            self._worst = button(gui, "Go to the worst", self._go_to_worst, visible=False)
        metric.on_update(lambda _: start(page.session))  # also where the server resets it
        page.follow(start, lambda now: now.check)

    def _put(self, painted: Painted | None) -> None:
        with self._page.client.atomic():
            self._painted = painted
            self._scene.draw_over(_REACH_LAYER, b"" if painted is None else painted.glb)
            self._legend.content = "" if painted is None else legend_html(painted.legend.items())
            self._worst.visible = painted is not None and painted.worst is not None

    def _go_to_worst(self) -> None:
        worst = None if self._painted is None else self._painted.worst
        if worst is not None:
            place_mm, time_s = worst
            self._scene.seek(time_s)
            self._scene.look_at_place(place_mm, _AROUND_WORST_MM)


class JointsCard:
    """Position, speed and acceleration of the joints over time, with their limits."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open; they are visible where there is a joint motion."""
        self._curves: list[Curve] = []
        self._end_s = 0.0
        gui = page.client.gui

        def possible(session: Session) -> bool:
            return session.check is not None and session.check.report.possible

        def draw(session: Session) -> None:
            check = session.check
            self._curves = []
            if check is not None and check.report.possible:
                self._end_s = check.program.totals.duration_s
                rates = rates_of(check.program, check.report.joints)
                self._curves = joint_curves(check.cell.cell.robot.joints, rates, _QUANTITIES[quantity.value])
                plots.content = curves_html(self._curves, self._end_s)

        def move_cursor(now_s: float) -> None:
            if self._curves:
                cursor.content = plot_cursor_html(now_s, self._end_s, len(self._curves))

        with folder(page, "Joints", possible):
            quantity = dropdown(gui, "Show", _QUANTITIES, "Dashed lines are limits.", lambda _: draw(page.session))
            plots, cursor = gui.add_html(""), gui.add_html("")
        page.follow(draw, lambda now: now.check)
        scene.on_moment(move_cursor)


def curves_html(curves: Sequence[Curve], end_s: float) -> str:
    """Plots of curves one below the other, as wide as their container; limits are drawn where they are near."""
    rows = "".join(_row_html(curve, end_s, to_hex(NAMED[index % len(NAMED)])) for index, curve in enumerate(curves))
    return (
        f'<div style="margin:0 12px;font-size:11px;color:{css_colour(INK)};font-variant-numeric:tabular-nums">'
        f"{rows}</div>"
    )


def plot_cursor_html(now_s: float, end_s: float, curves: int) -> str:
    """Cursor over the plots above, at the time that is shown."""
    height = curves * (_HEAD_PX + _PLOT_PX + _FOOT_PX)
    left = 100 * min(max(now_s / end_s, 0.0), 1.0) if end_s > 0 else 0.0
    return (
        '<div style="position:relative;height:0;margin:0 12px"><div style="position:absolute;'
        f"left:{left:.3f}%;top:-{height}px;height:{height}px;width:1px;background:{css_colour(ACCENT)}"
        '"></div></div>'
    )


def _row_html(curve: Curve, end_s: float, colour: str) -> str:
    low, high = envelope(curve.times, curve.values, end_s, _COLUMNS)
    bottom, top = curve.span
    x = np.linspace(0.0, 100.0, len(low))
    upper, lower = (100.0 * (top - edge) / (top - bottom) for edge in (high, low))
    corners = " ".join(f"{at:.2f},{y:.1f}" for at, y in zip([*x, *x[::-1]], [*upper, *lower[::-1]], strict=True))
    marks = [(limit, css_colour(COLLIDING), "4 3") for limit in (curve.lowest, curve.highest)]
    if curve.quantity != "position":
        marks.append((0.0, LINE_COLOUR, "none"))
    lines = "".join(
        f'<line x1="0" x2="100" y1="{y:.1f}" y2="{y:.1f}" stroke="{stroke}" stroke-width="1" '
        f'stroke-dasharray="{dashes}" vector-effect="non-scaling-stroke"/>'
        for y, stroke, dashes in ((100 * (top - at) / (top - bottom), stroke, dashes) for at, stroke, dashes in marks)
        if 0 <= y <= 100
    )
    summary = css_colour(COLLIDING if curve.use > 1.0 + 1e-3 else QUIET)
    return (
        f'<div style="height:{_HEAD_PX}px;line-height:{_HEAD_PX}px;display:flex;justify-content:space-between">'
        f'<span style="color:{colour};font-weight:600">{escape(curve.name)}</span>'
        f'<span style="color:{summary}">{escape(curve.summary)}</span>'
        '</div><svg viewBox="0 0 100 100" preserveAspectRatio="none" style="display:block;width:100%;'
        f'height:{_PLOT_PX}px;margin-bottom:{_FOOT_PX}px;background:{GROUND}">{lines}'
        f'<polygon points="{corners}" fill="{colour}" stroke="{colour}" stroke-width="1" stroke-linejoin="round" '
        'vector-effect="non-scaling-stroke"/></svg>'
    )
