"""The program at the pace of the cell's robot: planned on request, with what the robot's limits cost."""

from dataclasses import replace

from reports.tables.wording import clock
from robotcell.cell.load import cell_sha256
from rulesengine.planning.pipeline import Run
from webui.page.evaluations import plan_at_pace
from webui.page.page import Page
from webui.page.session import Session
from webui.panels.widgets.job import RunButton
from webui.theme.html import box_html, facts_html, quiet_html


class PaceCard:
    """The planning for the robot, and its price."""

    def __init__(self, page: Page) -> None:
        """Build the elements in the container that is open; they are visible where there is a cell."""
        self._page = page
        self._folder = page.client.gui.add_folder("Plan for this robot", visible=False)
        with self._folder:
            self._run: RunButton[Run] = RunButton(
                page,
                "Plan for this robot",
                self._begin,
                "Times the program so that the robot takes as long as planned.",
            )

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        self._run.show(price_html(session), (session.cell, session.run))
        if before is None or session.cell is not before.cell:
            self._folder.visible = session.cell is not None

    def _begin(self) -> None:
        run, cell = self._page.session.planned_run, self._page.session.cell
        if cell is not None:
            self._run.start(lambda progress: plan_at_pace(run, cell, progress), lambda done: self._take(run, done))

    def _take(self, run: Run, done: Run) -> None:
        """Show the program, unless another was planned meanwhile."""
        self._page.remember(lambda session: replace(session, run=done) if session.run is run else session)


def price_html(session: Session) -> str:
    """What the limits of the robot cost, or that the program does not know them."""
    run = session.run
    timing = None if run is None else run.robot
    if run is None or timing is None:
        return quiet_html("The times are those of the recipe's limits.")
    price = {kind[:1].upper() + kind[1:]: clock(seconds) for kind, seconds in timing.price_s}
    facts = {
        "Price": f"{clock(timing.planned_s - timing.free_s)} longer than the recipe's limits allow",
        **price,
        "Robot": f"takes {timing.robot_s / timing.planned_s:.3f} times the planned time",
    }
    same = session.cell is not None and cell_sha256(session.cell) == run.program.origin.cell_sha256
    older = "" if same else quiet_html(f"Another cell than this, {timing.cell}, gave the program its pace.")
    return older + box_html(facts_html(facts))
