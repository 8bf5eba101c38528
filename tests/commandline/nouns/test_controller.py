"""``washboard controller``: what a controller's programmer gets."""

import csv
import re
import shlex
import signal
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest
from command import contents, washboard
from model_controller import ModbusController, free_port, modbus, opcua
from operated import ALL_MET, DOOR, WATCHDOG_S, connect, dry_run, job_of, model_of, table, write_cell
from waiting import WAIT_S, wait_for

from robotcell.cell.load import read_cell
from robotcell.operate.interface import link_of, render_node_set


def test_the_registers_are_shown_and_written(tmp_path: Path) -> None:
    cell, file = write_cell(tmp_path, "{kind: modbus, host: h, orders_at: 1000, status_at: 400}"), tmp_path / "map.csv"
    outcome = washboard("controller", "map", cell, "-o", file)
    assert outcome.code == 0, outcome.err
    rows = list(csv.DictReader(file.read_text().splitlines()))
    assert {"1015": "Outputs.doRing", "400": "Epoch"}.items() <= {row["register"]: row["name"] for row in rows}.items()
    assert ("413", "2", "Inputs.diDoor") in {(row["register"], row["bit"], row["name"]) for row in rows}
    shown = " ".join(outcome.out.split())
    assert "1015 2 Int32 Outputs.doRing washboard 0 or 1, valve" in shown
    assert "413 2 bit Inputs.diDoor controller door_closed is met at 1" in shown


def test_the_nodes_of_a_cell_are_written_in_its_namespace(tmp_path: Path) -> None:
    link = "{kind: opcua, url: 'opc.tcp://h:1', namespace: 'urn:mine', object: Wash}"
    cell, file = write_cell(tmp_path, link), tmp_path / "map.xml"
    assert washboard("controller", "map", cell, "-o", file).code == 0
    loaded = read_cell(cell)
    assert file.read_text() == render_node_set(loaded, link_of(loaded, None))  # type: ignore[arg-type]
    assert "<Uri>urn:mine</Uri>" in file.read_text()
    assert 'NodeId="ns=1;s=Wash.Heartbeat"' in file.read_text()


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (("gantry",), "gantry.yaml: cell gantry is linked to LinuxCNC"),
        (("cairo-bench", "-o", "map.xml"), "a node set is of OPC UA, and the link is modbus. Give --link opcua"),
        (("cairo-bench", "-o", "map.txt"), "a map is .csv or .xml"),
        (("cairo-bench", "--link", "opcua", "-o", "map"), "a map is .csv or .xml"),
        (("none.yaml",), "none.yaml"),
    ],
)
def test_what_has_no_map_is_refused_and_nothing_is_written(
    words: tuple[str, ...], reason: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    outcome = washboard("controller", "map", *words)
    assert (outcome.code, outcome.out) == (2, "")
    assert reason in outcome.err
    assert contents(tmp_path) == {}


def test_an_order_too_long_for_modbus_has_no_registers(tmp_path: Path) -> None:
    cell = write_cell(tmp_path, "{kind: modbus, host: h}")
    more = "".join(f"    do{number}: {{kind: digital, number: {number}}}\n" for number in range(10, 70))
    cell.write_text(cell.read_text().replace("  outputs:\n", f"  outputs:\n{more}"))
    outcome = washboard("controller", "map", cell)
    assert outcome.code == 2
    assert "Modbus carries 120: use opcua" in outcome.err
    assert washboard("controller", "map", cell, "--link", "opcua").code == 0


@contextmanager
def simulated(folder: Path, *words: object) -> Iterator["subprocess.Popen[str]"]:
    code = "from commandline.start import main; main()"
    process = subprocess.Popen(
        [sys.executable, "-c", code, "controller", "simulate", *map(str, words)],
        stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=folder,
    )  # fmt: skip
    try:
        yield process
    finally:
        process.kill()
        process.communicate()


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["modbus", "opcua"])
def test_a_program_is_operated_on_the_simulated_controller_of_its_cell(kind: str, tmp_path: Path) -> None:
    cell, file = write_cell(tmp_path, opcua("opc.tcp://192.0.2.1:4840")), tmp_path / "board.csv"
    file.write_text(table(60, 30_000))
    with simulated(tmp_path, cell, "--port", "0", "--link", kind) as process:
        assert process.stdout is not None
        assert f"Serves {kind} at 127.0.0.1 port" in process.stdout.readline()
        program, *edit = shlex.split(process.stdout.readline())
        assert program == "washboard"
        assert process.stdout.readline() == "stopped, run 0, node 0, valves shut\n"  # it shows it before an order comes
        assert washboard(*(tmp_path / each if each.endswith("simulated.yaml") else each for each in edit)).code == 0
        outcome = washboard("operate", file, "--cell", tmp_path / "simulated.yaml", "--log", tmp_path / "run.csv")
        assert outcome.code == 0, outcome.out + outcome.err
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=WAIT_S)
    assert (process.returncode, err) == (0, "")
    assert (tmp_path / "run.csv").read_text() == dry_run(job_of(table(60, 30_000))).log.render()
    assert re.search(r"^running, run \d+, node \d+, doRing open$", out, re.MULTILINE)
    assert out.splitlines()[-1] == "Stopped."


