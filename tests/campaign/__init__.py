"""Seeded attempts to break the project with foreign data: media, names, tables, damaged files, models, command lines.

Each kind is a module with ``run(folder, seed, count)``, which returns a :class:`tests.campaign.results.Result` for each
attempt. A short campaign is one of the unit tests; ``python -m tests.campaign --cases 5000`` runs a long one.
"""
