"""The sample boards: what they promise, and that the committed files are what the script writes."""

import gzip
from collections import Counter
from dataclasses import replace
from functools import cache
from itertools import combinations, pairwise
from pathlib import Path

import numpy as np
import pytest
import shapely
from sample_boards.assemble import Place, Sample, assemble
from sample_boards.radio_stick import RADIO_STICK
from sample_boards.sensor_hub import SENSOR_HUB
from sample_boards.shapes import block, circle, prism, rectangle, rounded, slot, turned
from sample_boards.smt_demo import SMT_DEMO
from sample_boards.tiny import TINY
from sample_boards.two_sided import TWO_SIDED
from sample_boards.write_samples import render_samples
from shapely import Polygon

import boards
from boards.board import Body, Pad, Side
from boards.formats.tri.tri import read_tri
from boards.packages.families import package_family, pins_of

FOLDER = Path(boards.__file__).parent / "library"
FILES = {
    "smt-demo": "smt-demo.tri.gz",
    "sensor-hub": "sensor-hub.tri.gz",
    "radio-stick": "radio-stick.tri.gz",
    "two-sided": "two-sided.tri.gz",
    "tiny": "tiny.tri",
}


@cache
def bodies(name: str) -> tuple[Body, ...]:
    read, findings = read_tri(FOLDER / FILES[name])
    assert findings == ()
    return read


@cache
def rendered() -> dict[str, str]:
    return render_samples()


def components(name: str) -> list[Body]:
    return [body for body in bodies(name) if body.role == "component"]


def edge_counts(body: Body) -> Counter[tuple[bytes, bytes]]:
    """Count every directed edge; in a closed and evenly wound mesh each one has its opposite."""
    corners = np.round(body.patches * 1e4).astype(np.int64)
    keys = [[corner.tobytes() for corner in patch] for patch in corners]
    return Counter(edge for a, b, c in keys for edge in ((a, b), (b, c), (c, a)))


def volume_mm3(body: Body) -> float:
    a, b, c = np.moveaxis(body.patches, 1, 0)
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


@pytest.mark.slow
@pytest.mark.parametrize("file", sorted(FILES.values()))
def test_the_committed_file_is_what_the_script_writes(file: str) -> None:
    content = (FOLDER / file).read_bytes()
    text = gzip.decompress(content) if file.endswith(".gz") else content
    assert text == rendered()[file].encode(), "run: python tools/write_sample_boards.py"


@pytest.mark.slow
def test_no_sample_is_forgotten() -> None:
    assert {path.name for path in FOLDER.glob("*.tri*")} == set(FILES.values()) == set(rendered())


@pytest.mark.parametrize("name", FILES)
def test_every_mesh_is_closed_and_turned_outwards(name: str) -> None:
    for body in bodies(name):
        edges = edge_counts(body)
        assert max(edges.values()) == 1, body.name
        assert all((b, a) in edges for a, b in edges), body.name
        assert volume_mm3(body) > 0, body.name


@pytest.mark.parametrize("name", FILES)
def test_stated_normals_agree_with_the_winding(name: str) -> None:
    for body in bodies(name):
        a, b, c = np.moveaxis(body.patches, 1, 0)
        across = np.cross(b - a, c - a)
        across /= np.linalg.norm(across, axis=1, keepdims=True)
        assert np.einsum("ij,ij->i", across, body.normals).min() > 0.99, body.name


@pytest.mark.parametrize("name", FILES)
def test_parts_agree_with_their_package_names(name: str) -> None:
    """The model of a part and the table of families must tell the same story."""
    planes = {"top": bodies(name)[0].patches[:, :, 2].max(), "bottom": bodies(name)[0].patches[:, :, 2].min()}
    for body in components(name):
        assert body.package is not None
        assert body.side is not None
        assert body.gap_height_mm is not None
        family = package_family(body.package)
        assert family is not None, body.package
        assert pins_of(body.package) in (body.pins, None), body.package
        z = (body.patches[:, :, 2] - planes[body.side]) * (1 if body.side == "top" else -1)
        assert 0 < z.max() <= family.height_mm + 1e-6, body.package
        if family.gap_height_mm is not None:
            assert body.gap_height_mm == pytest.approx(family.gap_height_mm, rel=0.5), body.package


@pytest.mark.parametrize("name", FILES)
def test_the_stated_standoff_is_the_gap_under_the_body(name: str) -> None:
    board = bodies(name)[0].patches[:, :, 2]
    for body in components(name):
        gap = body.patches[:, :, 2] - board.max() if body.side == "top" else board.min() - body.patches[:, :, 2]
        heights = np.unique(np.round(gap[gap > 1e-9], 4))
        assert body.gap_height_mm is not None
        assert np.abs(heights - body.gap_height_mm).min() <= 1.1e-4, body.name


