"""Viewing tests: preference and naturalness studies."""
