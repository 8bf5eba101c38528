"""Shorten a route change by change until no change near to where it was disturbed makes it shorter."""

from geometry.compiled import inner
from geometry.coverage.tour import (
    ROOM,
    Network,
    State,
    Tour,
    Whole,
    at,
    do_swap,
    do_turn,
    do_way,
    leg,
    look_at,
    swap_change,
    touched,
    turn_change,
    undo_to,
)

LONGEST_MOVED = 3
"""Strokes that are moved together at most"""
MOST_DONE = 32
"""Room that one change needs in the undo log"""
UNREACHED = 1 << 60


@inner
def rejoin(
    network: Network, state: State, before: Whole, joint: tuple[Whole, Whole], after: Whole
) -> tuple[Whole, Whole, Whole]:
    """The best ways through two strokes that follow each other, between two that stay as they are.

    Returns:
        What they add to the length, at most 0, and the two ways.
    """
    first, second = network.stroke[joint[0]], network.stroke[joint[1]]
    old = leg(network, before, joint[0]) + leg(network, joint[0], joint[1]) + leg(network, joint[1], after)
    best, best_a, best_b = old, joint[0], joint[1]
    begin, end, onward = network.first[second], network.first[second + 1], state.cost[0]
    for b in range(begin, end):
        onward[b - begin] = leg(network, b, after)
    for a in range(network.first[first], network.first[first + 1]):
        reached = leg(network, before, a)
        if reached >= best:
            continue
        for b in range(begin, end):
            length = reached + leg(network, a, b) + onward[b - begin]
            if length < best:
                best, best_a, best_b = length, a, b
    return best - old, best_a, best_b


@inner
def try_turn(network: Network, tour: Tour, state: State, low: Whole, high: Whole) -> Whole:
    """Turn positions around, with the best ways at both joints, if that is shorter."""
    mirror = network.mirror
    change = turn_change(network, tour, low, high)
    joint = at(tour, low - 1), mirror[at(tour, high)]
    other = mirror[at(tour, low)], at(tour, high + 1)
    a, b, c, d = joint[0], joint[1], other[0], other[1]
    if high > low:
        saved, a, b = rejoin(network, state, at(tour, low - 2), joint, mirror[at(tour, high - 1)])
        change += saved
    if high > low + 1:
        saved, c, d = rejoin(network, state, mirror[at(tour, low + 1)], other, at(tour, high + 2))
        change += saved
    if change >= 0:
        return 0
    do_turn(network, tour, state, low, high)
    if high > low:
        do_way(network, tour, state, a)
        do_way(network, tour, state, b)
    if high > low + 1:
        do_way(network, tour, state, c)
        do_way(network, tour, state, d)
    touched(network, tour, state, low - 1, high + 2)
    for position in (low - 1, low, high, high + 1):
        look_at(tour, state, position)
    return change


@inner
def try_turns(network: Network, tour: Tour, state: State, p: Whole) -> Whole:
    """Put one of the near strokes next to the stroke at a position by turning around what lies between."""
    last, way = len(tour.place) - 2, at(tour, p)
    for follows in range(2):
        old = leg(network, way, at(tour, p + 1)) if follows else leg(network, at(tour, p - 1), way)
        for b in network.after[way] if follows else network.before[way]:
            if b < 0 or joint_length(network, way, b, follows) >= old:
                break
            q = tour.place[network.stroke[b]]
            low, high = min(p, q) + follows, max(p, q) - 1 + follows
            if low < 1 or high > last:
                continue
            change = try_turn(network, tour, state, low, high)
            if change < 0:
                return change
    return 0


@inner
def try_moves(network: Network, tour: Tour, state: State, p: Whole) -> Whole:
    """Move the run of up to three strokes that begins or ends at a position next to one of the near strokes."""
    last = len(tour.place) - 2
    if p < 1 or p > last:
        return 0
    for number in range(2 * LONGEST_MOVED - 1):
        low = p - number if number < LONGEST_MOVED else p
        high = p if number < LONGEST_MOVED else p + number - LONGEST_MOVED + 1
        if low < 1 or high > last:
            continue
        before, after = at(tour, low - 1), at(tour, high + 1)
        saved = leg(network, before, at(tour, low)) + leg(network, at(tour, high), after) - leg(network, before, after)
        for case in range(4):
            turned, follows = case >> 1, case & 1
            # the stroke at p has to be at that end of the moved run which meets the near stroke
            if saved > 0 and (low == high or (p == high) == (follows != turned)):
                change = try_gaps(network, tour, state, (low, high, saved), (p, turned, follows))
                if change < 0:
                    return change
    return 0


