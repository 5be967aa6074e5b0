"""Pure numpy models of tyre, wheel, brake and vehicle."""
