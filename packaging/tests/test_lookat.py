"""The wheel, in an environment of its own: the module, the program, and others that read what they write."""

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

import lookat

SCENES = Path(__file__).parents[2] / "pbrt-scenes"
MATTE = SCENES / "cornell-matte.pbrt"
TEXT = """LookAt 0 0 -4  0 0 0  0 1 0
Camera "perspective" "float fov" 40
Film "image" "integer xresolution" 32 "integer yresolution" 24
Sampler "sobol" "integer pixelsamples" 4
Integrator "path"
WorldBegin
LightSource "infinite" "rgb L" [.5 .5 .5]
Shape "trianglemesh" "point P" [-1 -1 0  1 -1 0  0 1 0] "integer indices" [0 1 2] "float uv" [0 0 1 0 0 1]
WorldEnd
"""


def program(*arguments):
    """Runs the program of the wheel."""
    path = Path(sys.executable).with_name("lookat")
    return subprocess.run([path, *map(str, arguments)], capture_output=True, text=True)


def test_a_picture_has_the_bits_of_the_programs(tmp_path):
    scene = lookat.load(MATTE)
    picture = lookat.render(scene, spp=8, seed=3, layers=["depth", "normal"])
    file = tmp_path / "a.exr"
    run = program("render", MATTE, "--spp", 8, "--seed", 3, "--layers", "depth,normal", "-q", "-o", file)
    assert run.returncode == 0, run.stderr
    own = lookat.Picture.read(file)
    assert np.array_equal(picture.pixels, own.pixels)
    assert picture.pixels.dtype == np.float32 and picture.pixels.shape == (128, 128, 3)
    assert np.array_equal(picture.layers["depth"], own.layers["depth"])
    assert picture.layers["normal"].shape == (128, 128, 3)
    assert picture.statistics["samples_per_pixel"] == 8 and picture.statistics["complete"]
    for threads in [1, 3]:
        again = lookat.render(scene, spp=8, seed=3, threads=threads)
        assert np.array_equal(again.pixels, picture.pixels)


def test_camera_and_film_change_the_picture(tmp_path):
    scene = lookat.load(MATTE)
    assert scene.camera.kind == "perspective"
    scene.camera.fov = 30
    scene.camera.look_at(eye=(0, 1, -6), target=(0, 1, 0))
    scene.film.resolution = (64, 48)
    scene.spp = 4
    assert scene.camera.fov == 30 and scene.film.resolution == (64, 48) and scene.camera.eye == (0, 1, -6)
    picture = lookat.render(scene)
    file = tmp_path / "a.exr"
    options = ["--fov", 30, "--lookat", "0 1 -6 0 1 0 0 1 0", "--resolution", "64x48", "--spp", 4]
    assert program("render", MATTE, *options, "-q", "-o", file).returncode == 0
    assert np.array_equal(picture.pixels, lookat.Picture.read(file).pixels)
    scene.film.crop = (8, 24, 0, 16)
    cropped = lookat.render(scene)
    assert cropped.window == (8, 0, 16, 16)
    assert np.array_equal(cropped.pixels, picture.pixels[0:16, 8:24])
    matrix = scene.camera.world_from_camera
    assert matrix.shape == (4, 4) and np.allclose(matrix[:3, 3], [0, 1, -6])
    scene.camera.world_from_camera = matrix
    assert np.array_equal(lookat.render(scene).pixels, cropped.pixels)


