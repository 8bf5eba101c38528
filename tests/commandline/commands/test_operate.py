"""``washboard operate``: dry runs, logs, and what it refuses."""

import gc
import json
import re
import socket
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from urllib.request import Request, urlopen

import pytest
from command import contents, washboard
from model_controller import STOP, ModbusController, free_port, modbus
from operated import DOOR, dry_run, job_of, looped, model_of, table, write_cell
from robot_programs import PROGRAMS
from small_cells import CELL
from waiting import WAIT_S, wait_for

from programs import native
from robotcell.cell.load import cell_sha256, read_cell
from webui.live.live import FOLDER, Running, running_in


@pytest.fixture
def job_file(tmp_path: Path) -> Path:
    file = tmp_path / "board.csv"
    file.write_text(table(40))
    return file


@pytest.mark.slow
def test_a_dry_run_writes_a_log_that_replays(job_file: Path, tmp_path: Path) -> None:
    cell = write_cell(tmp_path, modbus(1))
    outcome = washboard("operate", job_file, "--cell", cell, "--dry", "--log", tmp_path / "dry.csv")
    assert outcome.code == 0, outcome.err
    assert "end, after node 40" in outcome.out
    assert (tmp_path / "dry.csv").read_text() == dry_run(job_of(table(40))).log.render()
    assert set(contents(tmp_path)) == {"board.csv", "small.yaml", "dry.csv"}
    replayed = washboard("operate", "--replay", tmp_path / "dry.csv")
    assert replayed.code == 0, replayed.err
    assert "each in the state that its events lead to" in replayed.out


@pytest.mark.slow
def test_a_run_on_a_controller_writes_the_log_of_the_dry_run_and_its_clock(job_file: Path, tmp_path: Path) -> None:
    model = model_of(job_of(table(40)))
    controller, left_out = ModbusController(model), list[int]()
    model.at_node = lambda _: left_out.append(gc.get_freeze_count())
    try:
        cell = write_cell(tmp_path, controller.link)
        outcome = washboard("operate", job_file, "--cell", cell, "--log", tmp_path / "run.csv")
    finally:
        controller.close()
    assert outcome.code == 0, outcome.err
    log = (tmp_path / "run.csv").read_text()
    assert log == dry_run(job_of(table(40))).log.render()
    assert min(left_out) > 10_000  # a full collection meanwhile would stop the drive for as long as it takes
    assert gc.get_freeze_count() == 0
    clock = (tmp_path / "run.csv.clock").read_text().splitlines()
    assert len(clock) - 1 == len([line for line in log.splitlines() if re.match(r"\d", line)])


