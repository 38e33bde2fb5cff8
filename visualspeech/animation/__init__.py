"""From predicted parameters to video."""
