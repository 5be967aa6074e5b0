"""Slip control on the identified friction curve, below the safety envelope. No ROS."""
