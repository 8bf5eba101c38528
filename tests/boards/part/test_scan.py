"""Parts out of two silhouettes: pictures drawn from bodies whose volume is known."""

import struct
import zlib
from typing import get_args

import numpy as np
import pytest
from PIL import Image

from boards.errors import BoardError
from boards.formats.tri.tri import write_tri
from boards.part.load import load_part
from boards.part.picture_child import MAX_PIXELS
from boards.part.scan import Symmetry, scan_part
from boards.part.silhouette import read_silhouette

MM = 0.25
SIZE = (260, 300)
BLACK, WHITE = 20, 235


def drawn(inside, size=SIZE, part=BLACK, ground=WHITE, samples=4):
    """Grey picture of what lies inside, by sub-pixels: ``inside(x, z)`` in mm, the picture's middle and foot 0."""
    columns, rows = size
    x = (np.arange(columns * samples) + 0.5) / samples * MM - columns * MM / 2
    z = rows * MM - (np.arange(rows * samples) + 0.5) / samples * MM - 5.0
    share = inside(*np.meshgrid(x, z)).reshape(rows, samples, columns, samples).mean(axis=(1, 3))
    return np.round(ground + share * (part - ground)).astype(np.uint8)


def saved(folder, name, picture):
    path = folder / name
    Image.fromarray(picture).save(path)
    return path


def views(folder, front, side):
    return tuple(
        read_silhouette(saved(folder, f"{name}.png", drawn(each)), MM)
        for name, each in (("front", front), ("side", side))
    )


def rectangle(width, height):
    return lambda x, z: (np.abs(x) < width / 2) & (z > 0) & (z < height)


def disc(radius):
    return lambda x, z: x**2 + (z - radius) ** 2 < radius**2


def half_disc(radius):
    return lambda x, z: (np.hypot(x, z) <= radius) & (z >= 0)


def triangle(width, height):
    return lambda x, z: (z > 0) & (np.abs(x) < width / 2 * (1 - z / height))


SPHERE = (disc(25), disc(25), "revolution", 4 / 3 * np.pi * 25**3)
CYLINDER = (rectangle(30, 50), rectangle(30, 50), "revolution", np.pi * 15**2 * 50)
LYING_CYLINDER = (disc(20), rectangle(33, 40), "extrusion", np.pi * 20**2 * 33)
BOX = (rectangle(40, 55), rectangle(21, 55), "mirror", 40 * 21 * 55)
PRISM = (triangle(50, 45), rectangle(33, 45), "extrusion", 50 * 45 / 2 * 33)
CONE = (triangle(40, 60), triangle(40, 60), "revolution", np.pi * 20**2 * 60 / 3)
BODIES = {
    "sphere": SPHERE, "cylinder": CYLINDER, "lying cylinder": LYING_CYLINDER, "box": BOX, "prism": PRISM, "cone": CONE,
}  # fmt: skip


@pytest.mark.slow
@pytest.mark.parametrize("name", BODIES)
def test_with_its_symmetry_stated_the_volume_is_within_one_percent_and_the_outlines_within_a_pixel(tmp_path, name):
    front, side, symmetry, volume = BODIES[name]
    found = scan_part("thing", *views(tmp_path, front, side), symmetry)
    assert found.volume_mm3 == pytest.approx(volume, rel=0.01)
    assert max(found.off_px) <= 1.0
    assert not [each for each in found.part.findings if each.rule.severity != "info"]
    # An independent check of the outline: the part's triangles drawn as the pictures were.
    (tmp_path / "part.tri").write_text(write_tri(found.part.bodies), "utf-8")
    part = load_part(tmp_path / "part.tri")
    assert part.sha256 == found.part.sha256
    foot = [face for face in part.faces if face.flat and face.normal[2] < -0.99 and face.area_mm2 > 1]
    assert not any(face.serve for face in foot)
    assert {each.rule.id for each in part.findings} <= {"part-face-tiny"}
    again = tuple(read_silhouette(saved(tmp_path, "again.png", shadow(part, axes)), MM) for axes in ((0, 2), (1, 2)))
    for one, other in zip(again, (front, side), strict=True):
        first = read_silhouette(saved(tmp_path, "once.png", drawn(other)), MM)
        assert one.contour.symmetric_difference(first.contour).area < MM * first.contour.length