@inner
def try_gaps(
    network: Network, tour: Tour, state: State, run: tuple[Whole, Whole, Whole], joint: tuple[Whole, Whole, Whole]
) -> Whole:
    """Move a run to where the stroke at one of its ends meets a near one.

    Args:
        network: the strokes.
        tour: the route.
        state: the undo log.
        run: lowest and highest position, and what leaving them out saves.
        joint: the position that meets a near stroke, whether the run is turned, and whether the near stroke follows.
    """
    low, high, saved = run
    p, turned, follows = joint
    way = network.mirror[at(tour, p)] if turned else at(tour, p)
    first, end, skew = at(tour, low), at(tour, high), 0
    if turned:
        first, end, skew = network.mirror[end], network.mirror[first], tour.skew[high] - tour.skew[low]
    for b in network.after[way] if follows else network.before[way]:
        if b < 0 or joint_length(network, way, b, follows) >= saved:
            break
        gap = tour.place[network.stroke[b]] - follows
        if low - 1 <= gap <= high or gap < 0 or gap > len(tour.place) - 2:
            continue
        before, after = at(tour, gap), at(tour, gap + 1)
        if low == high:
            first = best_between(network, before, tour.order[p], after)
            end = first
        change = leg(network, before, first) + leg(network, end, after) - leg(network, before, after) + skew - saved
        if change < state.slack:
            begun = state.mark[2]
            lowest, cut, highest = do_move(network, tour, state, (low, high, gap), (first, turned))
            if may_shorten(network, tour, state, (lowest, cut, highest + 1), lowest, change):
                change = accept_or_undo(network, tour, state, (begun, lowest, cut, highest), change)
            else:
                undo_to(network, tour, state, begun, (lowest - 2, highest + 4))
                change = 0
            if change < 0:
                return change
    return 0


@inner
def joint_length(network: Network, way: Whole, near: Whole, follows: Whole) -> Whole:
    """Micrometres between a way and a near one that follows or comes before."""
    return leg(network, way, near) if follows else leg(network, near, way)


@inner
def do_move(
    network: Network, tour: Tour, state: State, what: tuple[Whole, Whole, Whole], how: tuple[Whole, Whole]
) -> tuple[Whole, Whole, Whole]:
    """Move positions low to high between gap and gap + 1, with the way through the first, perhaps turned around.

    Returns:
        Where the two runs that were swapped for this are now: lowest position, beginning of the second, highest.
    """
    low, high, gap = what
    first, turned = how
    length = high - low + 1
    if gap > high:
        do_swap(network, tour, state, low, high, gap)
        high, p = gap, gap - length + 1
        cut = p
    else:
        do_swap(network, tour, state, gap + 1, low - 1, high)
        low, p = gap + 1, gap + 1
        cut = low + length
    if length == 1:
        do_way(network, tour, state, first)
    elif turned:
        do_turn(network, tour, state, p, p + length - 1)
    touched(network, tour, state, low, high + 1)
    return low, cut, high


@inner
def best_between(network: Network, before: Whole, stroke: Whole, after: Whole) -> Whole:
    """The best way through a stroke between two others."""
    best, best_way = UNREACHED, -1
    for way in range(network.first[stroke], network.first[stroke + 1]):
        length = leg(network, before, way) + leg(network, way, after)
        if length < best:
            best, best_way = length, way
    return best_way


@inner
def try_swaps(network: Network, tour: Tour, state: State, p: Whole) -> Whole:
    """Put a near stroke behind another by swapping two runs of any length, each in its own sense."""
    if p > len(tour.place) - 2:
        return 0
    way, following = at(tour, p), at(tour, p + 1)
    old = leg(network, way, following)
    for b in network.after[way]:
        if b < 0 or leg(network, way, b) >= old:
            break
        q = tour.place[network.stroke[b]]
        gained = old - leg(network, way, b) + leg(network, at(tour, q - 1), at(tour, q))
        for c in network.before[following]:
            if c < 0 or leg(network, c, following) >= gained:
                break
            low, middle, high = runs_between(tour, p, q, tour.place[network.stroke[c]])
            if low > high:
                continue
            change = swap_change(network, tour, low, middle, high)
            cut = low + high - middle
            if change < state.slack and may_shorten(network, tour, state, (low, cut, high + 1), middle + 1, change):
                begun = state.mark[2]
                do_swap(network, tour, state, low, middle, high)
                touched(network, tour, state, low, high + 1)
                change = accept_or_undo(network, tour, state, (begun, low, cut, high), change)
                if change < 0:
                    return change
    return 0


@inner
def runs_between(tour: Tour, p: Whole, q: Whole, k: Whole) -> tuple[Whole, Whole, Whole]:
    """Lowest position, end of the first and of the second run whose swap puts q behind p and p + 1 behind k.

    Returns:
        (1, 0, 0) where there is no such swap.
    """
    if p + 1 < q <= k < len(tour.place) - 1:
        return p + 1, q - 1, k
    if 1 <= q <= k < p:
        return q, k, p
    if k < p and p + 1 < q:
        return k + 1, p, q - 1
    return 1, 0, 0


