"""A heap of patches is cut into its bodies."""

import numpy as np
import pytest
import trimesh

from boards.formats.parts import name_parts, split_bodies
from boards.formats.tree import Part


def test_two_boxes_are_two_bodies() -> None:
    box = np.asarray(trimesh.creation.box((1.0, 2.0, 3.0)).triangles)
    found = split_bodies(np.concatenate([box, box + 10.0]))
    assert [len(each) for each in found] == [12, 12]


@pytest.mark.parametrize("size", [0.0, 1e-310])
def test_a_heap_without_a_size_has_no_bodies(size: float) -> None:
    assert split_bodies(size * np.arange(18.0).reshape(2, 3, 3)) == []


def test_names_that_occur_again_are_numbered_past_those_that_are_taken() -> None:
    """Each number is tried once: a hundred thousand parts of one name are no hundred thousand squared."""
    given = ["", "U1-2", "U1", "U1", "", "U 1", "U_1", "part-1", "board", *["U1"] * 100_000]
    named, _ = name_parts([("component", Part(name, None, (), is_named=True)) for name in given])
    names = [part.name for _, part in named]
    assert names[:9] == ["part-1", "U1-2", "U1", "U1-3", "part-2", "U_1", "U_1-2", "part-1-2", "board-2"]
    assert names[9] == "U1-4"
    assert names[-1] == "U1-100003"
    assert len(set(names)) == len(names)
