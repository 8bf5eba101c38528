"""What every path class has to keep to: a class is enrolled by standing in ``PathSpec``.

Where a case needs a value that cannot be derived from the class, ``REQUIRED`` or ``TELLING`` has it.
"""

from collections.abc import Iterator
from contextlib import suppress
from dataclasses import replace
from functools import cache
from importlib import import_module
from importlib.util import find_spec
from types import UnionType
from typing import Any, Literal, Union, cast, get_args, get_origin, get_type_hints

import numpy as np
import pytest
from pydantic import ValidationError
from pydantic.fields import FieldInfo
from rigid import Motion, moved_template
from shapely import affinity, box
from sites import CONE, site_on
from small_boards import board_of, part

from boards.board import Board, Side
from geometry.arrays import Directions, Points
from recipes.nozzles import FlatFan, Nozzle
from recipes.paths import BOARD_PATH_CLASSES, Near
from recipes.recipe import Limits
from rulesengine.planning.board_job import BoardWays, lay, plan_path
from rulesengine.strokes.safe_height import floors
from rulesengine.strokes.stroke import Site, Stroke, StrokeSet

CLASSES = {spec.model_fields["path"].default: spec for spec in BOARD_PATH_CLASSES}
"""Path class to spec, from the union."""
HEIGHT, SPEED, TILT = 40.0, 35.0, 38.0
"""Tilted by more than the cone's half angle, so that its near wave front can lie on an edge."""
REQUIRED: dict[str, Any] = {"height_mm": HEIGHT, "speed_mm_s": SPEED, "from": (20.0, 15.0), "to": (75.0, 45.0)}
"""What a class cannot do without, by key; other keys take a small number."""
TELLING: dict[str, list[Any]] = {"near": [{"within_mm": 3.0, "speed_mm_s": 7.0}], "only": [["some"]]}
"""Values that show whether a key is read, where its type has none."""
FAN = FlatFan(half_angle_deg=20, flow_lpm=2)
NEAR_MM = 1e-6


def leans_of(path: str) -> list[tuple[str, float]]:
    """Where the jet may lean, and tilts; a class without them sprays straight down."""
    fields = CLASSES[path].model_fields
    words = get_args(fields["toward"].annotation) if "toward" in fields else ("",)
    return [(toward, tilt) for toward in words for tilt in ((0.0, TILT) if "tilt_deg" in fields else (0.0,))]


CASES = [
    pytest.param(path, toward, tilt, id=f"{path}-{toward}-{tilt:g}")
    for path in CLASSES
    for toward, tilt in leans_of(path)
]
EVERY = pytest.mark.parametrize(("path", "toward", "tilt"), CASES)
SIDES = pytest.mark.parametrize("side", ["top", "bottom"])
NOZZLES = pytest.mark.parametrize("nozzle", [CONE, FAN], ids=["cone", "fan"])


def spec_of(path: str, **changes: Any) -> Any:
    """A path of a class with no more than it needs, and with ``changes``."""
    fields = CLASSES[path].model_fields
    needed = {field.alias or name for name, field in fields.items() if field.is_required()}
    return CLASSES[path].model_validate({key: REQUIRED.get(key, 3) for key in needed} | changes)


def leaning(path: str, toward: str, tilt: float) -> Any:
    """A path of a class whose jet leans so, where it can."""
    return spec_of(path, **({"toward": toward, "tilt_deg": tilt} if toward else {}))


@cache
def board_with(side: Side = "top", motion: Motion | None = None) -> Board:
    """A rectangle with a slot; on one side a turned part, two that stand close together and a long one by itself."""
    parts = [part("U1", 30, 20, 12, 8, turn_deg=30, side=side), part("J1", 80, 5, 6, 50, 4, side=side)]
    parts += [part("C1", 60, 40, 2, 1, side=side), part("C2", 63.3, 40, 2, 1, side=side)]
    outline = box(0, 0, 100, 60, ccw=True).difference(box(45, 50, 60, 54))
    if motion is not None:
        place = [*motion.matrix[:2, :2].ravel(), *motion.shift[:2]]
        moved = [affinity.affine_transform(each.outline, place) for each in parts]
        parts = [replace(each, outline=one, footprint=one) for each, one in zip(parts, moved, strict=True)]
        outline = affinity.affine_transform(outline, place)
    return board_of(*parts, outline=outline)