@pytest.mark.slow
def test_the_live_view_stops_the_jet_while_the_terminal_hangs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A terminal that takes no more output does not keep the drive from the stop, nor the view from the state."""
    hangs, written, reached = threading.Event(), threading.Event(), threading.Event()

    @contextmanager
    def terminal() -> Iterator[Callable[[str, float], None]]:
        yield lambda _what, _done: written.set() or hangs.wait(WAIT_S)

    monkeypatch.setattr("commandline.loading.progress_bar", terminal)
    monkeypatch.chdir(tmp_path)
    file, port, seen, found = tmp_path / "board.csv", free_port(), list[object](), list[Running]()
    file.write_text(table(400, 50_000))  # long enough for a view that answers late
    model = model_of(job_of(file.read_text()), haste=1.0)
    model.at_node = lambda sequence: reached.set() if sequence == 20 else None
    controller = ModbusController(model)

    def view(word: str, method: str = "GET") -> dict[str, object]:
        url = f"http://127.0.0.1:{port}/{word}?token={found[0].token}"
        return json.load(urlopen(Request(url, method=method), timeout=WAIT_S))

    def person() -> None:
        assert reached.wait(WAIT_S)
        assert written.wait(WAIT_S)
        found.extend(wait_for(lambda: running_in(tmp_path), "the view"))
        seen.append(view("state"))
        view("stop", "POST")
        until = time.monotonic() + 20
        while model.command != STOP and time.monotonic() < until:
            time.sleep(0.001)
        seen.append((model.command, model.open, hangs.is_set()))
        hangs.set()

    watching = threading.Thread(target=person)
    watching.start()
    try:
        outcome = washboard("operate", file, "--cell", write_cell(tmp_path, controller.link), "--live", str(port))
    finally:
        hangs.set()
        watching.join()
        controller.close()
    shown, stopped = seen
    assert stopped == (STOP, False, False)
    assert isinstance(shown, dict)
    assert (shown["state"], shown["jets"], shown["nodes"]) == ("running", ["doRing"], 400)
    assert shown["node"] >= 19
    assert all(shown["conditions"].values())
    first = next(iter(shown["joints"]))
    assert (len(shown["joints"]), first) == (6, "shoulder_pan_deg")
    assert outcome.code == 1
    assert f"http://127.0.0.1:{port}/?token={found[0].token}\n" in outcome.out
    assert shown["tool"] == 1
    (running,) = found  # by a page whose folder it is
    assert (running.port, running.program, running.cell) == (port, "board.csv", "small")
    assert running.cell_sha256 == cell_sha256(read_cell(tmp_path / "small.yaml"))
    assert list((tmp_path / FOLDER).iterdir()) == []
    assert re.search(r"ended +idle, after node", outcome.out)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("differs", "code", "said"),
    [
        ({"readings": (300_000,)}, 3, "not reached resistivity_mohm_cm 0.6 of 1 after 3 turns"),
        ({"stuck": True}, 4, "NOT CONFIRMED SHUT a valve is still open after 0.1 s; shut the supply by hand"),
    ],
)
def test_what_a_run_leaves_open_has_an_exit_code_of_its_own(
    differs: dict[str, object], code: int, said: str, job_file: Path, tmp_path: Path
) -> None:
    job_file.write_text(looped())
    controller = ModbusController(model_of(job_of(looped()), **differs))
    try:
        cell, log = write_cell(tmp_path, controller.link), tmp_path / "run.csv"
        outcome = washboard("operate", job_file, "--cell", cell, "--log", log)
    finally:
        controller.close()
    assert outcome.code == code, outcome.err
    for shown in (outcome, washboard("operate", "--replay", log)):
        assert said in " ".join(shown.out.split())


@pytest.mark.slow
def test_an_interlock_that_is_not_met_is_named_and_nothing_is_sent(job_file: Path, tmp_path: Path) -> None:
    model = model_of(job_of(table(40)))
    model.set_input(DOOR, on=False)
    controller = ModbusController(model)
    try:
        outcome = washboard("operate", job_file, "--cell", write_cell(tmp_path, controller.link))
    finally:
        controller.close()
    assert outcome.code == 1
    assert "door_closed is not met: close the door" in outcome.out
    assert model.received == []


@pytest.mark.slow
def test_a_dry_run_from_a_node_keeps_the_valves_shut_until_there(job_file: Path, tmp_path: Path) -> None:
    log = tmp_path / "dry.csv"
    words = ("--cell", write_cell(tmp_path, modbus(1)), "--dry", "--from", "20", "--log", log)
    assert washboard("operate", job_file, *words).code == 0
    opened = [line.split(",")[2] for line in log.read_text().splitlines() if line.endswith(",doRing")]
    assert opened[0] == "20"


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (
            ["--cell", "BARE", "--dry"],
            "cell small has no operate: state its link, interlocks and sensors there",
        ),
        (["--cell", "SMALL", "--dry", "--from", "41"], "--from 41: the program has nodes 1 to 40"),
        (["--cell", "SMALL"], r"no controller answers at 127.0.0.1 port 1 (Modbus TCP)"),
        (["--dry"], "a program and --cell CELL are needed, or --replay LOG"),
        (["--cell", "cairo-bench", "--dry"], "the table is that of cell small, not of cairo-bench"),
    ],
)
def test_what_cannot_be_operated_is_refused(words: list[str], reason: str, job_file: Path, tmp_path: Path) -> None:
    bare, log = tmp_path / "bare.yaml", tmp_path / "run.csv"
    bare.write_text(CELL)
    named = {"SMALL": write_cell(tmp_path, modbus(1)), "BARE": bare}
    outcome = washboard("operate", job_file, *(named.get(word, word) for word in words), "--log", log)
    assert outcome.code == 2
    (line,) = outcome.err.splitlines()
    assert reason in line
    assert not log.exists()


@pytest.mark.parametrize(
    ("log", "reason"),
    [
        ("board.csv", "it is read by this command"),
        ("link.csv", "it is read by this command"),
        ("small.yaml", "it is read by this command"),
        ("", "it is a folder"),
        ("/", "it is a folder"),
        ("none/run.csv", "there is no folder"),
    ],
)
def test_a_log_has_a_place_of_its_own(
    log: str, reason: str, job_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    cell = write_cell(tmp_path, modbus(1))
    (tmp_path / "link.csv").symlink_to(job_file)
    before = contents(tmp_path)
    outcome = washboard("operate", job_file, "--cell", cell, "--dry", "--log", log)
    assert (outcome.code, outcome.out) == (2, "")
    assert reason in outcome.err
    assert outcome.err.count("\n") == 1
    assert contents(tmp_path) == before


def test_the_clock_of_a_log_does_not_replace_what_is_read(job_file: Path, tmp_path: Path) -> None:
    table_file = job_file.rename(tmp_path / "run.clock")
    cell = write_cell(tmp_path, modbus(1))
    outcome = washboard("operate", table_file, "--cell", cell, "--log", tmp_path / "run")
    assert outcome.code == 2
    assert "it is read by this command" in outcome.err


@pytest.mark.slow
def test_a_device_takes_the_log_and_stays_one(job_file: Path, tmp_path: Path) -> None:
    cell = write_cell(tmp_path, modbus(1))
    assert washboard("operate", job_file, "--cell", cell, "--dry", "--log", "/dev/null").code == 0
    assert Path("/dev/null").is_char_device()
    assert set(contents(tmp_path)) == {"board.csv", "small.yaml"}


def test_the_hal_file_does_not_replace_its_cell(tmp_path: Path) -> None:
    cell = write_cell(tmp_path, modbus(1))
    outcome = washboard("operate", "--cell", cell, "--hal", cell)
    assert outcome.code == 2
    assert "it is read by this command" in outcome.err


@pytest.mark.slow
def test_a_program_is_operated_by_the_joint_table_of_export(tmp_path: Path) -> None:
    program, file, log = tmp_path / "loop.wash", tmp_path / "loop.csv", tmp_path / "log.csv"
    program.write_text(native.render(PROGRAMS["loop"]()))
    cell = ("--cell", "cairo-bench", "--board", "tiny")
    assert washboard("export", program, *cell, "--dialect", "joint-table", "-o", file).code == 0
    assert washboard("operate", program, *cell, "--dry", "--log", log).code == 0
    by_program = log.read_bytes()
    assert washboard("operate", file, *cell[:2], "--dry", "--log", log).code == 0
    assert log.read_bytes() == by_program
    refused = washboard("operate", file, *cell, "--dry")
    assert (refused.code, "leave out --board" in refused.err) == (2, True)


@pytest.mark.slow
def test_a_table_that_was_changed_or_is_of_another_state_of_the_cell_is_refused(tmp_path: Path) -> None:
    program, file, cell = tmp_path / "loop.wash", tmp_path / "loop.csv", tmp_path / "mine.yaml"
    program.write_text(native.render(PROGRAMS["loop"]()))
    assert washboard("cell", "edit", "cairo-bench", "operate.queue: 20", "-o", cell).code == 0
    words = ("--cell", cell, "--board", "tiny")
    assert washboard("export", program, *words, "--dialect", "joint-table", "-o", file).code == 0
    assert washboard("cell", "edit", "cairo-bench", "operate.queue: 30", "-o", cell).code == 0
    assert washboard("operate", file, "--cell", cell, "--dry").code == 0
    text = file.read_text()
    file.write_text(text.replace(",reach,", ",held,", 1))
    changed = washboard("operate", file, "--cell", cell, "--dry")
    assert (changed.code, "the rows are not those that its head states" in changed.err) == (2, True)
    file.write_text(text)
    assert washboard("cell", "edit", "cairo-bench", "board.pose.xyz_mm: [0, 0, 61]", "-o", cell).code == 0
    moved = washboard("operate", file, "--cell", cell, "--dry")
    assert (moved.code, "its file was changed since" in moved.err) == (2, True)


@pytest.mark.parametrize("name", ["run.csv", "run.csv.part"])
@pytest.mark.parametrize("words", [(), ("--dry",)])
def test_the_log_of_an_earlier_run_is_kept(words: tuple[str, ...], name: str, job_file: Path, tmp_path: Path) -> None:
    log = tmp_path / name
    log.write_text(dry_run(job_of(table(40))).log.render())
    (tmp_path / "run.csv.clock").write_text("entry,seconds\n")
    before = log.read_bytes()
    cell = write_cell(tmp_path, modbus(1))
    outcome = washboard("operate", job_file, "--cell", cell, "--log", tmp_path / "run.csv", *words)
    assert outcome.code == 2
    assert f"{name}: is the log of an earlier run" in outcome.err
    assert log.read_bytes() == before


@pytest.mark.slow
def test_a_dry_run_takes_the_place_of_a_dry_run_and_a_run_does_not(job_file: Path, tmp_path: Path) -> None:
    words = ("operate", job_file, "--cell", write_cell(tmp_path, modbus(1)), "--log", tmp_path / "run.csv")
    assert [washboard(*words, *more).code for more in (("--dry",), ("--dry",), ())] == [0, 0, 2]


@pytest.mark.parametrize("words", [(), ("--dry", "--live"), ("--live",)])
def test_an_operation_that_cannot_begin_leaves_no_log(words: tuple[str, ...], job_file: Path, tmp_path: Path) -> None:
    """Its controller does not answer, or another program has the port of the live view."""
    with socket.create_server(("127.0.0.1", 0)) as other:
        port = other.getsockname()[1]
        cell, log = write_cell(tmp_path, modbus(1)), tmp_path / "logs" / "run.csv"
        log.parent.mkdir()
        taken = (*words, *([str(port)] if "--live" in words else []))
        outcome = washboard("operate", job_file, "--cell", cell, "--log", log, *taken)
    assert outcome.code == 2, outcome.err
    assert [*log.parent.iterdir()] == []


def test_the_hal_file_of_a_cell_is_written(tmp_path: Path) -> None:
    outcome = washboard("operate", "--cell", "gantry", "--hal", tmp_path / "washboard.hal")
    assert outcome.code == 0, outcome.err
    assert "setp watchdog.timeout-0 0.1" in (tmp_path / "washboard.hal").read_text()


@pytest.mark.slow
@pytest.mark.parametrize("board", ["tiny", "smt-demo"])
def test_a_loop_turns_back_the_joint_that_turned_about_the_jet(board: str, tmp_path: Path) -> None:
    """The gantry's fourth axis; of an arm it is the last joint."""
    assert washboard("plan", board, "rinse-only", "-o", tmp_path / "a.wash").code in (0, 1)
    for cell in ("gantry", "cairo-bench"):
        done = washboard("operate", tmp_path / "a.wash", "--cell", cell, "--dry", "--board", board)
        assert done.code == 0, done.err
