"""Holds the numbers of `--protocol nuscenes`, and what is read, against nuscenes-devkit: protocol_nuscenes.py SCANBENCH
FOLDER

The scenes that `nuscenes-val` has are those of the devkit. Points and boxes of a drawn scene, with a car and a lidar that
are tilted, are those of the devkit. So are numbers on simulated streets, brought into the layout of nuScenes box by box, of
what detectors of ours found there; and on a made-up data set, of made-up submissions and of the labels themselves. The
devkit cannot read a submission without any box. Where scores are alike the devkit takes the last of its list first, and so
it is given lists in the opposite order of scanbench.
"""

import math
import sys
import tomllib
from pathlib import Path

import numpy as np
from nuscenes import NuScenes
from nuscenes.eval.detection.config import config_factory
from nuscenes.eval.detection.evaluate import DetectionEval
from nuscenes.utils import splits
from nuscenes.utils.data_classes import LidarPointCloud
from pyquaternion import Quaternion

from converted import assert_same, boxes, points
from nuscenes_files import CATEGORIES, CATEGORY_OF, cloud_of, pose, records_of, upright, write_submission, write_tables
from program import run
from protocol_numbers import SIZE, Numbers, cases, compare, found_by_ours, made_things, numbers_of_tables, on_streets

MAKER = "nuscenes-devkit"
ERRORS = {"ate_m": "trans_err", "ase": "scale_err", "aoe_rad": "orient_err", "ave_m_per_s": "vel_err", "aae": "attr_err"}
# Scenes that the devkit takes for the split mini_val.
SCENES = ["scene-0103", "scene-0916"]
AT_ORIGIN = pose([0, 0, 0], upright(0))


def devkit_numbers(tables: NuScenes, path: Path, scratch: Path) -> Numbers:
    config = config_factory("detection_cvpr_2019")
    metrics, _ = DetectionEval(tables, config, str(path), "mini_val", str(scratch), verbose=False).evaluate()
    numbers: Numbers = {("all", "ap"): metrics.mean_ap, ("all", "nds"): metrics.nd_score}
    for ours, theirs in ERRORS.items():
        numbers["all", ours] = metrics.tp_errors[theirs]
    for name in config.class_names:
        numbers[name, "ap"] = metrics.mean_dist_aps[name]
        for distance in config.dist_ths:
            numbers[name, f"ap_{distance:g}m"] = metrics.get_label_ap(name, distance)
        for ours, theirs in ERRORS.items():
            numbers[name, ours] = metrics.get_label_tp(name, theirs)
    return numbers


