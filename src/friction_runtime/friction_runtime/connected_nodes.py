"""The nodes of one process, connected directly: what one of them makes the others get without the middleware.

What comes from outside is subscribed to once, by the first node that takes it, and is decoded once.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from time import monotonic
from typing import Any

from rclpy.executors import Executor

from friction_runtime.processor import Output, ProcessorGraph
from friction_runtime.processor_node import Connect, ProcessorNode

_MOST_WAITING = 1000
"""Messages that wait for a node which others do not wait for: as many as the queues of ten inputs hold."""


class ConnectedNodes:
    """Hands the messages of nodes to each other, by full names, so that remapping connects them as in the middleware.

    A message that several nodes take is given to them in their order. What is made of it is published at once, and
    handed on when all have taken the message. The last node gets its messages when nothing else waits, so that one that
    takes long does not hold back the others for longer than one of its estimates takes.
    """

    def __init__(self, makers: Sequence[Callable[[Connect], ProcessorNode[Any]]]) -> None:
        """Make the nodes, in the order in which they are served, and connect them."""
        self.nodes: list[ProcessorNode[Any]] = []
        """In the order in which they are served."""
        made = [make(self._connect) for make in makers]
        self._last = _Queued(made[-1])
        self._fed = 0
        self.nodes = made
        self._connect(made[0])

    def spin(self, executor: Executor, seconds: float) -> None:
        """Serve what arrives for about some time [s]; the last node works whenever nothing has arrived.

        A task of the executor for each piece of that work would take longer than to look whether anything waits.
        """
        until = monotonic() + seconds
        while (now := monotonic()) < until:
            if not self._last.waiting:
                executor.spin_once(timeout_sec=until - now)
                continue
            fed = self._fed
            executor.spin_once(timeout_sec=0.0)
            if self._fed == fed:
                self._hand_on(self._last.work())

    def _connect(self, _: ProcessorNode[Any]) -> None:
        """Connect the nodes anew, once all of them are there."""
        if not self.nodes:
            return
        self._graph = ProcessorGraph([*self.nodes[:-1], self._last])
        inside = {name for node in self.nodes for name in node.outputs}
        taken: set[str] = set()
        for node in self.nodes:
            for name in {**node.sensors, **node.estimates}.keys() - inside - taken:
                taken.add(name)
                node.subscribe(name, partial(self._feed, name))

    def _feed(self, name: str, message: Any) -> None:
        self._fed += 1
        self._graph.feed(name, message)

    def _hand_on(self, outputs: Sequence[Output]) -> None:
        for name, message in outputs:
            self._graph.feed(name, message)


class _Queued:
    """A node that gets its messages later, up to one estimate at a time."""

    def __init__(self, node: ProcessorNode[Any]) -> None:
        self._node = node
        self.waiting: deque[Output] = deque(maxlen=_MOST_WAITING)
        """Messages that have not been handed over."""

    @property
    def sensors(self) -> Mapping[str, type]:
        return self._node.sensors

    @property
    def estimates(self) -> Mapping[str, type]:
        return self._node.estimates

    def process(self, name: str, message: Any) -> Sequence[Output]:
        self.waiting.append((name, message))
        return ()

    def work(self) -> Sequence[Output]:
        """Hand over messages up to the first that is answered; return the answers."""
        while self.waiting:
            if outputs := self._node.process(*self.waiting.popleft()):
                return outputs
        return ()
