"""Operations that are found in a folder: those that answer, and nothing that a file only claims."""

import json
import os
import stat
import subprocess
import sys
from dataclasses import asdict, replace
from pathlib import Path

from waiting import wait_for

from webui.live.live import FOLDER, LiveServer, Running, announced, look, running_in

STATE = {"state": "running", "node": 7}


def test_an_operation_is_found_while_it_runs(tmp_path: Path) -> None:
    server = LiveServer(lambda: STATE, print)
    running = Running(server.address, server.token, "demo.wash", "small", "ab" * 32)
    assert running_in(tmp_path) == []
    with announced(tmp_path, running):
        assert stat.S_IMODE((tmp_path / FOLDER).stat().st_mode) == 0o700  # the token is its owner's
        assert wait_for(lambda: running_in(tmp_path), "the view") == [running]
        assert wait_for(lambda: look(running), "its state") == STATE
        server.close()
        assert running_in(tmp_path) == []  # killed: the file is there, and nobody answers
    assert list((tmp_path / FOLDER).iterdir()) == []


def test_files_that_are_no_operation_are_left_out(tmp_path: Path) -> None:
    server = LiveServer(lambda: STATE, print)
    good = Running(server.address, server.token, "demo.wash", "small", "ab" * 32)
    folder = tmp_path / FOLDER
    folder.mkdir(parents=True)
    elsewhere = server.address.replace("127.0.0.1", "evil.example")
    bad = [
        replace(good, address=elsewhere),
        replace(good, address=server.address + "/x"),
        replace(good, address="http://127.0.0.1:0"),
        replace(good, token="a b"),
        replace(good, program="a\nb"),
    ]
    texts = [json.dumps(asdict(each)) for each in bad]
    texts += ["", "[]", "[" * 3000, json.dumps(asdict(good) | {"more": 1}), json.dumps(asdict(good) | {"cell": 1})]
    own = folder / f"{good.port}-{os.getpid()}.json"
    for text in texts:
        own.write_text(text)
        assert running_in(tmp_path) == []
    own.unlink()
    (tmp_path / "outside.json").write_text(json.dumps(asdict(good)))
    own.symlink_to(tmp_path / "outside.json")
    (folder / f"{good.port + 1}-{os.getpid()}.json").write_text(json.dumps(asdict(good)))
    (folder / "good.json").write_text(json.dumps(asdict(good)))
    assert running_in(tmp_path) == []
    own.unlink()
    own.write_text(json.dumps(asdict(good)))
    assert wait_for(lambda: running_in(tmp_path), "the view") == [good]
    server.close()


def test_whoever_has_the_port_of_an_operation_that_was_killed_gets_no_request(tmp_path: Path) -> None:
    asked: list[str] = []
    server = LiveServer(lambda: asked.append("state") or STATE, print)
    running = Running(server.address, server.token, "demo.wash", "small", "ab" * 32)
    with subprocess.Popen([sys.executable, "-c", ""]) as killed:
        pass
    (tmp_path / FOLDER).mkdir(parents=True)
    (tmp_path / FOLDER / f"{running.port}-{killed.pid}.json").write_text(json.dumps(asdict(running)))
    assert running_in(tmp_path) == []
    assert asked == []
    server.close()
