"""The only package that reads and writes the project's files.

Tables are TSV, arrays HDF5 (one file per shard, one group per utterance), models safetensors with their settings as
JSON metadata. Every file is written under a temporary name in its folder and renamed into place, so a killed job never
leaves a half-written file under a name that another job reads. Nothing that is read is unpickled or executed.
"""
