"""A placement: a sheet of box plots, points and map, and a scene in binary glTF or USDZ (metres, y up)."""

from __future__ import annotations

from importlib import import_module
from importlib.util import find_spec
from io import BytesIO
from typing import TYPE_CHECKING, Any, NamedTuple, TypeAlias
from zipfile import ZipFile

import numpy as np
from numpy.typing import NDArray

from reports.cards.placement import CRITERIA, METRICS, value_text, worst_words
from reports.pictures import sheet
from reports.tables.wording import amount
from robotcell.robot.meshes import placed_triangles
from robotcell.robot.robot import link_poses
from specs.errors import JobError
from specs.temporary import read_temporary, temporary_folder

if TYPE_CHECKING:
    from collections.abc import Sequence

    from matplotlib.axes import Axes

    from boards.board import Workpiece
    from geometry.arrays import Points, Scalars, Triangles
    from robotcell.placement.configurations import PlacementDetails
    from robotcell.placement.placement_map import PlacementMap
    from robotcell.robot.robot import Body, Poses

_HEIGHT_MM = 170.0
_BOTTOM_MM = 24.0
COLOURS = "viridis"
"""Colours of values: dark is worse, light is better."""
_BAR = 0.32
_SCALE = {"fraction": 0.046, "pad": 0.09, "location": "bottom"}
"""Of the colours, below the ticks of the axes."""
_M_PER_MM = 1e-3
_Y_UP = np.array([[1.0, 0, 0, 0], [0, 0, 1, 0], [0, -1, 0, 0], [0, 0, 0, 1]])
_GREY, _ROBOT, _TOOL, _PART = (176, 182, 186), (120, 132, 140), (60, 70, 78), (205, 214, 200)
_ACCENT = (200, 68, 44)
_GAMMA = 2.2
"""Of sRGB, nearly: colours of USD are linear."""
_POINT_M, _WORST_M = 3e-3, 8e-3
_MOST_TRIANGLES = 50_000
"""Of the workpiece, and of the robot: beyond that bodies are drawn as boxes around them."""
_DATE, _END, _ENTRY = b"\0\0\x21\0", b"PK\5\6", 46
"""Of zip files: 1 January 1980, what the end of the directory begins with, and the length of an entry without names."""
_BOX_FACES = np.array([[0, 2, 1], [1, 2, 3], [4, 5, 6], [5, 7, 6], [0, 1, 4], [1, 5, 4], [2, 6, 3], [3, 6, 7],
                       [0, 4, 2], [2, 4, 6], [1, 3, 5], [3, 7, 5]])  # fmt: skip
_OCTAHEDRON = np.array([[1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1], [0, 0, -1]], dtype=np.float64)
_FACES = np.array([[0, 2, 4], [2, 1, 4], [1, 3, 4], [3, 0, 4], [2, 0, 5], [1, 2, 5], [3, 1, 5], [0, 3, 5]])


def draw_placement(details: PlacementDetails, mapped: PlacementMap | None, suffix: str) -> bytes:
    """Draw the box plots, the points from above in the colours of their values, and the map if there is one.

    Raises:
        JobError: the suffix is neither ``.png`` nor ``.svg``.
    """
    score, goal, count = details.score, details.goal, len(details.targets.tool)
    stated = f"{CRITERIA[goal.criterion]} of {METRICS[goal.metric]} is {value_text(score.value, goal.metric)}"
    failing = f"infeasible, {amount(len(details.failing), 'point')} of {count} not good enough"
    title = f"{details.cell.robot.name}: {stated if score.value >= 0.0 else failing}"
    foot = f"{details.cell.name}; {count} points, bodies checked. Boxes: 5, 25, 50, 75, 95 % of the points"
    with sheet.open_sheet(suffix, _HEIGHT_MM, title=(title, f"worst: {worst_words(details)}"), foot=foot) as page:
        widths = [1.15, 1.0, 1.0] if mapped is not None else [1.15, 1.0]
        left, right = (sheet.LEFT_MM + 30) / sheet.SHEET_MM[0], 1 - 10 / sheet.SHEET_MM[0]
        box = (left, _BOTTOM_MM / _HEIGHT_MM, right, 1 - sheet.TOP_MM / _HEIGHT_MM)
        boxes, points, *maps = page.grid(len(widths), len(widths), box, (0.3, 0.3), widths)
        _draw_boxes(boxes, details)
        _draw_points(points, details)
        if mapped is not None:
            _draw_map(maps[0], details, mapped)
        return page.content()


