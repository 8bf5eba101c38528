"""Layers of a part: edges of a chosen face, stripes with their order, the lance, cells by what is held, the jet."""

import numpy as np
import pytest
from part_session import part_session

from webui.layers.paths.nozzle import spray_rims
from webui.layers.surface.ground import chosen_glb, lances_glb, stripe_starts, stripes_glb
from webui.scene.camera import first_hit, target_of

UPRIGHT = np.array([0.0, 1.0, 0.0, 0.0])
"""Tool +Z down: half a turn about x."""


@pytest.fixture(scope="module")
def session():
    return part_session()


@pytest.mark.slow
def test_a_click_meets_a_face_or_a_fixture(session):
    target = target_of(session.workpiece)
    names = {each.name for each in session.workpiece.pickable_bodies}
    assert names == {*session.workpiece.place_names, "jaw"}
    assert first_hit(target, np.array([20.0, 15, 90]), np.array([0.0, 0, -1])).body == "face-1"
    assert first_hit(target, np.array([90.0, 15, 10]), np.array([-1.0, 0, 0])).body == "face-4"
    assert first_hit(target, np.array([-10.0, 15, 90]), np.array([0.0, 0, -1])).body == "jaw"


def test_a_face_is_looked_at_from_outside_and_named_in_its_middle(session):
    place = session.workpiece.find_place("face-4")
    assert place.towards @ [1, 0, 0] > 0
    np.testing.assert_allclose(place.label, [42, 15, 10])
    assert session.workpiece.find_place("nothing") is None


def test_the_edges_around_a_face_are_drawn_and_not_the_diagonal(session):
    corners, _ = drawn_flat(chosen_glb(session.workpiece, "face-4", (1, 2, 3)))
    assert len(corners) == 4 * 8  # four edges of four sides of two triangles
    middle = corners.reshape(-1, 3) - [40, 15, 10]
    inside = (np.abs(middle[:, 1]) < 13) & (np.abs(middle[:, 2]) < 8)
    assert not inside.any()


def drawn_flat(glb):
    """Triangles of a mesh without shared corners."""
    import json
    import struct

    length = struct.unpack_from("<I", glb, 12)[0]
    document, binary = json.loads(glb[20 : 20 + length]), glb[28 + length :]
    view = document["bufferViews"][0]
    points = np.frombuffer(binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]], np.float32)
    return points.reshape(-1, 3, 3), document


def test_stripes_are_numbered_as_they_are_sprayed(session):
    (covering,) = session.run.coverings
    starts = dict(stripe_starts([covering]))
    assert set(starts) == {number for number, each in enumerate(covering.pieces, 1) if len(each.targets) > 1}
    for number, point in starts.items():
        begin = covering.pieces[number - 1].targets[0]
        assert np.linalg.norm(point - begin) < 5
    assert stripes_glb([], 1.0) == lances_glb([]) == b""
    assert stripes_glb([covering], 1.0)
    assert lances_glb([covering])


def test_the_jet_ends_where_its_axis_meets_the_part(session):
    nozzle = session.recipe.nozzles["jet"]
    edge, middle = spray_rims(nozzle, session.workpiece, np.array([20.0, 15.0, 80.0]), UPRIGHT)
    radius = 60 * np.tan(np.radians(15))
    np.testing.assert_allclose(np.linalg.norm(edge[:, :2], axis=1), radius, rtol=1e-3)
    np.testing.assert_allclose(edge[:, 2], -60, atol=0.5)
    assert len(middle) == 0
    assert len(spray_rims(nozzle, session.workpiece, np.array([200.0, 15.0, 80.0]), UPRIGHT)[0]) == 0