def planned(spec: Any, side: Side = "top", nozzle: Nozzle = CONE, motion: Motion | None = None) -> StrokeSet:
    site = site_on(board_with(side, motion), nozzle, side=side)
    classes = {name: "some" if name in ("U1", "C1") else "any" for name in site.classes}
    return plan_path(spec, replace(site, classes=classes))


def in_board_frame(
    strokes: StrokeSet, side: Side, motion: Motion | None = None
) -> list[tuple[Points, Directions, Directions]]:
    """Orifice, jet and tool +X of each stroke."""
    board = board_with(side, motion)
    ways = BoardWays(board, Limits(), side, floors(board, side, 5))
    laid = [lay(each, "corridor") for each in strokes.strokes]
    return [ways.place(each.tcp, each.approach, each.reference) for each in laid]


@SIDES
@EVERY
@NOZZLES
def test_it_keeps_height_speed_and_tilt_and_has_unit_axes_at_right_angles(
    path: str, toward: str, tilt: float, side: Side, nozzle: Nozzle
) -> None:
    strokes = planned(leaning(path, toward, tilt), side, nozzle)
    assert strokes.strokes
    board, up = board_with(side), 1.0 if side == "top" else -1.0
    for stroke, (tcp, approach, reference) in zip(strokes.strokes, in_board_frame(strokes, side), strict=True):
        assert stroke.speed_mm_s == SPEED
        np.testing.assert_allclose((tcp[:, 2] - board.surface_z_mm(side)) * up, HEIGHT)
        np.testing.assert_allclose(approach[:, 2] * up, -np.cos(np.radians(tilt)))
        for axis in (approach, reference):
            np.testing.assert_allclose(np.linalg.norm(axis, axis=1), 1.0)
        np.testing.assert_allclose(np.sum(approach * reference, axis=1), 0.0, atol=1e-12)
        assert len(tcp) == len(stroke.delays)


