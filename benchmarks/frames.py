"""How smoothly a browser turns a large board with long paths, against an empty scene in the same run.

Run: ``OMP_NUM_THREADS=1 python benchmarks/frames.py [BOARD]``

Shows, through the page's own layers, nothing, a board of 200,000 triangles, and the same with paths of 50,000
vertices; drags the camera around for some seconds and counts the frames. Without BOARD one is made. The strokes are
those of ``smt-aqueous``, divided until they have so many vertices. Chromium draws without a graphics card here, on the
processor, and prints the seconds of it that a frame takes: they hold on a busy machine too.
"""

import itertools
import os
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import numpy as np
import rich
import viser
from playwright.sync_api import Browser, Page

sys.path.insert(0, str(Path(__file__).resolve().parent.parent / "tests" / "support"))

from driven_page import CHROMIUM, NO_CHROMIUM, open_chromium
from large_board import finer, write_large_board

from boards.board import Board
from boards.load import load_board
from recipes.load import load_recipe
from rulesengine.planning.pipeline import run
from webui.glb.glb import line_width_mm, size_mm
from webui.layers.paths.strokes import StrokeLine, stroke_lines, strokes_glb, tint_strokes
from webui.layers.surface.ground import ground_glb
from webui.scene.camera import light_scene

TRIANGLES, VERTICES = 200_000, 50_000
SECONDS = 20.0
WINDOW = {"width": 1400, "height": 900}
SETTLE_MS = 8000
COUNT = """() => {
  window.frames = 0; window.counting = true;
  const count = () => { if (window.counting) { window.frames += 1; requestAnimationFrame(count); } };
  requestAnimationFrame(count);
}"""
STOP = "() => { window.counting = false; return window.frames; }"


def refined(board: Board) -> Board:
    """Divide patches, body after body, until there are enough."""
    bodies, count = list(board.bodies), sum(len(body.patches) for body in board.bodies)
    turns = itertools.cycle(range(len(bodies)))
    while count < TRIANGLES:
        index = next(turns)
        count += 3 * len(bodies[index].patches)
        bodies[index] = finer(bodies[index])
    return replace(board, bodies=tuple(bodies))


def divided(lines: list[StrokeLine]) -> list[StrokeLine]:
    """Divide each line into so many parts that all together have enough vertices."""
    times = int(np.ceil(VERTICES / sum(len(line.points) for line in lines)))
    return [replace(line, points=_between(line.points, times)) for line in lines]


def _between(points: np.ndarray, times: int) -> np.ndarray:
    at = np.linspace(0, len(points) - 1, (len(points) - 1) * times + 1)
    known = np.arange(len(points))
    return np.column_stack([np.interp(at, known, channel) for channel in points.T])


@contextmanager
def scene(board: Board) -> Iterator[viser.ViserServer]:
    rich.get_console().quiet = True
    server = viser.ViserServer(host="127.0.0.1", port=8165, verbose=False)
    light_scene(server.scene)
    left, front, right, back = board.outline.bounds
    middle = np.array([(left + right) / 2, (front + back) / 2, board.top_z_mm]) / 1000
    server.initial_camera.near = 0.001
    server.initial_camera.look_at = middle
    server.initial_camera.position = middle + size_mm(board) / 1000 * np.array([0.0, -0.6, 0.8])
    try:
        yield server
    finally:
        server.stop()


def processor_s() -> float:
    """Processor time of all processes that this one began and that still live: chromium's."""
    parents: dict[int, tuple[int, int]] = {}
    for file in Path("/proc").glob("[0-9]*/stat"):
        try:
            fields = file.read_text().rpartition(")")[2].split()
        except OSError:  # it ended meanwhile
            continue
        parents[int(file.parent.name)] = int(fields[1]), int(fields[11]) + int(fields[12])
    family = {os.getpid()}
    for _ in range(8):
        family |= {child for child, (parent, _) in parents.items() if parent in family}
    return sum(parents[child][1] for child in family - {os.getpid()}) / os.sysconf("SC_CLK_TCK")


def turn(page: Page) -> tuple[float, float]:
    """Turn the camera with the mouse; frames in a second, and seconds of the processor for each."""
    x, y = WINDOW["width"] / 2, WINDOW["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.evaluate(COUNT)
    begun, worked, step = time.perf_counter(), processor_s(), 0
    while time.perf_counter() - begun < SECONDS:
        step += 1
        page.mouse.move(x + 200 * np.sin(step / 10), y + 60 * np.cos(step / 10))
        page.wait_for_timeout(15)
    frames = max(float(page.evaluate(STOP)), 1.0)
    lasted, worked = time.perf_counter() - begun, processor_s() - worked
    page.mouse.up()
    return frames / lasted, worked / frames


def measure(browser: Browser, board: Board, layers: dict[str, bytes], sharpness: float) -> tuple[float, float]:
    with scene(board) as server:
        for name, glb in layers.items():
            server.scene.add_glb(name, glb, scale=0.001)
        page = browser.new_page(viewport=WINDOW)
        page.goto(f"http://127.0.0.1:{server.get_port()}/?fixedDpr={sharpness}", wait_until="domcontentloaded")
        page.wait_for_selector("canvas")
        page.wait_for_timeout(SETTLE_MS)
        turned = turn(page)
        page.close()
        return turned


def main() -> None:
    if CHROMIUM is None:
        sys.exit(NO_CHROMIUM)
    with tempfile.TemporaryDirectory() as folder:
        file = Path(sys.argv[1]) if sys.argv[1:] else write_large_board(Path(folder) / "large.tri")
        board = load_board(file)
    plan = run(load_recipe("smt-aqueous"), board).plan
    board, lines = refined(board), divided(stroke_lines(plan))
    tints, _ = tint_strokes(lines, "function", [None] * len(lines))
    ground = ground_glb(board, {})
    strokes = strokes_glb(lines, tints, line_width_mm(size_mm(board)))
    triangles = sum(len(body.patches) for body in board.bodies)
    vertices = sum(len(line.points) for line in lines)
    print(f"{triangles} triangles in {len(ground) / 1e6:.1f} MB, {vertices} vertices in {len(strokes) / 1e6:.1f} MB")
    scenes = {"empty": {}, "board": {"/board": ground}, "board and paths": {"/board": ground, "/strokes": strokes}}
    for sharpness in (1.0, 0.25):
        with open_chromium() as browser:
            turned = {name: measure(browser, board, layers, sharpness) for name, layers in scenes.items()}
        for name, (rate, cost) in turned.items():
            ratio = cost / turned["empty"][1]
            print(
                f"sharpness {sharpness:g}  {name:16} {rate:6.2f} frames/s {cost:7.3f} s a frame, {ratio:6.1f} of empty"
            )


if __name__ == "__main__":
    main()
