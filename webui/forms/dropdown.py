"""What a dropdown offers."""

import viser


def offer(choice: viser.GuiDropdownHandle[str], names: tuple[str, ...], chosen: str) -> None:
    """Offer names with one of them chosen; nothing is sent of what is so already.

    Args:
        choice: The dropdown.
        names: What there is to choose from.
        chosen: One of them.
    """
    if tuple(choice.options) != names:
        choice.options = names
    if choice.value != chosen:
        choice.value = chosen
