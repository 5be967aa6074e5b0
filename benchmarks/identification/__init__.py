"""Identification of lambda_max, beside the Cramer-Rao bound."""
