"""Shared parts of the nodes of the friction graph: input alignment, parameters, QoS, diagnostics."""
