"""The tab Live: what runs in the folder is offered, its robot is that of the scene, and its end is stated."""

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pytest
from operated import small_cell
from small_page import SmallPage, press, small_page
from small_scene import SmallScene
from tiny_session import tiny_session
from waiting import wait_for

from robotcell.cell.load import cell_sha256, read_cell
from webui.live.live import LiveServer, Running, announced
from webui.page.project import open_project
from webui.panels.robot.live import LEAVE, WATCH, LivePanel, end_of, moment_of

JOINTS = {f"j{number}_deg": 10.0 * number for number in range(1, 7)}
STATE = {"state": "running", "reason": "", "node": 7, "nodes": 40, "joints": JOINTS, "tool": 1, "seconds": 3.0}


@dataclass
class Watched:
    page: SmallPage
    scene: SmallScene
    panel: LivePanel | None = None
    state: dict[str, object] = field(default_factory=lambda: {**STATE, "age_ms": 20.0})


@contextmanager
def watched(folder: Path) -> Iterator[Watched]:
    cell = small_cell()
    session = replace(tiny_session(), cell_name="small", cell=cell)
    with small_page(session, open_project(folder)) as page:
        scene = SmallScene(page)
        it = Watched(page, scene)
        server = LiveServer(lambda: it.state, print)
        running = Running(server.address, server.token, "demo.wash", "small", cell_sha256(cell))
        with announced(folder, running):
            it.panel = LivePanel(page, scene)
            page.open()
            yield it
            page.close()
            server.close()


def test_the_robot_in_the_scene_is_that_of_the_operation(tmp_path: Path) -> None:
    with watched(tmp_path) as it:
        press(it.page, WATCH)
        assert it.page.session.watched is not None
        wait_for(lambda: it.scene.stamps)
        joints, tool = it.scene.robot._pose
        np.testing.assert_allclose(joints, np.radians(list(JOINTS.values())))
        assert (tool, it.scene.stamps[0]) == (1, pytest.approx(2.98))
        assert it.scene.is_live  # the playback leaves it alone
        press(it.page, LEAVE)
        assert (it.page.session.watched, it.scene.is_live) == (None, False)


def test_the_robot_of_another_cell_stands_still(tmp_path: Path) -> None:
    with watched(tmp_path) as it:
        it.page.show(replace(it.page.session, cell=read_cell("ur5e-bench")))
        home = it.scene.robot._pose[0]
        press(it.page, WATCH)
        it.state = {**it.state, "state": "end"}
        wait_for(lambda: it.panel._follower.end)  # it was looked at
        np.testing.assert_array_equal(it.scene.robot._pose[0], home)


def test_the_end_is_stated_and_a_lost_operation_is_not_left(tmp_path: Path) -> None:
    with watched(tmp_path) as it:
        press(it.page, WATCH)
        running = it.page.session.watched
        (file,) = (tmp_path / ".washboard" / "live").iterdir()
        text = file.read_text()
        file.unlink()
        it.page.poll()
        assert it.page.session.watched is running  # it did not end: it is lost, and the page shows for how long
        file.write_text(text)
        it.page.poll()
        it.state = {**it.state, "state": "end", "node": 40}
        wait_for(lambda: it.panel._follower.end)
        file.unlink()
        it.page.poll()
        assert it.page.session.watched is None
        assert it.page.client.said[-1] == "The operation is over: end, after node 40 of 40."


def test_without_an_operation_it_is_stated_how_one_is_begun(tmp_path: Path) -> None:
    with small_page(tiny_session(), open_project(tmp_path)) as page:
        LivePanel(page, SmallScene(page))
        page.open()
        press(page, WATCH)
        assert page.session.watched is None
        assert "washboard operate PROGRAM --cell CELL --live 0" in page.client.said[-1]


def test_states_that_are_none_move_nothing() -> None:
    cell = small_cell()
    assert moment_of({**STATE, "age_ms": 0.0}, cell) is not None
    for odd in ({"joints": {}}, {"joints": None}, {"joints": {"a": "b"}}, {"seconds": None}, {"age_ms": "x"}):
        assert moment_of({**STATE, "age_ms": 0.0, **odd}, cell) is None
    assert end_of({"state": "faulted", "node": 3, "nodes": 9, "reason": "the link is cut"}) == (
        "faulted, after node 3 of 9: the link is cut."
    )
    assert end_of({"state": "paused"}) == ""
