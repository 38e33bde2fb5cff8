# Where landmarks come from: a tracker of this package, one of the user's own, or files.
from visualspeech.planning.landmarks import check_landmark_files, landmark_files_digest, tracker_code
from visualspeech.planning.paths import recording_folders

VIDEOS = {
    name: [one for utterances in corpus.utterances.values() for one in utterances]
    for name, corpus in PLAN.corpora.items()
    if "video" in corpus.gives
}

try:
    # The module of a tracker of the user's own lies beside a settings file, or in the folder in which the run starts.
    TRACKER = tracker_code(
        SETTINGS["landmarks"],
        [*(Path(file).parent for file in workflow.configfiles), Path.cwd()],
        [folder for _, folder in recording_folders(SETTINGS)],
    )
    if workflow.is_main_process:
        check_landmark_files(SETTINGS["landmarks"], VIDEOS)
except VisualSpeechError as error:
    raise WorkflowError(str(error))


def tracker_digest(wildcards):
    """Params function: digest of the code that gives the landmarks, which re-runs the tracking where it changes."""
    return code("track_landmarks.py", *filter(None, [TRACKER.module])), TRACKER.digest


def tracker_folder(wildcards):
    """Data of a job: the folder of the module of a tracker of the user's own."""
    return TRACKER.folder


def landmark_files(wildcards):
    """Params function: digest of the landmark files of a shard, which re-runs its job where one changes."""
    by_content = SETTINGS["corpora"][wildcards.corpus]["change_detection"] == "content"
    return landmark_files_digest(
        SETTINGS["landmarks"], PLAN.corpora[wildcards.corpus].utterances[wildcards.shard], by_content
    )
