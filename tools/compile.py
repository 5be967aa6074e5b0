"""Compile the estimators in ``install`` to machine code with mypyc: the same results, faster.

The code that runs for every sample of every wheel (layers 1 and 2) is compiled from its typed Python source and put
beside it. Without this step (a plain ``colcon build``) the Python modules run, with equal results to the last bit:
tests compare the two.
Called by build.py; the compiler's own files stay in ``build/mypyc``, so that the next time takes less.
"""

from __future__ import annotations

import filecmp
import os
import shutil
import sys
from pathlib import Path

from progress import run_with_progress

COMPILED = {
    "friction_runtime": "aligned_processor aligner brake_torque cdr_codec cdr_layout new_message pressure_watch "
    "primary processor_graph reason_text slip_fault stamp_progress stamps wheel_speeds wire",
    "vehicle_models": "acceleration_unit derivatives physical_bounds pressure_unit wheel_load",
    "wheel_slip": "accelerometer_age accelerometer_watch brake_pressures carried_wheels close_wheel estimate estimator "
    "free_rolling mode online_radii outvoted processor radius_calibration radius_doubt released_wheels ring_gap "
    "sensor_age sensor_skew sensor_watch slide_detector slip slope_watch speed_filter speed_parameters speed_queue "
    "speed_sample speed_sensor stuck_sensor unfelt_dive unit_check unseen_road vehicle_speed wheel_bounds wheel_noise "
    "wheel_speed_filter",
    "friction_slope": "crossing detector doubt estimate indicator messages processor signals told_slips "
    "tyre_relaxation vote",
    "abs_supervisor": "braking braking_log coming_back curve_control curve_queue curve_report end_of_stop envelope "
    "fsm guard input_watch known_curve law/brake_line law/disturbance law/explained law/late_brake "
    "law/released_wheel law/road_curve law/set_point law/three_commands law/torque_set_point law/usable_curve "
    "law/wheel_observer law/wheel_step own_fall pressure_check processor reference_wheel release_caps "
    "release_evidence road_torque rolling_scatter speed_trend sudden_stop supervisor wheel_check wheel_inputs "
    "wheel_motion wheel_pair",
    "friction_curve_id": "activation car/pitch_filter car_processor chapter/curve_fitting chapter/dead_reckoning "
    "chapter/exponential_curve chapter/friction_samples chapter/recursive_ls chapter/square_root curve/fitted_curve "
    "curve_messages inputs processor wheel_inputs",
    "friction_bags": "bag_io/bag_writer bag_io/cdr bag_io/mcap_chunk bag_io/mcap_writer offline/stage_run",
    "friction_parameters": "",
}
"""Modules by package, as paths within it. The compiled modules need the types of a package without any."""


def compile_modules(root: Path) -> int:
    """Compile the modules of the installed packages; return the exit status."""
    staging = root / "build" / "mypyc"
    present = {package: names.split() for package, names in COMPILED.items() if (root / "src" / package).is_dir()}
    if not present:
        return 0
    for package in present:
        _copy_changed(root / "src" / package / package, staging / package)
    for library in staging.glob("**/*.so"):
        library.unlink()
    files = [f"{package}/{name}.py" for package, names in present.items() for name in names]
    # Imports are followed for their types only: how strict numpy's are depends on its version.
    options = ["--config-file", str(root / "pyproject.toml"), "--follow-imports", "silent"]
    command = [sys.executable, "-m", "mypyc", *options, *files]
    # The messages are untyped here as they are for mypy; no debugging information, which takes longer than the rest.
    env = dict(os.environ, MYPYC_OPT_LEVEL="2", MYPYC_DEBUG_LEVEL="0", MYPYPATH=str(staging))
    log = root / "build" / "mypyc.log"
    code = run_with_progress("mypyc", command, log, lambda _: f"{len(files)} modules", env, staging)
    if code != 0:
        print(*log.read_text().splitlines()[-25:], sep="\n")
        return code
    for setup in (root / "src").glob("*/setup.py"):  # a module that is listed no more must not stay compiled
        for library in (root / "install" / setup.parent.name).glob("**/*.so"):
            library.unlink()
    for package in present:
        for library in (staging / package).glob("**/*.so"):
            shutil.copy2(library, _installed(root, package) / library.relative_to(staging / package))
    for library in staging.glob("*__mypyc*.so"):  # what they share lies beside the first of their packages
        shutil.copy2(library, _installed(root, next(iter(present))).parent)
    return 0


def _copy_changed(source: Path, target: Path) -> None:
    """Copy the modules of a package; unchanged ones keep their date, so that mypy's cache stays valid."""
    names = {path.relative_to(source) for path in source.glob("**/*.py")}
    for path in target.glob("**/*.py"):
        if path.relative_to(target) not in names:
            path.unlink()
    for name in names:
        if not (target / name).exists() or not filecmp.cmp(source / name, target / name, shallow=False):
            (target / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source / name, target / name)


def _installed(root: Path, package: str) -> Path:
    """Directory of an installed package, wherever this Python's installations put it."""
    return next((root / "install" / package).glob(f"**/{package}/__init__.py")).parent
