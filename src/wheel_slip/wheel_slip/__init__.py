"""Vehicle speed and wheel slip from wheel encoders, accelerometer and speed sensor."""
