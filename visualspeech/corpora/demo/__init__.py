"""The built-in demo corpus: recordings of a synthetic speaker, generated with the same bytes every time."""
