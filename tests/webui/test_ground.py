"""Boards as triangles with colours."""

import json
import struct
from dataclasses import replace

import numpy as np
import pytest
from tiny_session import tiny_session

from webui.layers.glb import triangles_glb
from webui.layers.ground import component_glb, ground_glb, paint_board, tint_components


def read_glb(glb):
    """Header and (n, 3) positions."""
    magic, version, length = struct.unpack("<III", glb[:12])
    assert (magic, version, length) == (0x46546C67, 2, len(glb))
    size = struct.unpack("<I", glb[12:16])[0]
    header = json.loads(glb[20 : 20 + size])
    binary = glb[20 + size + 8 :]
    count = header["accessors"][0]["count"]
    return header, np.frombuffer(binary[: 12 * count], dtype=np.float32).reshape(-1, 3)


def test_every_patch_is_drawn_where_it_is():
    board = tiny_session().board
    header, points = read_glb(ground_glb(board, {}))
    expected = np.concatenate([body.patches.reshape(-1, 3) for body in board.bodies])
    np.testing.assert_allclose(points, expected, atol=1e-4)
    assert header["accessors"][1]["count"] == len(points)
    assert header["accessors"][0]["max"] == points.max(axis=0).tolist()


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
    _, points = read_glb(component_glb(board, name, (1, 2, 3)))
    assert points[:, 2].max() > body.patches[..., 2].max()
    assert component_glb(board, "nobody", (1, 2, 3)) == b""


def test_nothing_is_no_glb():
    assert triangles_glb(np.empty((0, 3)), np.empty((0, 3), dtype=np.uint8)) == b""


def test_a_painted_board_is_remembered_until_its_colours_change():
    session = tiny_session()
    board, classified = session.board, session.run.classified
    painted = paint_board(board, classified, "class")
    assert paint_board(board, tuple(classified), "class") is painted
    assert painted.legend == tint_components(board, classified, "class")[1]
    others = tuple(replace(each, component_class="other") for each in classified)
    assert list(paint_board(board, others, "class").legend) == ["other"]
    assert paint_board(board, others, "class").glb != painted.glb
