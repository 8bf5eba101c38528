"""Parts from clouds of points: surfaces beside what the points were drawn from, and clouds that are none."""

from pathlib import Path

import numpy as np
import pytest

from boards.errors import BoardError
from boards.part.load import load_part
from geometry.mesh import areas_and_normals
from geometry.solids.point_surface import surface_of_points
from geometry.solids.soundness import find_edges

NOISE_MM = 0.1
SHEET = (400.0, 500.0)
RADIUS_MM = 100.0


def noisy(points, seed=5):
    return points + np.random.default_rng(seed).normal(0, NOISE_MM, points.shape)


def ball(count, seed=1):
    ways = np.random.default_rng(seed).normal(size=(count, 3))
    return RADIUS_MM * ways / np.linalg.norm(ways, axis=1, keepdims=True)


def sheet(count, seed=2):
    x, y = np.random.default_rng(seed).uniform((0, 0), SHEET, (count, 2)).T
    return np.column_stack([x, y, 10 * np.sin(2 * np.pi * x / 400) * np.cos(2 * np.pi * y / 500)])


def sheet_normals(points):
    u, v = 2 * np.pi * points[:, 0] / 400, 2 * np.pi * points[:, 1] / 500
    found = np.column_stack(
        [-np.pi / 20 * np.cos(u) * np.cos(v), np.pi / 25 * np.sin(u) * np.sin(v), np.ones(len(points))]
    )
    return found / np.linalg.norm(found, axis=1, keepdims=True)


