"""A recorded playback in one HTML file, which opens without a server and without a network."""

import threading
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager
from html import escape

import numpy as np
import rich
import viser

from geometry.arrays import Scalars
from programs.errors import ProgramError
from programs.playback import build_timeline
from rulesengine.planning.pipeline import Run
from specs.progress import Progress, no_progress
from webui.access.access import access_for
from webui.access.viser_guard import start_guarded
from webui.glb.glb import line_width_mm, size_mm
from webui.layers.paths.nozzle import moment
from webui.layers.paths.strokes import (
    clock,
    job_box,
    stroke_lines,
    strokes_glb,
    tint_functions,
    tint_strokes,
    transfers_glb,
)
from webui.layers.robot.robot import joints_at, tool_at
from webui.layers.surface.ground import ground_glb
from webui.page.evaluations import Checked
from webui.scene.camera import Lens, frame_box, light_scene
from webui.scene.moving import NozzleView, RobotView
from webui.theme.html import legend_html
from webui.theme.palette import INK, to_hex

_ONE_AT_A_TIME = threading.Lock()
_M = 0.001
_FRAMES_PER_S = 15
_ASPECT = 1.0
"""Of the picture in which all of the first view is seen; windows are wider."""
_MOST_FRAMES = 6000
_STAMPS = 400
"""Number of changes of the time label in the scene."""


def record(
    run: Run,
    rate: float = 10.0,
    progress: Progress = no_progress,
    checked: Checked | None = None,
    predicted: str = "",
) -> str:
    """Recording of a whole program at a playback speed: workpiece, paths, title, legend and what is predicted.

    Args:
        run: The run.
        rate: How many times faster than the robot; > 0.
        progress: Receives the stage and the share done.
        checked: Check of this very program, which adds its robot.
        predicted: What an analysis of this very program predicts; empty where it was not analysed.

    Returns:
        A self-contained HTML document.

    Raises:
        ProgramError: there is nothing to play.
    """
    end_s = run.program.totals.duration_s
    if end_s <= 0 or rate <= 0:
        raise ProgramError("a playback needs a program that takes time and a speed above 0.")
    with _quiet_server() as server:
        _draw_static(server, run)
        recording = server.get_scene_serializer()
        move = _robot_mover(server.scene, checked)
        for now_s, lasting in _play(server.scene, run, frame_times(end_s, rate), progress):
            move(now_s)
            recording.insert_sleep(lasting / rate)
        return _with_title(recording.as_html(), run, checked, predicted)


def _with_title(html: str, run: Run, checked: Checked | None, predicted: str) -> str:
    """Add the names of workpiece and recipe, totals, robot and prediction, and the colours of the functions."""
    totals = run.program.totals
    name = f"{run.workpiece.name} \N{MULTIPLICATION SIGN} {run.recipe.recipe}"
    litres = sum(amount for _, amount in totals.liquid_l)
    lines = [f"{clock(totals.duration_s)}, {litres:.1f} l"]
    if checked is not None:
        robot = checked.cell.cell.robot.name
        lines.append(f"Robot {robot}: {'can do it' if checked.motion is not None else 'cannot do it'}")
    lines.append(predicted or "Cleaning: not analysed")
    facts = "".join(f"<div>{escape(line)}</div>" for line in lines)
    title = (
        '<div style="position:fixed;left:12px;top:12px;z-index:9;pointer-events:none;padding:8px 12px;'
        f'border-radius:4px;background:#fffffff0;font:13px/1.45 sans-serif;color:{to_hex(INK)}">'
        f'<div style="font-size:16px;font-weight:600">{escape(name)}</div>{facts}'
        f"{legend_html(tint_functions(run.recipe).items())}</div>"
    )
    head, body, rest = html.partition("<body>")
    return head.replace("<title>Viser</title>", f"<title>{escape(name)}</title>") + body + title + rest


def frame_times(end_s: float, rate: float) -> Scalars:
    """(n,) times to record, evenly from the beginning to the end; long recordings have fewer a second."""
    count = int(np.clip(np.ceil(end_s / rate * _FRAMES_PER_S), 1, _MOST_FRAMES))
    return np.linspace(0.0, end_s, count + 1)


def _play(api: viser.SceneApi, run: Run, times: Scalars, progress: Progress) -> Iterator[tuple[float, float]]:
    """Draw frame after frame; yield the time of each and its duration."""
    timeline = build_timeline(run.program)
    tool = NozzleView(api, tint_functions(run.recipe))
    (low_x, low_y, _), (_, _, top_z) = (corner.tolist() for corner in run.workpiece.box)
    stamp = api.add_label("/time", "", position=(low_x * _M, low_y * _M, top_z * _M))
    every = max(1, len(times) // _STAMPS)
    for index, (now_s, lasting) in enumerate(zip(times.tolist(), [*np.diff(times).tolist(), 0.0], strict=True)):
        if index % every == 0:
            progress("recording", index / len(times))
        shown = moment(timeline, run.recipe, run.workpiece, now_s)
        tool.show(shown)
        if index % every == 0:
            stamp.text = f"{shown.function} {clock(now_s)}".strip()
        yield now_s, lasting


def _robot_mover(api: viser.SceneApi, checked: Checked | None) -> Callable[[float], None]:
    """Draw the robot, if there is one; return a function that moves it to its pose at a time."""
    if checked is None or checked.motion is None:
        return lambda _now_s: None
    view, motion = RobotView(api), checked.motion
    view.show_cell(checked.cell.cell)
    return lambda now_s: view.stand(joints_at(motion, np.array([now_s]))[0], tool_at(motion, now_s))


def _draw_static(server: viser.ViserServer, run: Run) -> None:
    """Draw light, workpiece and paths, and set the first view."""
    light_scene(server.scene)
    lines = stroke_lines(run.plan)
    tints, _ = tint_strokes(lines, "function", [None] * len(lines))
    parts = {
        "/board": ground_glb(run.workpiece, {}),
        "/strokes": strokes_glb(lines, tints, line_width_mm(size_mm(run.workpiece))),
        "/transfers": transfers_glb(run.plan),
    }
    for name, glb in parts.items():
        if glb:
            server.scene.add_glb(name, glb, scale=_M)
    camera = server.initial_camera
    pose = frame_box(*job_box(run.workpiece, lines), Lens(camera.fov, _ASPECT))
    camera.near, camera.look_at, camera.position = 0.001, pose.target * _M, pose.eye * _M


@contextmanager
def _quiet_server() -> Generator[viser.ViserServer]:
    """A temporary server, reachable from this machine only, which prints nothing."""
    console = rich.get_console()
    with _ONE_AT_A_TIME:
        loud, console.quiet = console.quiet, True
        try:
            server = start_guarded(access_for("127.0.0.1"), "127.0.0.1", 0)
            try:
                yield server
            finally:
                server.stop()
        finally:
            console.quiet = loud
