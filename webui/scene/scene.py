"""The scene: workpiece, paths and selection, redrawn where the session changed."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np
import viser

from boards.board import NEAREST_MM, Place, Side, Workpiece
from geometry.arrays import Points, Scalars
from rulesengine.planning.pipeline import Run
from specs.source import Source
from webui.glb.glb import bars, flat_triangles_glb, line_width_mm, size_mm, unlike_segments
from webui.layers.paths import strokes
from webui.layers.paths.nozzle import find_markers, markers_glb
from webui.layers.paths.strokes import Span, spray_spans
from webui.layers.robot.robot import joints_at, tool_at
from webui.layers.surface import ground
from webui.page.page import Page
from webui.page.session import Session
from webui.scene.camera import Camera, Target, choose_stroke, first_hit, light_scene, strokes_at, target_of
from webui.scene.camera import View as CameraView
from webui.scene.moving import RobotView
from webui.theme.palette import SELECTED

_M = 0.001
"""The scene is in metres: a browser clips scenes of hundreds of units."""
_NEAR_STROKE_MM = 2.0
_NOZZLE_MM = 50.0
"""Usual height of paths above a board."""

_NUMBER_SCALE = 0.7
_OBLIQUE = np.array([0.5, -0.75, 0.45])
"""From a part towards the eye."""

ClickTaker: TypeAlias = Callable[[Points, Points], None]
"""Takes the ray of a click: (3,) where it comes from, mm, and (3,) its direction."""


@dataclass(frozen=True, slots=True)
class View:
    """What of a session is visible, and in which colours; kept when the session changes."""

    components_by: ground.ColourBy = "nothing"
    strokes_by: strokes.ColourBy = "function"
    hidden: frozenset[Source] = frozenset()
    """Templates in their steps whose strokes are not shown, such as ``"sequence[0]/sweep"``."""
    transfers: bool = True
    markers: bool = True
    paths: bool = True
    """Without them only the selected strokes are drawn."""
    stripes: bool = True
    """On the faces of a part: where the jet meets them, numbered in their order."""
    lances: bool = False
    """The lance at moments of its way over a part."""


class Scene:
    """Draws a session for one browser."""

    def __init__(self, page: Page) -> None:
        """Set up light and camera."""
        self._page = page
        self._camera = Camera(page.client)
        self._framed = False
        """Whether the paths of this board have been in the picture."""
        page.on_close(self._camera.stop)
        self._api = page.client.scene
        light_scene(self._api)
        self.view = View()
        self.strokes: list[strokes.StrokeLine] = []
        self.spans: list[Span | None] = []
        """Time span of each stroke, where colours show it."""
        self.legends: dict[str, ground.Tints] = {}
        self.click_taker: ClickTaker | None = None
        """Receives clicks in place of the selection."""
        self._target: Target | None = None
        self._api.on_click()(self._clicked)
        self._handles: dict[str, viser.GlbHandle] = {}
        self._drawn: dict[str, bytes] = {}
        self._label: viser.LabelHandle | None = None
        self._numbers: list[viser.LabelHandle] = []
        """Of the stripes on a part, in their order."""
        self.robot = RobotView(self._api)
        self.seek: Callable[[float], None] = self.show_moment
        """Goes to a time of the program, s; replaced by the playback."""
        self._followers: list[Callable[[float], None]] = []
        self.is_live = False
        """Whether the robot is shown as it is operated, and not at a time of the program."""
        self.stamp: Callable[[float], None] = lambda _: None
        """Writes the time of the operation, s, that is shown, where the browser reads it."""

        page.follow(self._show_workpiece, lambda now: now.workpiece)
        page.follow(self._draw_ground, lambda now: (now.workpiece, self.view.components_by == "class" and now.run))
        page.follow(lambda now: self.robot.show_cell(None if now.cell is None else now.cell.cell), lambda now: now.cell)
        page.follow(self._draw_stripes, lambda now: now.coverings)
        page.follow(self._show_plan, lambda now: now.plan)
        page.follow(self._draw_selection, lambda now: (now.plan, now.selection, now.lit))

    def _show_workpiece(self, session: Session) -> None:
        self._target = target_of(session.workpiece)
        self._framed = False
        self._camera.show_whole(*session.workpiece.room("top", _NOZZLE_MM), _first_view(session.workpiece))

    def _show_plan(self, session: Session) -> None:
        self.strokes = [] if session.plan is None else strokes.stroke_lines(session.plan)
        self.spans = [] if session.timed is None else self._spans(session.timed)
        self._draw_strokes(session)
        if self.strokes and not self._framed:
            self._framed = True
            self._camera.show_whole(*self._whole(), _first_view(session.workpiece))

    def change_view(self, view: View) -> None:
        """Show the same session in another view."""
        before, self.view = self.view, view
        session = self._page.session
        if view.components_by != before.components_by:
            self._draw_ground(session)
        if replace(view, components_by=before.components_by) != before:
            if view.strokes_by != before.strokes_by and session.timed is not None:
                self.spans = self._spans(session.timed)
            self._draw_strokes(session)
        if (view.stripes, view.lances, view.paths, view.hidden) != (
            before.stripes, before.lances, before.paths, before.hidden,
        ):  # fmt: skip
            self._draw_stripes(session)

    def _clicked(self, event: viser.SceneClickEvent) -> None:
        origin, direction = np.array(event.ray_origin) / _M, np.array(event.ray_direction)
        if self.click_taker is not None:
            self.click_taker(origin, direction)
            return
        hit = None if self._target is None else first_hit(self._target, origin, direction)
        shown = [line for line in self.strokes if self._shows(line)]
        before_mm = np.inf if hit is None else hit.distance_mm
        part = hit.body if hit is not None and hit.body in self._page.session.workpiece.place_names else ""
        makers = strokes_at(shown, origin, direction, before_mm)
        if not makers and not part:  # on the bare board, or a fixture
            makers = strokes_at(shown, origin, direction, before_mm, _NEAR_STROKE_MM)
        if makers:
            self._page.select(made_by=choose_stroke(makers, self._page.session.selection.made_by))
        else:
            self._page.select(component=part)

    def on_moment(self, follow: Callable[[float], None]) -> None:
        """Call a function with each time of the program that the playback shows, s."""
        self._followers.append(follow)

    def show_moment(self, now_s: float) -> None:
        """Show the robot at a time of the program, s, and notify followers; the nozzle is drawn by the playback."""
        check = self._page.session.check
        if check is not None and check.motion is not None and not self.is_live:
            self.robot.stand(joints_at(check.motion, np.array([now_s]))[0], tool_at(check.motion, now_s))
        for follow in self._followers:
            follow(now_s)

    def show_live(self, joints: Scalars, tool: int, seconds: float) -> None:
        """Show the robot as it is operated, and the time of the operation, s, that it is shown at.

        Args:
            joints: (dof,) rad or m.
            tool: Number of the mounted tool.
            seconds: Since the operation began.
        """
        self.robot.stand(joints, tool)
        self.stamp(seconds)

    def draw_over(self, name: str, glb: bytes) -> None:
        """Draw a layer, mm in the board frame, in place of the one of that name; no bytes remove it."""
        if self._drawn.get(name, b"") == glb:
            return
        handle = self._handles.pop(name, None)
        if handle is not None:
            handle.remove()
        if glb:
            self._handles[name] = self._api.add_glb(name, glb, scale=_M)
        self._drawn[name] = glb

    def point_on_board(self, origin: Points, direction: Points) -> tuple[float, float] | None:
        """Point where a ray meets the board or a part, else the plane of its top, mm; ``None`` if it meets neither."""
        hit = None if self._target is None else first_hit(self._target, origin, direction)
        if hit is not None:
            return round(float(hit.point[0]), 2), round(float(hit.point[1]), 2)
        down = float(self._page.session.workpiece.box[1][2]) - float(origin[2])
        if direction[2] == 0 or down / float(direction[2]) < 0:
            return None
        x, y, _ = (float(value) for value in origin + direction * (down / float(direction[2])))
        return round(x, 2), round(y, 2)

    def look_at_job(self, view: CameraView | None = None) -> None:
        """Show the workpiece and all strokes, from straight above or from the front; else as they are shown first."""
        workpiece = self._page.session.workpiece
        of_part = view == "iso" and bool(workpiece.faces)
        self._camera.fly_to(*self._whole(), _first_view(workpiece) if view is None or of_part else view)

    def look_back(self) -> None:
        """Return to the view before."""
        self._camera.fly_back()

    def _whole(self) -> tuple[Points, Points]:
        """Lowest and highest corner, mm, of the workpiece and all strokes."""
        return strokes.job_box(self._page.session.workpiece, self.strokes)

    def look_at_board(self, side: Side = "top") -> None:
        """Show the whole workpiece and all strokes, from the front, above or below."""
        (low, high), (room_low, room_high) = self._whole(), self._page.session.workpiece.room(side, _NOZZLE_MM)
        box = np.minimum(low, room_low), np.maximum(high, room_high)
        self._camera.fly_to(*box, from_below=side == "bottom")

    def look_at_cell(self) -> None:
        """Show the robot and the workpiece."""
        low, high = self._page.session.workpiece.room("top", _NOZZLE_MM)
        robot_low, robot_high = self.robot.bounds_mm() or (low, high)
        self._camera.fly_to(np.minimum(low, robot_low), np.maximum(high, robot_high))

    def look_at(self, place: Place) -> None:
        """Zoom in on a component or a face."""
        self._camera.fly_to(place.low, place.high, place.towards)

    def look_at_place(self, place: tuple[float, float, float], around_mm: float = NEAREST_MM) -> None:
        """Zoom in on a place, mm, from its side of the workpiece, with a half width of the view."""
        (low, high), half = self._page.session.workpiece.box, np.array([around_mm, around_mm, 0.0])
        below = place[2] < float(low[2] + high[2]) / 2
        self._camera.fly_to(np.array(place) - half, np.array(place) + half, from_below=below)

    def _draw_ground(self, session: Session) -> None:
        by = self.view.components_by
        classified = session.run.classified if session.run is not None and by == "class" else ()
        glb, self.legends["components"] = ground.paint_workpiece(session.workpiece, classified, by)
        self.draw_over("/board", glb)

    def _draw_strokes(self, session: Session) -> None:
        plan, size = session.plan, size_mm(session.workpiece)
        tints, self.legends["strokes"] = strokes.tint_strokes(self.strokes, self.view.strokes_by, self.spans)
        shown = [index for index, line in enumerate(self.strokes) if self._shows(line)]
        lines = [self.strokes[index] for index in shown]
        self.draw_over("/strokes", strokes.strokes_glb(lines, [tints[index] for index in shown], line_width_mm(size)))
        transfers = self.view.paths and self.view.transfers and plan is not None
        self.draw_over("/transfers", strokes.transfers_glb(plan, self.view.hidden) if transfers and plan else b"")
        found = find_markers(plan) if self.view.paths and self.view.markers and plan is not None else []
        seen = [marker for marker in found if marker.made_by not in self.view.hidden]
        self.draw_over("/markers", markers_glb(seen, size / 260))

    def _draw_stripes(self, session: Session) -> None:
        """Draw the stripes on the faces of a part, with their numbers, and its lance; of a board there are none."""
        view = self.view
        shown = [each for each in session.coverings if each.made_by not in view.hidden]
        shown = shown if view.paths else []
        width = line_width_mm(size_mm(session.workpiece))
        self.draw_over("/stripes", ground.stripes_glb(shown, width) if view.stripes else b"")
        self.draw_over("/lances", ground.lances_glb(shown) if view.lances else b"")
        for number in self._numbers:
            number.remove()
        self._numbers = [
            self._api.add_label(
                f"/order/{number}", str(number), position=tuple((place * _M).tolist()), depth_test=True,
                font_screen_scale=_NUMBER_SCALE, anchor="center-center",
            )
            for number, place in (ground.stripe_starts(shown) if view.stripes else ())
        ]  # fmt: skip

    def _shows(self, line: strokes.StrokeLine) -> bool:
        return self.view.paths and line.made_by.place not in self.view.hidden

    def _spans(self, run: Run) -> list[Span | None]:
        """Time spans of strokes; computed only where their colours show them."""
        if self.view.strokes_by != "time":
            return [None] * len(self.strokes)
        return strokes.stroke_spans(self.strokes, spray_spans(run.program))

    def _draw_selection(self, session: Session) -> None:
        component = session.selection.component
        self.draw_over("/selection", ground.chosen_glb(session.workpiece, component, SELECTED))
        if self._label is not None:
            self._label.remove()
            self._label = None
        place = session.workpiece.find_place(component)
        if place is not None:
            self._label = self._api.add_label("/name", place.name, position=tuple((place.label * _M).tolist()))
        lit = session.lit
        chosen = [line for line in self.strokes if any(line.made_by.belongs_to(each) for each in lit)]
        segments = np.concatenate([np.empty((0, 2, 3)), *(line.segments for line in chosen)])
        segments = segments[unlike_segments(segments)]
        width = 2.0 * line_width_mm(size_mm(session.workpiece))
        self.draw_over("/chosen", flat_triangles_glb(*bars(segments, SELECTED, width)))


def _first_view(workpiece: Workpiece) -> CameraView:
    """A board from straight above; a part from where three of its sides are seen."""
    return _OBLIQUE if workpiece.faces else "plan"
