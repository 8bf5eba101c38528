"""Keep the collector of circular garbage from walking through a whole board in the middle of an edit."""

import gc


def set_aside() -> None:
    """Leave all that lives now out of the collector's rounds, after one last round through all of it.

    A board, its plan and the libraries are hundreds of thousands of objects that stay; a round through them takes
    as long as an edit. What is set aside goes as usual when nobody refers to it any more; circles among it go when
    this is called the next time.
    """
    gc.unfreeze()
    gc.collect()
    gc.freeze()
