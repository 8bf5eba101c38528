"""The hash of a JSON value's content."""

from hashlib import sha256

from specs.json import content_sha256


def test_the_order_of_keys_does_not_count_and_that_of_lists_does() -> None:
    assert content_sha256({"a": 1, "b": [1, 2]}) == content_sha256({"b": [1, 2], "a": 1})
    assert content_sha256({"a": 1, "b": [1, 2]}) != content_sha256({"a": 1, "b": [2, 1]})


def test_the_hash_is_that_of_compact_text() -> None:
    """So that anyone can compute it; letters beyond ASCII stand for themselves, in UTF-8."""
    assert content_sha256({"b": 0.5, "a": "größe"}) == sha256('{"a":"größe","b":0.5}'.encode()).hexdigest()
