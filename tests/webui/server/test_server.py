import socket
from contextlib import suppress

import pytest

from webui.server.server import ServerError, free_port


def test_a_port_in_use_is_passed_over() -> None:
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        free = free_port("127.0.0.1", port)
    assert port < free < port + 100


def test_a_free_port_is_taken() -> None:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    assert free_port("127.0.0.1", port) == port


def test_the_last_port_has_none_after_it() -> None:
    with socket.socket() as taken:
        with suppress(OSError):  # then somebody else has it
            taken.bind(("127.0.0.1", 65535))
            taken.listen()
        with pytest.raises(ServerError, match=r"65535.*--port"):
            free_port("127.0.0.1", 65535)


@pytest.mark.parametrize("host", ["203.0.113.9", "no such host", "256.1.1.1", "a.b.invalid", "a..b", "x" * 300])
def test_a_host_that_is_not_this_machine_is_refused_at_once(host: str) -> None:
    with pytest.raises(ServerError, match="--host"):
        free_port(host, 8080)
