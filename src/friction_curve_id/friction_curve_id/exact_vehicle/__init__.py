"""Method `exact_vehicle`: a full-information maximum a posteriori fit to the signals of one wheel."""