@pytest.mark.parametrize(
    "change",
    [
        lambda scene: setattr(scene.camera, "fov", 180),
        lambda scene: setattr(scene.camera, "fov", float("nan")),
        lambda scene: setattr(scene.camera, "focal_distance", 3),
        lambda scene: setattr(scene.camera, "lens_radius", -1),
        lambda scene: setattr(scene.camera, "world_from_camera", np.zeros((4, 4))),
        lambda scene: setattr(scene.camera, "shutter", (1, 0)),
        lambda scene: scene.camera.look_at((0, 0, 0), (0, 0, 0)),
        lambda scene: setattr(scene.film, "resolution", (0, 1)),
        lambda scene: setattr(scene.film, "resolution", (100_000, 100_000)),
        lambda scene: setattr(scene.film, "crop", (0, 129, 0, 1)),
        lambda scene: setattr(scene.film, "scale", float("inf")),
        lambda scene: setattr(scene, "spp", 0),
        lambda scene: lookat.render(scene, spp=0),
        lambda scene: lookat.render(scene, target_error=2),
        lambda scene: lookat.render(scene, adaptive=True, error_layers=True),
        lambda scene: lookat.render(scene, layers=["deph"]),
        lambda scene: lookat.render(scene, threads=5000),
        lambda scene: lookat.render(scene, time=0),
        lambda scene: lookat.render(scene, spp=1).save("x.png", exposure=float("nan")),
        lambda scene: lookat.compare(scene, scene, threshold=-1),
        lambda scene: scene.camera.world_from_camera.__setitem__((0, 3), 5),
        lambda scene: lookat.compare(scene, scene),
        lambda scene: lookat.compare(np.zeros((4, 4, 2), np.float32), np.zeros((4, 4, 3), np.float32)),
        lambda scene: lookat.Mesh(np.zeros((3, 2)), np.zeros((1, 3), np.int32)),
        lambda scene: lookat.Mesh(np.zeros((3, 3)), np.full((1, 3), 3)),
        lambda scene: lookat.Mesh(np.zeros((3, 3)), [[0, 1, 2**40]]),
        lambda scene: lookat.Mesh(np.zeros((3, 3)), [[0.5, 1, 2]]),
        lambda scene: lookat.Mesh([["a", "b", "c"]], [[0, 0, 0]]),
        lambda scene: lookat.Mesh([1, 2, 3], [[0, 0, 0]]),
        lambda scene: lookat.Mesh(np.full((3, 3), np.nan), np.zeros((1, 3), np.int32)),
        lambda scene: scene.set_mesh(1000, scene.meshes[0]),
        lambda scene: lookat.chart(scene, spp=3),
        lambda scene: lookat.chart(scene, methods=["magic"]),
    ],
)
def test_what_makes_no_sense_is_refused(change):
    scene = lookat.load(MATTE)
    before = lookat.render(scene, spp=1).pixels
    with pytest.raises((ValueError, TypeError, IndexError)) as error:
        change(scene)
    assert str(error.value)
    assert np.array_equal(lookat.render(scene, spp=1).pixels, before)


def test_scenes_with_errors_are_explained():
    text = TEXT.replace('"trianglemesh"', '"trianglemehs"')
    with pytest.raises(lookat.SceneError) as error:
        lookat.load(text)
    assert 'unknown Shape "trianglemehs"' in str(error.value) and ":8:" in str(error.value)
    [first, *_] = error.value.diagnostics
    assert first["severity"] == "error" and first["labels"][0]["line"] == 8
    assert lookat.check(text) == error.value.diagnostics
    assert lookat.check(TEXT) == []
    with pytest.raises(lookat.SceneError):
        lookat.load("no-such-file.pbrt")


def test_meshes_are_views_of_the_scene():
    scene = lookat.load(TEXT)
    [mesh] = scene.meshes
    assert mesh.positions.shape == (3, 3) and mesh.indices.tolist() == [[0, 1, 2]] and mesh.uvs.shape == (3, 2)
    assert mesh.normals.shape == (0, 3)
    addresses = {again.positions.__array_interface__["data"][0] for again in [mesh, mesh, scene.meshes[0]]}
    assert len(addresses) == 1
    with pytest.raises(ValueError):
        mesh.positions[0, 0] = 5
    positions = mesh.positions
    before = lookat.render(scene)
    scene.set_mesh(0, lookat.Mesh(mesh.positions + [0.5, 0, 0], mesh.indices, uvs=mesh.uvs))
    del mesh
    after = lookat.render(scene)
    moved = TEXT.replace("[-1 -1 0  1 -1 0  0 1 0]", "[-.5 -1 0  1.5 -1 0  .5 1 0]")
    assert not np.array_equal(before.pixels, after.pixels)
    assert np.array_equal(after.pixels, lookat.render(lookat.load(moved)).pixels)
    # The old mesh lives as long as its array.
    assert positions.tolist()[0] == [-1, -1, 0]


