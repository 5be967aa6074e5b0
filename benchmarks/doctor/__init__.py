"""The doctor on drives with injected faults, and on healthy ones."""
