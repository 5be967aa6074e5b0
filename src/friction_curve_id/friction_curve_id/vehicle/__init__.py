"""The whole-vehicle method: one curve from deceleration and the slips of all wheels."""
