"""Visual speech: from recordings of a speaker to models, result tables and a talking head."""

__version__ = "0.1.0"
