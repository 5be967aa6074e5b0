"""The friction curve of a car that is not known exactly: one fit for all wheels, nuisances and their priors included."""
