"""The tables and figures of chapter 8 beside their numbers from this code, as one page."""
