"""What a drive has shown: recorded messages as arrays, its brakings, and the table of both."""
