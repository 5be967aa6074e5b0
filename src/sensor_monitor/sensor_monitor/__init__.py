"""Monitors of sensor signals: noise, frozen values, missing teeth, units, age and sign."""
