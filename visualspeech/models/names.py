"""Names of the rows that every result table has beside its networks."""

#: What a prediction must beat, and the AAM's own error, which is its floor.
BASELINES = ["training_mean", "phone_state_mean", "triphone_state_mean", "aam_reconstruction"]

#: The HMMs of a table, each made from the one before it.
HMMS = ["hmm_monophone", "hmm_tied", "hmm_mge"]
