"""Pictures of parts: faces, stripes in their order, traces of the lance, and what is clean; and of scans of parts."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from boards.board import Face, Part, scene_of
from geometry.arrays import Directions, Scalars, Triangles
from geometry.mesh import areas_and_normals
from geometry.rays import RayScene, cast, split_patches
from programs.playback import build_timeline, play
from programs.program import TimedProgram
from reports.pictures.sheet import (
    ACCENT,
    FAINT,
    FUNCTION_COLOURS,
    INK,
    QUIET,
    TOP_MM,
    curve_of,
    open_sheet,
    totals_line,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes

    from boards.part.scan import Scan
    from boards.part.silhouette import Silhouette
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
_SCAN_MM, _SCAN_BOTTOM_MM = 160.0, 20.0


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
    from matplotlib.colors import to_rgb

    palette = np.array([to_rgb(each) for each in FUNCTION_COLOURS]) * 0.5 + 0.5
    colours = np.where(survey.visible[:, None], palette[survey.cell_face % len(palette)], _UNSEEN)
    solids = [_Solid(survey.cells.triangles, colours), _ignored(part), *_fixtures(part)]
    names: list[tuple[Scalars, Face]] = []
    for face in part.faces:
        patches = part.patches[face.patches]
        areas, _ = areas_and_normals(patches.copy())
        weighted = (patches.mean(axis=1) * areas[:, None]).sum(axis=0)
        names.append((np.asarray(weighted / max(float(areas.sum()), 1e-12)), face))
    title = (part.name, "a colour for each face; grey: seen by no free pose of the nozzle")
    foot = f"part sha256 {part.sha256[:16]}"
    with open_sheet(suffix, TOP_MM + 2 * _PANEL_MM + 14, title=title, foot=foot) as sheet:
        for axes, (name, angles) in zip(sheet.panels(4, 2, 12, (0.03, 0.08)), _VIEWS, strict=True):
            view = _view(*angles)
            _draw(axes, view, solids, [])
            for place, face in names:
                if view.depth(np.array(face.normal)) > 0.1:
                    _write(axes, view, place, face.name, 6.5)
            axes.set_title(name, loc="left", fontsize=8, color=QUIET)
        return sheet.content()


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
    own = [_painted(part.patches, _STEEL), *_fixtures(part)]
    stripes, starts = _stripes(coverings)
    rows = [("traces of the nozzle", own, _traces(program), np.empty((0, 2, 3)))]
    if coverings:
        text = "green: held for the required time; orange: less; grey: seen by no free pose"
        rows.insert(0, ("stripes in their order", own, stripes, starts))
        rows.append((text, [_cleanness(coverings), _ignored(part), *_fixtures(part)], [], np.empty((0, 2, 3))))
    origin, scene = program.origin, scene_of(part)
    title = (f"{part.name}  ·  {origin.recipe}", totals_line(program.totals))
    foot = f"part sha256 {origin.board_sha256[:16]}    recipe sha256 {origin.recipe_sha256[:16]}"
    with open_sheet(suffix, TOP_MM + len(rows) * _PANEL_MM + 14, title=title, foot=foot) as sheet:
        panels = sheet.panels(2 * len(rows), 2, 12, (0.03, 0.08))
        for row, (text, solids, lines, numbers) in enumerate(rows):
            for column, (name, angles) in enumerate(_VIEWS[:2]):
                axes, view = panels[2 * row + column], _view(*angles)
                shown = [
                    replace(each, pieces=each.pieces[_seen(scene, view, each.pieces.mean(axis=1))]) for each in lines
                ]
                _draw(axes, view, solids, shown)
                # The number of each stripe stands where it begins, if that is seen.
                for number in np.flatnonzero(
                    _seen(scene, view, numbers[:, 0]) & (view.depth(numbers[:, 1]) > 0)
                ).tolist():
                    _write(axes, view, numbers[number, 0], str(number + 1), 6)
                axes.set_title(f"{text}; {name}", loc="left", fontsize=8, color=QUIET)
        return sheet.content()


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
    # The ways between are cut into short pieces, each of which is seen or hidden as a whole.
    ways, shares = np.concatenate(between), np.linspace(0.0, 1.0, _CUTS + 1)[:, None, None]
    along = ways[:, 0] + (ways[:, 1] - ways[:, 0]) * shares
    cut = np.stack([along[:-1], along[1:]], axis=2).reshape(-1, 2, 3)
    lines = [_Lines(cut, ACCENT, 0.5), _Lines(np.concatenate(over), FUNCTION_COLOURS[0], 1.6)]
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


def _seen(scene: RayScene, view: _View, points: NDArray[np.float64]) -> NDArray[np.bool_]:
    """(n,) whether nothing stands between a point and the eye."""
    if not len(points):
        return np.zeros(0, dtype=np.bool_)
    faces, _ = cast(scene, np.ascontiguousarray(points), np.tile(view.axes[2], (len(points), 1)))
    return faces < 0


def _write(axes: Axes, view: _View, place: NDArray[np.float64], text: str, size: float) -> None:
    x, y = view.flat(place)
    axes.text(x, y, text, fontsize=size, color=INK, ha="center", va="center", zorder=9)


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
            pieces = list(view.flat(each.pieces))
            axes.add_collection(LineCollection(pieces, colors=each.colour, linewidths=each.width, zorder=4))
    drawn = [solids[0].triangles, *(each.pieces for each in lines)]
    places = np.concatenate([view.flat(each).reshape(-1, 2) for each in drawn])
    low, high = places.min(axis=0), places.max(axis=0)
    room = 0.03 * float((high - low).max())
    axes.set_xlim(low[0] - room, high[0] + room)
    axes.set_ylim(low[1] - room, high[1] + room)
    axes.set_aspect("equal")
    axes.set_axis_off()


def draw_scan(scan: Scan, views: tuple[Silhouette, Silhouette], suffix: str) -> bytes:
    """Draw both views; the same scan gives the same bytes.

    Args:
        scan: What was made of the views.
        views: From the front and from the side.
        suffix: ``.png`` or ``.svg``.
    """
    from matplotlib.patches import PathPatch

    size = " x ".join(f"{each:.2f}" for each in np.ptp(scan.part.patches.reshape(-1, 3), axis=0).tolist())
    symmetry = scan.symmetry or "no symmetry: the hull of both views"
    title = (scan.part.name, f"{size} mm    {scan.volume_mm3 / 1000:.3f} cm3    {symmetry}")
    foot = "grey: silhouettes as seen; red: outline of the part"
    with open_sheet(suffix, TOP_MM + _SCAN_MM + _SCAN_BOTTOM_MM, title=title, foot=foot) as sheet:
        panels = sheet.panels(2, 2, _SCAN_BOTTOM_MM, (0.12, 0.1))
        rows = zip(panels, views, scan.shadows, scan.off_px, ("front", "side"), strict=True)
        for axes, view, shadow, off_px, word in rows:
            axes.add_patch(PathPatch(curve_of(view.contour), facecolor=FAINT, edgecolor="none"))
            for ring in (shadow.exterior, *shadow.interiors):
                axes.plot(*np.asarray(ring.coords).T[:2], color=ACCENT, linewidth=0.9)
            axes.set_aspect("equal")
            axes.set_xlabel("mm", color=QUIET)
            axes.autoscale_view()
            axes.set_title(f"{word}: {view.name}, within {off_px:.2f} pixels", fontsize=9, loc="left", color=INK)
        return sheet.content()
