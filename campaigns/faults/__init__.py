"""Stops in closed loop with one fault each, judged by what no fault may do."""
