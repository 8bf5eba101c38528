"""Plans over the faces of parts, held to what somebody else would measure."""

from dataclasses import replace
from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from scipy.spatial import KDTree
from scipy.spatial.transform import Rotation
from small_parts import block, cylinder, moved, part_of, prism, surface_recipe

from boards.part.load import load_part
from boards.part.understand import understand_part
from geometry.rays import split_patches
from programs import native
from programs.plan import Dwell, SprayPass, Transfer
from programs.playback import build_timeline, play
from recipes.errors import RecipeError
from recipes.load import load_recipe
from rulesengine.planning.pipeline import Run, run

HALF_RAD, STANDOFF_MM = np.radians(15), 60.0
RADIUS_MM, LENGTH_MM, CLEARANCE_MM = 8.0, 100.0, 2.0
BOXES = np.array([
    [[0, 0, 0], [30, 30, 110]], [[30, 0, 40], [55, 30, 60]], [[30, 0, 90], [70, 30, 110]],
    [[-150, -150, -80], [250, 200, -60]], [[-5, -20, -60], [35, 0, 20]], [[-5, 30, -60], [35, 50, 20]],
], dtype=np.float64)  # fmt: skip
"""A part like an F is three boxes; its table and jaws are one each."""
LIBRARY_BOXES = np.array([
    [[0, 0, 0], [45, 50, 200]], [[45, 0, 80], [100, 50, 120]], [[45, 0, 155], [140, 50, 200]],
    [[-150, -150, -80], [250, 200, -60]], [[-7.5, -30, -60], [52.5, 0, 40]], [[-7.5, 50, -60], [52.5, 80, 40]],
], dtype=np.float64)  # fmt: skip
"""The same of the library's F-shaped part."""
F_RING = [(0, 0), (30, 0), (30, 40), (55, 40), (55, 60), (30, 60), (30, 90), (70, 90), (70, 110), (0, 110)]
L_RING = [(0, 0), (60, 0), (60, 25), (25, 25), (25, 110), (0, 110)]


@cache
def f_run() -> Run:
    upright = np.array([[1, 0, 0], [0, 0, -1], [0, 1, 0]])
    fixtures = dict(zip(("table", "front_jaw", "back_jaw"), (block(*each) for each in BOXES[3:]), strict=True))
    part = part_of(moved(prism(F_RING, -30, 0), upright, (0, 0, 0)), **fixtures)
    stands = next(each.name for each in part.faces if part.patches[each.patches][..., 2].max() < 1)
    return run(surface_recipe(), part_of(part.patches, stands, **fixtures))


@cache
def plate_run(keys: str = "required_s: 1") -> Run:
    plate = part_of(block((0, 0, 0), (100, 60, 10)), "face-2", "face-3", "face-4", "face-5", "face-6")
    return run(surface_recipe(keys), plate)


@cache
def l_part():
    return part_of(prism(L_RING, 0, 30), table=block((-100, -100, -10), (200, 200, 0)))


@cache
def l_run() -> Run:
    return run(surface_recipe(), l_part())


def box_distance(points: np.ndarray, boxes: np.ndarray = BOXES) -> np.ndarray:
    """Distance of points from the nearest of the boxes; 0 inside."""
    outside = np.maximum(np.maximum(boxes[:, 0] - points[:, None], points[:, None] - boxes[:, 1]), 0)
    return np.linalg.norm(outside, axis=2).min(axis=1)


def moments(run: Run, step_s: float):
    timeline = build_timeline(run.program)
    times = np.arange(0.0, float(timeline.times[-1]), step_s) + step_s / 2
    return play(timeline, times)


