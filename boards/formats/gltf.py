"""glTF 2.0, text and binary: its tree of nodes, and the triangles of its meshes."""

import json
import struct
from base64 import b64decode
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from boards.bounds import MOST_TRIANGLES
from boards.errors import MAX_BYTES, BoardError, read_bytes
from boards.formats.names import cause
from boards.formats.tree import DEEPEST, Node
from geometry.arrays import Triangles
from specs.confinement import find_beside
from specs.progress import Progress

_JSON, _BIN = 0x4E4F534A, 0x004E4942
_TRIANGLES, _STRIP, _FAN = 4, 5, 6
_COMPONENTS = {5120: "<i1", 5121: "<u1", 5122: "<i2", 5123: "<u2", 5125: "<u4", 5126: "<f4"}
_COLUMNS = {"SCALAR": 1, "VEC3": 3}
_MOST_REPEATS = 10_000
_TOO_MANY = f"holds more than {MOST_TRIANGLES:,} triangles, repeated meshes counted. Export it more coarsely."


def read_gltf(path: Path, _: Progress) -> tuple[Node, tuple[()]]:
    """Read a ``.gltf`` (with its ``.bin`` files) or ``.glb`` file.

    Raises:
        BoardError: not glTF 2.0, damaged, compressed, or a ``.bin`` is missing.
    """
    return parse_gltf(read_bytes(path), path), ()


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
            meshes = _decode_meshes(header, _read_buffers(header, chunk, path, data), path)
            return _build_tree(header, meshes, path)
    except BoardError:
        raise
    except Exception as reason:  # the header may hold anything anywhere
        message = f"cannot be read as glTF 2.0, the file is damaged or cut short ({cause(reason)}). Export it again."
        raise BoardError(message, file=path) from None


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


def _read_buffers(header: dict[str, Any], chunk: bytes, path: Path, data: bytes) -> list[bytes]:
    """Read every buffer: the binary chunk, data in the header itself, or a file beside it or below, each file once."""
    buffers: list[bytes] = []
    beside: dict[str, bytes] = {}
    for buffer in header.get("buffers", []):
        uri = buffer.get("uri")
        if uri is None:
            buffers.append(chunk)
        elif (begin := uri.find("base64,")) >= 0:
            buffers.append(b64decode(uri[begin + len("base64,") :]))
        else:
            try:
                if uri not in beside:
                    beside[uri] = read_bytes(find_beside(unquote(uri), path), "data file")
                    if sum(map(len, beside.values())) > MAX_BYTES:
                        raise ValueError(f"brings its data files to more than {MAX_BYTES:,} bytes")
                buffers.append(beside[uri])
            except (BoardError, ValueError) as reason:
                why = "cannot be read" if isinstance(reason, BoardError) else str(reason)
                message = f"its data file {uri[:80]!r} {why}. Put it beside the .gltf, or export a .glb."
                at = -1 if data[:4] == b"glTF" else data.find(uri.encode(errors="replace"))
                line = None if at < 0 else data.count(b"\n", 0, at) + 1
                raise BoardError(message, file=path, line=line) from reason
    return buffers


def _decode_meshes(header: dict[str, Any], buffers: list[bytes], path: Path) -> dict[int, tuple[Triangles, ...]]:
    """Decode every triangulated primitive; mesh index to (n, 3, 3) arrays in the mesh's own frame.

    No more than the positions and indices is read, each in place: what a file announces costs nothing.
    """
    meshes: dict[int, tuple[Triangles, ...]] = {}
    count = 0
    for index, mesh in enumerate(header.get("meshes", [])):
        decoded: list[Triangles] = []
        for primitive in mesh["primitives"]:
            decoded.append(_decode_primitive(header, buffers, primitive))
            count += len(decoded[-1])
            if count > MOST_TRIANGLES:
                raise BoardError(_TOO_MANY, file=path)
        meshes[index] = tuple(patches for patches in decoded if len(patches))
    return meshes


