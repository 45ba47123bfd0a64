"""Rows of words in sentences."""

from kinolab.errors import a_few, counted, row_of


def test_one_thing_has_no_plural() -> None:
    assert [counted(n, "step") for n in (0, 1, 2)] == ["0 steps", "1 step", "2 steps"]


def test_the_last_of_a_row_is_joined_by_a_word() -> None:
    assert [row_of("abc"[:n]) for n in range(4)] == ["", "a", "a and b", "a, b and c"]
    assert row_of((1, 2), "or") == "1 or 2"


def test_of_many_a_few_are_named_and_the_others_counted() -> None:
    assert a_few("abcd") == "a, b, c, d"
    assert a_few("abcdef", between="; ") == "a; b; c; d and 2 more"
    assert a_few((), 2) == ""