def test_meshes_of_numpy_are_not_copied():
    positions = np.array([[-1, -1, 0], [1, -1, 0], [0, 1, 0]], dtype=np.float64)
    indices = np.array([[0, 1, 2]], dtype=np.int32)
    uvs = np.array([[0, 0], [1, 0], [0, 1]], dtype=np.float64)
    assert positions.flags.writeable and lookat.Mesh(positions, indices, uvs=uvs) and positions.flags.writeable
    mesh = lookat.Mesh(positions, indices, uvs=uvs, copy=False)
    for own, array in [(mesh.positions, positions), (mesh.indices, indices), (mesh.uvs, uvs)]:
        assert own.__array_interface__["data"][0] == array.__array_interface__["data"][0]
        assert np.array_equal(own, array) and not array.flags.writeable
        with pytest.raises(ValueError):
            array[0, 0] = 1
    scene = lookat.load(TEXT)
    expected = lookat.render(scene)
    scene.set_mesh(0, mesh)
    del mesh, positions, indices, uvs
    assert np.array_equal(lookat.render(scene).pixels, expected.pixels)
    # Where others could write, the arrays are copied: a view, and what has another type or order.
    base = np.zeros((4, 3))
    fixed = base[:3]
    fixed.flags.writeable = False
    indices = np.array([[0, 1, 2]], dtype=np.int64)
    mesh = lookat.Mesh(fixed, indices, copy=False)
    base[0, 0] = 5
    assert mesh.positions[0, 0] == 0
    base[0, 0] = 0
    for positions in [base[:3], np.zeros((3, 3), np.float32), np.asfortranarray(np.zeros((3, 3)))]:
        mesh = lookat.Mesh(positions, indices, copy=False)
        assert positions.flags.writeable and indices.flags.writeable
        positions[0, 0] = 7
        assert mesh.positions[0, 0] == 0
    # What is refused can still be written.
    positions = np.full((3, 3), np.inf)
    with pytest.raises(ValueError):
        lookat.Mesh(positions, indices, copy=False)
    assert positions.flags.writeable
    again = lookat.Mesh(mesh.positions, mesh.indices, copy=False)
    assert again.positions.__array_interface__["data"][0] == mesh.positions.__array_interface__["data"][0]
    assert lookat.Mesh(np.zeros((0, 3)), np.zeros((0, 3), np.int32)).positions.shape == (0, 3)


def test_checks_look_at_the_view():
    beside = TEXT.replace("LookAt 0 0 -", "LookAt 0 50 -")
    assert lookat.check(beside) == []
    assert any("nothing" in found["message"] or "view" in found["message"] for found in lookat.check(beside, view=True))
    assert lookat.check(TEXT, view=True) == []


def test_errors_are_layers_and_are_compared():
    scene = lookat.load(MATTE)
    a = lookat.render(scene, spp=64, error_layers=True)
    b = lookat.render(scene, spp=64, seed=1, error_layers=True)
    assert a.standard_error.shape == a.pixels.shape and (a.samples == 64).all()
    assert lookat.compare(a, b)["noise"]["agree"] is True
    brighter = lookat.compare(a.pixels * np.float32(1.1), b.pixels)
    assert brighter["metrics"]["error"] > 0 and brighter["noise"] is None
    assert set(lookat.compare(a, b, only=["rmse"])["metrics"]) == {"rmse"}
    file = SCENES / "cornell-matte.exr"
    assert lookat.compare(a, file)["metrics"]["rmse"] < 0.05
    target = lookat.render(scene, target_error=0.2, spp=256)
    assert target.statistics["target"]["within"] > 0


def test_pictures_are_shown_and_saved(tmp_path):
    picture = lookat.render(TEXT)
    assert picture._repr_png_()[:8] == b"\x89PNG\r\n\x1a\n"
    assert np.asarray(picture).shape == (24, 32, 3)
    assert np.array(picture, dtype=np.float64).dtype == np.float64
    for name in ["a.exr", "a.pfm", "a.png", "a.tga"]:
        picture.save(tmp_path / name)
    assert np.array_equal(lookat.Picture.read(tmp_path / "a.exr").pixels, picture.pixels)
    assert np.array_equal(lookat.Picture.read(tmp_path / "a.pfm").pixels, picture.pixels)
    picture.save(tmp_path / "b.png", exposure="auto", tone="aces")
    for arguments in [("c.gif",), ("none/c.exr",), ("c.exr", 1.0), ("c.png", 0.0, "rainbow")]:
        with pytest.raises((OSError, ValueError)):
            picture.save(tmp_path / arguments[0], *arguments[1:])
    with pytest.raises(ValueError):
        lookat.Picture.read(tmp_path / "none.exr")


def test_files_are_those_of_the_program(tmp_path):
    own, other = tmp_path / "own.exr", tmp_path / "other.exr"
    for settings, options in [({}, []), ({"error_layers": True, "layers": ["shape"], "spp": 32}, ["--error-layers", "--layers", "shape", "--spp", "32"])]:
        lookat.render(MATTE, seed=3, **settings).save(own)
        assert program("render", MATTE, "--seed", 3, *options, "-q", "--force", "-o", other).returncode == 0
        assert own.read_bytes() == other.read_bytes()


def test_others_read_the_files(tmp_path):
    OpenEXR = pytest.importorskip("OpenEXR")
    mi = pytest.importorskip("mitsuba")
    picture = lookat.render(lookat.load(MATTE), spp=4, layers=["depth"])
    file = tmp_path / "a.exr"
    picture.save(file)
    with OpenEXR.File(str(file)) as found:
        channels = found.channels()
        assert np.array_equal(channels["RGB"].pixels, picture.pixels)
        assert np.array_equal(channels["Z"].pixels, picture.layers["depth"])
    part = tmp_path / "part.exr"
    assert program("render", MATTE, "--spp", 4, "--part", "0/2", "-q", "-o", part).returncode == 0
    with OpenEXR.File(str(part), separate_channels=True) as found:
        assert found.channels()["sums.R.0"].pixels.dtype == np.uint32
    lookat.render(lookat.load(MATTE), spp=4).save(file)
    assert np.array_equal(np.array(mi.Bitmap(str(file))), picture.pixels)