def shadow(part, axes):
    """The same picture of a mesh: sub-pixels inside the shadow of any triangle."""
    corners = part.patches[:, :, axes]

    def inside(x, z):
        hit = np.zeros(x.shape, dtype=bool)
        (x1, z1), (x2, z2) = (np.moveaxis(corners[:, k] - corners[:, 0], -1, 0) for k in (1, 2))
        for a, b, c in corners[
            x1 * z2 - z1 * x2 > 0
        ]:  # those that face one way: each of the body has one that does not
            low, high = np.minimum(np.minimum(a, b), c), np.maximum(np.maximum(a, b), c)
            rows = np.flatnonzero((z[:, 0] >= low[1]) & (z[:, 0] <= high[1]))
            columns = np.flatnonzero((x[0] >= low[0]) & (x[0] <= high[0]))
            if not (len(rows) and len(columns)):
                continue
            at = np.ix_(rows, columns)
            signs = [
                (q[0] - p[0]) * (z[at] - p[1]) - (q[1] - p[1]) * (x[at] - p[0]) for p, q in ((a, b), (b, c), (c, a))
            ]
            hit[at] |= np.all([s >= -1e-9 for s in signs], axis=0) | np.all([s <= 1e-9 for s in signs], axis=0)
        return hit

    return drawn(inside, samples=2)


def test_without_a_symmetry_it_is_a_hull_and_its_excess_is_told(tmp_path):
    found = scan_part("thing", *views(tmp_path, disc(25), disc(25)))
    assert found.volume_mm3 / SPHERE[3] == pytest.approx(4 / np.pi, rel=0.01)
    (told,) = [each.message for each in found.part.findings if each.rule.id == "scan-hull"]
    assert "1.273" in told


def test_what_is_not_convex_is_said_and_a_hole_goes_through(tmp_path):
    def ring(x, z):
        return disc(25)(x, z) & ~(x**2 + (z - 25) ** 2 < 10**2)

    found = scan_part("thing", *views(tmp_path, ring, rectangle(12, 50)), "extrusion")
    assert found.volume_mm3 == pytest.approx(np.pi * (25**2 - 10**2) * 12, rel=0.01)
    assert {each.rule.id for each in found.part.findings} - {"part-face-tiny"} == {"scan-recess"}


def test_greys_polarity_depth_and_dirt_do_not_matter(tmp_path):
    plain = read_silhouette(saved(tmp_path, "a.png", drawn(disc(25))), MM)
    turned = read_silhouette(saved(tmp_path, "b.png", drawn(disc(25), part=WHITE, ground=BLACK)), MM)
    deep = read_silhouette(saved(tmp_path, "c.png", drawn(disc(25)).astype(np.uint16) * 250), MM)
    plain_text = read_silhouette(saved(tmp_path, "d.pgm", drawn(disc(25))), MM)
    for other in (turned, deep, plain_text):
        assert other.contour.symmetric_difference(plain.contour).area < 2e-3 * plain.contour.area
    dirty = drawn(disc(25))
    dirty[40:44, 30:35], dirty[180:183, 130:134] = BLACK, WHITE
    found = read_silhouette(saved(tmp_path, "e.png", dirty), MM)
    assert found.specks == 2
    assert found.contour.symmetric_difference(plain.contour).area < 1e-3 * plain.contour.area


def test_what_is_opaque_is_the_part(tmp_path):
    grey = drawn(disc(25))
    clear = np.dstack([np.full((*grey.shape, 3), 128, dtype=np.uint8), 255 - grey])
    found = read_silhouette(saved(tmp_path, "a.png", clear), MM)
    assert found.size_mm == pytest.approx((50, 50), abs=MM)


@pytest.mark.parametrize(
    ("front", "side", "symmetry", "words"),
    [
        (disc(25), disc(20), None, "mm high"),
        (rectangle(30, 50), rectangle(20, 50), "revolution", "looks the same from both"),
        (lambda x, z: triangle(40, 50)(x - (z - 50) / 9, z), triangle(40, 50), "mirror", "mirror image"),
        (disc(25), disc(25), "extrusion", "neither view is a rectangle"),
    ],
)  # fmt: skip
def test_views_that_contradict_each_other_or_the_symmetry_are_refused(tmp_path, front, side, symmetry, words):
    both = views(tmp_path, front, side)
    with pytest.raises(BoardError, match=words):
        scan_part("thing", *both, symmetry)


