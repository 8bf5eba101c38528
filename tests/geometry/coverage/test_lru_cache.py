from geometry.coverage.route import LruCache


def test_a_result_that_was_put_is_got():
    cache = LruCache(4)
    assert cache.get("how many") is None
    assert cache.put("how many", 7) == 7
    assert cache.get("how many") == 7


def test_the_least_recently_used_result_is_dropped():
    cache = LruCache(2)
    cache.put("a", 1)
    cache.put("b", 2)
    assert cache.get("a") == 1
    cache.put("c", 3)
    assert [cache.get(name) for name in "abc"] == [1, None, 3]


def test_a_cleared_cache_is_empty():
    cache = LruCache(2)
    cache.put("a", 1)
    cache.clear()
    assert cache.get("a") is None
