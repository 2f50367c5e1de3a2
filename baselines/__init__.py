"""Policies: scripted rules and learned agents behind one protocol."""