def placement_picture(details: PlacementDetails, mapped: PlacementMap | None) -> sheet.Picture:
    """Give the sheet as a picture of a page."""
    alt = f"Box plots of the configurations, points of the workpiece{'' if mapped is None else ', map of placements'}"
    return sheet.Picture(".svg", draw_placement(details, mapped, ".svg"), alt)


def _draw_boxes(axes: Axes, details: PlacementDetails) -> None:
    rows = details.configurations
    for row, each in enumerate(rows):
        used = each.branch in details.score.branches
        colour = sheet.INK if used else sheet.QUIET
        low, first, middle, third, high = each.box.tolist()
        if not np.isfinite(middle):
            continue
        axes.plot((low, first), (row, row), color=colour, linewidth=1.0)
        axes.plot((third, high), (row, row), color=colour, linewidth=1.0)
        for end in (low, high):
            axes.plot((end, end), (row - 0.15, row + 0.15), color=colour, linewidth=1.0)
        axes.barh(row, third - first, 2 * _BAR, first, color="#d5e4ef" if used else "#eef1ec", edgecolor=colour)
        axes.plot((middle, middle), (row - _BAR, row + _BAR), color=colour, linewidth=2.0)
        least = float(each.values[np.isfinite(each.values)].min())
        axes.plot(least, row, marker="o", markersize=3.5, color=sheet.ACCENT if used else sheet.QUIET, linestyle="none")
    names = [f"{each.name}\n{each.reached:.0%} reached" for each in rows]
    axes.set_yticks(range(len(rows)), names)
    axes.invert_yaxis()
    if details.goal.floor > 0.0:
        axes.axvline(details.goal.floor, color=sheet.ACCENT, linewidth=0.8, linestyle="--")
    axes.set_xlim(left=0.0)
    axes.set_title(f"{METRICS[details.goal.metric]} of each configuration", loc="left", fontsize=9)
    axes.set_xlabel("dot: the least; dashed: the floor" if details.goal.floor > 0.0 else "dot: the least")


def _draw_points(axes: Axes, details: PlacementDetails) -> None:
    at, values = 1e3 * details.targets.T_board_tcp[:, :3, 3], details.values
    there = np.isfinite(values)
    drawn = axes.scatter(at[there, 0], at[there, 1], c=values[there], cmap=COLOURS, s=14, linewidths=0)
    axes.plot(at[~there, 0], at[~there, 1], marker="x", color=sheet.ACCENT, markersize=4, linestyle="none")
    worst = details.worst
    axes.plot(
        at[worst, 0], at[worst, 1], marker="o", markersize=11, markerfacecolor="none", markeredgecolor=sheet.ACCENT
    )
    place = (float(at[worst, 0]), float(at[worst, 1]))
    axes.annotate(f"point {worst}", place, (7, 7), textcoords="offset points", color=sheet.ACCENT, fontsize=8)
    if there.any():
        sheet.add_scale(axes, drawn, **_SCALE)
    axes.set_aspect("equal", adjustable="datalim")
    axes.set_title("points of the workpiece from above, mm", loc="left", fontsize=9)