def bomb(columns, rows):
    """The header of a PNG that promises so many pixels."""

    def chunk(kind, data):
        return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))

    head = struct.pack(">IIBBBBB", columns, rows, 8, 0, 0, 0, 0)
    return (
        b"\x89PNG\r\n\x1a\n" + chunk(b"IHDR", head) + chunk(b"IDAT", zlib.compress(b"\0" * 1000)) + chunk(b"IEND", b"")
    )


def test_hostile_pictures_are_refused_in_one_sentence(tmp_path):
    random = np.random.default_rng(1)
    noise = random.integers(0, 255, SIZE, dtype=np.uint8)
    noise[[0, -1]], noise[:, [0, -1]] = 0, 0
    two = np.minimum(drawn(lambda x, z: disc(9)(x - 15, z)), drawn(lambda x, z: disc(9)(x + 15, z)))
    png = saved(tmp_path, "whole.png", drawn(disc(25))).read_bytes()
    hostile = {
        "text.png": (b"no picture at all", "no PNG or PGM"),
        "empty.png": (b"", "no PNG or PGM"),
        "cut.png": (png[: len(png) // 2], "no PNG or PGM"),
        "bomb.png": (bomb(60_000, 60_000), f"at most {MAX_PIXELS:,}"),
        "page.svg": (b"<svg xmlns='http://www.w3.org/2000/svg'/>", "no PNG or PGM"),
        "gif.png": (b"GIF89a" + b"\0" * 50, "no PNG or PGM"),
        "cut.pgm": (b"P5 100 100 255\n" + b"\0" * 50, "no PNG or PGM"),
        "thin.pgm": (b"P5 100 2 255\n" + b"\0" * 200, "too few"),
    }  # fmt: skip
    for name, (content, words) in hostile.items():
        (tmp_path / name).write_bytes(content)
        with pytest.raises(BoardError, match=words):
            read_silhouette(tmp_path / name, MM)
    drawings = {
        "flat": (np.full(SIZE, 128, dtype=np.uint8), "same grey"),
        "edge": (drawn(rectangle(200, 50)), "reaches the edge"),
        "two": (two, "2 separate pieces"),
        "noise": (noise, "separate pieces|no clear outline"),
        "speck": (drawn(disc(0.8)), "shows no part"),
    }
    for name, (picture, words) in drawings.items():
        with pytest.raises(BoardError, match=words):
            read_silhouette(saved(tmp_path, f"{name}.png", picture), MM)
    whole = tmp_path / "whole.png"
    for scale, threshold, words in ((0.0, 0.5, "scale"), (np.nan, 0.5, "scale"), (1.0, 1.0, "threshold")):
        with pytest.raises(BoardError, match=words):
            read_silhouette(whole, scale, threshold)


@pytest.mark.slow
def test_the_same_pictures_give_the_same_bytes(tmp_path):
    both = views(tmp_path, disc(25), disc(25))
    for symmetry in ("revolution", None):
        assert symmetry is None or symmetry in get_args(Symmetry)
        first, second = (write_tri(scan_part("thing", *both, symmetry).part.bodies) for _ in range(2))
        assert first == second


@pytest.mark.slow
@pytest.mark.parametrize(
    ("body", "volume", "faces"),
    [
        pytest.param(disc(25), 4 / 3 * np.pi * 25**3, 2, id="sphere"),
        pytest.param(half_disc(20), 2 / 3 * np.pi * 20**3, 5, id="hemisphere"),
    ],
)
def test_a_picture_in_black_and_white_gives_a_smooth_part(tmp_path, body, volume, faces):
    """The steps of its pixels are no faces; its outline stays within a pixel of them."""
    stepped = np.where(drawn(body) < 128, BLACK, WHITE).astype(np.uint8)
    view = read_silhouette(saved(tmp_path, "front.png", stepped), MM)
    found = scan_part("thing", view, view, "revolution")
    assert found.volume_mm3 == pytest.approx(volume, rel=0.01)
    assert len(found.part.faces) <= faces
    assert max(found.off_px) <= 1.0


def test_corners_of_a_picture_in_black_and_white_stay(tmp_path):
    stepped = np.where(drawn(triangle(50, 45)) < 128, BLACK, WHITE).astype(np.uint8)
    view = read_silhouette(saved(tmp_path, "front.png", stepped), MM)
    assert view.outline.bounds == pytest.approx((-25, 0, 25, 45), abs=MM)  # the picture cuts the tip
    assert len(view.outline.exterior.coords) < 20


@pytest.mark.parametrize("sigma", [0.0, 0.02, 0.05])
@pytest.mark.parametrize(("width", "height"), [(6, 30), (6, 60), (12, 60), (40, 60), (50, 30)])
def test_a_tip_goes_on_where_the_picture_cuts_it(tmp_path, width, height, sigma):
    """A pixel of part and ground is no part where the part is thinner: 11 pixels of the most acute tip."""
    picture = photographed(drawn(triangle(width, height)), sigma, 0.0)
    view = read_silhouette(saved(tmp_path, "front.png", picture), MM)
    assert view.outline.bounds == pytest.approx((-width / 2, 0, width / 2, height), abs=MM)
    assert view.outline.area == pytest.approx(width * height / 2, rel=0.003)
    assert len(view.outline.exterior.coords) == 4


def test_a_blunt_tip_stays_blunt(tmp_path):
    def blunt(x, z):
        return triangle(40, 60)(x, z) & (z < 57)  # 2 mm across: eight pixels

    view = read_silhouette(saved(tmp_path, "front.png", photographed(drawn(blunt), 0.02, 0.0)), MM)
    assert view.outline.bounds[3] == pytest.approx(57, abs=MM)


def lying_l(x, z):
    return (np.abs(x) < 20) & (z > 0) & (z < 40) & ((x < -5) | (z < 15))


FACES = {
    "cube": (rectangle(40, 40), rectangle(40, 40), None, 5, 40**3),
    "box": (*BOX[:3], 5, BOX[3]),
    "L": (lying_l, rectangle(30, 40), "extrusion", 7, 30 * (40 * 15 + 15 * 25)),
    "plate": (rectangle(58, 6), rectangle(40, 6), None, 5, 58 * 6 * 40),
    "cylinder": (*CYLINDER[:3], 2, CYLINDER[3]),
    "sphere": (*SPHERE[:3], 1, SPHERE[3]),
    "cone": (*CONE[:3], 1, CONE[3]),
}
"""Views, symmetry, faces that are sprayed, as of the exact mesh that stands on its foot, volume."""


def photographed(picture, sigma, darker):
    """The picture with noise of the camera, the light weaker by a share to the left and by half of it to the foot."""
    rows, columns = picture.shape
    light = np.linspace(1 - darker, 1, columns)[None] * np.linspace(1, 1 - darker / 2, rows)[:, None]
    noise = np.random.default_rng(rows + columns).normal(0, sigma * (WHITE - BLACK), picture.shape)
    return np.clip(picture * light + noise, 0, 255).astype(np.uint8)


@pytest.mark.slow
@pytest.mark.parametrize(("sigma", "darker"), [(0.0, 0.0), (0.02, 0.0), (0.05, 0.0), (0.02, 0.3)])
@pytest.mark.parametrize("name", FACES)
def test_a_scan_has_the_faces_of_its_body_whatever_the_camera_and_the_light(tmp_path, name, sigma, darker):
    *shapes, symmetry, faces, volume = FACES[name]
    both = (saved(tmp_path, f"{n}.png", photographed(drawn(each), sigma, darker)) for n, each in enumerate(shapes))
    found = scan_part("thing", *(read_silhouette(each, MM) for each in both), symmetry)
    assert sum(each.serve for each in found.part.faces) == faces
    assert found.volume_mm3 == pytest.approx(volume, rel=0.003)
    assert max(found.off_px) < 0.75


@pytest.mark.parametrize("grey", [0.15, 0.25, 0.3, 0.5, 0.7])
def test_a_shadow_beside_a_part_is_left_out_and_stated(tmp_path, grey):
    whole = drawn(rectangle(40, 40)).astype(float)
    cast = drawn(lambda x, z: (x > 15) & (x < 29) & (z > -0.2) & (z < 8)) < 128
    picture = np.where(cast & (whole > 100), BLACK + grey * (WHITE - BLACK), whole)
    path = saved(tmp_path, "front.png", photographed(picture, 0.02, 0.0))
    view = read_silhouette(path, MM)
    assert view.shadow > 0.0
    assert view.threshold < grey
    assert view.size_mm == pytest.approx((40, 40), abs=2 * MM)
    found = scan_part("thing", view, read_silhouette(saved(tmp_path, "side.png", drawn(rectangle(40, 40))), MM))
    assert sum(each.serve for each in found.part.faces) == 5
    assert "scan-shadow" in {each.rule.id for each in found.part.findings}
    if grey < 0.5:  # half way from the part to the ground it is taken as part
        assert read_silhouette(path, MM, 0.5).size_mm[0] > 45
