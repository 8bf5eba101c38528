"""Reads back what was drawn as binary glTF."""

import json
import struct

import numpy as np


def drawn(glb):
    """Corners (k, 3, 3) and their colours as they stand in the file."""
    length = struct.unpack_from("<I", glb, 12)[0]
    document, binary = json.loads(glb[20 : 20 + length]), glb[28 + length :]
    views = [binary[v["byteOffset"] : v["byteOffset"] + v["byteLength"]] for v in document["bufferViews"]]
    index = np.frombuffer(views[2], np.uint32)
    return (
        np.frombuffer(views[0], np.float32).reshape(-1, 3)[index].reshape(-1, 3, 3),
        np.frombuffer(views[1], np.uint8).reshape(-1, 4)[index].reshape(-1, 3, 4),
    )