@inner
def accept_or_undo(
    network: Network, tour: Tour, state: State, where: tuple[Whole, Whole, Whole, Whole], change: Whole
) -> Whole:
    """Go better ways around the joints of two swapped runs; take all back if the route has not become shorter."""
    begun, low, cut, high = where
    if state.slack > 0:
        for joint in (low, cut, high + 1):
            change += mend(network, tour, state, joint - 1)
        for joint in (low, cut, high + 1):
            change += mend(network, tour, state, joint - 2)
            change += mend(network, tour, state, joint)
    if change >= 0:
        undo_to(network, tour, state, begun, (low - 2, high + 4))
        return 0
    for joint in (low, cut, high + 1):
        look_at(tour, state, joint - 1)
        look_at(tour, state, joint)
    return change


@inner
def may_shorten(
    network: Network, tour: Tour, state: State, joints: tuple[Whole, Whole, Whole], second: Whole, change: Whole
) -> bool:
    """Whether a change of the length would be below 0 with the best ways through the two strokes beside each joint.

    No mending of joints makes a route shorter than this dynamic programme, which is less work where it is in vain.

    Args:
        network: The strokes.
        tour: The route.
        state: Has the slack; without one nothing is mended.
        joints: Ascending positions behind each joint, of the tour as it becomes.
        second: Position from which on the second of two runs stands that will be swapped; else that of the first joint.
        change: Of the length, without other ways.
    """
    if state.slack <= 0:
        return change < 0
    cost, row, least = state.cost, 0, UNREACHED
    last, done = len(tour.place) - 1, max(joints[0] - 3, 0)
    before = low = at(tour, done)
    cost[0, 0], high = 0, low + 1
    for number in range(3):
        joint, following = joints[number], joints[number + 1] if number < 2 else last + 3
        if joint - 3 > done:  # the way between is fixed and stays
            done = joint - 3
            before = low = at(tour, position_now(joints, second, done))
            high = low + 1
        for position in range(done + 1, min(joint + 2, last) + 1):
            stroke = tour.order[position_now(joints, second, position)]
            begin, end = tour.way[stroke], tour.way[stroke] + 1
            change -= leg(network, before, begin)
            before = begin
            if position <= joint + 1 or position >= following - 2:
                begin, end = network.first[stroke], network.first[stroke + 1]
            for b in range(begin, end):
                nearest = UNREACHED
                for a in range(low, high):
                    nearest = min(nearest, cost[row, a - low] + leg(network, a, b))
                cost[1 - row, b - begin] = nearest
            low, high, row, done = begin, end, 1 - row, position
    for a in range(high - low):
        least = min(least, cost[row, a])
    return change + least < 0


@inner
def position_now(joints: tuple[Whole, Whole, Whole], second: Whole, position: Whole) -> Whole:
    """Where a position of the tour is before two runs are swapped, of which the second begins at ``second``."""
    low, cut, after = joints
    if second == low or position < low or position >= after:
        return position
    return position + second - low if position < cut else position - cut + low


@inner
def mend(network: Network, tour: Tour, state: State, p: Whole) -> Whole:
    """Go the best ways through the stroke at a position and the next one."""
    if p < 1 or p > len(tour.place) - 2:
        return 0
    saved, a, b = rejoin(network, state, at(tour, p - 1), (at(tour, p), at(tour, p + 1)), at(tour, p + 2))
    if saved < 0:
        do_way(network, tour, state, a)
        do_way(network, tour, state, b)
        touched(network, tour, state, p, p + 2)
    return saved


@inner
def try_ways(network: Network, tour: Tour, state: State, p: Whole) -> Whole:
    """Go better ways through the stroke at a position and the next one."""
    saved = mend(network, tour, state, p)
    if saved < 0:
        for position in range(p - 1, p + 3):
            look_at(tour, state, position)
    return saved


@inner
def shorten_at(network: Network, tour: Tour, state: State, p: Whole) -> Whole:
    """Make the first change found at a position that shortens the route."""
    change = try_ways(network, tour, state, p)
    if change == 0:
        change = try_turns(network, tour, state, p)
    if change == 0:
        change = try_moves(network, tour, state, p)
    if change == 0:
        change = try_swaps(network, tour, state, p)
    return change


@inner
def descend(network: Network, tour: Tour, state: State) -> Whole:
    """Look at the queued strokes, and at those that changes touch, until nothing near them makes the route shorter.

    It pauses when the undo log is full.

    Returns:
        What this added to the length in micrometres, at most 0.
    """
    gained = 0
    while state.mark[1] > 0 and state.mark[2] < ROOM - MOST_DONE:
        stroke = state.queue[state.mark[0]]
        state.mark[0] = (state.mark[0] + 1) % len(state.queue)
        state.mark[1] -= 1
        state.waiting[stroke] = 0
        change = -1
        while change < 0 and state.mark[2] < ROOM - MOST_DONE:
            change = shorten_at(network, tour, state, tour.place[stroke])
            gained += change
    return gained
