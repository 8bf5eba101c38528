import pytest

from webui.panels.widgets.choices import cycle


@pytest.mark.parametrize(
    ("now", "steps", "then"),
    [("a", 1, "b"), ("c", 1, "a"), ("a", -1, "c"), ("b", -1, "a"), ("gone", 1, "a"), ("gone", -1, "c")],
)
def test_one_steps_on_and_back_around_the_end(now, steps, then):
    assert cycle(["a", "b", "c"], now, steps, "") == then


def test_there_is_nowhere_to_step_in_an_empty_list():
    assert cycle([], "a", 1, "") == ""
