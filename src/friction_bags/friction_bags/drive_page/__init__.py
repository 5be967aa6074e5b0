"""One's own drive as a page: a bag as arrays, its brakings, and one HTML file that shows them."""
