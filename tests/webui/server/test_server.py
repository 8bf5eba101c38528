import socket
from contextlib import suppress
from pathlib import Path

import pytest

from boards.load import board_library, load_board
from recipes.errors import RecipeError
from webui.page.project import open_project
from webui.server.server import ServerError, free_port, open_session, serve


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


def test_what_the_command_line_names_is_read_again_and_nothing_beside_it(tmp_path: Path) -> None:
    project, own = tmp_path / "project", tmp_path / "own"
    project.mkdir()
    own.mkdir()
    (own / "base.yaml").write_text("recipe: base\nextends: rinse-only\n", "utf-8")
    (own / "other.yaml").write_text("recipe: other\nextends: rinse-only\n", "utf-8")
    (own / "mine.yaml").write_text("recipe: mine\nextends: base.yaml\n", "utf-8")
    (own / "card.tri").write_bytes(board_library()["tiny"].read_bytes())
    first = open_session(str(own / "card.tri"), str(own / "mine.yaml"))
    assert {path.name for path in first.opened} >= {"card.tri", "mine.yaml", "base.yaml"}
    server = serve(first, open_project(project), "127.0.0.1", 0)
    try:
        assert first.edited("recipe: mine\nextends: ./base.yaml\n").recipe.recipe == "mine"
        with pytest.raises(RecipeError, match=r"mine\.yaml:2: extends: .*other\.yaml: is outside the project folder"):
            first.edited("recipe: mine\nextends: other.yaml\n")
        assert load_board(own / "card.tri").name == "card"
    finally:
        server.stop()
    assert first.edited("recipe: mine\nextends: other.yaml\n").recipe.recipe == "mine"