def _draw_map(axes: Axes, details: PlacementDetails, mapped: PlacementMap) -> None:
    x, y = 1e3 * mapped.x, 1e3 * mapped.y
    half = 0.5 * np.array([x[1] - x[0], y[1] - y[0]])
    extent = (x[0] - half[0], x[-1] + half[0], y[0] - half[1], y[-1] + half[1])
    sheet.draw_image(axes, mapped.highest.T, extent, COLOURS, _SCALE, origin="lower")
    i, j, _ = mapped.best
    if mapped.score.value >= 0.0:
        at = (x[i], y[j]) if mapped.refined_at is None else (1e3 * mapped.refined_at[0], 1e3 * mapped.refined_at[1])
        axes.plot(*at, marker="+", markersize=12, color=sheet.ACCENT, markeredgewidth=2)
    base = 1e3 * details.cell.T_cell_base[:2, 3]
    if extent[0] <= base[0] <= extent[1] and extent[2] <= base[1] <= extent[3]:
        axes.plot(*base, marker="s", markersize=7, color=sheet.INK)
    axes.set_facecolor(sheet.FAINT)
    axes.set_title("map: best over the yaws; +: best node, refined; square: base", loc="left", fontsize=9)


Colour: TypeAlias = tuple[int, int, int]
Colours: TypeAlias = NDArray[np.uint8]
"""(n, 4) red, green, blue, opacity."""


class Drawn(NamedTuple):
    """A mesh of the scene."""

    name: str
    triangles: Triangles
    """(n, 3, 3) in the cell's frame, m."""
    colour: Colour | Colours
    """Of all, or of each triangle."""


def placement_glb(details: PlacementDetails, workpiece: Workpiece | None, mapped: PlacementMap | None) -> bytes:
    """Write the scene, the robot at the worst point; the same placement gives the same bytes."""
    from trimesh import Scene
    from trimesh.exchange.gltf import export_glb

    scene = Scene(base_frame="cell")
    for each in scene_meshes(details, workpiece, mapped):
        scene.add_geometry(_mesh(each), node_name=each.name, geom_name=each.name)
    scene.apply_transform(_Y_UP)
    return export_glb(scene)


def require_usd() -> None:
    """Refuse USDZ where it cannot be written.

    Raises:
        JobError: ``usd-core`` is missing.
    """
    if find_spec("pxr") is None:
        raise JobError("a scene as USDZ needs `pip install washboard[ar]`.")


def placement_usdz(details: PlacementDetails, workpiece: Workpiece | None, mapped: PlacementMap | None) -> bytes:
    """Write the scene as USDZ, for augmented reality; the same placement gives the same bytes.

    Raises:
        JobError: ``usd-core`` is missing.
    """
    require_usd()
    usd, geom, utils = (_usd(name) for name in ("Usd", "UsdGeom", "UsdUtils"))
    stage = usd.Stage.CreateInMemory()
    geom.SetStageUpAxis(stage, geom.Tokens.y)
    geom.SetStageMetersPerUnit(stage, 1.0)
    root = geom.Xform.Define(stage, "/placement")
    stage.SetDefaultPrim(root.GetPrim())
    for number, each in enumerate(scene_meshes(details, workpiece, mapped)):
        _define_mesh(stage, f"/placement/mesh_{number}", each)
    with temporary_folder() as folder:
        layer, package = str(folder / "placement.usdc"), str(folder / "placement.usdz")
        stage.GetRootLayer().Export(layer)
        if not utils.CreateNewUsdzPackage(layer, package):
            raise JobError("usd-core did not write the package.")
        return _undated(read_temporary(folder, "placement.usdz"))


def _undated(package: bytes) -> bytes:
    """Give a package the first date of zip files in place of the clock's, in both headers of each file."""
    content = bytearray(package)
    with ZipFile(BytesIO(package)) as archive:
        end = package.rindex(_END)
        at = int.from_bytes(package[end + 16 : end + 20], "little")
        for each in archive.infolist():
            content[each.header_offset + 10 : each.header_offset + 14] = _DATE
            content[at + 12 : at + 16] = _DATE
            at += _ENTRY + sum(int.from_bytes(content[at + field : at + field + 2], "little") for field in (28, 30, 32))
    return bytes(content)


def _usd(name: str) -> Any:
    """Import a module of OpenUSD, which has no types."""
    return import_module(f"pxr.{name}")


