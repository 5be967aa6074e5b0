"""A whole car with unknown parameters: the plant that the estimators are judged on.

Its equations are written here once more on purpose, with numpy and constants of nature only: a plant that shares its
model with an estimator proves nothing.
"""
