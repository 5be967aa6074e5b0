"""Vehicle speed and slip without a speed sensor."""
