"""What can collide in a URDF: boxes, cylinders, spheres and meshes of its links."""

from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from robotcell.robot.meshes import cylinder_triangles, read_mesh
from robotcell.robot.poses import pose
from robotcell.robot.robot import Body, Box, Capsule, Mesh, Poses, Shape
from robotcell.robot.xml_tree import Element


def read_bodies(link: Element, T_carrier_link: Poses) -> list[Body]:
    """Read the collision bodies of a link; each is named after the link unless it has a name of its own.

    Raises:
        CellError: a shape is not known, or its mesh cannot be read.
    """
    return [
        Body(
            each.attributes.get("name", link.text("name")),
            _read_shape(each.need("geometry")),
            T_carrier_link @ read_origin(each),
        )
        for each in link.all("collision")
    ]


def read_origin(element: Element) -> Poses:
    """Read the (4, 4) pose of an element's <origin>; the identity if it has none."""
    origin = element.first("origin")
    if origin is None:
        return np.eye(4)
    xyz, rpy = (read_numbers(origin, name, 3) if name in origin.attributes else np.zeros(3) for name in ("xyz", "rpy"))
    return pose(xyz.tolist(), rpy.tolist())


def read_numbers(element: Element, name: str, count: int) -> NDArray[np.float64]:
    """Read an attribute of ``count`` numbers.

    Raises:
        CellError: it is missing, or holds something else.
    """
    text = element.text(name)
    try:
        numbers = np.array([float(word) for word in text.split()])
    except ValueError:
        numbers = np.empty(0)
    if len(numbers) != count or not np.isfinite(numbers).all():
        raise element.error(f"has {name}={text[:40]!r}; it takes {count} finite numbers")
    return numbers


def _read_shape(geometry: Element) -> Shape:
    if len(geometry.children) != 1:
        raise geometry.error(f"holds {len(geometry.children)} shapes; it takes one")
    shape = geometry.children[0]
    match shape.tag:
        case "box":
            x, y, z = _sizes(shape, "size", 3)
            return Box((x, y, z))
        case "sphere":
            return Capsule(_sizes(shape, "radius", 1)[0], 0.0)
        case "cylinder":
            return Mesh(cylinder_triangles(_sizes(shape, "radius", 1)[0], _sizes(shape, "length", 1)[0]))
        case "mesh":
            scale = read_numbers(shape, "scale", 3) if "scale" in shape.attributes else np.ones(3)
            return Mesh(read_mesh(_find_mesh(shape)) * scale)
        case _:
            raise shape.error("is not a shape that is known: box, sphere, cylinder, mesh")


def _sizes(shape: Element, name: str, count: int) -> list[float]:
    numbers = read_numbers(shape, name, count)
    if (numbers <= 0).any():
        raise shape.error(f"has {name}={shape.text(name)!r}; sizes are above 0")
    return numbers.tolist()


def _find_mesh(shape: Element) -> Path:
    """Find a mesh beside the URDF; ``package://`` means the URDF's folder or the one that holds it."""
    name = shape.text("filename")
    folder = shape.file.parent.resolve()
    folders, inside = [folder], name
    if name.startswith("package://"):
        inside = name.removeprefix("package://").partition("/")[2]
        folders.append(folder.parent)
    elif "://" in name or Path(name).is_absolute():
        raise shape.error(f"names {name!r}; give a path from the URDF's folder, or package://...")
    if "\0" in inside:
        raise shape.error(f"names {name!r}, which cannot be a file")
    for each in folders:
        file = (each / inside).resolve()
        if not file.is_relative_to(each):
            raise shape.error(f"names {name!r}, which is outside the URDF's folder; copy it there")
        if file.is_file():
            return file
    looked = " or ".join(str(each / inside) for each in folders)
    raise shape.error(f"names {name!r}, which is not there: no file {looked}")
