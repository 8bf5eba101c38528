from typing import Any

breadth_first_order: Any
connected_components: Any
dijkstra: Any
minimum_spanning_tree: Any
