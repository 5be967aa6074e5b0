"""Monte Carlo studies of the estimators and of the closed loop, with bounds and limits."""
