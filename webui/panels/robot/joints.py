"""What the joints do over time, against their limits."""

from reports.pictures.joint_picture import QUANTITIES, Curve, Quantity, joint_curves
from robotcell.motion.retime import rates_of
from webui.layers.robot.joint_plots import curves_html, plot_cursor_html
from webui.page.page import Page
from webui.page.session import Session
from webui.scene.scene import Scene

_SHOWN: dict[str, Quantity] = {quantity.capitalize(): quantity for quantity in QUANTITIES}


class JointsCard:
    """What the joints do over time, against their limits."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open; they are seen where there is a joint motion."""
        self._page = page
        self._curves: list[Curve] = []
        self._end_s = 0.0
        gui = page.client.gui
        self._folder = gui.add_folder("Joints", visible=False)
        with self._folder:
            self._quantity = gui.add_dropdown("Show", tuple(_SHOWN), hint="Dashed lines are limits.")
            self._plots = gui.add_html("")
            self._cursor = gui.add_html("")
        self._quantity.on_update(lambda _: self._draw(page.session))
        scene.on_moment(self._follow)

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        if before is None or session.check is not before.check:
            self._draw(session)

    def _draw(self, session: Session) -> None:
        check = session.check
        self._folder.visible = check is not None and check.report.possible
        if check is None or not check.report.possible:
            self._curves = []
            return
        self._end_s = check.program.totals.duration_s
        rates = rates_of(check.program, check.report.joints)
        self._curves = joint_curves(check.cell.cell.robot.joints, rates, _SHOWN[self._quantity.value])
        self._plots.content = curves_html(self._curves, self._end_s)

    def _follow(self, now_s: float) -> None:
        if self._curves:
            self._cursor.content = plot_cursor_html(now_s, self._end_s, len(self._curves))
