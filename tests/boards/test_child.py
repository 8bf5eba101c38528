"""Foreign readers in a child: whatever they do ends as one sentence, and with exit code 2."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest
from command import washboard
from foreign_readers import REASONS, count_for_ever, crash, echo, fill_memory, wait_for_ever
from PIL import Image
from step_writer import StepWriter
from waiting import WAIT_S

import boards.formats.step
import boards.part.silhouette
from boards.child import ChildError, Limits, in_child

ROOT = Path(__file__).parents[2]

LIMITS = Limits(cpu_s=1, memory_bytes=300_000_000, wall_s=WAIT_S)
Read = Callable[[bytes], bytes]


def limits_of(read: Read) -> Limits:
    """Only what waits for ever is to end by the clock, however busy the machine is."""
    return replace(LIMITS, wall_s=3.0) if read is wait_for_ever else LIMITS


def test_the_child_gives_what_the_function_gives_and_its_log() -> None:
    seen: list[float] = []
    assert in_child(echo, b"abc" * 100_000, LIMITS, seen.append) == (b"cba" * 100_000, "found nothing odd\n")
    assert seen == sorted(seen)
    assert len(seen) > 0


@pytest.mark.slow
@pytest.mark.parametrize(("read", "reason"), REASONS.items(), ids=lambda each: getattr(each, "__name__", ""))
def test_what_a_reader_does_is_the_reason_of_one_error(
    read: Read, reason: str, capfd: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(ChildError) as caught:
        in_child(read, b"data", limits_of(read))
    assert str(caught.value) == reason
    assert capfd.readouterr() == ("", "")


def test_no_process_is_a_reason_too(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys, "executable", "/nowhere/python")
    with pytest.raises(ChildError, match="no process for its reader: No such file or directory"):
        in_child(echo, b"", LIMITS)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["STEP", "picture"])
@pytest.mark.parametrize("read", [wait_for_ever, count_for_ever, fill_memory, crash], ids=lambda each: each.__name__)
def test_a_command_ends_with_one_line_and_2(
    kind: str, read: Read, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    if kind == "STEP":
        monkeypatch.setattr(boards.formats.step, "triangulate", read)
        monkeypatch.setattr(boards.formats.step, "limits_for", lambda _: limits_of(read))
        Path("in.step").write_text(StepWriter().write([("R1", "R", (1, 1, 1), (0, 0, 0))]))
        done = washboard("board", "import", "in.step", "-o", "out.tri")
    else:
        monkeypatch.setattr(boards.part.silhouette, "decode_grey", read)
        monkeypatch.setattr(boards.part.silhouette, "_LIMITS", limits_of(read))
        Image.new("L", (40, 40)).save("in.png")
        done = washboard("part", "scan", "in.png", "in.png", "--mm-per-pixel", "1", "-o", "out.tri")
    assert (done.code, done.out) == (2, "")
    assert done.err.startswith(f"error: in.{'step' if kind == 'STEP' else 'png'}: ")
    assert REASONS[read] in done.err
    assert done.err.count("\n") == 1
    assert not Path("out.tri").exists()


@pytest.mark.slow
def test_the_child_ends_with_its_parent() -> None:
    start = (
        "import boards.child, foreign_readers\n"
        "boards.child.in_child(foreign_readers.wait_for_ever, b'', boards.child.Limits(60, 10**10, 60.0))\n"
    )
    with subprocess.Popen(
        [sys.executable, "-c", start], env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    ) as parent:
        children = Path(f"/proc/{parent.pid}/task/{parent.pid}/children")
        while not (found := children.read_text().split()) or "boards.child_start" not in command_of(found[0]):
            time.sleep(0.01)
        time.sleep(0.3)
        parent.send_signal(signal.SIGKILL)
    until = time.monotonic() + WAIT_S
    while command_of(found[0]) and time.monotonic() < until:
        time.sleep(0.02)
    assert command_of(found[0]) == ""


def command_of(pid: str) -> str:
    """Command line of a process; empty where it has ended."""
    try:
        return Path(f"/proc/{pid}/cmdline").read_text()
    except OSError:
        return ""


@pytest.mark.slow
@pytest.mark.parametrize("limit", ["-v 4000000", "-f 10000", "-t 30", "-c 0"])
def test_limits_of_the_caller_are_not_raised(limit: str, tmp_path: Path) -> None:
    (tmp_path / "b.step").write_text(StepWriter().write([("PCB", "PCB", (40.0, 30.0, 1.6), (0.0, 0.0, 0.0))]))
    command = f"ulimit {limit} && exec {sys.executable} -m washboard board show b.step"
    environment = os.environ | {"PYTHONPATH": str(ROOT)}
    done = subprocess.run(["bash", "-c", command], cwd=tmp_path, env=environment, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
