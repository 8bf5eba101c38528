"""A language's layout keeps texts in quotes and comments as they are."""

import pytest

from programs.posts.layout import Layout, tidy

TIDY = Layout(comments="// (", single_blanks=True, comma=", ")


@pytest.mark.parametrize(
    ("line", "found"),
    [
        ("a  b,c", "a b, c"),
        ("a  b // c  d,e", "a b"),
        ('say "a // b,  c" d,e', 'say "a // b,  c" d, e'),
        ('say "a // b", "(" // c,d', 'say "a // b", "("'),
        ("msg  1,2 (x,  y)", "msg 1, 2 (x,  y)"),
        ("// c,d", "// c,d"),
        ('"open // text', '"open // text'),
        ("", ""),
    ],
)
def test_a_line_is_tidied_up_to_its_comment(line: str, found: str) -> None:
    assert tidy({"a": f"x\n{line}\ny"}, TIDY) == {"a": f"x\n{found}\ny\n"}
