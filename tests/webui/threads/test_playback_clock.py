import threading

import pytest

from webui.threads.threads import Player


@pytest.fixture
def drawn():
    return []


@pytest.fixture
def player(drawn):
    assert until(lambda: not players())  # of other tests: they end when they wake up next
    player = Player(drawn.append)
    yield player
    player.pause()


def players():
    return [thread for thread in threading.enumerate() if thread.name == "washboard-player"]


def until(holds, tries=4000):
    pause = threading.Event()
    for _ in range(tries):
        if holds():
            return True
        pause.wait(0.01)
    return False


def test_time_runs_forwards_to_the_end_and_the_thread_ends(player, drawn):
    player.load(1.0)
    player.rate = 50.0
    player.play()
    assert until(lambda: not player.playing)
    assert drawn == sorted(drawn)
    assert drawn[-1] == player.now_s == 1.0
    assert until(lambda: not players())


def test_a_pause_holds_the_time(player, drawn):
    player.load(100.0)
    player.play()
    assert until(lambda: player.now_s > 0)
    player.pause()
    assert until(lambda: not players())
    held = player.now_s
    assert not until(lambda: player.now_s != held, tries=10)


def test_it_begins_again_at_the_end(player):
    player.load(10.0)
    player.seek(10.0)
    player.play()
    assert player.now_s < 10.0


def test_playing_twice_runs_one_thread(player):
    player.load(100.0)
    player.play()
    player.play()
    assert len(players()) == 1


def test_another_program_keeps_the_time_that_it_has_and_stops(player, drawn):
    player.load(100.0)
    player.seek(40.0)
    player.play()
    player.load(50.0)
    assert not player.playing
    assert 40.0 <= player.now_s <= 50.0
    player.load(30.0)
    assert player.now_s == drawn[-1] == 0.0


def test_moments_outside_are_the_ends(player):
    player.load(10.0)
    player.seek(-5.0)
    assert player.now_s == 0.0
    player.seek(50.0)
    assert player.now_s == 10.0


def test_nothing_plays_nothing(player):
    player.play()
    assert not player.playing
