"""Slip control on the identified friction curve: what it asks for. The envelope decides what the brake gets. No ROS."""
