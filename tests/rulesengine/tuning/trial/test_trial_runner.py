"""The estimate of how long tuning still takes: by the clock of analyses that were made, not of those that were read."""

from rulesengine.tuning.trial.trial_runner import Estimate


def test_time_is_that_of_the_analyses_made_so_far():
    now = [100.0]
    estimate = Estimate(lambda: now[0])
    assert estimate.describe(40) == ""
    estimate.shortening(0)
    now[0] += 1.0
    estimate.made(restored=True)
    assert estimate.describe(40) == "about 8 more"
    for seconds in (10.0, 20.0):
        now[0] += seconds
        estimate.made(restored=False)
    estimate.shortening(2)
    assert estimate.describe(40) == "about 6 more, 1:30"
    assert estimate.describe(3) == "about 3 more, 0:45"
    assert estimate.describe(0) == ""


def test_the_shortfall_is_expected_to_fall_on_as_it_did():
    estimate = Estimate(lambda: 0.0)
    estimate.improving((100.0, 10.0), 4, 24)  # a tenth in four: the next tenths take four each
    assert estimate.expected == 8 + 8
    estimate.improving((100.0, 100.0), 1, 24)
    assert estimate.expected == 24 + 8


def test_the_share_counts_what_is_expected_and_no_more_than_may_be_made():
    estimate = Estimate(lambda: 0.0)
    assert estimate.share(10, 30) == 0.25
    estimate.shortening(3)
    assert estimate.share(15, 25) == 0.75
    assert estimate.share(38, 2) == 0.95