def test_smt_demo_is_a_dense_board() -> None:
    parts = components("smt-demo")
    packages = {str(body.package) for body in parts}
    assert len(parts) >= 80
    size = np.ptp(bodies("smt-demo")[0].patches.reshape(-1, 3), axis=0)
    np.testing.assert_allclose(size, [100.0, 80.0, 1.6], atol=1e-9)
    for word in ("LQFP-48", "LQFP-64", "LQFP-100", "QFN-32", "QFN-48", "BGA-144", "SOIC-8", "SOIC-14", "SOIC-16"):
        assert any(package.startswith(word) for package in packages), word
    assert max(body.patches[:, :, 2].max() for body in parts) == pytest.approx(16.0)
    assert sum(body.role == "fixture" for body in bodies("smt-demo")) == 2
    capacitors = [body for body in parts if str(body.package).startswith("C_0402")]
    left = sorted(body.patches.reshape(-1, 3).min(axis=0)[1] for body in capacitors if 41 < body.patches[0, 0, 0] < 43)
    assert any(0.25 <= low - before - 0.5 <= 1.0 for before, low in pairwise(left))


def test_sensor_hub_has_eighty_parts_and_states_what_most_are_soldered_to() -> None:
    parts = components("sensor-hub")
    assert len(parts) == 80
    through_holes_or_round = {"J2", "J3", "D2"}
    assert {body.name for body in parts if not body.pads} == through_holes_or_round
    pads = {str(body.package): len(body.pads) for body in parts}
    assert pads["QFN-48-1EP_7x7mm_P0.5mm"] == 49
    assert pads["BGA-144_13x13mm_P1.0mm"] == 144
    assert pads["LQFP-64_10x10mm_P0.5mm"] == 64
    assert pads["C_0402_1005Metric"] == 2


def test_radio_stick_has_small_parts_on_both_sides_and_states_all_their_pads() -> None:
    parts = components("radio-stick")
    size = np.ptp(bodies("radio-stick")[0].patches.reshape(-1, 3), axis=0)
    np.testing.assert_allclose(size, [50.0, 23.0, 1.0], atol=1e-9)
    assert Counter(body.side for body in parts) == {"top": 79, "bottom": 59}
    assert all(body.pads for body in parts)
    counts = Counter("_".join(str(body.package).split("_")[1:2]) for body in parts)
    assert counts["0201"] >= 60
    assert counts["0402"] >= 40
    radio = next(body for body in parts if body.name == "U1")
    assert (radio.package, radio.side, len(radio.pads)) == ("LQFP-48_7x7mm_P0.5mm", "top", 48)


def test_parts_of_the_radio_stick_keep_their_distance() -> None:
    inside = shapely.box(0.5, 0.5, 49.5, 22.5)
    parts = components("radio-stick")
    lands = [shapely.union_all([outline_of(pad) for pad in body.pads]) for body in parts]
    shadows = [shapely.union_all(shapely.convex_hull(shapely.linestrings(body.patches[:, :, :2]))) for body in parts]
    for one, other in combinations(range(len(parts)), 2):
        if parts[one].side == parts[other].side:
            names = (parts[one].name, parts[other].name)
            assert shadows[one].distance(shadows[other]) > 0.3, names
            assert lands[one].distance(lands[other]) > 0.2, names
    outside = [body.name for body, shadow in zip(parts, shadows, strict=True) if not inside.contains(shadow)]
    assert outside == ["J1"]  # the port


def test_pads_of_an_0201_reach_beyond_its_ends() -> None:
    place = Place("C1", "C_0201_0603Metric", 10.0, 7.0)
    _, part = assemble(replace(TINY, places=(place,), states_pads=True))
    assert [(pad.x_mm, pad.y_mm, pad.length_mm, pad.width_mm) for pad in part.pads] == [
        pytest.approx((9.68, 7.0, 0.46, 0.4)),
        pytest.approx((10.32, 7.0, 0.46, 0.4)),
    ]


def test_other_samples_leave_the_pads_to_the_package_names() -> None:
    assert not any(body.pads for name in ("smt-demo", "two-sided", "tiny") for body in bodies(name))


@pytest.mark.parametrize("side", ["top", "bottom"])
def test_pads_lie_where_a_turned_part_touches_the_board(side: Side) -> None:
    place = Place("U1", "QFN-16-1EP_3x3mm_P0.5mm", 10.0, 7.0, 30.0, side=side)
    sample = replace(TINY, places=(place,), states_pads=True)
    _, part = assemble(sample)
    z = sample.top if side == "top" else sample.bottom
    flat = part.patches[np.abs(part.patches[:, :, 2] - z).max(axis=1) < 1e-9][:, :, :2]
    touching = shapely.union_all(shapely.polygons(flat), grid_size=1e-6)
    pads = shapely.union_all([outline_of(pad) for pad in part.pads], grid_size=1e-6)
    assert len(part.pads) == 17
    assert pads.symmetric_difference(touching).area < 1e-3 * touching.area


