"""How well the robot can do each part of the paths: colours along them."""

from webui.cards.stroke_card import legend_html
from webui.glb.ribbons import board_size_mm, line_width_mm
from webui.page.page import Page
from webui.page.session import Session
from webui.scene.reach_colours import METRICS, Painted, paint_reach
from webui.scene.scene import Scene
from webui.threads.worker import Worker

_PLAIN: str = "The recipe"
_LAYER = "/reach"
_AROUND_MM = 60.0


class ReachCard:
    """How well the robot can do each part of the paths: colours along them."""

    def __init__(self, page: Page, scene: Scene) -> None:
        """Build the elements in the container that is open; they are seen where there is a joint motion."""
        self._page, self._scene = page, scene
        self._worker: Worker[Painted] = Worker(self._show_progress)
        page.on_close(self._worker.close)
        gui = page.client.gui
        self._folder = gui.add_folder("Reach", visible=False)
        with self._folder:
            self._metric = gui.add_dropdown(
                "Metric", (_PLAIN, *METRICS), hint="What is sprayed; dark is worse, light is better."
            )
            self._legend = gui.add_html("")
            self._worst = gui.add_button("Go to the worst", visible=False, color="gray")
        self._painted: Painted | None = None
        self._metric.on_update(lambda _: self._start(page.session))
        self._worst.on_click(lambda _: self._go_to_worst())

    def show(self, session: Session, before: Session | None) -> None:
        """Show a session."""
        if before is None or session.check is not before.check:
            self._folder.visible = session.check is not None and session.check.motion is not None
            self._start(session)

    def _start(self, session: Session) -> None:
        """Draw the map of the metric that is chosen, beside the page."""
        self._worker.cancel()
        self._put(None)
        check, metric = session.check, METRICS.get(self._metric.value)
        width = line_width_mm(board_size_mm(session.board))
        if check is not None and metric is not None:
            self._worker.start(lambda _progress: paint_reach(metric, check, width), self._put, self._page.report)

    def _put(self, painted: Painted | None) -> None:
        with self._page.client.atomic():
            self._painted = painted
            self._scene.draw_over(_LAYER, b"" if painted is None else painted.glb)
            self._legend.content = "" if painted is None else legend_html(painted.legend)
            self._worst.visible = painted is not None and painted.worst is not None

    def _go_to_worst(self) -> None:
        painted = self._painted
        if painted is not None and painted.worst is not None:
            self._scene.seek(painted.worst.time_s)
            self._scene.look_at_place(painted.worst.place_mm, _AROUND_MM)

    def _show_progress(self, what: str, done: float) -> None:
        pass
