from typing import Any

connected_component_labels: Any
face_adjacency: Any
