"""Whether the robot can do the program: the check, what came of it, and where."""

from html import escape
from operator import is_

import numpy as np

from programs.program import MoveTo
from specs.finding import Finding
from specs.finding_rules import COLLISION
from webui.cards.boxes import box_html, quiet_html
from webui.cards.finding_list import kinds_html, tally
from webui.layers.robot.near_mark import near_glb
from webui.layers.robot.proximity import Near, moment_of, near_at, nearest_of
from webui.page.checked import Checked, check_program, facts_of
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.widgets.finding_steps import FindingSteps
from webui.panels.widgets.job import RunButton
from webui.scene.scene import Scene
from webui.theme.palette import QUIET, to_hex

_HINTS = (
    "Shows the place, who asked for it, and the robot at that moment.",
    "Through the findings; where bodies are nearest.",
)
_LAYER = "/near"
_AROUND_MM = 250.0
"""What is seen to each side where bodies touch: enough to recognise them."""


class CheckCard:
    """Whether the robot can do the program: the check, what came of it, and where."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open; they are seen where there is a cell."""
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
                page, "Check", self._begin, "Finds how the joints move, and what keeps the robot from it."
            )
            self._steps = FindingSteps(gui, _HINTS, self._go, {"Nearest": self._show_nearest})
            self._steps.show(visible=False)
            self._list = gui.add_html("")

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        if before is None or not all(map(is_, _subject_of(session), _subject_of(before))):
            self._run.show(state_html(session))
        if before is not None and session.cell is before.cell and session.check is before.check:
            return
        self._folder.visible = session.cell is not None
        self._steps.chosen = None
        self._unmark()
        self._list_findings(session)

    def _begin(self) -> None:
        session = self._page.session
        run, cell = session.run, session.cell
        if run is None or cell is None or not session.planned:
            self._page.refuse("The recipe as it is now is not planned yet; wait until it is.")
            return
        lean = np.radians(self._lean.value)
        self._run.start(lambda progress: check_program(run, cell, progress, lean), self._take)

    def _take(self, checked: Checked) -> None:
        self._page.remember(lambda session: session.with_check(checked))

    def _list_findings(self, session: Session) -> None:
        findings = session.check.findings if session.check is not None else ()
        self._steps.offer(findings)
        self._steps.show(visible=session.check is not None)
        chosen = self._steps.chosen
        self._list.content = kinds_html(findings, session.loaded, chosen) if session.check is not None else ""

    def _go(self, finding: Finding | None) -> None:
        """Show what a finding is about: place, maker, the robot at that moment, what it touches there."""
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
                near = near_at(check.cell.cell, check.run.board, check.motion, time_s)
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
            self._page.say("Nothing is near", "Robot and tool keep clear of board and fixtures all the time.")
            return
        self._scene.seek(near.time_s)
        self._unmark()
        self._mark(near, "")

    def _mark(self, near: Near, made_by: str) -> None:
        """Draw two bodies in red, and the line between their nearest points."""
        with self._page.client.atomic():
            self._scene.robot.mark({near.body, near.other})
            self._scene.draw_over(_LAYER, near_glb(near))
        x, y, z = near.points.mean(axis=0).tolist()
        self._scene.look_at_place((x, y, z), _AROUND_MM)
        parts = {component.name for component in self._page.session.board.components}
        self._page.select(component=near.other if near.other in parts else "", made_by=made_by)

    def _unmark(self) -> None:
        self._scene.robot.mark(())
        self._scene.draw_over(_LAYER, b"")


def _subject_of(session: Session) -> tuple[object, ...]:
    """What the line beneath the button is about."""
    return session.cell, session.run, session.checked, session.check


def when(finding: Finding, check: Checked) -> float:
    """Say when the robot is where a finding is, s; 0 where nothing moves."""
    moves = [item for item in check.program.instructions if isinstance(item, MoveTo)]
    if check.motion is None or finding.where is None:
        return 0.0
    places = np.array([move.position for move in moves])
    makers = tuple(move.made_by for move in moves)
    return moment_of(check.motion, places, makers, finding.made_by, np.array(finding.where))


def state_html(session: Session) -> str:
    """Say whether the program as it is now was checked in this cell, and what came of it at one glance."""
    check = session.check
    if check is None:
        older = session.checked is not None and session.checked.run.board is session.board
        text = "The program or the cell changed since it was checked." if older else "Not checked yet."
        return quiet_html(text)
    done = "The robot can do it." if check.motion is not None else "The robot cannot do it."
    if any(finding.severity == "error" for finding in check.findings):
        done = "The robot cannot do it as it is."
    rows = "".join(
        f'<tr><td style="color:{to_hex(QUIET)};padding:1px 12px 1px 0;vertical-align:top">{escape(name)}</td>'
        f"<td>{escape(text)}</td></tr>"
        for name, text in facts_of(check).items()
    )
    head = f'<div style="font-weight:600">{done} <span style="font-weight:400;color:{to_hex(QUIET)}">'
    return box_html(
        f"{head}{tally(check.findings).capitalize()}.</span></div>"
        f'<table style="border-collapse:collapse;margin-top:2px">{rows}</table>'
    )