def _define_mesh(stage: Any, path: str, drawn: Drawn) -> None:
    """Define a mesh of a stage, with its name, its colours as materials see them, and both sides visible."""
    gf, sdf, geom, shade, vt = (_usd(name) for name in ("Gf", "Sdf", "UsdGeom", "UsdShade", "Vt"))
    corners = drawn.triangles.reshape(-1, 3) @ _Y_UP[:3, :3].T
    points, index = np.unique(np.round(corners, 6), axis=0, return_inverse=True)
    mesh = geom.Mesh.Define(stage, path)
    mesh.GetPrim().SetDisplayName(drawn.name)
    mesh.CreatePointsAttr(vt.Vec3fArray.FromNumpy(points.astype(np.float32)))
    mesh.CreateFaceVertexCountsAttr(vt.IntArray.FromNumpy(np.full(len(drawn.triangles), 3, dtype=np.int32)))
    mesh.CreateFaceVertexIndicesAttr(vt.IntArray.FromNumpy(index.reshape(-1).astype(np.int32)))
    mesh.CreateExtentAttr([gf.Vec3f(*each.tolist()) for each in (points.min(axis=0), points.max(axis=0))])
    mesh.CreateSubdivisionSchemeAttr(geom.Tokens.none)
    mesh.CreateDoubleSidedAttr(True)
    of_triangle = not isinstance(drawn.colour, tuple)
    colours = np.array(drawn.colour, dtype=np.float32).reshape(len(drawn.triangles) if of_triangle else 1, -1)[:, :3]
    linear = (colours / 255.0) ** _GAMMA
    shown = mesh.CreateDisplayColorPrimvar(geom.Tokens.uniform if of_triangle else geom.Tokens.constant)
    shown.Set(vt.Vec3fArray.FromNumpy(linear.astype(np.float32)))
    material = shade.Material.Define(stage, f"{path}_material")
    shader = shade.Shader.Define(stage, f"{path}_material/surface")
    shader.CreateIdAttr("UsdPreviewSurface")
    colour = shader.CreateInput("diffuseColor", sdf.ValueTypeNames.Color3f)
    shader.CreateInput("roughness", sdf.ValueTypeNames.Float).Set(0.9)
    if of_triangle:
        reader = shade.Shader.Define(stage, f"{path}_material/colours")
        reader.CreateIdAttr("UsdPrimvarReader_float3")
        reader.CreateInput("varname", sdf.ValueTypeNames.String).Set("displayColor")
        colour.ConnectToSource(reader.CreateOutput("result", sdf.ValueTypeNames.Float3))
    else:
        colour.Set(gf.Vec3f(*linear[0].tolist()))
    material.CreateSurfaceOutput().ConnectToSource(shader.CreateOutput("surface", sdf.ValueTypeNames.Token))
    shade.MaterialBindingAPI.Apply(mesh.GetPrim()).Bind(material)


def _mesh(drawn: Drawn) -> Any:
    """A mesh of trimesh: of one colour corners are shared, of several each triangle has its own."""
    from trimesh import Trimesh
    from trimesh.visual import ColorVisuals, TextureVisuals
    from trimesh.visual.material import PBRMaterial

    corners = drawn.triangles.reshape(-1, 3)
    if isinstance(drawn.colour, tuple):
        material = PBRMaterial(metallicFactor=0.0, roughnessFactor=0.9, doubleSided=True)
        material.baseColorFactor = np.array([*drawn.colour, 255], dtype=np.uint8)
        kept, index = np.unique(np.round(corners, 6), axis=0, return_inverse=True)
        return Trimesh(kept, index.reshape(-1, 3), visual=TextureVisuals(material=material), process=False)
    index = np.arange(len(corners)).reshape(-1, 3)
    return Trimesh(corners, index, visual=ColorVisuals(vertex_colors=np.repeat(drawn.colour, 3, axis=0)), process=False)


