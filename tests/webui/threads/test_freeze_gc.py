import gc
import weakref

import pytest

from webui.threads.freeze_gc import set_aside


class Circle:
    def __init__(self):
        self.me = self


@pytest.fixture(autouse=True)
def as_before():
    yield
    gc.unfreeze()


def test_what_lives_is_no_longer_looked_at():
    kept = [Circle() for _ in range(1000)]
    set_aside()
    assert gc.get_freeze_count() > len(kept)
    assert not any(isinstance(each, Circle) for each in gc.get_objects())


def test_circles_go_at_the_latest_when_it_is_called_again():
    circle = Circle()
    gone = weakref.ref(circle)
    set_aside()
    del circle
    gc.collect()
    assert gone() is not None
    set_aside()
    assert gone() is None


def test_what_comes_later_is_collected_as_usual():
    set_aside()
    gone = weakref.ref(Circle())
    gc.collect()
    assert gone() is None
