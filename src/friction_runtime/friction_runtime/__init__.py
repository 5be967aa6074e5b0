"""What every node of the friction graph shares: input alignment, parameters, QoS, diagnostics."""