def is_hidden(points: np.ndarray, eyes: np.ndarray) -> np.ndarray:
    """Whether a box stands between points of the surface and eyes, by slabs."""
    ways = eyes - points
    ways = np.where(np.abs(ways) < 1e-12, 1e-12, ways)
    hidden = np.zeros(len(points), dtype=bool)
    for low, high in BOXES:
        one, two = (low - points) / ways, (high - points) / ways
        enter, leave = np.minimum(one, two).max(axis=1), np.maximum(one, two).min(axis=1)
        hidden |= (np.minimum(leave, 1.0) - np.maximum(enter, 0.0)) > 1e-6
    return hidden


def surface_points(run: Run, step: float) -> tuple[np.ndarray, np.ndarray]:
    """Points some mm apart on the sprayed faces of the F, on a grid of their own, with their normals."""
    points, normals = [], []
    for box in BOXES[:3]:
        for axis in range(3):
            others = [each for each in range(3) if each != axis]
            grids = [np.arange(box[0, each] + 0.37 * step, box[1, each], step) for each in others]
            a, b = (each.ravel() for each in np.meshgrid(*grids))
            for side, sign in ((0, -1.0), (1, 1.0)):
                place = np.empty((len(a), 3))
                place[:, axis], place[:, others[0]], place[:, others[1]] = box[side, axis], a, b
                normal = np.zeros(3)
                normal[axis] = sign
                bare = box_distance(place + normal * 1e-3) > 0
                points.append(place[bare])
                normals.append(np.tile(normal, (int(bare.sum()), 1)))
    points, normals = np.concatenate(points), np.concatenate(normals)
    stands = (normals[:, 2] < -0.5) & (points[:, 2] < 1)
    return points[~stands], normals[~stands]


@pytest.mark.slow
def test_nearly_all_that_can_be_seen_is_held_by_an_independent_count_of_rays() -> None:
    run = f_run()
    points, normals = surface_points(run, 3.0)
    step_s = 0.1
    states = moments(run, step_s)
    tcp, approach = states.tcp[states.spraying], states.approach[states.spraying]
    seconds = np.zeros(len(points))
    for eye, axis in zip(tcp, approach, strict=True):
        ways = points - eye
        lengths = np.linalg.norm(ways, axis=1)
        inside = (ways @ axis >= lengths * np.cos(HALF_RAD)) & (-np.einsum("ij,ij->i", ways, normals) > 0.5 * lengths)
        rows = np.flatnonzero(inside)
        lifted = points[rows] + normals[rows] * 1e-3
        seconds[rows[~is_hidden(lifted, np.tile(eye, (len(rows), 1)))]] += step_s
    covering = run.coverings[0]
    nearest = KDTree(covering.cells.points + covering.cells.normals).query(points + normals)[1]
    visible = covering.visible[nearest]
    assert visible.mean() > 0.99  # what the jaws lie on is no point of the grid
    assert (seconds[visible] >= 1.0 - 1e-6).mean() >= 0.99


@pytest.mark.slow
def test_the_lance_is_clear_of_everything_in_an_independent_sweep() -> None:
    states = moments(f_run(), 0.02)
    moved = np.linalg.norm(np.diff(states.tcp, axis=0), axis=1)
    far = states.tcp - states.approach * LENGTH_MM
    assert max(moved.max(), np.linalg.norm(np.diff(far, axis=0), axis=1).max()) < 12
    nearest = min(
        float(box_distance(states.tcp - states.approach * along).min()) for along in np.linspace(0, LENGTH_MM, 66)
    )
    assert nearest >= RADIUS_MM
    spraying = states.spraying
    assert box_distance(states.tcp[spraying]).min() >= RADIUS_MM + CLEARANCE_MM - 0.2


