"""Rays on their way from the nozzle to the faces that they hit, batch after batch."""

from collections.abc import Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor

import numpy as np
from numpy.typing import NDArray

from cleaning.exposure.accumulate import Poses, Rays, place_rays
from cleaning.jet.jet import Jet
from cleaning.jet.ray_samples import ray_samples_of
from cleaning.process.stages import Samples
from cleaning.surface.ray_scene import Scene, cast_rays


def poses_of(samples: Samples) -> Poses:
    """Lay samples out for compiled code."""
    seconds, tcp, axes = (
        np.ascontiguousarray(each, dtype=np.float64) for each in (samples.seconds, samples.tcp, samples.axes)
    )
    return Poses(seconds, tcp, axes, np.ascontiguousarray(samples.made_by, dtype=np.int64))


def rays_of(jet: Jet, per_sample: int) -> Rays:
    """Deal a jet's deck, so many rays to a sample."""
    deck = ray_samples_of(jet)
    columns = [deck.starts, *deck.directions.T, deck.strength, deck.inside, deck.front, deck.spread]
    return Rays(np.column_stack(columns).astype(np.float64), per_sample)


def trace_batches(
    rays: Rays, poses: Poses, scene: Scene, batches: Sequence[tuple[int, int]]
) -> Iterator[NDArray[np.int32]]:
    """Follow the rays of batch after batch of samples, given by first and last + 1.

    The next batch flies while the caller works on one. That changes no number: each batch is its own, and they come in
    order.

    Yields:
        (n,) face that each ray of a batch hits, or -1.
    """
    most = max((last - first for first, last in batches), default=0) * rays.per_sample
    # Two pairs of arrays: one is filled while embree reads the other.
    pairs = [(np.empty((most, 3), dtype=np.float32), np.empty((most, 3), dtype=np.float32)) for _ in range(2)]
    with ThreadPoolExecutor(max_workers=1) as worker:
        flying: Future[NDArray[np.int32]] | None = None
        for number, (first, last) in enumerate(batches):
            count = (last - first) * rays.per_sample
            origins, directions = (each[:count] for each in pairs[number % 2])
            place_rays(rays, poses, scene.origin, first, (origins, directions))
            ahead = worker.submit(cast_rays, scene, origins, directions)
            if flying is not None:
                yield flying.result()
            flying = ahead
        if flying is not None:
            yield flying.result()
