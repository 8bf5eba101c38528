"""A heap of patches is cut into its bodies."""

import numpy as np
import pytest
import trimesh

from boards.formats.parts import split_bodies


def test_two_boxes_are_two_bodies() -> None:
    box = np.asarray(trimesh.creation.box((1.0, 2.0, 3.0)).triangles)
    found = split_bodies(np.concatenate([box, box + 10.0]))
    assert [len(each) for each in found] == [12, 12]


@pytest.mark.parametrize("size", [0.0, 1e-310])
def test_a_heap_without_a_size_has_no_bodies(size: float) -> None:
    assert split_bodies(size * np.arange(18.0).reshape(2, 3, 3)) == []
