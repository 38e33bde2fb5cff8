"""The active appearance model of the lower face (Fan et al. 2015, section 3.2)."""
