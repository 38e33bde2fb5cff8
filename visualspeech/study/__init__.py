"""Viewing tests of videos: studies are made, run in a browser, rehearsed and evaluated."""