@pytest.mark.slow
def test_on_the_part_of_1993_the_jet_is_upright_wherever_there_is_room() -> None:
    recipe = load_recipe("part-degrease")
    stripes = {name: each.model_copy(update={"repair": False}) for name, each in recipe.templates.items()}
    done = run(recipe.model_copy(update={"templates": stripes}), load_part("f-bracket"))
    covering = done.coverings[0]
    spine = np.linspace(0, LENGTH_MM, 131)[:, None, None]
    normals = {face.name: np.array(face.normal) for face in done.workpiece.faces}
    needless, tilted = 0, 0
    for piece in covering.pieces:
        if len(piece.targets) < 2:
            continue
        normal = normals[piece.face]
        lean = np.degrees(np.arccos(np.clip(-piece.approach @ normal, -1, 1)))
        np.testing.assert_allclose(lean, piece.tilts_deg, atol=1e-6)
        assert lean.max() <= 60 + 1e-9
        upright = piece.targets + normal * STANDOFF_MM + spine * normal
        room = box_distance(upright.reshape(-1, 3), LIBRARY_BOXES).reshape(131, -1).min(axis=0)
        room = room >= RADIUS_MM + CLEARANCE_MM
        tilted += int((lean > 1e-6).sum())
        needless += int(((lean > 1e-6) & room).sum())
    assert tilted > 20
    assert needless <= 0.01 * sum(len(piece.targets) for piece in covering.pieces)


@pytest.mark.slow
def test_the_repair_is_reported_round_by_round_and_what_is_hidden_by_face_and_body() -> None:
    run = f_run()
    covering = run.coverings[0]
    assert 1 <= len(covering.rounds) <= 5
    shares = [covering.uniform_share, *(each.share for each in covering.rounds)]
    assert shares == sorted(shares)
    assert shares[0] < 0.9
    assert shares[-1] >= 0.99
    assert [finding.message for finding in run.findings if finding.rule.id == "surface-unseen"] == [
        f"600 of 4600 mm2 of {face} are seen by no free pose within the range of 114 mm; hidden by {jaw}."
        for face, jaw in (("face-1", "front_jaw"), ("face-2", "back_jaw"))
    ]
    assert sum(finding.rule.id == "surface-repair" for finding in run.findings) == len(covering.rounds)


@pytest.mark.slow
def test_chosen_stripes_come_near_the_bound_and_the_timed_program_sprays_as_long_as_planned() -> None:
    run = f_run()
    covering = run.coverings[0]
    assert covering.least().seconds <= covering.spray_s < 1.4 * covering.least().seconds
    assert covering.spray_s == pytest.approx(sum(piece.spray_s for piece in covering.pieces))
    assert max(float(piece.tilts_deg.max()) for piece in covering.pieces) <= 60
    step_s = 0.02
    assert moments(run, step_s).spraying.sum() * step_s <= 1.03 * covering.spray_s


@pytest.mark.slow
def test_the_bound_is_the_same_for_another_triangulation_and_place() -> None:
    """Within 1 % of the part's; the cells and poses that it is worked out on are others."""
    ring, table = [(0, 0), (60, 0), (60, 45), (0, 45)], block((-100, -100, -10), (200, 200, 0))
    coarse = prism(ring, 0, 30)
    fine, _ = split_patches(coarse, 11.0, 1e-3)
    shift = np.array([3.3, 1.7, 0.0])
    keys = "required_s: 1, repair: false"
    bounds = [
        run(surface_recipe(keys), part_of(part, table=stand)).coverings[0].least().seconds
        for part, stand in ((coarse, table), (fine, table), (coarse + shift, table + shift))
    ]
    assert bounds == pytest.approx([bounds[0]] * 3, rel=0.01)


@pytest.mark.slow
def test_a_jet_with_a_short_range_holds_no_more_than_is_near() -> None:
    """A wall that a longer jet sees across a channel is left to poses that come near to it."""
    keys = "required_s: 1, repair: false, striping: fewest, tilt_max_deg: 10"
    plate = part_of(block((0, 0, 0), (100, 60, 10)), "face-2", "face-3", "face-4", "face-5", "face-6")
    recipe = surface_recipe(keys)
    jet = recipe.nozzles["jet"]
    short, long = (
        recipe.model_copy(update={"nozzles": {"jet": jet.model_copy(update={"range_mm": reach})}})
        for reach in (60.6, 120.0)
    )
    near, far = (run(each, plate).coverings[0].seconds for each in (short, long))
    assert (near <= far + 1e-9).all()
    assert near.sum() < 0.5 * far.sum()
    with pytest.raises(RecipeError, match="beyond the 50 mm that the jet reaches"):
        run(recipe.model_copy(update={"nozzles": {"jet": jet.model_copy(update={"range_mm": 50.0})}}), plate)


