"""Boards as triangles with colours."""

import json
import struct
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tiny_session import tiny_session

from webui.glb.glb import shared_corners, triangles_glb
from webui.layers.surface.ground import chosen_glb, ground_glb, paint_workpiece, tint_components


def read_glb(glb):
    """Header, (n, 3) corners of triangles in turn and (n, 4) their colours."""
    magic, version, length = struct.unpack("<III", glb[:12])
    assert (magic, version, length) == (0x46546C67, 2, len(glb))
    size = struct.unpack("<I", glb[12:16])[0]
    header = json.loads(glb[20 : 20 + size])
    binary = glb[20 + size + 8 :]
    points, tints, index = (
        np.frombuffer(binary[view["byteOffset"] : view["byteOffset"] + view["byteLength"]], dtype=kind)
        for view, kind in zip(header["bufferViews"], (np.float32, np.uint8, np.uint32), strict=True)
    )
    assert header["buffers"] == [{"byteLength": points.nbytes + tints.nbytes + index.nbytes}]
    return header, points.reshape(-1, 3)[index], tints.reshape(-1, 4)[index]


def test_every_patch_is_drawn_where_it_is():
    board = tiny_session().board
    header, points, _ = read_glb(ground_glb(board, {}))
    expected = np.concatenate([body.patches.reshape(-1, 3) for body in board.bodies])
    np.testing.assert_allclose(points, expected, atol=1e-4)
    assert header["accessors"][0]["max"] == points.max(axis=0).tolist()
    assert header["accessors"][0]["count"] < len(points) / 3, "triangles share their corners"


def test_parts_that_touch_keep_their_own_colours():
    board = tiny_session().board
    tints = {component.name: (10 * index, 0, 0) for index, component in enumerate(board.components, 1)}
    _, _, colours = read_glb(ground_glb(board, tints))
    _, _, again = read_glb(ground_glb(board, dict.fromkeys(tints, (7, 7, 7))))
    begin = 0
    seen = set()
    for body in board.bodies:
        own = colours[begin : begin + 3 * len(body.patches)]
        assert (own == own[0]).all()
        if body.name in tints:
            seen.add(tuple(own[0].tolist()))
        begin += 3 * len(body.patches)
    assert begin == len(colours) == len(again)
    assert len(seen) == len(tints)


@pytest.mark.slow
@settings(max_examples=40)
@given(data=st.data())
def test_shared_corners_stand_for_all_of_them(data):
    count = data.draw(st.integers(0, 30))
    corner = st.tuples(*[st.sampled_from([0.0, -0.0, 1.0, 1.0 + 1e-12, -2.5])] * 3)
    corners = np.array(data.draw(st.lists(corner, min_size=count, max_size=count))).reshape(-1, 3)
    tint = st.sampled_from([(0, 0, 1), (0, 1, 0), (255, 255, 255)])
    colours = np.array(data.draw(st.lists(tint, min_size=count, max_size=count)), dtype=np.uint8).reshape(-1, 3)
    labels = colours.astype(np.int64) @ [65536, 256, 1]
    kept, index = shared_corners(corners, labels)
    np.testing.assert_allclose(corners[kept][index], corners, atol=1e-6)
    np.testing.assert_array_equal(colours[kept][index], colours)
    assert list(kept) == sorted(set(kept))
    assert len(kept) == len(np.unique(np.column_stack([np.round(corners, 6) + 0.0, colours]), axis=0))


@pytest.mark.parametrize("by", ["class", "package", "height", "nothing"])
def test_the_legend_says_every_colour(by):
    session = tiny_session()
    tints, legend = tint_components(session.board, session.run.classified, by)
    if by == "nothing":
        assert (tints, legend) == ({}, {})
        return
    assert set(tints) == {component.name for component in session.board.components}
    if by != "height":
        assert set(tints.values()) == set(legend.values())


def test_a_selected_component_lies_over_the_one_that_is_there():
    board = tiny_session().board
    name = board.components[0].name
    body = next(each for each in board.bodies if each.name == name)
    _, points, _ = read_glb(chosen_glb(board, name, (1, 2, 3)))
    assert points[:, 2].max() > body.patches[..., 2].max()
    assert chosen_glb(board, "nobody", (1, 2, 3)) == b""


def test_nothing_is_no_glb():
    assert triangles_glb(np.empty((0, 3)), np.empty((0, 3), dtype=np.uint8)) == b""


def test_a_painted_board_is_remembered_until_its_colours_change():
    session = tiny_session()
    board, classified = session.board, session.run.classified
    painted = paint_workpiece(board, classified, "class")
    assert paint_workpiece(board, tuple(classified), "class") is painted
    assert painted[1] == tint_components(board, classified, "class")[1]
    others = tuple(replace(each, component_class="other") for each in classified)
    assert list(paint_workpiece(board, others, "class")[1]) == ["other"]
    assert paint_workpiece(board, others, "class")[0] != painted[0]
