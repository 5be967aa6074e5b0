"""Friction that a drive uses, has proven, and leaves."""
