"""An edit can be undone, a file is written whole, and nobody's work is overwritten unseen."""

import pytest

from recipes.errors import RecipeError
from webui.page.document import open_document


@pytest.fixture
def mine(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text("recipe: mine\nextends: smt-aqueous\n")
    return open_document(str(file))


def test_edits_are_undone_and_done_again_in_their_order(mine):
    texts = [mine.text, mine.text + "# one\n", mine.text + "# two\n"]
    document = mine.edited(texts[1]).edited(texts[2])
    assert document.dirty
    assert document.undone().text == texts[1]
    assert document.undone().undone().undone().text == texts[0]
    assert not document.undone().undone().dirty
    assert document.undone().undone().redone().redone().redone().text == texts[2]


def test_a_new_edit_forgets_what_was_undone(mine):
    document = mine.edited(mine.text + "# one\n").undone().edited(mine.text + "# two\n")
    assert document.redone() is document
    assert document.undone().text == mine.text


def test_the_same_text_is_no_edit(mine):
    assert mine.edited(mine.text) is mine


def test_saving_writes_the_file_and_notices_who_else_did(mine):
    document = mine.edited(mine.text + "# one\n")
    assert not document.changed_on_disk()
    mine.file.write_text("recipe: mine\nextends: low-standoff\n")
    assert document.changed_on_disk()
    saved = document.save()
    assert mine.file.read_text() == document.text
    assert not saved.dirty
    assert not saved.changed_on_disk()
    assert saved.undone().dirty, "what was saved is not what is shown now"


def test_a_file_that_is_gone_has_changed(mine):
    mine.file.unlink()
    assert mine.changed_on_disk()
    assert not mine.save().changed_on_disk()


def test_the_library_stays_as_it_is(tmp_path):
    document = open_document("smt-aqueous")
    assert document.belongs_to_library
    with pytest.raises(RecipeError, match="library"):
        document.save()
    copy = document.save_as(tmp_path / "house.yaml")
    assert not copy.belongs_to_library
    assert not copy.dirty
    assert copy.read().recipe.recipe == "house"
    assert "# What is sprayed." in copy.file.read_text()
    assert copy.undone().text == document.text
    with pytest.raises(RecipeError, match="there already"):
        document.save_as(tmp_path / "house.yaml")