def check_made_up(scanbench: str, folder: Path) -> None:
    random, root = np.random.default_rng(5), folder / "nuscenes"
    # The fifth sample comes late, so that velocities over it are not known.
    times_s = [0.5 * it + (2.0 if it >= 5 else 0.0) for it in range(12)]
    labels = made_things(SCENES, list(CATEGORIES), times_s, 60.0, 5)
    n, labels["scan"] = len(labels), labels["scan"].str.replace("/", "-")
    labels["category"], labels["class"] = labels["class"], labels["class"].map(lambda it: CATEGORIES[it][0])
    attributes = labels["category"].map(lambda it: CATEGORIES[it][1])
    labels["attribute"] = attributes.where(random.random(n) < 0.9, "")
    labels["n_lidar"], labels["n_radar"] = labels["n_points"], random.integers(0, 2, n)
    # What holds no point is not evaluated.
    labels["n_points"] += labels["n_radar"]
    # What lies in racks is not evaluated.
    labels.loc[labels["category"] == "static_object.bicycle_rack", SIZE] *= 2.4

    egos, scenes, lidar = {}, {}, pose([0.94, 0.0, 1.84], upright(-np.pi / 2))
    for number, scene in enumerate(SCENES):
        start, heading, scenes[scene] = random.normal(0, 1000, 2), random.uniform(-np.pi, np.pi), {}
        ahead = np.array([np.cos(heading), np.sin(heading)])
        for index, time_s in enumerate(times_s):
            sample, driven = f"{scene}-{index:06}", 2.0 * index * ahead
            egos[sample] = np.array([*(start + driven), 0.0])
            scenes[scene][sample] = 10**15 + number * 10**9 + int(time_s * 10**6), pose(egos[sample], upright(heading))
            is_here = labels["scan"] == sample
            labels.loc[is_here, ["x", "y"]] -= driven
            here = labels[is_here]
            # Thirty points in each box, in the frame of the lidar.
            inside = random.uniform(-0.5, 0.5, (30, len(here), 3)) * here[SIZE].to_numpy()
            turned = [inside[:, it] @ Quaternion(upright(yaw)).rotation_matrix.T for it, yaw in enumerate(here["yaw"])]
            cloud = np.concatenate(np.array(turned) + here[["x", "y", "z"]].to_numpy()[:, None])
            in_car = cloud @ Quaternion(upright(heading)).rotation_matrix - lidar["translation"]
            cloud = np.column_stack([in_car @ Quaternion(lidar["rotation"]).rotation_matrix, np.full((len(cloud), 2), 7.0)])
            (root / cloud_of(sample)).parent.mkdir(parents=True, exist_ok=True)
            cloud.astype("<f4").tofile(root / cloud_of(sample))
    annotations = [
        record | {"thing": f"thing{it['thing']}", "category": it["category"], "num_lidar_pts": it["n_lidar"],
                  "num_radar_pts": it["n_radar"], "attribute_tokens": [it["attribute"]] if it["attribute"] else []}
        for record, it in zip(records_of(labels, egos), labels.to_dict("records"))
    ]  # fmt: skip
    write_tables(root, scenes, annotations, lidar)

    found = cases(labels[labels["class"].notna()], "car")
    found["one-box"] = found["distinct"].head(1)
    submissions, in_order = ({name: folder / f"{name}{kind}.json" for name in found} for kind in ("", ".last-first"))
    for name, it in found.items():
        write_submission(submissions[name], it, egos)
        write_submission(in_order[name], found[name.removesuffix("-shuffled")][::-1], egos)
    submissions["ours"] = in_order["ours"] = found_by_ours(scanbench, root, "nuscenes", folder)
    ours = numbers_of_tables(scanbench, root, "nuscenes", submissions, folder)
    tables = NuScenes("v1.0-mini", str(root), verbose=False)
    theirs = {name: devkit_numbers(tables, path, folder / "devkit") for name, path in in_order.items()}
    compare("nuscenes", "made-up scenes", MAKER, ours, theirs, 500)
    if ours["truth"]["present", "ap"] != 1.0:
        sys.exit(f"the labels themselves have an AP of {ours['truth']['present', 'ap']}")


def check_streets(scanbench: str, folder: Path) -> None:
    """Detectors of ours on simulated streets, whose boxes are written as the tables and submissions of nuScenes."""
    ours, found = on_streets(scanbench, "nuscenes", "car", folder)
    egos = {it: np.zeros(3) for it in sorted(found["scan"].unique())}
    # One scene; the split has a second one, which is empty.
    samples = {sample: (10**15 + index * 500_000, AT_ORIGIN) for index, sample in enumerate(egos)}
    labels = found.query("kind == 'annotation' and detector == detector.iloc[0]")
    annotations = [
        record | {"thing": f"thing{index}", "category": CATEGORY_OF[name], "num_lidar_pts": int(n_points)}
        for index, (record, name, n_points) in enumerate(zip(records_of(labels, egos), labels["class"], labels["n_points"]))
    ]
    write_tables(folder / "converted", {SCENES[0]: samples}, annotations, AT_ORIGIN)
    tables = NuScenes("v1.0-mini", str(folder / "converted"), verbose=False)
    detections, theirs = found[found["kind"] == "detection"], {}
    # The devkit refuses scores below 0: all are moved alike, the least to 1.
    detections = detections.assign(score=detections["score"] - detections["score"].min() + 1.0)
    for name, of_detector in detections.groupby("detector"):
        write_submission(folder / f"{name}.json", of_detector[::-1], egos)
        of_devkit = devkit_numbers(tables, folder / f"{name}.json", folder / "devkit")
        # What is not labelled has no number with us, and the worst one with the devkit.
        unknown = {key for key, it in ours[name].items() if math.isnan(it) and of_devkit.get(key) in (0.0, 1.0)}
        theirs[name] = {key: it for key, it in of_devkit.items() if key not in unknown}
    compare("nuscenes", "simulated streets", MAKER, ours, theirs, 60)


