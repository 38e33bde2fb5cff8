"""The shipped settings with changes, as a run resolves them."""

import yaml

from tests.paths import REPOSITORY
from visualspeech.planning.run import plan_run, resolve
from visualspeech.settings import merged, read_yaml

CONFIG = REPOSITORY / "config"


def config(*overlays):
    """``config.yaml`` with overlays, each YAML text, a mapping, or the path of a file."""
    settings = read_yaml(CONFIG / "config.yaml")
    for one in overlays:
        over = yaml.safe_load(one) if isinstance(one, str) else one if isinstance(one, dict) else read_yaml(one)
        settings = merged(settings, over)
    return settings


def resolved(*overlays):
    return resolve(config(*overlays), CONFIG)


def planned(*overlays):
    return plan_run(config(*overlays), CONFIG)


def rows(settings, system="fan2015", role="model"):
    """Names of the rows of a system."""
    return [row["name"] for row in settings["systems"][system]["rows"] if row["role"] == role]