def box(count, seed=3):
    rng, size = np.random.default_rng(seed), np.array([100.0, 80.0, 60.0])
    points = rng.uniform(0, size, (count, 3))
    areas = np.repeat([size[1] * size[2], size[0] * size[2], size[0] * size[1]], 2)
    side = rng.choice(6, count, p=areas / areas.sum())
    points[np.arange(count), side // 2] = (side % 2) * size[side // 2]
    return points


def angles(one, two):
    return np.degrees(np.arccos(np.clip((one * two).sum(axis=1), -1, 1)))


def volume(patches):
    return float(np.einsum("ni,ni->", patches[:, 0], np.cross(patches[:, 1], patches[:, 2])) / 6)


def written(folder: Path, points, name="cloud.xyz", head="") -> Path:
    file = folder / name
    file.write_text(head + "".join(f"{x:.4f} {y:.4f} {z:.4f}\n" for x, y, z in points))
    return file


@pytest.mark.slow
def test_a_scan_of_a_sheet_has_its_normals_its_area_and_one_rim():
    found = surface_of_points(noisy(sheet(460_000)))
    assert np.median(angles(found.normals, sheet_normals(found.points))) < 0.5
    assert np.median(angles(areas_and_normals(found.patches.copy())[1], sheet_normals(found.patches.mean(axis=1)))) < 1
    x, y = np.meshgrid(np.linspace(0, SHEET[0], 801), np.linspace(0, SHEET[1], 801))
    flat = np.column_stack([x.ravel(), y.ravel(), 0 * x.ravel()])
    area = SHEET[0] * SHEET[1] * float((1 / sheet_normals(flat)[:, 2]).mean())
    assert areas_and_normals(found.patches.copy())[0].sum() == pytest.approx(area, rel=0.01)
    assert len(found.openings) == 1
    assert found.noise == pytest.approx(NOISE_MM, rel=0.1)
    assert found.left_out == 0


@pytest.mark.slow
def test_a_scanned_ball_is_closed_and_looks_out():
    found = surface_of_points(noisy(ball(80_000)))
    edges = find_edges(found.patches)
    assert (edges.open, edges.crowded, int(edges.against.sum())) == (0, 0, 0)
    assert found.openings == ()
    assert volume(found.patches) == pytest.approx(4 / 3 * np.pi * RADIUS_MM**3, rel=0.005)
    assert np.median(angles(found.normals, found.points / RADIUS_MM)) < 2


@pytest.mark.parametrize("turned", [(0, 1, 2), (1, 2, 0), (2, 0, 1)])
def test_a_tube_ends_at_two_rims_and_is_the_same_however_its_points_are_ordered(turned):
    rng = np.random.default_rng(4)
    angle, along = rng.uniform(0, 2 * np.pi, 8_000), rng.uniform(0, 200, 8_000)
    points = np.column_stack([60 * np.cos(angle), 60 * np.sin(angle), along])
    found = surface_of_points(points[:, turned])
    assert len([rim for rim in found.openings if rim > 100]) == 2
    axis = turned.index(2)
    outwards = np.where(np.arange(3) == axis, 0, found.points)
    assert np.median(angles(found.normals, outwards / np.linalg.norm(outwards, axis=1, keepdims=True))) < 2
    again = surface_of_points(rng.permutation(points)[:, turned])
    np.testing.assert_array_equal(found.patches, again.patches)


@pytest.mark.slow
def test_a_box_has_its_six_faces_although_its_edges_are_rounded(tmp_path):
    part = load_part(str(written(tmp_path, noisy(box(30_000)))))
    large = [face for face in part.faces if face.area_mm2 > 0.8 * 60 * 80]
    normals = {tuple(np.rint(face.normal).astype(int).tolist()) for face in large}
    assert normals == {(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)}
    assert sum(face.area_mm2 for face in large) > 0.97 * sum(face.area_mm2 for face in part.faces)
    assert volume(part.patches) == pytest.approx(100 * 80 * 60, rel=0.01)


@pytest.mark.slow
def test_holes_are_noticed_and_points_beside_the_surface_left_out(tmp_path):
    points = noisy(sheet(30_000))
    points = points[np.hypot(points[:, 0] - 200, points[:, 1] - 250) > 40]
    stray = np.random.default_rng(6).uniform((0, 0, 60), (400, 500, 300), (200, 3))
    part = load_part(str(written(tmp_path, np.concatenate([points, stray]))))
    found = {finding.rule.id: finding.message for finding in part.findings}
    assert "200 of" in found["cloud-points-left-out"]
    assert "2 rims" in found["cloud-open"]
    assert (part.patches[:, :, 2] < 20).all()
    middle = part.patches.mean(axis=1)
    assert (np.hypot(middle[:, 0] - 200, middle[:, 1] - 250) > 30).all()


def test_a_wall_thinner_than_its_cells_is_noticed(tmp_path):
    flat = np.random.default_rng(7).uniform((0, 0, 0), (200, 200, 0), (20_000, 3))
    flat[::2, 2] = 3.0
    part = load_part(str(written(tmp_path, flat)))
    assert "cloud-rough" in [finding.rule.id for finding in part.findings]


@pytest.mark.slow
def test_a_part_file_states_unit_and_cells_and_ply_and_commas_are_read(tmp_path):
    points = ball(20_000)
    (tmp_path / "ball.txt").write_text(
        "20000\n# x, y, z, intensity\n" + "".join(f"{x / 25.4}, {y / 25.4}; {z / 25.4}, 7\n" for x, y, z in points)
    )
    (tmp_path / "ball.yaml").write_text("part: ball\nbody: {file: ball.txt, mm_per_unit: 25.4, cell_mm: 12}\n")
    part = load_part(str(tmp_path / "ball.yaml"))
    assert volume(part.patches) == pytest.approx(4 / 3 * np.pi * RADIUS_MM**3, rel=0.01)
    assert "cells of 12 mm" in part.findings[-1].message
    head = "ply\nformat ascii 1.0\nelement vertex 20000\n" + "".join(f"property float {axis}\n" for axis in "xyz")
    other = load_part(str(written(tmp_path, points, "ball.ply", head + "end_header\n")))
    assert volume(other.patches) == pytest.approx(4 / 3 * np.pi * RADIUS_MM**3, rel=0.01)


GOOD = "".join(f"{x:.3f} {y:.3f} {z:.3f}\n" for x, y, z in ball(200))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "0 different points"),
        ("# # 1 2 3\n// 4 5 6\n \t# 7\n\n", "0 different points"),
        ("0 0 0\n" * 500, "1 different points"),
        ("".join(f"{n} 0 0\n" for n in range(500)), "no surface"),
        (GOOD + "1 2\n", ":201: "),
        (GOOD + "one two three\n", ":201: "),
        (GOOD + "1 2 1e9\n", "beyond 10 m"),
        (GOOD + "\0\0\0", ":201: "),
    ],
)
def test_clouds_that_are_none_are_refused(tmp_path, text, words):
    file = tmp_path / "cloud.xyz"
    file.write_text(text)
    with pytest.raises(BoardError, match=words):
        load_part(str(file))


