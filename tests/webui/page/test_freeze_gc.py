import gc
import weakref

import pytest

from webui.page.page import freeze_gc


class Circle:
    def __init__(self):
        self.me = self


@pytest.fixture(autouse=True)
def as_before():
    yield
    gc.unfreeze()


@pytest.mark.slow
def test_what_lives_is_no_longer_looked_at():
    kept = [Circle() for _ in range(1000)]
    freeze_gc()
    assert gc.get_freeze_count() > len(kept)
    assert not any(isinstance(each, Circle) for each in gc.get_objects())


@pytest.mark.slow
def test_circles_go_at_the_latest_when_it_is_called_again():
    circle = Circle()
    gone = weakref.ref(circle)
    freeze_gc()
    del circle
    gc.collect()
    assert gone() is not None
    freeze_gc()
    assert gone() is None


@pytest.mark.slow
def test_what_comes_later_is_collected_as_usual():
    freeze_gc()
    gone = weakref.ref(Circle())
    gc.collect()
    assert gone() is None
