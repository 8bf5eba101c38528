"""How long to look for a good order."""

from geometry.arrays import Indices
from geometry.coverage.annealing import anneal
from geometry.coverage.route_exact import choose_ways, solve_small, start_order
from geometry.coverage.route_network import Network

MOST_EXACT = 9
"""Up to so many strokes the best order is found by dynamic programming"""
ROUNDS_PER_STROKE = 150
CHAIN_ROUNDS = 1000
HOT, COLD = 0.3, 0.02


def search_order(network: Network) -> Indices:
    """A good order of the strokes, the best one for a few.

    Returns:
        Strokes by position, from the start's to the end's.
    """
    count = len(network.first) - 3
    if count <= MOST_EXACT and (1 << count) * int(network.first[count]) ** 2 < 10_000_000:
        return solve_small(network)
    order, length = start_order(network)
    leg = max(1.0, length / (count + 1))
    rounds = ROUNDS_PER_STROKE * count
    chains = max(1, CHAIN_ROUNDS // count)
    best = choose_ways(network, order)[0]
    for chain in range(chains):
        found, _, _ = anneal(network, order, rounds // chains, HOT * leg, COLD * leg, chain)
        reached = choose_ways(network, found)[0]
        if reached <= best:
            best, order = reached, found
    return order