def test_cells_that_are_finer_than_the_points_are_refused():
    with pytest.raises(ValueError, match="too few points that hang together"):
        surface_of_points(ball(2_000), 0.01)


def test_points_that_are_no_numbers_are_left_out_and_counted_with_their_line(tmp_path):
    points = noisy(sheet(20_000))
    points[[7, 90], 2] = np.nan
    found = load_part(written(tmp_path, points, head="# x y z\n"))
    (text,) = [each.message for each in found.findings if each.rule.id == "cloud-points-left-out"]
    assert text == "2 of 20,000 points are no numbers and were left out; the first is line 9."
    clean = load_part(written(tmp_path, np.delete(points, [7, 90], axis=0), "clean.xyz"))
    assert found.bodies[0].patches.tolist() == clean.bodies[0].patches.tolist()


def test_points_of_a_ply_that_are_no_numbers_are_left_out(tmp_path):
    points = noisy(ball(20_000)).astype("<f4")
    points[3] = np.nan
    head = "ply\nformat binary_little_endian 1.0\nelement vertex 20000\n"
    head += "".join(f"property float {axis}\n" for axis in "xyz") + "end_header\n"
    (tmp_path / "ball.ply").write_bytes(head.encode() + points.tobytes())
    found = load_part(tmp_path / "ball.ply")
    assert any(
        "1 of 20,000 points are no numbers and were left out; the first is point 4." in each.message
        for each in found.findings
    )


def test_another_bad_line_is_named_beside_one_that_is_no_number(tmp_path):
    lines = written(tmp_path, sheet(100)).read_text().splitlines()
    lines[4], lines[8] = "1 2 nan", "1 2 x"
    (tmp_path / "cloud.xyz").write_text("\n".join(lines))
    with pytest.raises(BoardError, match="holds no three numbers") as error:
        load_part(tmp_path / "cloud.xyz")
    assert error.value.line == 9


@pytest.mark.parametrize("separator", ["; ", ";", " ", "\t"])
def test_decimal_commas_are_read_and_told(tmp_path, separator):
    points = noisy(sheet(20_000))
    points[1] = points[1].round()
    file = tmp_path / "comma.xyz"
    file.write_text("".join(separator.join(f"{each:.5g}" for each in row).replace(".", ",") + "\n" for row in points))
    found = load_part(file)
    assert [each.rule.id for each in found.findings if "comma" in each.rule.id] == ["cloud-decimal-commas"]
    plain = tmp_path / "plain.xyz"
    plain.write_text("".join(" ".join(f"{each:.5g}" for each in row) + "\n" for row in points))
    assert found.bodies[0].patches.tolist() == load_part(plain).bodies[0].patches.tolist()


@pytest.mark.parametrize(
    "line", ["{:.4f},{:.4f},{:.4f}", "{:.0f},{:.0f},{:.0f}", "{:.0f}, {:.0f}, {:.0f}", "{:.3f}, {:.3f}, {:.3f}, 7"]
)
def test_commas_between_numbers_are_no_decimal_points(tmp_path, line):
    points = np.unique(sheet(20_000).round(), axis=0)
    file = tmp_path / "between.xyz"
    file.write_text("".join(line.format(*row) + "\n" for row in points))
    found = load_part(file)
    assert not [each for each in found.findings if "comma" in each.rule.id]
    assert np.ptp(found.bodies[0].patches, axis=(0, 1)) == pytest.approx(np.ptp(points, axis=0), rel=0.05)


def test_points_beside_the_surface_are_named(tmp_path):
    beside = np.array([[200.0, 250.0, 90.0], [200.2, 250.1, 90.3], [120.0, 100.0, 40.0]])
    found = load_part(written(tmp_path, np.concatenate([noisy(sheet(20_000)), beside])))
    (text,) = [each.message for each in found.findings if each.rule.id == "cloud-points-left-out"]
    assert text == "3 of 20,003 points lie beside the surface and were left out, the farthest at 200.2, 250.1, 90.3 mm."
