"""Settings of the training of the active appearance model."""

from collections.abc import Mapping
from dataclasses import dataclass

from visualspeech.fields import MAX_SEED, FieldError, Settings, setting, shortened

WEIGHTINGS = ("variance", "none")
#: A component has as many values as a texture; more than these fill the memory of a small machine.
MOST_COMPONENTS = 2000
#: One analysis keeps a share of the variance (perhaps capped), or a number of components.
TARGET = {
    "type": "object",
    "additionalProperties": False,
    "oneOf": [{"required": ["energy"]}, {"required": ["components"]}],
    "dependentRequired": {"at_most": ["energy"]},
    "properties": {
        "energy": {
            "description": "Share of the training variance that is kept, above 0 and below 1.",
            "type": "number",
            "exclusiveMinimum": 0,
            "exclusiveMaximum": 1,
        },
        "at_most": {
            "description": "With `energy`: maximum number of components.",
            "type": "integer",
            "minimum": 1,
            "maximum": MOST_COMPONENTS,
        },
        "components": {
            "description": "Number of components.",
            "type": "integer",
            "minimum": 1,
            "maximum": MOST_COMPONENTS,
        },
    },
}


@dataclass(frozen=True)
class AamSettings(Settings):
    """Training of the active appearance model.

    The paper keeps 66 shape components with about 99 % of the variance, 100 texture components with about 87 %, and 87
    joint ones. Noise of the camera and of video compression may spread the last tenth of the texture's variance over
    more directions than a model has use for; hence the cap.
    """

    section = "aam"
    images: int = setting(
        20000,
        "Maximum number of training frames, drawn at random from all training utterances.",
        minimum=2,
        maximum=10_000_000,
    )
    shape: Mapping = setting(
        {"energy": 0.99},
        "Components of the shape analysis: `energy` (share of the variance, with `at_most` as a cap) or `components`.",
        item=TARGET,
    )
    texture: Mapping = setting(
        {"energy": 0.87, "at_most": 100},
        "Components of the texture analysis: `energy` (share of the variance, with `at_most` as a cap) or "
        "`components`.",
        item=TARGET,
    )
    appearance: Mapping = setting(
        {"energy": 0.99},
        "Components of the joint analysis: `energy` (share of the variance, with `at_most` as a cap) or `components`.",
        item=TARGET,
    )
    weighting: str = setting(
        "variance",
        "Weight of shape against texture in the joint analysis (Eq. 6): equal total variance, or none (pixels against "
        "grey levels).",
        choices=WEIGHTINGS,
    )
    iterations: int = setting(10, "Maximum number of iterations of EM-PCA.", minimum=1, maximum=1000)
    seed: int = setting(
        0, "Seed of the draw of training frames and of the start of EM-PCA.", minimum=0, maximum=MAX_SEED
    )

    def __post_init__(self) -> None:
        super().__post_init__()
        for name in ("shape", "texture", "appearance"):
            _check_target(name, getattr(self, name))
        self.check_possible(self.images)

    def check_possible(self, images: int, coordinates: int | None = None) -> None:
        """Check that so many images can have the components asked for, as far as that is known before the analyses.

        Parameters
        ----------
        images : training images
        coordinates : coordinates that vary independently in a shape (``PointSet.freedom``); None where not known

        Raises
        ------
        SettingError
            They cannot.
        """
        tracked = [] if coordinates is None else [(coordinates, f"{coordinates} tracked coordinates")]
        limits = {
            "shape": [*tracked, (images - 1, f"{images} images")],
            "texture": [(images - 1, f"{images} images")],
        }
        # Where an energy decides on the components of shape or texture, no more is known of how many come out.
        parts = [getattr(self, name).get("components") for name in limits]
        joint = [(sum(parts), f"{parts[0]} shape and {parts[1]} texture components")] if all(parts) else []
        limits["appearance"] = [(images - 1, f"{images} images"), *joint]
        for name, found in limits.items():
            asked, (most, why) = getattr(self, name).get("components", 0), min(found)
            if asked > most:
                said = f"is more than there can be: {why} give {most} at most. Ask for fewer, or write an energy such"
                raise FieldError(f"aam.{name}.components", f": {asked}` {said} as 0.95 in place of components.")


def _check_target(name: str, target: Mapping) -> None:
    if not isinstance(target, Mapping) or set(target) not in ({"energy"}, {"energy", "at_most"}, {"components"}):
        raise FieldError(
            f"aam.{name}",
            f": {shortened(target)}` must be energy (a fraction such as 0.99, with at_most beside it where the number "
            "of components is to be capped) or components (a number).",
        )
    for key, value in target.items():
        if key == "energy" and not (isinstance(value, int | float) and 0 < value < 1):
            raise FieldError(
                f"aam.{name}.energy", f": {shortened(value)}` must be above 0 and below 1, for example 0.99."
            )
        whole = isinstance(value, int) and not isinstance(value, bool)
        if key != "energy" and not (whole and 1 <= value <= MOST_COMPONENTS):
            rule = f"must be a whole number, at least 1 and at most {MOST_COMPONENTS}."
            raise FieldError(f"aam.{name}.{key}", f": {shortened(value)}` {rule}")
