"""Pictures of parts: faces, stripes in their order, traces of the lance, and what is clean; seen from four sides."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from boards.board import Part, scene_of
from geometry.arrays import Directions, Scalars, Triangles
from geometry.mesh import areas_and_normals
from geometry.rays import RayScene, cast, split_patches
from programs.playback import build_timeline, play
from programs.program import TimedProgram
from reports.pictures.sheet import (
    ACCENT,
    FUNCTION_COLOURS,
    INK,
    LEFT_MM,
    QUIET,
    RIGHT_MM,
    SHEET_MM,
    TOP_MM,
    check_suffix,
    sheet,
    to_bytes,
    write_foot,
    write_title,
)
from reports.tables.wording import clock

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from rulesengine.surface.part_job import Covering, Survey

_VIEWS: tuple[tuple[str, tuple[float, float]], ...] = (
    ("from the front right", (-55.0, 25.0)), ("from the back left", (125.0, 25.0)),
    ("from the front left below", (-145.0, -25.0)), ("from the back right below", (35.0, -25.0)),
)  # fmt: skip
_LIGHT = np.array([0.35, 0.45, 0.82])
_LIFT_MM = 0.6
_CLEAN, _SHORT, _UNSEEN = np.array([0.37, 0.66, 0.47]), np.array([0.86, 0.42, 0.27]), np.array([0.55, 0.57, 0.60])
_STEEL, _FIXTURE = np.array([0.86, 0.88, 0.86]), np.array([0.72, 0.74, 0.78])
_PANEL_MM = 92.0
_MOMENT_S = 0.04
_LANCES = 25
"""Moments of spraying from one lance that is drawn to the next."""
_LANCE_MM = 30.0
_CUTS = 12
_PAINTED_MM = 8.0


@dataclass(frozen=True, slots=True, eq=False)
class _View:
    """Orthographic view: rows are the picture's right and up, and the direction towards the eye."""

    axes: Directions

    def flat(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        return points @ self.axes[:2].T

    def depth(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        return points @ self.axes[2]


def _view(azimuth_deg: float, elevation_deg: float) -> _View:
    a, e = np.radians([azimuth_deg, elevation_deg])
    eye = np.array([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)])
    right = np.array([-np.sin(a), np.cos(a), 0.0])
    return _View(np.stack([right, np.cross(eye, right), eye]))


@dataclass(frozen=True, slots=True, eq=False)
class _Solid:
    """Triangles with a colour each."""

    triangles: Triangles
    colours: NDArray[np.float64]


@dataclass(frozen=True, slots=True, eq=False)
class _Lines:
    """Short pieces of lines with a colour, seen or hidden like the surface that they lie on."""

    pieces: NDArray[np.float64]
    """(n, 2, 3)"""
    colour: str
    width: float


def draw_part(part: Part, survey: Survey, suffix: str) -> bytes:
    """Draw a part with a colour for each face, and what no free pose sees; four views.

    Raises:
        JobError: the suffix is neither ``.png`` nor ``.svg``.
    """
    check_suffix(suffix)
    palette = np.array([_rgb(each) for each in FUNCTION_COLOURS]) * 0.5 + 0.5
    colours = np.where(survey.visible[:, None], palette[survey.cell_face % len(palette)], _UNSEEN)
    solids = [_Solid(survey.cells.triangles, colours), _ignored(part), *_fixtures(part)]
    names = [(np.array(_middle(part, number)), face.name, face.normal) for number, face in enumerate(part.faces)]
    legend = "a colour for each face; grey: seen by no free pose of the nozzle"
    with sheet(TOP_MM + 2 * _PANEL_MM + 14) as figure:
        write_title(figure, part.name, legend)
        for axes, (name, angles) in zip(_panels(figure, 2, 2), _VIEWS, strict=True):
            view = _view(*angles)
            _draw(axes, view, solids, [])
            for place, text, normal in names:
                if view.depth(np.array(normal)) > 0.1:
                    x, y = view.flat(place)
                    axes.text(x, y, text, fontsize=6.5, color=INK, ha="center", va="center", zorder=9)
            axes.set_title(name, loc="left", fontsize=8, color=QUIET)
        write_foot(figure, f"part sha256 {part.sha256[:16]}")
        return to_bytes(figure, suffix)


def draw_part_plan(part: Part, program: TimedProgram, coverings: Sequence[Covering], suffix: str) -> bytes:
    """Draw a program over a part: stripes and their order, traces of the lance, clean and not clean; two views of each.

    Args:
        part: What is sprayed.
        program: What is done to it.
        coverings: What is seen and held; without any the traces alone are drawn.
        suffix: ``.png`` or ``.svg``.

    Raises:
        JobError: another suffix.
        ProgramError: the program has no move.
    """
    check_suffix(suffix)
    steel = _painted(part.patches, _STEEL)
    own = [steel, *_fixtures(part)]
    stripes, starts = _stripes(coverings)
    rows = [("traces of the nozzle", own, _traces(program), np.empty((0, 2, 3)))]
    if coverings:
        text = "green: held for the required time; orange: less; grey: seen by no free pose"
        rows.insert(0, ("stripes in their order", own, stripes, starts))
        rows.append((text, [_cleanness(coverings), _ignored(part), *_fixtures(part)], [], np.empty((0, 2, 3))))
    with sheet(TOP_MM + len(rows) * _PANEL_MM + 14) as figure:
        totals = program.totals
        litres = "    ".join(f"{name} {amount:.2f} l" for name, amount in totals.liquid_l)
        write_title(
            figure, f"{part.name}  ·  {program.origin.recipe}",
            f"{clock(totals.duration_s)} in all    {clock(totals.spray_s)} sprayed    {litres}",
        )  # fmt: skip
        panels = _panels(figure, len(rows), 2)
        scene = scene_of(part)
        for row, (text, solids, lines, numbers) in enumerate(rows):
            for column, (name, angles) in enumerate(_VIEWS[:2]):
                axes, view = panels[2 * row + column], _view(*angles)
                _draw(axes, view, solids, [_unhidden(scene, view, each) for each in lines])
                _number(axes, scene, view, numbers)
                axes.set_title(f"{text}; {name}", loc="left", fontsize=8, color=QUIET)
        origin = program.origin
        write_foot(figure, f"part sha256 {origin.board_sha256[:16]}    recipe sha256 {origin.recipe_sha256[:16]}")
        return to_bytes(figure, suffix)


def _stripes(coverings: Sequence[Covering]) -> tuple[list[_Lines], NDArray[np.float64]]:
    """Stripes, the way from one to the next, and (k, 2, 3) where each begins with the surface's outward direction."""
    over: list[NDArray[np.float64]] = [np.empty((0, 2, 3))]
    between: list[NDArray[np.float64]] = [np.empty((0, 2, 3))]
    starts: list[NDArray[np.float64]] = []
    last: NDArray[np.float64] | None = None
    for piece in (piece for covering in coverings for piece in covering.pieces):
        lifted = piece.targets - piece.approach * _LIFT_MM
        over.append(np.stack([lifted[:-1], lifted[1:]], axis=1))
        if last is not None:
            between.append(np.stack([last, lifted[0]])[None])
        last = lifted[-1]
        if len(lifted) > 1:
            starts.append(np.stack([lifted[0], -piece.approach[0]]))
    lines = [_Lines(_cut(np.concatenate(between)), ACCENT, 0.5), _Lines(np.concatenate(over), FUNCTION_COLOURS[0], 1.6)]
    return lines, np.array(starts).reshape(-1, 2, 3)


def _traces(program: TimedProgram) -> list[_Lines]:
    """The way of the orifice with the jet off and on, and the lance at some moments."""
    timeline = build_timeline(program)
    end = float(timeline.times[-1])
    times = np.union1d(np.linspace(0.0, end, max(2, int(end / _MOMENT_S))), timeline.switch_times)
    states = play(timeline, times)
    on = states.spraying[:-1] & states.spraying[1:]
    ways = np.stack([states.tcp[:-1], states.tcp[1:]], axis=1)
    few = np.flatnonzero(states.spraying)[::_LANCES]
    lances = np.stack([states.tcp[few], states.tcp[few] - states.approach[few] * _LANCE_MM], axis=1)
    return [_Lines(ways[~on], QUIET, 0.4), _Lines(lances, ACCENT, 0.5), _Lines(ways[on], FUNCTION_COLOURS[0], 1.1)]


def _cut(pieces: NDArray[np.float64]) -> NDArray[np.float64]:
    """Cut lines into short pieces, each of which is seen or hidden as a whole."""
    shares = np.linspace(0.0, 1.0, _CUTS + 1)[:, None, None]
    along = pieces[:, 0] + (pieces[:, 1] - pieces[:, 0]) * shares
    return np.stack([along[:-1], along[1:]], axis=2).reshape(-1, 2, 3)


def _unhidden(scene: RayScene, view: _View, lines: _Lines) -> _Lines:
    """Keep the pieces between which and the eye nothing stands."""
    if not len(lines.pieces):
        return lines
    middles = lines.pieces.mean(axis=1)
    faces, _ = cast(scene, middles, np.tile(view.axes[2], (len(middles), 1)))
    return replace(lines, pieces=lines.pieces[faces < 0])


def _number(axes: Axes, scene: RayScene, view: _View, starts: NDArray[np.float64]) -> None:
    """Write the number of each stripe where it begins, if that is seen."""
    if not len(starts):
        return
    faces, _ = cast(scene, starts[:, 0], np.tile(view.axes[2], (len(starts), 1)))
    seen = (faces < 0) & (view.depth(starts[:, 1]) > 0)
    for number in np.flatnonzero(seen).tolist():
        x, y = view.flat(starts[number, 0])
        axes.text(x, y, str(number + 1), fontsize=6, color=INK, ha="center", va="center", zorder=9)


def _cleanness(coverings: Sequence[Covering]) -> _Solid:
    """Cells coloured by what is held of them over all templates: the worst requirement decides."""
    first = coverings[0]
    held = np.ones(len(first.seconds), dtype=np.bool_)
    visible = np.ones(len(first.seconds), dtype=np.bool_)
    for each in coverings:
        held &= each.seconds >= each.required_s * (1 - 1e-9)
        visible &= each.visible
    colours = np.where(held[:, None], _CLEAN, np.where(visible[:, None], _SHORT, _UNSEEN))
    return _Solid(first.cells.triangles, colours)


def _ignored(part: Part) -> _Solid:
    rows = [face.patches for face in part.faces if not face.serve]
    patches = part.patches[np.concatenate(rows)] if rows else np.empty((0, 3, 3))
    return _painted(patches, _STEEL)


def _fixtures(part: Part) -> list[_Solid]:
    bodies = [body.patches for body in part.bodies if body.role == "fixture"]
    return [_painted(patches, _FIXTURE) for patches in bodies]


def _painted(patches: Triangles, colour: NDArray[np.float64]) -> _Solid:
    """Give patches in one colour, cut into small ones: large ones cannot be painted one behind the other."""
    pieces, _ = split_patches(patches, _PAINTED_MM)
    return _Solid(pieces, np.tile(colour, (len(pieces), 1)))


def _middle(part: Part, number: int) -> Scalars:
    patches = part.patches[part.faces[number].patches]
    areas, _ = areas_and_normals(patches.copy())
    return np.asarray((patches.mean(axis=1) * areas[:, None]).sum(axis=0) / max(float(areas.sum()), 1e-12))


def _panels(figure: Any, rows: int, columns: int) -> list[Axes]:
    height_mm = figure.get_figheight() * 25.4
    grid = figure.add_gridspec(
        rows, columns, left=LEFT_MM / SHEET_MM[0], right=1 - RIGHT_MM / SHEET_MM[0],
        bottom=12 / height_mm, top=1 - TOP_MM / height_mm, wspace=0.03, hspace=0.08,
    )  # fmt: skip
    return [figure.add_subplot(grid[index // columns, index % columns]) for index in range(rows * columns)]


def _draw(axes: Axes, view: _View, solids: list[_Solid], lines: list[_Lines]) -> None:
    """Paint triangles and pieces of lines from the farthest to the nearest."""
    from matplotlib.collections import LineCollection, PolyCollection

    triangles = np.concatenate([each.triangles for each in solids])
    colours = np.concatenate([each.colours for each in solids])
    _, normals = areas_and_normals(triangles.copy())
    facing = normals @ view.axes[2] > 0
    triangles, colours, normals = triangles[facing], colours[facing], normals[facing]
    shade = 0.72 + 0.28 * np.clip(normals @ (view.axes.T @ _LIGHT), 0.0, 1.0)
    order = np.argsort(view.depth(triangles.mean(axis=1)), kind="stable")
    flat = view.flat(triangles)[order]
    faces = np.clip(colours * shade[:, None], 0, 1)[order]
    axes.add_collection(PolyCollection(list(flat), facecolors=faces, edgecolors=faces, linewidths=0.2, zorder=2))
    for each in lines:
        if len(each.pieces):
            axes.add_collection(
                LineCollection(list(view.flat(each.pieces)), colors=each.colour, linewidths=each.width, zorder=4)
            )
    places = np.concatenate(
        [view.flat(solids[0].triangles).reshape(-1, 2), *(view.flat(each.pieces).reshape(-1, 2) for each in lines)]
    )
    low, high = places.min(axis=0), places.max(axis=0)
    room = 0.03 * float((high - low).max())
    axes.set_xlim(low[0] - room, high[0] + room)
    axes.set_ylim(low[1] - room, high[1] + room)
    axes.set_aspect("equal")
    axes.set_axis_off()


def _rgb(colour: str) -> tuple[float, float, float]:
    return int(colour[1:3], 16) / 255, int(colour[3:5], 16) / 255, int(colour[5:7], 16) / 255
