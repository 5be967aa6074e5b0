"""Tyre-road friction curve and its peak, identified online from wheel speed and brake torque (section 8.3)."""
