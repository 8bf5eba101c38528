"""Divided work: results in order with any number of threads, none begun far ahead, failures as without threads."""

import threading

import pytest

from cleaning.threads import limit_threads, map_in_threads, thread_count


@pytest.mark.parametrize("most", [1, 2])
def test_results_are_those_of_one_thread_in_order(most: int) -> None:
    with limit_threads(most):
        assert list(map_in_threads(lambda item: item * item, range(50))) == [item * item for item in range(50)]
        assert list(map_in_threads(str, ())) == []


def test_one_thread_is_the_callers_own() -> None:
    with limit_threads(1):
        assert set(map_in_threads(lambda _: threading.get_ident(), range(5))) == {threading.get_ident()}
    assert threading.get_ident() not in set(map_in_threads(lambda _: threading.get_ident(), range(5)))


def test_limits_only_lower_and_end_with_their_block() -> None:
    alone = thread_count()
    with limit_threads(1):
        with limit_threads(8):
            assert thread_count() == 1
        assert thread_count() == 1
    with limit_threads(alone + 5):
        assert thread_count() == alone
    assert thread_count() == alone


@pytest.mark.parametrize("most", [1, 2])
def test_no_item_is_begun_far_ahead(most: int) -> None:
    begun: list[int] = []
    with limit_threads(most):
        for taken, _ in enumerate(map_in_threads(begun.append, range(30)), start=1):
            assert len(begun) <= taken + most


@pytest.mark.parametrize("most", [1, 2])
def test_a_failure_is_raised_in_its_place(most: int) -> None:
    taken: list[float] = []
    with limit_threads(most), pytest.raises(ZeroDivisionError):
        taken.extend(map_in_threads(lambda item: 6 / item, (1, 2, 3, 0, 4)))
    assert taken == [6, 3, 2]
