"""Instrumented tyres of section 8.4: belt, encoder and in-tyre accelerometer, and the drives they were tested on."""