@pytest.mark.slow
def test_a_line_changes_an_input_and_another_is_named(tmp_path: Path) -> None:
    port = free_port()
    cell = write_cell(tmp_path, modbus(port))
    with simulated(tmp_path, cell, "--port", port) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        process.stdout.readline()
        link = connect(job_of(table(5)), modbus(port))
        assert link.look().status.inputs == ALL_MET
        process.stdin.write("diDoor 0\ndiWindow 0\n")
        process.stdin.flush()
        wait_for(lambda: link.look().status.inputs == ALL_MET & ~(1 << DOOR), "the door")
        link.close()
        taken = washboard("controller", "simulate", cell, "--port", port)
        assert taken.code == 2
        assert f"no server can listen at 127.0.0.1 port {port}" in taken.err
        process.send_signal(signal.SIGTERM)
        _, err = process.communicate(timeout=WAIT_S)
    assert (process.returncode, err) == (128 + signal.SIGTERM, "give an input and its state, such as diBoard 0\n")


def test_an_address_of_another_machine_is_refused() -> None:
    outcome = washboard("controller", "simulate", "cairo-bench", "--host", "192.0.2.1")
    assert (outcome.code, outcome.out) == (2, "")
    assert "192.0.2.1" in outcome.err


@pytest.mark.slow
def test_rules_that_a_controller_keeps_and_breaks_are_listed(tmp_path: Path) -> None:
    model = model_of(job_of(table(5)), haste=1.0)
    controller = ModbusController(model)
    cell = write_cell(tmp_path, controller.link, WATCHDOG_S)
    try:
        kept = washboard("controller", "check", cell)
        model.stuck = True
        broken = washboard("controller", "check", cell)
    finally:
        controller.close()
    assert kept.code == 0, kept.out + kept.err
    assert broken.code == 1
    assert re.search(r"^watchdog +pass", kept.out, re.MULTILINE)
    assert re.search(r"^inputs +not testable +by hand: open the door", kept.out, re.MULTILINE)
    assert re.search(r"^stop +fail +a valve is still open after 0.1 s", broken.out, re.MULTILINE)


@pytest.mark.parametrize(
    ("words", "reason"),
    [
        (("gantry",), "gantry.yaml: cell gantry is linked to LinuxCNC"),
        (("SMALL",), "no controller answers at 127.0.0.1 port 1 (Modbus TCP)"),
    ],
)
def test_a_controller_that_cannot_be_checked_is_refused(words: tuple[str, ...], reason: str, tmp_path: Path) -> None:
    small = write_cell(tmp_path, modbus(1))
    outcome = washboard("controller", "check", *(small if word == "SMALL" else word for word in words))
    assert (outcome.code, outcome.out) == (2, "")
    assert reason in outcome.err
