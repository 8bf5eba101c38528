"""The check of the program in the cell: its result, its findings and their places."""

from dataclasses import replace

import numpy as np

from programs.program import MoveTo
from reports.cards.robot import check_card
from specs.finding import Finding
from specs.finding_rules import COLLISION
from specs.source import NO_SOURCE, Source
from webui.cards.finding_list import kinds_html
from webui.layers.robot.proximity import Near, near_at, near_glb, nearest_of
from webui.page.evaluations import Checked, check_program
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.widgets.choices import FindingStepper
from webui.panels.widgets.job import RunButton
from webui.panels.widgets.remedy import RemedyButton
from webui.scene.scene import Scene
from webui.theme.html import card_html, quiet_html

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
        self._folder = gui.add_folder("Check", visible=False)
        with self._folder:
            self._lean = gui.add_number(
                "Tilt band (\N{DEGREE SIGN})",
                0.0,
                min=0.0,
                max=45.0,
                step=1.0,
                hint="Largest jet tilt the robot may add to avoid collisions or limits.",
            )
            self._run: RunButton[Checked] = RunButton(
                page, "Check", self._begin, "Computes the joint motion, and what prevents it."
            )
            self._remedy = RemedyButton(page)
            self._steps = FindingStepper(gui, _HINTS, self._go, {"Nearest": self._show_nearest})
            self._steps.show(visible=False)
            self._list = gui.add_html("")
        page.check = self._begin

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        self._run.show(state_html(session), (session.cell, session.run, session.checked, session.check))
        if before is not None and session.cell is before.cell and session.check is before.check:
            return
        self._folder.visible = session.cell is not None
        self._steps.chosen = None
        self._unmark()
        self._list_findings(session)
        self._remedy.show(session)

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

    def _go(self, finding: Finding | None) -> None:
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
