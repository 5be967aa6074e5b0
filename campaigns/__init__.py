"""Campaigns against the whole system: faults in closed loop, hostile messages, long runs, the live graph."""
