"""Answers that were found lately, so that the same question needs no work again."""

import threading
from collections import OrderedDict
from collections.abc import Hashable
from typing import Generic, TypeVar

V = TypeVar("V")


class Memory(Generic[V]):
    """The last answers by their questions; several threads may ask. Answers are shared: nobody may change them."""

    def __init__(self, most: int) -> None:
        """Remember nothing yet, and never more than so many answers."""
        self._most = most
        self._known: OrderedDict[Hashable, V] = OrderedDict()
        self._lock = threading.Lock()

    def find(self, question: Hashable) -> V | None:
        """Give the answer to a question, if it is remembered."""
        with self._lock:
            if question in self._known:
                self._known.move_to_end(question)
            return self._known.get(question)

    def keep(self, question: Hashable, answer: V) -> V:
        """Remember an answer, and forget the one that was not asked for longest if there are too many."""
        with self._lock:
            self._known[question] = answer
            self._known.move_to_end(question)
            while len(self._known) > self._most:
                self._known.popitem(last=False)
        return answer

    def forget(self) -> None:
        """Remember nothing any more."""
        with self._lock:
            self._known.clear()