@pytest.mark.slow
def test_chosen_stripes_spray_for_less_time_than_those_of_a_stated_width() -> None:
    chosen, stated = plate_run().coverings[0], plate_run("width_mm: 25").coverings[0]
    assert "chosen among" in chosen.rounds[0].what
    assert "chosen among" not in stated.rounds[0].what
    rows = sorted({round(float(piece.targets[0, 1]), 3) for piece in stated.pieces if len(piece.targets) > 1})
    assert rows == [10.0, 30.0, 50.0]
    assert min(chosen.share, stated.share) >= 0.999
    assert chosen.spray_s <= stated.spray_s


@pytest.mark.slow
def test_a_plate_seen_from_above_alone_is_bounded_from_below() -> None:
    covering = plate_run().coverings[0]
    # No cone holds more than its own footprint at a time.
    footprint = np.pi * (STANDOFF_MM * np.tan(HALF_RAD)) ** 2
    assert covering.least().seconds >= 0.9 * 100 * 60 / footprint
    assert covering.least().seconds <= covering.spray_s


@pytest.mark.slow
def test_items_meet_and_the_program_is_the_same_each_time() -> None:
    again = plate_run.__wrapped__()
    assert native.render(again.program) == native.render(plate_run().program)
    run = l_run()
    moving = list(run.plan.moving())
    for one, two in pairwise(moving):
        np.testing.assert_allclose(one.tcp[-1], two.tcp[0], atol=1e-6)
        np.testing.assert_allclose(one.approach[-1], two.approach[0], atol=1e-9)
        np.testing.assert_allclose(one.reference[-1], two.reference[0], atol=1e-6)
    for item in moving:
        np.testing.assert_allclose(np.einsum("ij,ij->i", item.approach, item.reference), 0, atol=1e-9)


@pytest.mark.slow
def test_a_part_moved_and_turned_gives_the_program_moved_and_turned() -> None:
    part = l_part()
    turn = Rotation.from_euler("xyz", [20, -35, 70], degrees=True).as_matrix()
    shift = np.array([300.0, -120.0, 55.5])
    bodies = [
        replace(each, patches=each.patches @ turn.T + shift, normals=each.normals @ turn.T) for each in part.bodies
    ]
    here, there = l_run(), run(surface_recipe(), understand_part(bodies, part.name, None))
    assert len(here.plan.items) == len(there.plan.items)
    for one, two in zip(here.plan.items, there.plan.items, strict=True):
        assert type(one) is type(two)
        if isinstance(one, SprayPass | Transfer):
            assert isinstance(two, SprayPass | Transfer)
            np.testing.assert_allclose(two.tcp, one.tcp @ turn.T + shift, atol=0.02)
            np.testing.assert_allclose(two.approach, one.approach @ turn.T, atol=1e-4)
        elif isinstance(one, Dwell):
            assert isinstance(two, Dwell)
            assert two.duration_s == pytest.approx(one.duration_s, abs=0.01)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("striping", "order"),
    [("longest_edge", "one_stage"), ("fewest", "two_stage"), ("along", "one_stage"), ("contour", "two_stage")],
)
def test_every_striping_covers_a_plate_from_above(striping: str, order: str) -> None:
    covering = plate_run(f"required_s: 0.8, striping: {striping}, along: [1, 2, 0], order: {order}").coverings[0]
    assert covering.share >= 0.99
    assert all((piece.tilts_deg == 0).all() for piece in covering.pieces)


