"""A controller that goes from node to node by a clock that only the drive moves."""

from dataclasses import dataclass, replace

from robotcell.operate.handshake import Link, LinkError, Order, Status

STEP_S, EXCHANGE_S = 0.1, 0.004


@dataclass
class Paced:
    """Its nodes take their time, and each exchange takes some."""

    planned: Link
    now: float = 0.0
    began: float = -1.0
    breaks_at: float = float("inf")
    step_s: float = STEP_S
    """That a node takes."""
    exchange_s: float = EXCHANGE_S
    waits_until: float = 0.0
    """Until then its sensor shows nothing."""

    def clock(self) -> float:
        return self.now

    def rest(self, seconds: float) -> None:
        self.now += seconds

    def look(self) -> None:
        return None

    def exchange(self, order: Order) -> Status:
        self.now += self.exchange_s
        if self.now > self.breaks_at:
            raise LinkError("cut")
        status = self.planned.exchange(order)
        if self.now < self.waits_until:
            return replace(status, readings=(0,))
        if order.command != "run":
            return status
        self.began = self.now if self.began < 0.0 else self.began
        passed = 1 + int((self.now - self.began) / self.step_s)
        return replace(status, reached=min(status.accepted, passed), readings=(500_000,))

    def close(self) -> None:
        pass
