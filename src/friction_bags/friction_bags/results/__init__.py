"""Results of a drive: recorded messages as arrays, its brakings, and the table of both."""
