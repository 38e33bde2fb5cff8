# The workflow on Debian, by the commands of the README:  docker build -t visualspeech .   (or podman, or buildah)
# PyTorch's smaller build for CPUs:  --build-arg PIP_EXTRA_INDEX_URL=https://download.pytorch.org/whl/cpu
FROM docker.io/library/debian:bookworm-slim

RUN apt-get update && apt-get install -y --no-install-recommends python3 python3-venv && rm -rf /var/lib/apt/lists/*

WORKDIR /visualspeech
COPY . .

ARG PIP_EXTRA_INDEX_URL
ENV PIP_NO_CACHE_DIR=1
RUN python3 -m venv .venv && .venv/bin/pip install -c constraints.txt -e '.[dev]'

ENV PATH=/visualspeech/.venv/bin:$PATH
VOLUME /visualspeech/results
CMD [".venv/bin/snakemake", "--cores", "2", "all"]