def _decode_primitive(header: dict[str, Any], buffers: list[bytes], primitive: dict[str, Any]) -> Triangles:
    """Triangles of one primitive, none where it is points or lines (glTF 2.0, 3.7.2.1)."""
    mode = primitive.get("mode", _TRIANGLES)
    vertices = _read_accessor(header, buffers, primitive["attributes"]["POSITION"], 3)
    if "indices" in primitive:
        indices = _read_accessor(header, buffers, primitive["indices"], 1)[:, 0].astype(np.int64)
    else:
        indices = np.arange(len(vertices))
    if mode == _TRIANGLES:
        faces = indices.reshape(-1, 3)
    elif mode == _STRIP:
        faces = np.column_stack([indices[:-2], indices[1:-1], indices[2:]])
        faces[1::2] = faces[1::2, [1, 0, 2]]  # every other one is wound the other way
    elif mode == _FAN:
        faces = np.column_stack([np.full(max(len(indices) - 2, 0), indices[:1].sum()), indices[1:-1], indices[2:]])
    else:
        return np.empty((0, 3, 3))
    return vertices[faces].astype(np.float64)


def _read_accessor(header: dict[str, Any], buffers: list[bytes], index: int, columns: int) -> NDArray[Any]:
    """Rows of an accessor where they lie in the buffer; numpy refuses what reaches beyond it."""
    accessor = header["accessors"][index]
    if "sparse" in accessor or "bufferView" not in accessor:
        raise ValueError("an accessor is sparse or has no data")
    if _COLUMNS[accessor["type"]] != columns:
        raise ValueError(f"an accessor is {accessor['type']}")
    view = header["bufferViews"][accessor["bufferView"]]
    kind = np.dtype(_COMPONENTS[accessor["componentType"]])
    begin = view.get("byteOffset", 0)
    data = memoryview(buffers[view["buffer"]])[begin : begin + view["byteLength"]]
    stride = view.get("byteStride", columns * kind.itemsize)
    shape, strides = (accessor["count"], columns), (stride, kind.itemsize)
    return np.ndarray(shape, kind, data, accessor.get("byteOffset", 0), strides)


def _build_tree(header: dict[str, Any], meshes: dict[int, tuple[Triangles, ...]], path: Path) -> Node:
    nodes: list[dict[str, Any]] = header.get("nodes", [])
    scenes: list[dict[str, Any]] = header.get("scenes", [])
    below = {child for node in nodes for child in node.get("children", [])}
    roots = (
        scenes[header.get("scene", 0)].get("nodes", []) if scenes else [i for i in range(len(nodes)) if i not in below]
    )
    left = {"nodes": 4 * len(nodes) + _MOST_REPEATS, "triangles": MOST_TRIANGLES}

    def build(index: int, parent: NDArray[np.float64], depth: int) -> Node:
        node = nodes[index]
        own = meshes.get(node.get("mesh", -1), ())
        left["nodes"] -= 1
        left["triangles"] -= sum(map(len, own))
        if depth > DEEPEST or left["nodes"] < 0:  # nodes that several others hold multiply at every level
            raise BoardError("the tree of its nodes never ends. Export it again.", file=path)
        if left["triangles"] < 0:
            raise BoardError(_TOO_MANY, file=path)
        matrix = parent @ _pose(node)
        product = str(header["meshes"][node["mesh"]].get("name", "")) if node.get("mesh", -1) >= 0 else ""
        placed = (patches @ matrix[:3, :3].T + matrix[:3, 3] for patches in own)
        # A mirroring pose turns the winding inside out.
        patches = tuple(own[:, ::-1] if np.linalg.det(matrix[:3, :3]) < 0.0 else own for own in placed)
        children = tuple(build(child, matrix, depth + 1) for child in node.get("children", []))
        return Node(str(node.get("name", "")), product, patches, children)

    return Node("", "", (), tuple(build(root, np.eye(4), 1) for root in roots))


def _pose(node: dict[str, Any]) -> NDArray[np.float64]:
    """Pose of a node in its parent, (4, 4): its matrix, or T · R · S (glTF 2.0, 3.5.3)."""
    from trimesh.transformations import quaternion_matrix

    if "matrix" in node:
        return np.array(node["matrix"], dtype=np.float64).reshape(4, 4).T
    x, y, z, w = node.get("rotation", (0.0, 0.0, 0.0, 1.0))
    pose = np.array(quaternion_matrix([w, x, y, z]), dtype=np.float64)
    pose[:3, :3] *= np.array(node.get("scale", (1.0, 1.0, 1.0)), dtype=np.float64)
    pose[:3, 3] = node.get("translation", (0.0, 0.0, 0.0))
    return pose
