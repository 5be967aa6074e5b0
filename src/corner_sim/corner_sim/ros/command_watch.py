"""Middleware events of the publishers of brake_command as diagnostics texts."""

from rclpy.event_handler import (
    QoSLivelinessChangedInfo,
    QoSRequestedDeadlineMissedInfo,
    QoSRequestedIncompatibleQoSInfo,
    SubscriptionEventCallbacks,
)
from rclpy.qos import qos_policy_name_from_kind

from friction_runtime.qos import COMMAND_DEADLINE, COMMAND_LEASE


class CommandWatch:
    """Counts missed deadlines, and knows whether the sender lives."""

    def __init__(self, topic: str) -> None:
        """Start without a sender of `topic`."""
        self._topic = topic
        self._missed = 0
        self._reported = 0
        self._dead = 0
        self._alive = 0
        self._was_alive = False
        self._incompatible = ""
        self.callbacks = SubscriptionEventCallbacks(
            deadline=self._on_deadline, liveliness=self._on_liveliness, incompatible_qos=self._on_incompatible
        )
        """For the subscription."""

    @property
    def missed(self) -> int:
        """Deadlines missed since the start: one more for each period without a command, after the first one."""
        return self._missed

    def findings(self, senders: int) -> list[str]:
        """Return what is wrong with `senders` matched publishers now, or since the last call."""
        found: list[str] = []
        if self._missed > self._reported:
            times = self._missed - self._reported
            found.append(f"{self._topic}: deadline of {COMMAND_DEADLINE} s missed {times} times")
        self._reported = self._missed
        if self._dead:
            found.append(f"{self._topic}: its supervisor has given no sign of life for {COMMAND_LEASE} s")
        elif self._was_alive and not self._alive:
            found.append(f"{self._topic}: its supervisor has left")
        if senders > 1:
            found.append(f"{self._topic}: {senders} supervisors command")
        if self._incompatible and not senders:
            found.append(f"{self._topic}: a publisher is not obeyed, it does not offer {self._incompatible}")
        return found

    def _on_deadline(self, info: QoSRequestedDeadlineMissedInfo) -> None:
        self._missed = info.total_count

    def _on_liveliness(self, info: QoSLivelinessChangedInfo) -> None:
        self._alive, self._dead = info.alive_count, info.not_alive_count
        self._was_alive = self._was_alive or self._alive > 0

    def _on_incompatible(self, info: QoSRequestedIncompatibleQoSInfo) -> None:
        self._incompatible = str(qos_policy_name_from_kind(info.last_policy_kind)).lower()
