"""Monte Carlo, Cramer-Rao bounds, the chapter's tables and figures, benchmarks."""
