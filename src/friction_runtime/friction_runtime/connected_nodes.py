"""The nodes of one process, connected directly: what one of them makes the others get without the middleware.

What comes from outside is subscribed to once, by the first node that takes it, and is decoded once.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any

from rclpy.executors import Executor

from friction_runtime.processor import Output
from friction_runtime.processor_graph import ProcessorGraph
from friction_runtime.processor_node import Connect, ProcessorNode

_MOST_WAITING = 1000
"""Messages that wait for a node which others do not wait for: as many as the queues of ten inputs hold."""


class ConnectedNodes:
    """Hands the messages of nodes to each other, by full names, so that remapping connects them as in the middleware.

    A message that several nodes take is given to them in their order. What is made of it is published at once, and
    handed on when all have taken the message. The last node gets its messages when nothing else waits, so that one that
    takes long does not hold back the others for longer than one of its estimates takes.
    """

    def __init__(self, executor: Executor, makers: Sequence[Callable[[Connect], ProcessorNode[Any]]]) -> None:
        """Make the nodes and connect them.

        Args:
            executor: will spin the nodes.
            makers: make the nodes, in the order in which they are served.
        """
        self.nodes: list[ProcessorNode[Any]] = []
        """In the order in which they are served."""
        made = [make(self._connect) for make in makers]
        self._last = _WhenNothingWaits(made[-1], executor, self._hand_on)
        self.nodes = made
        self._connect(made[0])

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
        self._graph.feed(name, message)

    def _hand_on(self, outputs: Sequence[Output]) -> None:
        for name, message in outputs:
            self._graph.feed(name, message)


class _WhenNothingWaits:
    """A node that gets its messages when the executor has nothing else to do, up to one estimate at a time."""

    def __init__(
        self, node: ProcessorNode[Any], executor: Executor, hand_on: Callable[[Sequence[Output]], None]
    ) -> None:
        self._node = node
        self._executor = executor
        self._hand_on = hand_on
        self._waiting: deque[Output] = deque(maxlen=_MOST_WAITING)
        self._planned = False

    @property
    def sensors(self) -> Mapping[str, type]:
        return self._node.sensors

    @property
    def estimates(self) -> Mapping[str, type]:
        return self._node.estimates

    def process(self, name: str, message: Any) -> Sequence[Output]:
        self._waiting.append((name, message))
        self._plan()
        return ()

    def _plan(self) -> None:
        if not self._planned:
            self._planned = True
            self._executor.create_task(self._work)  # behind all messages that have arrived

    def _work(self) -> None:
        self._planned = False
        while self._waiting:
            if outputs := self._node.process(*self._waiting.popleft()):
                self._hand_on(outputs)
                break
        if self._waiting:
            self._plan()
