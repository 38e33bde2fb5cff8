"""Video and sound files: decoding, encoding, and long streams kept out of memory."""
