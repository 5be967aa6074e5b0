"""Support for the tests of the other packages: pytest settings and a DDS client. Product code never imports it."""