@pytest.mark.slow
def test_stripes_run_along_the_longest_edge_and_are_no_wider_than_the_cone_covers() -> None:
    pieces = plate_run("repair: false").coverings[0].pieces
    ways = [piece.targets[-1] - piece.targets[0] for piece in pieces]
    assert all(abs(way[0]) > 90 and abs(way[1]) < 1e-4 for way in ways)
    rows = np.sort([piece.targets[0, 1] for piece in pieces])
    diameter = 2 * STANDOFF_MM * np.tan(HALF_RAD)
    assert np.diff(rows).max() <= diameter / np.sqrt(2) + 1e-9
    assert len(rows) == int(np.ceil(60 / (diameter / np.sqrt(2))))
    chord = np.sqrt(diameter**2 - 20**2)
    np.testing.assert_allclose(pieces[0].length_mm / pieces[0].seconds.sum(), chord, rtol=1e-6)


@pytest.mark.slow
def test_a_cylinder_is_gone_around_in_rings_that_close() -> None:
    done = run(surface_recipe("repair: false"), part_of(cylinder(30, 60), "face-1", "face-2"))
    pieces = done.coverings[0].pieces
    assert len(pieces) == 3
    for piece in pieces:
        np.testing.assert_allclose(piece.targets[0], piece.targets[-1])
        angles = np.unwrap(np.arctan2(piece.targets[:, 1], piece.targets[:, 0]))
        assert abs(angles[-1] - angles[0]) == pytest.approx(2 * np.pi)
        assert np.ptp(piece.targets[:, 2]) < 1e-6
        np.testing.assert_allclose(np.hypot(piece.tcp[:, 0], piece.tcp[:, 1]), 90, atol=0.2)


@pytest.mark.slow
def test_in_a_corner_the_jet_leans_away_from_the_wall() -> None:
    assert l_run().coverings[0].share >= 0.99
    covering = run(surface_recipe("repair: false"), l_part()).coverings[0]
    floor = [piece for piece in covering.pieces if abs(piece.targets[0, 1] - 25) < 1e-6 and len(piece.targets) > 2]
    near = np.concatenate([piece.tilts_deg[piece.targets[:, 0] < 33] for piece in floor])
    # but for the table, near which the jet leans too
    far = np.concatenate([piece.tilts_deg[(piece.targets[:, 0] > 45) & (piece.targets[:, 2] > 12)] for piece in floor])
    assert near.min() > 0
    assert far.max() == 0


@pytest.mark.slow
def test_the_floor_of_a_narrow_pit_is_named_as_hidden_by_the_part_itself() -> None:
    ring = [(0, 0), (80, 0), (80, 140), (46, 140), (46, 15), (34, 15), (34, 140), (0, 140)]
    part = part_of(prism(ring, 0, 100))
    findings = run(surface_recipe("repair: false"), part).findings
    messages = [each.message for each in findings if each.rule.id == "surface-unseen"]
    assert messages
    assert all(message.endswith("hidden by part.") for message in messages)


def test_paths_of_boards_do_not_fit_parts_nor_a_lance_where_nothing_is_free() -> None:
    with pytest.raises(
        RecipeError,
        match=r"sequence\[0\]\.paths: edge .path: board_perimeter. is a path over boards, and thing is a part",
    ):
        run(load_recipe("rinse-only"), l_part())
    walls = {f"w{n}": block(*each) for n, each in enumerate(
        [((-20, -20, -20), (0, 60, 60)), ((40, -20, -20), (60, 60, 60)), ((0, -20, -20), (40, 0, 60)),
         ((0, 40, -20), (40, 60, 60)), ((0, 0, -20), (40, 40, 0)), ((0, 0, 40), (40, 40, 60))])}  # fmt: skip
    boxed = part_of(block((1, 1, 1), (39, 39, 39)), **walls)
    with pytest.raises(RecipeError, match="no face of thing can be sprayed"):
        run(surface_recipe(), boxed)
