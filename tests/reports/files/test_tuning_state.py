"""The state of a tuning on disk: whole records are found again, others are cut off, and other states are refused."""

import pytest

from reports.files.tuning_state import StateError, check_output, open_state, state_place
from specs.output_file import OutputError

BOARD = {"board": "a1", "recipe": "b2", "version": "1"}


@pytest.fixture
def place(tmp_path):
    return state_place(tmp_path / "new.yaml")


@pytest.fixture
def kept(place):
    with open_state(place, BOARD, resume=False) as state:
        state.add("recipe: one\n", b"\x00first" * 100)
        state.add("recipe: two\n", b"")
        state.note_output(b"recipe: new\n")
    return place


def test_records_are_found_again(kept):
    with open_state(kept, BOARD, resume=True) as state:
        assert len(state) == 2
        assert state.find("recipe: one\n") == b"\x00first" * 100
        assert state.find("recipe: two\n") == b""
        assert state.find("recipe: three\n") is None
        state.add("recipe: three\n", b"3")
    with open_state(kept, BOARD, resume=True) as state:
        assert state.find("recipe: three\n") == b"3"


def test_wherever_writing_stopped_only_whole_records_are_read_and_more_can_follow(kept):
    whole = kept.read_bytes()
    first = whole.index(b"\n") + 1
    counts = set()
    for cut in range(first, len(whole), 7):
        kept.write_bytes(whole[:cut])
        with open_state(kept, BOARD, resume=True) as state:
            counts.add(len(state))
            assert state.find("recipe: one\n") in (None, b"\x00first" * 100)
            state.add("recipe: more\n", b"more")
        with open_state(kept, BOARD, resume=True) as state:
            assert state.find("recipe: more\n") == b"more"
    assert counts == {0, 1, 2}


def test_a_record_that_was_altered_is_not_read(kept):
    altered = bytearray(kept.read_bytes())
    altered[altered.index(b"first")] ^= 1
    kept.write_bytes(altered)
    with open_state(kept, BOARD, resume=True) as state:
        assert state.find("recipe: one\n") is None


@pytest.mark.parametrize("name", BOARD)
def test_a_state_of_something_else_is_refused_in_one_sentence_and_stays(kept, name):
    before = kept.read_bytes()
    with (
        pytest.raises(StateError, match=f"it is of another {name}") as refused,
        open_state(kept, BOARD | {name: "other"}, resume=True),
    ):
        pass
    assert "\n" not in str(refused.value)
    assert kept.read_bytes() == before


@pytest.mark.parametrize("content", [b"", b"\x00\xff", b"[]\n", b'{"washboard_tuning_state": 99}\n'])
def test_what_is_no_state_is_refused(place, content):
    place.write_bytes(content)
    with pytest.raises(StateError, match="no state of a tuning"), open_state(place, BOARD, resume=True):
        pass
    assert place.read_bytes() == content


def test_there_must_be_one_to_go_on_from(place):
    with pytest.raises(StateError, match="there is none"), open_state(place, BOARD, resume=True):
        pass
    assert not place.exists()


def test_a_new_tuning_forgets_the_old_one(kept):
    with open_state(kept, BOARD | {"board": "other"}, resume=False) as state:
        assert len(state) == 0


def test_two_tunings_do_not_share_a_state(kept):
    again = open_state(kept, BOARD, resume=False)
    with open_state(kept, BOARD, resume=True), pytest.raises(OutputError, match="another process writes it"), again:
        pass
    with open_state(kept, BOARD, resume=True) as state:
        assert len(state) == 2


def test_no_link_is_followed(kept, tmp_path):
    (tmp_path / "link").symlink_to(kept)
    with pytest.raises(OutputError), open_state(tmp_path / "link", BOARD, resume=True):
        pass


def test_only_a_recipe_as_the_tuning_left_it_is_written_over(kept, tmp_path):
    output = tmp_path / "new.yaml"
    with open_state(kept, BOARD, resume=True) as state:
        check_output(state, output)
        output.write_bytes(b"recipe: new\n")
        check_output(state, output)
        output.write_bytes(b"recipe: new\n# mine\n")
        with pytest.raises(OutputError, match="changed since"):
            check_output(state, output)
        state.remove()
        assert not kept.exists()
