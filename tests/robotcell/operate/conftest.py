"""Controllers that tests share."""

import gc
from collections.abc import Iterator

import pytest
from model_controller import OpcuaController
from operated import job_of, model_of, table


@pytest.fixture(autouse=True)
def no_collections() -> Iterator[None]:
    """A controller, which runs in this process here, has no collections of garbage that stop it."""
    gc.disable()
    yield
    gc.enable()


@pytest.fixture(scope="session")
def opcua_controller() -> Iterator[OpcuaController]:
    """An OPC UA server takes seconds to begin: one for all tests."""
    controller = OpcuaController(model_of(job_of(table(5))))
    gc.collect()
    gc.freeze()  # a controller has no collections that stop it; of the server's half a million objects they are long
    yield controller
    gc.unfreeze()
    controller.close()
