"""The built-in corpus: a face that is nobody's, speaking; made by a rule, the same bytes every time."""
