"""The report: every table and figure of the chapter on one page."""
