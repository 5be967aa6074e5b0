"""The doctor: what a drive says of the sensors and of the car that made it, on whole arrays, without middleware."""