def test_other_threads_run_and_progress_is_told():
    scene, told, ticks = lookat.load(MATTE), [], []
    done = threading.Event()

    def count():
        while not done.is_set():
            ticks.append(time.perf_counter())
            time.sleep(0.001)

    thread = threading.Thread(target=count)
    thread.start()
    lookat.render(scene, spp=256, progress=lambda done, all: told.append((done, all)))
    done.set()
    thread.join()
    assert len(told) > 1 and told[-1][0] == told[-1][1] and all(done <= all for done, all in told)
    assert len(ticks) > 20
    with pytest.raises(ZeroDivisionError):
        lookat.render(scene, spp=4096, progress=lambda done, all: 1 / 0)
    lookat.render(scene, spp=16, progress=True)


@pytest.mark.skipif(os.name != "posix", reason="signals")
def test_ctrl_c_ends_a_rendering():
    code = f"import lookat; lookat.render({str(MATTE)!r}, spp=65536)"
    child = subprocess.Popen([sys.executable, "-c", code], stderr=subprocess.PIPE, text=True)
    time.sleep(2)
    child.send_signal(signal.SIGINT)
    started = time.monotonic()
    _, err = child.communicate(timeout=20)
    assert child.returncode != 0 and "KeyboardInterrupt" in err
    assert time.monotonic() - started < 2


def test_a_chart_has_errors_and_times():
    scene = lookat.load(TEXT)
    chart = lookat.chart(scene, methods=["sobol", "random"], spp=4)
    assert chart.svg.startswith("<svg") or "<svg" in chart.svg
    assert [method["name"] for method in chart.results["methods"]] == ["sobol", "random"]


def test_the_notebook_runs():
    nbclient = pytest.importorskip("nbclient")
    nbformat = pytest.importorskip("nbformat")
    notebook = nbformat.read(SCENES.parent / "docs" / "python.ipynb", as_version=4)
    nbclient.NotebookClient(notebook, resources={"metadata": {"path": SCENES.parent / "docs"}}).execute()
    shown = [output.get("data", {}) for cell in notebook.cells for output in cell.get("outputs", [])]
    assert sum("image/png" in data for data in shown) == 3


def test_cameras_without_a_lookat_are_placed(tmp_path):
    text = TEXT.replace("LookAt 0 0 -4  0 0 0  0 1 0", "Translate 0 0 4")
    scene = lookat.load(text)
    scene.camera.look_at((1, 0, -5), (0, 0, 0))
    (tmp_path / "a.pbrt").write_text(text)
    run = program("render", tmp_path / "a.pbrt", "--lookat", "1 0 -5 0 0 0 0 1 0", "-q", "-o", tmp_path / "a.exr")
    assert run.returncode == 0, run.stderr
    assert np.array_equal(lookat.render(scene).pixels, lookat.Picture.read(tmp_path / "a.exr").pixels)
    follows = lookat.load(TEXT.replace("Shape", 'CoordSysTransform "camera" Translate 0 0 4 Shape'))
    with pytest.raises(ValueError, match="CoordSysTransform"):
        follows.camera.look_at((1, 0, -5), (0, 0, 0))


def test_threads_share_a_scene():
    scene, pictures = lookat.load(MATTE), []
    threads = [threading.Thread(target=lambda: pictures.append(lookat.render(scene, spp=16))) for _ in range(4)]
    for thread in threads:
        thread.start()
    scene.camera.fov = scene.camera.fov
    for thread in threads:
        thread.join()
    assert len(pictures) == 4 and all(np.array_equal(it.pixels, pictures[0].pixels) for it in pictures)


@pytest.mark.skipif(not hasattr(os, "fork"), reason="fork")
def test_a_forked_process_is_told():
    code = """import lookat, os, sys
lookat.render(sys.argv[1], spp=1)
if os.fork() == 0:
    try:
        lookat.render(sys.argv[1], spp=1)
    except RuntimeError as error:
        os._exit("spawn" in str(error))
    os._exit(2)
sys.exit(os.waitstatus_to_exitcode(os.wait()[1]) - 1)
"""
    assert subprocess.run([sys.executable, "-c", code, str(MATTE)], timeout=60).returncode == 0


def test_what_does_not_fit_the_memory_is_refused():
    scene = lookat.load(TEXT)
    scene.film.resolution = (10_000, 10_000)
    with pytest.raises(MemoryError):
        lookat.render(scene, target_error=0.1)
