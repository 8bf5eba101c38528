"""The map of what reaches a part: multiples of what is needed, by hand, and a picture that is the same every time."""

from dataclasses import replace

import numpy as np
import pytest
from cleaning_report import small_report

from reports.pictures.reach_picture import draw_reach, times_needed


def test_multiples_count_run_off_and_repeats_and_never_hit_is_nothing() -> None:
    report = small_report()
    (wash,) = [
        (stage, exposure)
        for stage, exposure in zip(report.stages, report.exposures, strict=True)
        if (stage.use, stage.side) == ("wash", "top")
    ]
    times = times_needed(report, "top", "wash")
    limits = report.parameters.limits
    expected = wash[1].supply_mm / (limits.margin * limits.wash_volume_mm)
    hit = wash[1].volume_mm > 0
    np.testing.assert_allclose(times[hit], np.broadcast_to(expected, times.shape)[hit])
    assert not times[~hit].any()
    often = replace(report, stages=tuple(replace(stage, repeats=3) for stage in report.stages))
    np.testing.assert_allclose(times_needed(often, "top", "wash"), 3.0 * times)
    assert not times_needed(report, "bottom", "wash").any()


@pytest.mark.slow
def test_the_same_part_gives_the_same_picture_and_a_side_without_liquid_none() -> None:
    report = small_report()
    part = report.parts[0]
    picture = draw_reach(report, part)
    assert picture is not None
    assert picture == draw_reach(report, part)
    assert part.component in picture.alt
    assert draw_reach(replace(report, stages=(), exposures=()), part) is None
