"""The smallest board of the library with the recipe that comes first, planned once for all tests."""

from functools import cache
from pathlib import Path

from boards.load import load_board
from rulesengine.planning.pipeline import run
from webui.page.document import open_document
from webui.page.session import Session


@cache
def tiny_session() -> Session:
    board, document = load_board(Path("tiny")), open_document("smt-aqueous")
    loaded = document.read()
    return Session("tiny", board, document, loaded, run(loaded.recipe, board))
