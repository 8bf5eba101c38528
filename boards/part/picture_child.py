"""What Pillow does to a picture, in a process of its own: imports nothing that takes time."""

import io

MAX_PIXELS = 25_000_000
_DAMAGED = "it is no PNG or PGM picture, or a damaged one. Export it again."


def decode_grey(data: bytes) -> bytes:
    """Decode a PNG or PGM picture to its greys, or to its opacity where that differs.

    Returns:
        A line ``MODE WIDTH HEIGHT`` with the mode of Pillow, and the rows of the picture, from the top.

    Raises:
        SystemExit: it is none, or has too many pixels or frames: a sentence's end.
    """
    from PIL.PngImagePlugin import PngImageFile
    from PIL.PpmImagePlugin import PpmImageFile

    try:
        picture = (PngImageFile if data.startswith(b"\x89PNG") else PpmImageFile)(io.BytesIO(data))
        width, height = picture.size
        if width * height > MAX_PIXELS:
            raise SystemExit(f"{width} x {height} pixels are too many; a picture has at most {MAX_PIXELS:,}")
        if getattr(picture, "n_frames", 1) > 1:
            raise SystemExit("it has several frames; give a picture with one")
        grey = picture if picture.mode.startswith(("I", "F")) else picture.convert("L")
        if "A" in picture.getbands() or "transparency" in picture.info:
            opaque = picture.convert("RGBA").getchannel("A")
            least, most = opaque.getextrema()
            grey = opaque if least != most else grey
        return f"{grey.mode} {width} {height}\n".encode() + grey.tobytes()
    except (MemoryError, SystemExit):
        raise
    except Exception:  # whatever a damaged chunk lets Pillow stumble over
        raise SystemExit(_DAMAGED) from None
