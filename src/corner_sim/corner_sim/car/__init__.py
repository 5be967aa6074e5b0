"""A whole car with what is never known of one: the plant the estimators are judged on. It needs numpy and nothing else.

Its equations are written down here once more on purpose: a plant that shares its model with an estimator proves
nothing.
"""