def outline_of(pad: Pad) -> Polygon:
    corners = np.array(rectangle((pad.length_mm, pad.width_mm)))
    cos, sin = np.cos(pad.turn_rad), np.sin(pad.turn_rad)
    return Polygon(corners @ np.array([[cos, sin], [-sin, cos]]) + [pad.x_mm, pad.y_mm])


def test_two_sided_has_parts_on_both_sides_and_its_bottom_at_zero() -> None:
    board, *parts = bodies("two-sided")
    assert board.patches[:, :, 2].min() == 0.0
    assert board.patches[:, :, 2].max() == pytest.approx(1.6)
    sides = Counter(body.side for body in parts)
    assert 35 <= len(parts) <= 50
    assert min(sides["top"], sides["bottom"]) >= 15
    face = [patch for patch in board.patches if np.ptp(patch[:, 2]) == 0 and patch[0, 2] == 0]
    shape = shapely.union_all(shapely.polygons(np.array(face)[:, :, :2]), grid_size=1e-4)
    assert isinstance(shape, Polygon)
    assert sum(Polygon(ring).area > 4 for ring in shape.interiors) == 7  # four screws, two slots, one cut-out
    assert sum(Polygon(ring).area < 4 for ring in shape.interiors) == 10  # one per pin of the header
    assert shape.convex_hull.area - Polygon(shape.exterior).area > 300


def test_tiny_is_small() -> None:
    assert 4 <= len(components("tiny")) <= 6
    assert (FOLDER / FILES["tiny"]).stat().st_size < 60_000
    assert (FOLDER / FILES["smt-demo"]).stat().st_size < 1_500_000


def test_parts_that_touch_are_refused() -> None:
    near = Place("R9", "R_0603_1608Metric", 18.75, 5.0)
    with pytest.raises(ValueError, match="R2 and R9"):
        assemble(replace(TINY, places=(*TINY.places, near)))
    apart = replace(near, x=18.81)
    assert len(assemble(replace(TINY, places=(*TINY.places, apart)))) == len(bodies("tiny")) + 1


def test_a_pin_that_meets_a_part_of_the_other_side_is_refused() -> None:
    under = Place("R9", "R_0603_1608Metric", 25.0, 8.73, side="bottom")
    with pytest.raises(ValueError, match="J1 and R9"):
        assemble(replace(TINY, places=(*TINY.places, under)))


@pytest.mark.parametrize(
    ("place", "message"),
    [
        (Place("R9", "R_0603_1608Metric", 29.5, 15.0), "edge of the board"),
        (Place("R9", "R_0603_1608Metric", 4.0, 4.0), "over a hole"),
        (Place("J9", "PinHeader_1x04_P2.54mm_Vertical", 8.0, 4.0), "over a hole"),
    ],
)
def test_a_part_outside_the_board_is_refused(place: Place, message: str) -> None:
    sample = replace(TINY, places=(place,), holes=(circle(1.5, 16, (4.0, 4.0)),))
    with pytest.raises(ValueError, match=message):
        assemble(sample)


def test_holes_that_meet_are_refused() -> None:
    sample = replace(TINY, places=(), holes=(circle(1.5, 16, (10.0, 10.0)), slot(9.0, 2.0, (14.0, 10.0))))
    with pytest.raises(ValueError, match="two holes"):
        assemble(sample)


def test_solids_have_the_volume_of_their_formulas() -> None:
    def volume(solid: np.ndarray) -> float:
        a, b, c = np.moveaxis(solid, 1, 0)
        return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)

    assert volume(block((2.0, 3.0), 1.0, 5.0, (7.0, -2.0))) == pytest.approx(24.0)
    hole = rectangle((1.0, 1.0))
    assert volume(prism(rectangle((4.0, 4.0)), 0.0, 2.0, [hole])) == pytest.approx(30.0)
    assert volume(turned([(1.0, 0.0), (2.0, 3.0)], 4)) == pytest.approx(2 * 1 * (1 + 2 + 4))  # square frustum
    assert Polygon(slot(10.0, 2.0, (3.0, 4.0), 64)).area == pytest.approx(16.0 + np.pi, rel=1e-2)
    corner = 4 - np.pi  # a fillet of radius 1 takes (4 - pi) / 4 from each of four corners
    assert Polygon(rounded(rectangle((6.0, 4.0)), 1.0, 64)).area == pytest.approx(24.0 - corner, rel=1e-3)


@pytest.mark.parametrize("sample", [SMT_DEMO, SENSOR_HUB, RADIO_STICK, TWO_SIDED, TINY], ids=lambda sample: sample.name)
def test_names_are_unique_and_the_file_name_is_the_samples(sample: Sample) -> None:
    names = [place.name for place in sample.places]
    assert len(set(names)) == len(names)
    assert [body.name for body in components(sample.name)] == names
