"""The light in which boards are shown: on a page and in a recording alike."""

import viser

_ENVIRONMENT = 0.35
"""More of it washes out the colours that tell parts apart."""


def light_scene(api: viser.SceneApi) -> None:
    """Light a scene evenly, without shadows: they cost as much time as all the rest."""
    api.set_up_direction("+z")
    api.configure_default_lights(cast_shadow=False)
    api.configure_environment_map("warehouse", environment_intensity=_ENVIRONMENT)
