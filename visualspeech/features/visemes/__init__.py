"""Dynamic visemes: gestures of the visible articulators, their classes, and their prediction from text."""
