"""A run's file and a study's index, as h5py sees them.

Usage: h5md.py RECKON STUDY. Exit code 77 (skipped) where h5py is not installed.
"""
import pathlib
import subprocess
import sys
import tempfile

try:
    import h5py
    import numpy
except ImportError as missing:
    print(f"skipped: {missing} (Debian: python3-h5py)")
    sys.exit(77)

RECKON, STUDY = sys.argv[1], sys.argv[2]
GRAINS, FRAMES, SAMPLES, STEPS_A_PERIOD = 61, 5, 81, 25000


def text(value):
    return value.decode() if isinstance(value, bytes) else str(value)


def check_h5md(run):
    assert list(run["h5md"].attrs["version"]) == [1, 1]
    assert text(run["h5md/creator"].attrs["name"]) == "reckon"
    assert text(run["h5md/author"].attrs["name"])
    assert list(run["h5md/modules/units"].attrs["version"]) == [1, 0]


def check_grains(run, periodic, rotates):
    grains = run["particles/grains"]
    box = grains["box"]
    assert box.attrs["dimension"] == 2
    assert [text(b) for b in box.attrs["boundary"]] == ["periodic" if periodic else "none", "none"]
    assert box["edges"].shape == (2,) and (not periodic or box["edges"][0] == 10)
    assert grains["radius"].shape == grains["mass"].shape == (GRAINS,)
    assert numpy.isclose(grains["radius"][:].max(), 1.5)
    assert ("angle" in grains) == ("angular_velocity" in grains) == rotates
    shapes = {"position": (2,), "velocity": (2,)}
    if rotates:
        shapes.update(angle=(), angular_velocity=())
    for name, width in shapes.items():
        element = grains[name]
        assert element["value"].shape == (FRAMES, GRAINS, *width), name
        assert element["value"].dtype == numpy.float32 and element["value"].compression == "gzip"
        assert numpy.isfinite(element["value"][:]).all()
        assert element["step"][:].tolist() == [STEPS_A_PERIOD * i for i in range(FRAMES)]
        assert numpy.allclose(element["time"][:], element["step"][:] * 3.952847075210474 / 25000)
        assert text(element["value"].attrs["unit"])
    if periodic:
        x = grains["position/value"][:, :, 0]
        assert (x >= 0).all() and (x <= 10).all()


def check_observables(run):
    height = run["observables/intruder/height"]
    assert height["value"].shape == (SAMPLES,) and height["value"].dtype == numpy.float64
    assert height["step"].shape == () and height["step"].attrs["offset"] == 0
    assert numpy.isclose(height["time"][()] * (SAMPLES - 1), run["provenance"].attrs["time"])
    # The same grain at the same moment, recorded in two ways.
    frames = height["value"][:: (SAMPLES - 1) // (FRAMES - 1)]
    assert text(height["value"].attrs["unit"]) == "d" and len(frames) == FRAMES
    for probe in run["observables"].values():
        for column in probe.values():
            assert column["value"].shape == (SAMPLES,)


def check_contacts(run, rotates):
    """What touches and what presses, recorded in two ways: per contact and by the probes."""
    contacts, probes = run["contacts"], run["observables"]
    every = (SAMPLES - 1) // (FRAMES - 1)
    count = contacts["count"][:]
    assert count.shape == (FRAMES,) and contacts["steps_per_period"][()] == STEPS_A_PERIOD
    assert contacts["step"][:].tolist() == run["particles/grains/position/step"][:].tolist()
    columns = "first", "second", "angle", "normal_force", "tangential_force"
    ends = count.cumsum()
    for name in columns:
        assert contacts[name].shape == (ends[-1],), name
    for frame, end in enumerate(ends):
        _, second, angle, normal, tangential = (
            contacts[name][end - count[frame] : end].astype(float) for name in columns)
        ends_of_contacts = 2 * (second >= 0).sum() + (second < 0).sum()
        assert ends_of_contacts / GRAINS == probes["bed/coordination/value"][frame * every]
        on_plate = second == -1  # wall 0; a force and its angle are floats
        for axis, force in (("x", normal * numpy.cos(angle) - tangential * numpy.sin(angle)),
                            ("y", normal * numpy.sin(angle) + tangential * numpy.cos(angle))):
            allowed = 4 * numpy.finfo(numpy.float32).eps * numpy.hypot(normal, tangential)[on_plate].sum()
            probed = probes[f"plate/force_{axis}/value"][frame * every]
            assert abs(force[on_plate].sum() - probed) <= allowed
        assert rotates or (tangential == 0).all()


def check_provenance(run, name):
    about = run["provenance"].attrs
    assert text(about["run"]) == name and about["seed"] == 11 and text(about["status"]) == "done"
    for key in ("identity", "code_version", "hdf5_version", "gsl_version", "point", "case"):
        assert text(about[key]), key
    assert about["steps"] == 4 * STEPS_A_PERIOD
    assert run["provenance/preparation"].attrs["steps"] > 0
    assert run["parameters/grains/count"][()] == 60
    assert text(run["parameters/contact/kn"].attrs["unit"])
    assert text(run["parameters/contact/friction"][()]) in ("none", "cundall-strack")


def check_index(folder):
    with h5py.File(folder / "study.h5") as study:
        assert [text(s) for s in study["runs"]["state"]] == ["done"] * 6
        for point in ("walls", "pbc"):
            stacked = study[f"observables/{point}/intruder/height"]
            assert stacked.shape == (3, SAMPLES) and stacked.is_virtual
            assert study[f"observables/{point}/complete"][:].tolist() == [1, 1, 1]
            for replica in range(3):
                run = study[f"files/{point}-{replica:04}"]
                assert (run["observables/intruder/height/value"][:] == stacked[replica]).all()
            assert len({row.tobytes() for row in stacked[:]}) == 3


def check_gap(folder):
    """A run that is missing reads as NaN and is marked."""
    (folder / "runs" / "pbc-0001.h5").rename(folder / "away")
    with h5py.File(folder / "study.h5") as study:
        rows = study["observables/pbc/intruder/height"][:]
    assert numpy.isnan(rows[1]).all() and numpy.isfinite(rows[[0, 2]]).all()


def main():
    with tempfile.TemporaryDirectory(prefix="rk-h5md-") as name:
        folder = pathlib.Path(name) / "out"
        subprocess.run([RECKON, "run", STUDY, "-o", str(folder), "--quiet"], check=True)
        for run in ("walls-0000", "pbc-0002"):
            with h5py.File(folder / "runs" / f"{run}.h5") as file:
                check_h5md(file)
                check_grains(file, periodic=run < "q", rotates=run > "q")
                check_observables(file)
                check_contacts(file, rotates=run > "q")
                check_provenance(file, run)
        check_index(folder)
        check_gap(folder)
    print("h5py finds every H5MD element, and the index agrees with the files")


main()
