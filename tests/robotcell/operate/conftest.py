"""Controllers that tests share."""

from collections.abc import Iterator

import pytest
from model_controller import OpcuaController
from operated import job_of, model_of, table


@pytest.fixture(scope="session")
def opcua_controller() -> Iterator[OpcuaController]:
    """An OPC UA server takes seconds to begin: one for all tests."""
    controller = OpcuaController(model_of(job_of(table(5))))
    yield controller
    controller.close()
