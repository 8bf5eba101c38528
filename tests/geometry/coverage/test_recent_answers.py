from geometry.coverage.recent_answers import Memory


def test_what_was_kept_is_found():
    memory = Memory(4)
    assert memory.find("how many") is None
    assert memory.keep("how many", 7) == 7
    assert memory.find("how many") == 7


def test_what_was_not_asked_for_longest_is_forgotten():
    memory = Memory(2)
    memory.keep("a", 1)
    memory.keep("b", 2)
    assert memory.find("a") == 1
    memory.keep("c", 3)
    assert [memory.find(name) for name in "abc"] == [1, None, 3]


def test_nothing_is_remembered_after_forgetting():
    memory = Memory(2)
    memory.keep("a", 1)
    memory.forget()
    assert memory.find("a") is None