def check_reading(scanbench: str, folder: Path) -> None:
    """A drawn scene: points and boxes in the frame of the sensor, of which ours has x forward and the devkit y."""
    random, root = np.random.default_rng(13), folder / "drawn"
    classes = {"vehicle.car": "Car", "vehicle.bus.rigid": "Bus", "human.pedestrian.adult": "Pedestrian", "animal": "Animal"}
    lidar = pose([0.94, 0.01, 1.84], Quaternion(0.7077, 0.0047, -0.009, -0.7064).unit)
    (root / "samples/LIDAR_TOP").mkdir(parents=True)
    samples, annotations = {}, []
    for number in range(5):
        sample = f"sample{number}"
        axis, at = [*random.normal(0, 0.02, 2), 1.0], random.normal(0, 1000, 3)
        samples[sample] = 10**15 + number, pose(at, Quaternion(axis=axis, radians=random.uniform(-np.pi, np.pi)))
        random.normal(0, 20, (1000, 5)).astype("<f4").tofile(root / cloud_of(sample))
        for index in range(20):
            # Upright in the world, as all are that people have labelled.
            box = pose(at + random.uniform(-40, 40, 3), upright(random.uniform(-np.pi, np.pi)))
            thing = {"thing": f"{sample}-{index}", "category": random.choice(list(classes)), "num_lidar_pts": 1}
            annotations.append({"sample_token": sample, "size": random.uniform(0.5, 5, 3).tolist()} | box | thing)
    write_tables(root, {"scene-0001": samples}, annotations, lidar)
    tables, converted = NuScenes("v1.0-mini", str(root), verbose=False), folder / "drawn-converted"
    run(scanbench, "data", "convert", root, "-o", converted, "--to", "kitti-object")
    for number, sample in enumerate(samples):
        path, of_devkit, _ = tables.get_sample_data(f"data{sample}")
        right, forward, up, intensity = LidarPointCloud.from_file(path).points
        found = points(converted, number)
        assert np.array_equal(found[:, :3], np.column_stack([forward, -right, up]))
        assert np.allclose(found[:, 3], intensity / 255)
        expected = []
        for it in of_devkit:
            (right, forward, up), (width, length, height), heading = it.center, it.wlh, it.orientation.rotate([1, 0, 0])
            box = [forward, -right, up, length, width, height, np.arctan2(-heading[0], heading[1])]
            expected.append((classes[it.name], np.array(box)))
        assert_same(boxes(converted, number), expected)
    print(f"  nuscenes: {len(annotations)} boxes of a drawn scene as {MAKER} has them")


def check_scenes() -> None:
    """The scenes of the data set `nuscenes-val`."""
    catalogue = tomllib.loads((Path(__file__).parents[2] / "datasets.toml").read_text())
    ours = catalogue["recorded"]["nuscenes-val"]["sequences"]
    if sorted(ours) != sorted(splits.val):
        sys.exit(f"nuscenes-val has {len(ours)} scenes, which are not the {len(splits.val)} of the devkit")
    print(f"  nuscenes: the {len(ours)} scenes of nuscenes-val are those of {MAKER}")


if __name__ == "__main__":
    check_scenes()
    for check in (check_reading, check_made_up, check_streets):
        check(sys.argv[1], Path(sys.argv[2]))