def scene_meshes(details: PlacementDetails, workpiece: Workpiece | None, mapped: PlacementMap | None) -> list[Drawn]:
    """Give what is drawn: cell, robot, workpiece, points in the colours of their values, map."""
    cell, worst = details.cell, details.worst
    meshes = [Drawn(f"fixture {n} {body.name}", placed_triangles(body), _GREY) for n, body in enumerate(cell.fixtures)]
    joints = details.joints[worst]
    q = joints if np.isfinite(joints).all() else cell.home
    links = cell.T_cell_base @ link_poses(cell.robot, q[None])[0]
    tool = cell.tools[int(details.targets.tool[worst])]
    carried = [(body, links[-1] @ cell.robot.T_link_flange) for body in tool.bodies]
    arm = [(body, links[number]) for number, bodies in enumerate(cell.robot.bodies) for body in bodies]
    meshes += _placed("robot", arm, _ROBOT) + _placed("tool", carried, _TOOL)
    if workpiece is not None:
        shapes = _coarse([body.patches * _M_PER_MM for body in workpiece.bodies])
        meshes += [Drawn("workpiece", _moved(np.concatenate(shapes), cell.T_cell_board), _PART)]
    values = details.values
    at = details.targets.T_board_tcp[:, :3, 3] @ cell.T_cell_board[:3, :3].T + cell.T_cell_board[:3, 3]
    there = np.isfinite(values)
    meshes.append(Drawn("points", _marks(at[there], _POINT_M), np.repeat(tints(values[there]), 8, axis=0)))
    meshes.append(Drawn("points not reached", _marks(at[~there], _POINT_M), _ACCENT))
    meshes.append(Drawn("worst point", _marks(at[worst : worst + 1], _WORST_M), _ACCENT))
    if mapped is not None:
        meshes.append(Drawn("map", *_map_squares(details, mapped)))
    return [each for each in meshes if len(each.triangles)]


def tints(values: Scalars) -> NDArray[np.uint8]:
    """(n, 4) colours of values, from the least to the greatest."""
    from matplotlib import colormaps

    low, high = (float(values.min()), float(values.max())) if len(values) else (0.0, 1.0)
    share = (values - low) / max(high - low, 1e-12)
    return np.asarray(np.round(255 * np.asarray(colormaps[COLOURS](share))), dtype=np.uint8).reshape(-1, 4)


def _placed(name: str, bodies: Sequence[tuple[Body, Poses]], colour: Colour) -> list[Drawn]:
    """One mesh of bodies."""
    shapes = _coarse([placed_triangles(body) for body, _ in bodies])
    moved = [_moved(each, pose) for each, (_, pose) in zip(shapes, bodies, strict=True)]
    return [Drawn(name, np.concatenate(moved), colour)] if moved else []


def _coarse(shapes: Sequence[Triangles]) -> list[Triangles]:
    """Bodies as they are; boxes around them where they are too fine."""
    if sum(map(len, shapes)) <= _MOST_TRIANGLES:
        return list(shapes)
    lows, highs = ([end(each, axis=(0, 1)) for each in shapes] for end in (np.min, np.max))
    signs = np.array([[k & 1, k >> 1 & 1, k >> 2] for k in range(8)])
    return [(low + signs * (high - low))[_BOX_FACES] for low, high in zip(lows, highs, strict=True)]


def _moved(triangles: Triangles, pose: Poses) -> Triangles:
    return triangles @ pose[:3, :3].T + pose[:3, 3]


def _marks(at: Points, size: float) -> Triangles:
    """(8 n, 3, 3) octahedra at points."""
    return (at[:, None, None, :] + size * _OCTAHEDRON[_FACES]).reshape(-1, 3, 3)


def _map_squares(details: PlacementDetails, mapped: PlacementMap) -> tuple[Triangles, NDArray[np.uint8]]:
    """Two triangles for each node that is feasible, at the height of the cell's origin, a hair above a table there."""
    half = 0.5 * np.array([mapped.x[1] - mapped.x[0], mapped.y[1] - mapped.y[0]])
    i, j = np.nonzero(np.isfinite(mapped.highest))
    height = float(details.cell.T_cell_base[2, 3]) + 2e-3
    middle = np.column_stack([mapped.x[i], mapped.y[j], np.full(len(i), height)])
    signs = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    corners = np.repeat(middle[:, None], 4, axis=1)
    corners[:, :, :2] += signs * half
    triangles = corners[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3, 3)
    return triangles, np.repeat(tints(mapped.highest[i, j]), 2, axis=0)
