"""glTF 2.0, text and binary: the tree of nodes is walked here, trimesh decodes the meshes."""

import json
import struct
from io import BytesIO
from pathlib import Path
from typing import Any, cast
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from boards.errors import BoardError
from boards.formats.names import cause
from boards.formats.tree import DEEPEST, Node
from geometry.arrays import Triangles

_JSON, _BIN = 0x4E4F534A, 0x004E4942
_IN_FILE = "binary chunk of the file"


def read_gltf(path: Path) -> Node:
    """Read a ``.gltf`` (with its ``.bin`` files) or ``.glb`` file.

    Raises:
        BoardError: not glTF 2.0, damaged, compressed, or a ``.bin`` is missing.
    """
    return parse_gltf(path.read_bytes(), path)


def parse_gltf(data: bytes, path: Path) -> Node:
    """Turn the content of a glTF file into its tree, in the file's units; ``path`` is for messages and ``.bin`` files.

    Raises:
        BoardError: as ``read_gltf``.
    """
    try:
        with np.errstate(all="ignore"):  # numbers that overflow are refused later, with the name of their part
            header, chunk = _unpack(data)
            for name in header.get("extensionsRequired", []):
                if "compression" in name or "quantization" in name:
                    raise BoardError(f"uses {name}, which is not read here. Export it without compression.", file=path)
            meshes = _decode_meshes(header, chunk, path)
            return _build_tree(header, meshes, path)
    except BoardError:
        raise
    except Exception as reason:  # the header may hold anything anywhere, and trimesh does not check it
        message = f"cannot be read as glTF 2.0, the file is damaged or cut short ({cause(reason)}). Export it again."
        raise BoardError(message, file=path) from reason


def _unpack(data: bytes) -> tuple[dict[str, Any], bytes]:
    """Split a file into its JSON header and its binary chunk."""
    if data[:4] != b"glTF":
        return json.loads(data.decode("utf-8-sig")), b""
    length = struct.unpack_from("<I", data, 8)[0]
    if length > len(data):
        raise ValueError(f"{length} bytes announced, {len(data)} there")
    chunks: dict[int, bytes] = {}
    start = 12
    while start + 8 <= length:
        size, kind = struct.unpack_from("<II", data, start)
        chunks.setdefault(kind, data[start + 8 : start + 8 + size])
        start += 8 + size
    return json.loads(chunks[_JSON].decode("utf-8")), chunks.get(_BIN, b"")


class _Buffers(dict[str, bytes]):
    """Gives trimesh its buffers by name: the binary chunk, or a file beside the header."""

    def __init__(self, chunk: bytes, path: Path) -> None:
        super().__init__({_IN_FILE: chunk})
        self._path = path

    def __missing__(self, uri: str) -> bytes:
        beside = self._path.parent / unquote(uri)
        try:
            return beside.read_bytes()
        except (OSError, ValueError) as reason:
            message = f"its data file {uri!r} cannot be read. Put it beside the .gltf, or export a .glb."
            raise BoardError(message, file=self._path) from reason


def _decode_meshes(header: dict[str, Any], chunk: bytes, path: Path) -> dict[int, tuple[Triangles, ...]]:
    """Decode every triangulated primitive; mesh index to (n, 3, 3) arrays in the mesh's own frame.

    Names, nodes, materials and pictures are kept from trimesh: it would make names unique, and read pictures.
    """
    from trimesh.exchange.gltf import load_gltf

    primitives: list[dict[str, Any]] = []
    owner: dict[str, int] = {}
    for index, mesh in enumerate(header.get("meshes", [])):
        for primitive in mesh["primitives"]:
            name = f"primitive-{len(owner)}"
            owner[name] = index
            plain = {key: primitive[key] for key in ("indices", "mode") if key in primitive}
            plain["attributes"] = {"POSITION": primitive["attributes"]["POSITION"]}
            primitives.append({"name": name, "primitives": [plain]})
    buffers = [{"uri": _IN_FILE, **buffer} for buffer in header.get("buffers", [])]
    keep = ("accessors", "bufferViews", "asset")
    bare = {**{key: header[key] for key in keep if key in header}, "buffers": buffers, "meshes": primitives}
    loaded = load_gltf(BytesIO(json.dumps(bare).encode()), resolver=cast(Any, _Buffers(chunk, path)))
    meshes: dict[int, list[Triangles]] = {}
    for name, content in cast(dict[str, Any], loaded["geometry"]).items():
        if "faces" in content and len(content["faces"]):
            vertices = np.asarray(content["vertices"], dtype=np.float64)
            meshes.setdefault(owner[name], []).append(vertices[np.asarray(content["faces"], dtype=np.int64)])
    return {index: tuple(arrays) for index, arrays in meshes.items()}


def _build_tree(header: dict[str, Any], meshes: dict[int, tuple[Triangles, ...]], path: Path) -> Node:
    from trimesh.transformations import quaternion_matrix

    nodes: list[dict[str, Any]] = header.get("nodes", [])
    scenes: list[dict[str, Any]] = header.get("scenes", [])
    below = {child for node in nodes for child in node.get("children", [])}
    roots = (
        scenes[header.get("scene", 0)].get("nodes", []) if scenes else [i for i in range(len(nodes)) if i not in below]
    )

    def build(index: int, parent: NDArray[np.float64], depth: int) -> Node:
        if depth > DEEPEST:
            raise BoardError("the tree of its nodes never ends. Export it again.", file=path)
        node = nodes[index]
        if "matrix" in node:  # its pose in its parent (glTF 2.0, 3.5.3), or T · R · S
            pose = np.array(node["matrix"], dtype=np.float64).reshape(4, 4).T
        else:
            x, y, z, w = node.get("rotation", (0.0, 0.0, 0.0, 1.0))
            pose = np.array(quaternion_matrix([w, x, y, z]), dtype=np.float64)
            pose[:3, :3] *= np.array(node.get("scale", (1.0, 1.0, 1.0)), dtype=np.float64)
            pose[:3, 3] = node.get("translation", (0.0, 0.0, 0.0))
        matrix = parent @ pose
        mesh = node.get("mesh", -1)
        product = str(header["meshes"][mesh].get("name", "")) if mesh >= 0 else ""
        placed = (patches @ matrix[:3, :3].T + matrix[:3, 3] for patches in meshes.get(mesh, ()))
        # A mirroring pose turns the winding inside out.
        patches = tuple(own[:, ::-1] if np.linalg.det(matrix[:3, :3]) < 0.0 else own for own in placed)
        children = tuple(build(child, matrix, depth + 1) for child in node.get("children", []))
        return Node(str(node.get("name", "")), product, patches, children)

    return Node("", "", (), tuple(build(root, np.eye(4), 1) for root in roots))
