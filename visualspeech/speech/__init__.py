"""From sound and text to timed words, phones and states; speech from text."""
