"""``washboard controller``: what a controller's programmer gets."""

import csv
from pathlib import Path

import pytest
from command import contents, washboard
from operated import write_cell

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
        (("gantry",), "cell gantry is linked to LinuxCNC"),
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