@EVERY
@NOZZLES
def test_the_bottom_side_is_the_mirror_image_of_the_top(path: str, toward: str, tilt: float, nozzle: Nozzle) -> None:
    spec = leaning(path, toward, tilt)
    top, bottom = planned(spec, "top", nozzle), planned(spec, "bottom", nozzle)
    board, mirror = board_with(), np.array([1.0, 1.0, -1.0])
    middle = np.array([0.0, 0.0, board.top_z_mm + board.bottom_z_mm])
    assert [(each.made_by, each.laps) for each in bottom.strokes] == [(each.made_by, each.laps) for each in top.strokes]
    for above, below in zip(in_board_frame(top, "top"), in_board_frame(bottom, "bottom"), strict=True):
        np.testing.assert_allclose(below[0], above[0] * mirror + middle, atol=NEAR_MM)
        np.testing.assert_allclose(below[1], above[1] * mirror, atol=1e-9)
        np.testing.assert_allclose(below[2], above[2] * mirror, atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("turn_deg", [90.0, 137.0])
@SIDES
@EVERY
def test_it_moves_with_the_board(path: str, toward: str, tilt: float, side: Side, turn_deg: float) -> None:
    motion = Motion(turn_deg, (-30.0, 210.0, 0.0))
    spec = leaning(path, toward, tilt)
    here, there = planned(spec, side), planned(moved_template(spec, motion), side, motion=motion)
    pairs = zip(in_board_frame(here, side), in_board_frame(there, side, motion), strict=True)
    for (tcp, approach, reference), moved in pairs:
        np.testing.assert_allclose(moved[0], motion.points(tcp), atol=0.02)
        np.testing.assert_allclose(moved[1], approach @ motion.matrix.T, atol=1e-4)
        np.testing.assert_allclose(moved[2], reference @ motion.matrix.T, atol=1e-4)


@EVERY
def test_a_tilted_jet_leans_toward_what_it_is_asked_to(path: str, toward: str, tilt: float) -> None:
    if tilt == 0.0 or toward not in ("travel", "against_travel", "left", "right"):
        return
    for stroke in planned(leaning(path, toward, tilt)).strokes:
        ways, leans = straight_runs(stroke)
        left = np.column_stack([-ways[:, 1], ways[:, 0]])
        expected = {"travel": ways, "against_travel": -ways, "left": left, "right": -left}[toward]
        np.testing.assert_allclose(leans, expected, atol=1e-6)


def straight_runs(stroke: Stroke) -> tuple[Points, Points]:
    """Directions of travel, and of the jet in plan, of the segments along which the jet does not turn."""
    steps, turns = np.diff(stroke.tcp[:, :2], axis=0), np.ptp([stroke.approach[1:], stroke.approach[:-1]], axis=0)
    along = (np.linalg.norm(steps, axis=1) > 1e-3) & (turns.max(axis=1) < 1e-9)
    leans = stroke.approach[1:, :2][along]
    return (
        steps[along] / np.linalg.norm(steps[along], axis=1, keepdims=True),
        leans / np.linalg.norm(leans, axis=1, keepdims=True),
    )


KEYS = [
    pytest.param(path, key, id=f"{path}-{key}")
    for path, spec in CLASSES.items()
    for key in spec.model_fields
    if key != "path"
]


@pytest.mark.parametrize(("path", "key"), KEYS)
def test_it_uses_every_key(path: str, key: str) -> None:
    field = CLASSES[path].model_fields[key]
    before = fingerprint(planned(told(path)))
    others: list[Any] = []
    for value in alternatives(key, field, getattr(told(path), key)):
        with suppress(ValidationError):  # out of the key's range
            others.append(told(path, **{field.alias or key: value}))
    assert others, f"{path}.{key}: add a value to TELLING in {__file__}"
    assert any(fingerprint(planned(other)) != before for other in others), f"no planner reads {path}.{key}"


@pytest.mark.parametrize("key", [key for key in Near.model_fields if key != "within_mm"])
def test_it_uses_every_key_of_near(key: str) -> None:
    near = {"within_mm": 3.0} if key != "within_mm" else {}
    before = fingerprint(planned(told("component_perimeter", near=near)))
    assert fingerprint(planned(told("component_perimeter", near=near | {key: 3}))) != before


@pytest.mark.parametrize("path", CLASSES)
def test_it_refuses_the_keys_of_other_classes(path: str) -> None:
    known = {field.alias or name for name, field in CLASSES[path].model_fields.items()}
    foreign = {name for spec in CLASSES.values() for name in spec.model_fields} - known - {"from_mm", "to_mm"}
    assert foreign
    for key in foreign:
        with pytest.raises(ValidationError, match="extra_forbidden"):
            spec_of(path, **{key: 1})


def told(path: str, **changes: Any) -> Any:
    """A tilted path, so that the direction of its lean shows."""
    tilt = {"tilt_deg": TILT} if "tilt_deg" in CLASSES[path].model_fields else {}
    return spec_of(path, **(tilt | changes))


def fingerprint(strokes: StrokeSet) -> list[object]:
    """All that a plan takes over of strokes."""
    shape: list[object] = [strokes.freedom, strokes.retract, strokes.findings, sorted(strokes.edge_pauses.items())]
    for each in strokes.strokes:
        shape += [array.round(9).tobytes() for array in (each.tcp, each.approach, each.azimuth, each.delays)]
        shape += [each.speed_mm_s, each.made_by, each.laps, each.sense, each.entries, each.lead_in_mm, each.pauses]
    return shape


def alternatives(key: str, field: FieldInfo, now: Any) -> Iterator[Any]:
    """Give other values of a key, derived from its type."""
    yield from TELLING.get(key, [])
    for kind in members(field.annotation):
        if get_origin(kind) is Literal:
            yield from (value for value in get_args(kind) if value != now)
        elif kind in (int, float):
            start = now if isinstance(now, int | float) else 0
            yield from (kind(value) for value in (start + 1, start + 65, start / 3, (start + 9) / 10) if value != now)
        elif get_origin(kind) is tuple:
            yield tuple(value + 1 for value in cast("tuple[float, ...]", now))


def members(annotation: Any) -> list[Any]:
    """Take a union apart, without what pydantic knows of it."""
    if get_origin(annotation) in (Union, UnionType):
        return [kind for member in get_args(annotation) for kind in members(member)]
    return members(get_args(annotation)[0]) if hasattr(annotation, "__metadata__") else [annotation]


@pytest.mark.parametrize("path", CLASSES)
def test_it_has_a_planner_of_its_name(path: str) -> None:
    place = f"rulesengine/paths/{path}.py: def plan_{path}(spec: {CLASSES[path].__name__}, site: Site) -> StrokeSet"
    assert find_spec(f"rulesengine.paths.{path}") is not None, f"missing: {place}"
    planner = getattr(import_module(f"rulesengine.paths.{path}"), f"plan_{path}", None)
    assert planner is not None, f"missing: {place}"
    assert get_type_hints(planner) == {"spec": CLASSES[path], "site": Site, "return": StrokeSet}, f"expected: {place}"
