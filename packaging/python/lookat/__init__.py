"""Reads, renders and compares pbrt-v3 scenes.

    import lookat

    scene = lookat.load("scene.pbrt")
    scene.camera.look_at(eye=(0, 2, -8), target=(0, 1, 0))
    picture = lookat.render(scene, spp=64)
    picture.save("picture.exr")

`docs/python.md` describes it all; the stubs beside this file have the types.
"""

from . import _lookat
from ._lookat import (
    Camera,
    Chart,
    Film,
    Mesh,
    Picture,
    Scene,
    SceneError,
    __version__,
    chart,
    check,
    compare,
    load,
)

__all__ = [
    "Camera",
    "Chart",
    "Film",
    "Mesh",
    "Picture",
    "Scene",
    "SceneError",
    "__version__",
    "chart",
    "check",
    "compare",
    "load",
    "render",
]


def render(scene, *, progress=None, **settings):
    """Renders a scene, or the scene of a path or a text: see the stubs beside this file."""
    if not isinstance(scene, Scene):
        scene = load(scene)
    if progress is not True:
        return _lookat.render(scene, progress=progress or None, **settings)
    try:
        from tqdm.auto import tqdm
    except ImportError:
        return _lookat.render(scene, **settings)
    with tqdm(unit=" samples", unit_scale=True) as bar:

        def show(done, total):
            bar.total = total
            bar.update(done - bar.n)

        return _lookat.render(scene, progress=show, **settings)
