"""The doctor on drives with known troubles, and on healthy ones."""
