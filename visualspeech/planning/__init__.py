"""The plan of a run, made before any job and without writing anything: settings, corpora, systems, rows."""
