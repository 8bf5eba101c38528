"""The nozzle in a scene: body, jet and wave front, moved from moment to moment."""

from collections.abc import Mapping

import numpy as np
import viser

from geometry.arrays import Points
from webui.layers.paths.nozzle import Moment, cone_of, nozzle_body, outlines_of
from webui.layers.paths.strokes import Tint
from webui.theme.palette import ACCENT, QUIET

_M = 0.001
_STEEL = (124, 136, 146)
_SAME_MM = 0.02
"""A rim that moved less against the orifice is not sent again."""


class NozzleView:
    """Draws one nozzle; used by a page and by a recording alike."""

    def __init__(self, api: viser.SceneApi, tints: Mapping[str, Tint]) -> None:
        """Make the nodes, hidden.

        Args:
            api: Where to draw.
            tints: Colour of each function's jet.
        """
        self._tints = dict(tints)
        corners, faces = nozzle_body()
        rim, faces_of_cone = cone_of(np.zeros((96, 3)))
        self._frame = api.add_frame("/tool", show_axes=False, visible=False)
        api.add_mesh_simple("/tool/body", corners * _M, faces, color=_STEEL, cast_shadow=False)
        self._cone = api.add_mesh_simple(
            "/jet", rim, faces_of_cone, color=QUIET, opacity=0.28, side="double", visible=False, cast_shadow=False
        )
        self._front = api.add_line_segments(
            "/front", np.zeros((1, 2, 3)), ACCENT, thickness=2.5, thickness_units="screen", visible=False
        )
        self._rim: Points = np.empty((0, 3))
        self._function = ""

    def show(self, moment: Moment) -> None:
        """Move it all to a moment."""
        place = moment.tcp * _M
        self._frame.position, self._frame.wxyz = place, moment.quaternion
        if not self._frame.visible:
            self._frame.visible = True
        sprays = len(moment.rim) > 0
        if sprays:
            self._cone.position = self._front.position = place
            self._shape(moment)
        self._switch(sprays)

    def hide(self) -> None:
        """Show nothing."""
        self._frame.visible = False
        self._switch(False)

    def recolour(self, tints: Mapping[str, Tint]) -> None:
        """Give the jets of functions other colours."""
        self._tints, self._function = dict(tints), ""

    def _switch(self, spraying: bool) -> None:
        if self._cone.visible != spraying:
            self._cone.visible = self._front.visible = spraying

    def _shape(self, moment: Moment) -> None:
        if moment.function != self._function:
            self._function = moment.function
            self._cone.color = self._tints.get(moment.function, QUIET)
        if self._rim.shape == moment.rim.shape and np.abs(self._rim - moment.rim).max() < _SAME_MM:
            return
        self._rim = moment.rim
        self._cone.vertices = (cone_of(moment.rim)[0] * _M).astype(np.float32)
        self._front.points = (outlines_of(moment.rim, moment.core) * _M).astype(np.float32)
