"""The light in which boards are shown: on a page and in a recording alike."""

import viser

_FROM_BELOW = 4.0
"""The default lights are all above."""


def light_scene(api: viser.SceneApi) -> None:
    """Light a scene from both sides, without shadows: they cost as much time as all the rest.

    The browser's own surroundings stay: others that a server sends fade the whole picture in some browsers.
    """
    api.set_up_direction("+z")
    api.configure_default_lights(cast_shadow=False)
    api.add_light_directional("/light", intensity=_FROM_BELOW, position=(0.0, -0.4, -1.0))
