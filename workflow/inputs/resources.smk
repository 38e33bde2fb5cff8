# What a cluster is asked for. Peaks are resident memory and seconds are processor time of the scripts, as their benchmark
# files report them for the default run; docs/cluster.md has the rule and the measurements. A second attempt is given
# twice as much, a third one three times.

#: MB of the two Snakemake processes around the script of a cluster's job.
AROUND_MB = 400
#: MB up to which training keeps its features in memory.
KEPT_MB = 256


def size_mb(paths):
    """MB of the files of a job that exist: those that another job of its group makes do not, when it is submitted."""
    return sum(Path(path).stat().st_size for path in paths if Path(path).is_file()) / 1e6


def memory(peak):
    """Resources function: MB of memory of a job whose script had this peak; it does not grow with the corpus, because
    scripts read one utterance at a time."""
    return lambda wildcards, attempt: attempt * (AROUND_MB + round(1.5 * peak))


def growing_memory(peak, per_mb):
    """Resources function: as :func:`memory`, with MB for each MB of the job's inputs, which are read as a whole."""
    return lambda wildcards, input, attempt: attempt * (AROUND_MB + round(1.5 * (peak + per_mb * size_mb(input))))


def memory_of_training(wildcards, input, attempt):
    """MB of memory of a training job: with mini-batches of single frames, features and targets are in memory."""
    size = size_mb(input)
    whole = row_of(wildcards).training.get("batcher") in FRAME_BATCHERS
    return attempt * (AROUND_MB + round(1.5 * (450 + (2 * size if whole else min(size, KEPT_MB)))))


def minutes(seconds, least=5):
    """Resources function: minutes of a job that takes so many seconds for each MB of its inputs, four times over."""
    return lambda wildcards, input, attempt: attempt * (least + round(4 * seconds * size_mb(input) / 60))


def minutes_of_recordings(seconds, least=15):
    """Resources function: as :func:`minutes`, for each MB of the recordings of the job's shard, which are no inputs."""

    def asked(wildcards, attempt):
        utterances = PLAN.corpora[wildcards.corpus].utterances[wildcards.shard]
        return attempt * (least + round(4 * seconds * size_mb(one.file for one in utterances) / 60))

    return asked


def disk(least, per_mb=0):
    """Resources function: MB of disk of what a job writes: so many, and so many for each MB of its inputs."""
    return lambda wildcards, input, attempt: attempt * (least + round(per_mb * size_mb(input)))
