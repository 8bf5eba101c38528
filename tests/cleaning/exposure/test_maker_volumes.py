"""What each maker left on each component: sums in order, and memory for what is not nothing."""

import tracemalloc

import numpy as np

from cleaning.exposure.accumulate import MakerVolumes


def test_rows_go_on_where_they_stopped():
    volumes = MakerVolumes(makers=4, components=2)
    for makers, given in (([0, 2], [[1.0, 0.0, 2.0], [0.0, 3.0, 0.0]]), ([2, 3], [[0.5, 0.25, 0.0], [0.0, 0.0, 0.0]])):
        rows = volumes.of(np.array(makers))
        rows += given
        volumes.keep(np.array(makers), rows)
    expected = [[1.0, 0.0, 0.5, 0.0], [0.0, 0.0, 3.25, 0.0], [2.0, 0.0, 0.0, 0.0]]
    np.testing.assert_array_equal(volumes.by_component().toarray(), expected)


def test_makers_and_components_that_do_not_meet_take_no_memory():
    count, together = 3000, 50
    volumes = MakerVolumes(makers=count, components=count)
    tracemalloc.start()
    for first in range(0, count, together):
        makers = np.arange(first, first + together)
        rows = volumes.of(makers)
        rows[np.arange(together), makers] = 1.0
        volumes.keep(makers, rows)
    found = volumes.by_component()
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert found.sum() == count
    assert peak < 8 * count * count / 10  # a tenth of a table of all
