"""Friction used, proven and left, in ordinary driving on changing roads."""
