"""Nodes over real servers: their order is kept, none is lost, none comes twice, and every digit arrives."""

import csv
from collections.abc import Iterator

import pytest
from model_controller import ModbusController, OpcuaController, Received, modbus, opcua
from operated import connect, dry_run, job_of, looped, model_of, perform, small_cell, table, write_whole

from robotcell.operate.handshake import OperateError
from robotcell.operate.links.opening import LINKS
from robotcell.operate.log import replay
from robotcell.operate.nodes import Job

MANY = 10_000


@pytest.fixture
def modbus_controller() -> Iterator[ModbusController]:
    controller = ModbusController(model_of(job_of(table(5))))
    yield controller
    controller.close()


def assert_all_received(job: Job, text: str, received: list[Received]) -> None:
    """What the controller received is the table: every row once, in order, to the last digit."""
    rows = [line for line in text.splitlines() if not line.startswith("#")][1:]
    assert [each.sequence for each in received] == list(range(1, len(rows) + 1))
    for each, row in zip(received, csv.reader(rows), strict=True):
        assert [str(each.number), *(write_whole(joint, 5) for joint in each.joints)] == [row[0], *row[2:8]]
    assert [each.lasts_us for each in received] == [node.lasts_us for node in job.nodes]
    assert [each.outputs for each in received] == [node.outputs for node in job.nodes]


@pytest.mark.slow
def test_ten_thousand_nodes_over_modbus(modbus_controller: ModbusController) -> None:
    text = table(MANY)
    job = job_of(text)
    done = perform(job, connect(job, modbus_controller.link))
    assert done.operation.state == "end", done.operation.reason
    assert_all_received(job, text, modbus_controller.model.received)
    assert done.log.render() == dry_run(job).log.render()
    assert [on for _, on in modbus_controller.model.switched] == [True, False]


@pytest.mark.slow
def test_nodes_over_opcua(opcua_controller: OpcuaController) -> None:
    """Ten thousand of them are in benchmarks/operate.py, which counts them too: they take a quarter of a minute."""
    text = table(MANY // 5, step_us=20_000)
    job = job_of(text)
    opcua_controller.model = model_of(job)
    done = perform(job, connect(job, opcua_controller.link))
    assert done.operation.state == "end", done.operation.reason
    assert_all_received(job, text, opcua_controller.model.received)
    assert done.log.render() == dry_run(job).log.render()


def test_an_operation_by_the_clock_of_the_controller(modbus_controller: ModbusController) -> None:
    job = job_of(table(60, step_us=2000))
    modbus_controller.model = model_of(job, haste=1.0)
    done = perform(job, connect(job, modbus_controller.link))
    assert done.operation.state == "end", done.operation.reason
    (on, off) = (seconds for seconds, _ in modbus_controller.model.switched)
    assert off - on >= 0.9 * 0.002 * (58 - 3)  # the controller's own time, not that of the link


def test_a_controller_without_function_23_takes_orders_by_two_requests(modbus_controller: ModbusController) -> None:
    job = job_of(table(60))
    modbus_controller.model = model_of(job, at_once=False)
    done = perform(job, connect(job, modbus_controller.link))
    assert done.operation.state == "end", done.operation.reason
    assert [each.number for each in modbus_controller.model.received] == list(range(1, 61))


def test_a_loop_that_never_reaches_its_quantity_is_unmet(modbus_controller: ModbusController) -> None:
    job = job_of(looped())
    model = modbus_controller.model = model_of(job, readings=(450_000,))
    done = perform(job, connect(job, modbus_controller.link))
    assert done.operation.state == "end", done.operation.reason
    assert [each.number for each in model.received] == [1, 2, 3, 4, 3, 4, 3, 4, 5, 6]
    assert done.operation.unmet == ("resistivity_mohm_cm 0.9 of 1 after 3 turns",)
    assert replay(done.log.render(), "run.csv")[-1] == done.operation


def test_a_loop_whose_sensor_the_cell_has_not_is_refused_at_the_start() -> None:
    job = job_of(looped("turbidity_ntu"))
    with pytest.raises(OperateError, match="node 2 begins a loop until turbidity_ntu is 1, and cell small has no such"):
        dry_run(job)


def test_a_loop_follows_the_reading_of_its_sensor(modbus_controller: ModbusController) -> None:
    job = job_of(looped())
    model = model_of(job, readings=(499_999,))  # scale 2: 0.999998 of 1 until the second turn is done

    def wash(sequence: int) -> None:
        if sequence == 6:
            model.readings = (500_000,)

    model.at_node = wash
    modbus_controller.model = model
    done = perform(job, connect(job, modbus_controller.link))
    assert done.operation.state == "end", done.operation.reason
    assert [each.number for each in model.received] == [1, 2, 3, 4, 3, 4, 5, 6]


def test_a_controller_that_does_not_answer_is_named() -> None:
    job = job_of(table(5))
    with pytest.raises(OperateError, match=r"no controller answers at 127\.0\.0\.1 port 1 \(Modbus TCP\)"):
        connect(job, modbus(1))


@pytest.mark.slow
def test_an_object_that_a_server_lacks_is_named(opcua_controller: OpcuaController) -> None:
    job = job_of(table(5))
    link = f"{{kind: opcua, url: '{opcua_controller.url}', object: Other}}"
    with pytest.raises(OperateError, match="has the object Other of urn:washboard"):
        connect(job, link)


@pytest.mark.parametrize("module", ["pymodbus", "asyncua"])
def test_a_missing_extra_is_one_sentence(module: str, monkeypatch: pytest.MonkeyPatch) -> None:
    import sys

    for name in [each for each in sys.modules if each.split(".")[0] == module]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, module, None)
    link = modbus(1) if module == "pymodbus" else opcua("opc.tcp://127.0.0.1:1")
    with pytest.raises(OperateError, match=r"needs `pip install washboard\[operate\]`"):
        connect(job_of(table(5)), link)


def test_every_kind_of_link_that_a_cell_can_name_can_be_opened() -> None:
    kinds = small_cell().spec.model_json_schema()["$defs"]["OperateSpec"]["properties"]["link"]["discriminator"]
    assert set(kinds["mapping"]) == set(LINKS)
