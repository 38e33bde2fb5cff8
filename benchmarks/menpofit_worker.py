"""The other side of ``benchmarks.menpofit``; it runs in menpofit's environment and imports nothing of this project.

``python -P menpofit_worker.py in.npz out.npz``. In: train, test (n, height, width) uint8; train_points, test_points,
starts (n, 68, 2) as (x, y); diagonal, shape_modes, texture_modes, iterations, variants. Out: for each variant the final
points, seconds, processor seconds and reconstruction errors in grey levels; and the model's number of pixels.
"""

import sys
import time
import warnings

import cv2
import numpy as np
from menpo.feature import no_op
from menpo.image import Image
from menpo.shape import PointCloud
from menpofit.aam import HolisticAAM, LucasKanadeAAMFitter, ProjectOutInverseCompositional, WibergInverseCompositional
from menpofit.transform import DifferentiablePiecewiseAffine

warnings.filterwarnings("ignore")
cv2.setNumThreads(1)
ALGORITHMS = {"alternating": WibergInverseCompositional, "project_out": ProjectOutInverseCompositional}


def picture(frame, points):
    image = Image(frame[None] / 255.0)
    image.landmarks["PTS"] = cloud(points)
    return image


def cloud(points):
    return PointCloud(points[:, ::-1].astype(float))  # menpo counts (y, x)


def reconstruction_errors(aam, images, shapes):
    """Root mean square residual of the texture model for each face, read from the frame as it is."""
    model = aam.appearance_models[-1]
    template = model.template_instance
    source = template.landmarks["source"]
    errors = []
    for image, shape in zip(images, shapes, strict=True):
        transform = DifferentiablePiecewiseAffine(getattr(source, "lms", source), shape)
        warped = image.warp_to_mask(template.mask, transform, warp_landmarks=False)
        left = warped.as_vector() - model.reconstruct(warped).as_vector()
        errors.append(255 * np.sqrt(np.mean(left**2)))
    return np.array(errors)


def main(source: str, target: str) -> None:
    data = np.load(source)
    sizes = int(data["shape_modes"]), int(data["texture_modes"])
    training = [picture(*pair) for pair in zip(data["train"], data["train_points"], strict=True)]
    aam = HolisticAAM(
        training,
        group="PTS",
        diagonal=int(data["diagonal"]),
        scales=(1.0,),
        holistic_features=no_op,
        verbose=False,
        max_shape_components=sizes[0],
        max_appearance_components=sizes[1],
    )
    results = {"pixels": aam.appearance_models[-1].template_instance.n_true_pixels()}
    images = [picture(*pair) for pair in zip(data["test"], data["test_points"], strict=True)]
    starts = [cloud(points) for points in data["starts"]]
    for variant in data["variants"]:
        fitter = LucasKanadeAAMFitter(
            aam, lk_algorithm_cls=ALGORITHMS[str(variant)], n_shape=sizes[0], n_appearance=sizes[1]
        )
        shapes, clock, processor = [], 0.0, 0.0
        for image, start in zip(images, starts, strict=True):
            began = time.perf_counter(), time.process_time()
            fitted = fitter.fit_from_shape(image, start, max_iters=int(data["iterations"]))
            clock, processor = clock + time.perf_counter() - began[0], processor + time.process_time() - began[1]
            shapes.append(fitted.final_shape)
        results[f"{variant}_points"] = np.stack([shape.points[:, ::-1] for shape in shapes])
        results[f"{variant}_seconds"] = np.array([clock, processor])
        results[f"{variant}_reconstruction"] = reconstruction_errors(aam, images, shapes)
    np.savez(target, **results)


if __name__ == "__main__":
    main(*sys.argv[1:])
