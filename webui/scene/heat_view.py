"""The heat map in a scene: pieces of the surface, each replaced when its colours change."""

import threading

import viser

from cleaning.surface.facets import Facets
from webui.glb.glb import Colours, as_seen
from webui.layers.surface.heat import HeatPiece, has_changed, heat_pieces, paint_piece, shade

_M = 0.001
_FADE_S = 0.4
"""A browser needs some time to load a piece; the one that it replaces stays so long beneath it."""


class HeatView:
    """Draws the surface of one board in colours; other colours send only the pieces in which they differ."""

    def __init__(self, api: viser.SceneApi) -> None:
        """Show nothing yet.

        Args:
            api: The scene, in metres and in the board's frame.
        """
        self._api = api
        self._lock = threading.Lock()
        self._facets: Facets | None = None
        self._pieces: tuple[HeatPiece, ...] = ()
        self._colours: Colours | None = None
        self._shown: dict[int, viser.GlbHandle] = {}
        self._old: list[viser.GlbHandle] = []
        """Replaced, and still beneath what replaced them."""
        self._sent = 0

    def show(self, facets: Facets, colours: Colours) -> int:
        """Show a surface in colours.

        Args:
            facets: The surface.
            colours: (c, 3) of its cells.

        Returns:
            Number of bytes sent.
        """
        with self._lock:
            if facets is not self._facets:
                self._clear()
                self._facets, self._pieces = facets, heat_pieces(facets)
            changed = [at for at, piece in enumerate(self._pieces) if has_changed(piece, colours, self._colours)]
            old = [self._shown.pop(at) for at in changed if at in self._shown]
            shaded = as_seen(shade(colours, facets.cell_normals))
            sent = sum(self._add(at, paint_piece(self._pieces[at], shaded)) for at in changed)
            self._colours = colours
            self._old += old
        if old:
            sweep = threading.Timer(_FADE_S, self._sweep, [old])
            sweep.daemon = True
            sweep.start()
        return sent

    def hide(self) -> None:
        """Hide the map; its pieces are kept for the next time."""
        with self._lock:
            self._clear()

    def _clear(self) -> None:
        for handle in (*self._shown.values(), *self._old):
            handle.remove()
        self._shown, self._old, self._colours = {}, [], None

    def _sweep(self, replaced: list[viser.GlbHandle]) -> None:
        with self._lock:
            for handle in replaced:
                if handle in self._old:  # else it went with the rest
                    self._old.remove(handle)
                    handle.remove()

    def _add(self, number: int, glb: bytes) -> int:
        """Draw a piece under a new name: the replaced one is removed later, so that nothing flickers."""
        self._sent += 1
        self._shown[number] = self._api.add_glb(f"/heat/{number}_{self._sent}", glb, scale=_M, cast_shadow=False)
        return len(glb)
