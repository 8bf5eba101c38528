"""A button that begins work and gives it up; the line beneath it never says what is no longer so."""

import threading
import time
from contextlib import contextmanager

import pytest
from small_page import find, press, small_page
from tiny_session import tiny_session
from waiting import WAIT_S, wait_for

from specs.errors import JobError
from webui.panels.widgets.job import Job, RunButton
from webui.theme.html import progress_html

HOLDS = "<p>nothing yet</p>"


@contextmanager
def opened():
    with small_page(tiny_session()) as page:
        yield page
        page.close()


def button_of(page, work, done=lambda _: None, failed=lambda _: None):
    button = RunButton(page, "Do", lambda: button.start(work, done, failed), "Does it.", "Stop")
    button.show(HOLDS)
    return button


def says(button):
    return button._line.content


def test_work_is_begun_told_of_and_taken():
    go, taken = threading.Event(), []

    def work(progress):
        progress("trying <hard>", 0.25)
        go.wait(WAIT_S)
        return 7

    with opened() as page:
        button = button_of(page, work, taken.append)
        press(page, "Do")
        wait_for(lambda: "Trying &lt;hard&gt;" in says(button))
        assert "25%" in says(button)
        assert find(page, "Stop")
        button.show("<p>newer</p>")
        assert "Trying" in says(button)
        go.set()
        wait_for(lambda: says(button) == "<p>newer</p>")
        assert taken == [7]
        assert find(page, "Do")


def test_what_is_shown_of_the_result_stays():
    with opened() as page:
        button = button_of(page, lambda _progress: 7, lambda found: button.show(f"<p>{found}</p>"))
        press(page, "Do")
        wait_for(lambda: says(button) == "<p>7</p>")
        assert find(page, "Do")


def test_work_that_is_given_up_leaves_no_trace():
    ended, taken = threading.Event(), []

    def work(progress):
        try:
            while True:
                time.sleep(0.005)
                progress("trying", 0.5)
        finally:
            ended.set()

    with opened() as page:
        button = button_of(page, work, taken.append, taken.append)
        press(page, "Do")
        wait_for(lambda: "Trying" in says(button))
        press(page, "Stop")
        assert says(button) == HOLDS
        assert find(page, "Do")
        assert ended.wait(WAIT_S)
        assert says(button) == HOLDS
        assert taken == []


def test_work_without_a_button_of_its_own_has_one_that_cancels_it_while_it_is_under_way():
    go, reset = threading.Event(), []

    def work(progress):
        while not go.wait(0.005):
            progress("trying", 0.5)

    with opened() as page:
        job = Job(page, cancelled=lambda: reset.append(True))
        job.show(HOLDS)
        button = find(page, "Cancel")
        assert not button.visible
        job.start(work, lambda _: None)
        assert button.visible
        press(page, "Cancel")
        assert (job.running, button.visible, reset, says(job)) == (False, False, [True], HOLDS)
        job.start(lambda _: None, lambda _: None)
        wait_for(lambda: not job.running)
        assert not button.visible
        go.set()


@pytest.mark.parametrize(
    ("error", "remark", "said"), [(JobError("no <way>"), "no <way>", 0), (ValueError("oops"), "", 1)]
)
def test_why_it_came_to_nothing_is_said_until_something_else_holds(error, remark, said):
    heard = []

    def work(_progress):
        raise error

    with opened() as page:
        button = button_of(page, work, failed=heard.append)
        press(page, "Do")
        wait_for(lambda: heard)
        assert heard == [remark]
        assert find(page, "Do")
        wait_for(lambda: ("no &lt;way&gt;" in says(button)) if remark else (says(button) == HOLDS))
        assert len(page.client.said) == said
        button.show(HOLDS)
        assert says(button) == HOLDS


def test_a_result_that_cannot_be_shown_is_a_failure():
    def refuse(_found):
        raise JobError("no room")

    with opened() as page:
        button = button_of(page, lambda _progress: 7, refuse)
        press(page, "Do")
        wait_for(lambda: "no room" in says(button))
        assert find(page, "Do")


def test_somebody_else_may_hear_how_far_it_is():
    told = []
    with opened() as page:
        job = Job(page, lambda what, done: told.append((what, done)))
        job.start(lambda progress: progress("trying", 0.5), lambda _: told.append("done"))
        wait_for(lambda: "done" in told)
        job.stop()  # nothing is under way
        assert told == [("waiting", 0.0), ("trying", 0.5), "done"]
        assert not job.running


def test_a_page_that_is_gone_begins_nothing():
    begun = []
    with small_page(tiny_session()) as page:
        button = button_of(page, lambda _progress: begun.append(True))
        page.close()
        press(page, "Do")
        time.sleep(0.05)
    assert begun == []
    assert says(button) == HOLDS


def test_progress_is_never_without_a_bar():
    assert "width:3%" in progress_html("x", 0.0)
    assert "width:60%" in progress_html("x", 0.6)
