"""Reads, renders and compares pbrt-v3 scenes."""

from os import PathLike
from pathlib import Path
from typing import Any, Callable, Dict, List, Literal, Optional, Sequence, Tuple, Union

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str

_Path = Union[str, PathLike[str]]
_Vector = Sequence[float]
_Picture = Union["Picture", _Path, NDArray[np.float32]]

class SceneError(ValueError):
    """A scene has errors."""

    diagnostics: List[Dict[str, Any]]
    """All problems of the scene, as in `check`."""

class Camera:
    """The camera of a scene. What is set changes the scene. Values out of range raise `ValueError`."""

    @property
    def kind(self) -> Literal["perspective", "orthographic", "environment", "realistic"]: ...
    @property
    def eye(self) -> Tuple[float, float, float]:
        """The position of the eye in the world."""
    fov: Optional[float]
    """The angle of view along the shorter side, in degrees, above 0 and below 180. Only a perspective camera takes another."""
    lens_radius: float
    """The radius of the aperture, in units of camera space; 0 is a pinhole. A pinhole that gets a lens is focused far away."""
    focal_distance: Optional[float]
    """The distance to the plane in focus, in units of camera space; None for a pinhole."""
    screen_window: Tuple[float, float, float, float]
    """The part of the screen on the film: x from, x to, y from, y to."""
    shutter: Tuple[float, float]
    """When the shutter opens and closes, in units of TransformTimes."""
    world_from_camera: NDArray[np.float64]
    """World from camera space: 4 x 4, for column vectors. A copy: set the whole matrix."""
    def look_at(self, eye: _Vector, target: _Vector, up: _Vector = (0.0, 1.0, 0.0)) -> None:
        """Places the eye, and turns the camera to a point."""

class Film:
    """The film of a scene. What is set changes the scene. Values out of range raise `ValueError`."""

    resolution: Tuple[int, int]
    """Width and height of the full picture in pixels. Another one resets the crop window."""
    crop: Tuple[int, int, int, int]
    """The pixels to render: left, right, top, bottom; the right and the bottom one are behind the last."""
    scale: float
    """The factor on every pixel."""
    max_sample_luminance: float
    """The largest luminance of a sample: brighter ones are scaled down."""

class Mesh:
    """A triangle mesh. Its arrays are read-only views of its memory."""

    def __init__(
        self,
        positions: ArrayLike,
        indices: ArrayLike,
        normals: Optional[ArrayLike] = None,
        uvs: Optional[ArrayLike] = None,
        *,
        copy: bool = True,
    ) -> None:
        """Vertices in world space (N x 3), and three vertex numbers for each triangle (M x 3).

        With `copy=False`, arrays of float64 and int32 in C order that own their memory are not copied but locked: writing to them raises
        `ValueError`. Their memory must not change while the mesh lives. Do not unlock or resize them, and do not write through views that were
        made before: the program may crash. Other arrays are copied all the same.
        """
    @property
    def positions(self) -> NDArray[np.float64]: ...
    @property
    def indices(self) -> NDArray[np.int32]: ...
    @property
    def normals(self) -> NDArray[np.float64]: ...
    @property
    def uvs(self) -> NDArray[np.float64]: ...

class Scene:
    """A scene, from `load`."""

    @property
    def camera(self) -> Camera: ...
    @property
    def film(self) -> Film: ...
    spp: int
    """Samples per pixel."""
    @property
    def output(self) -> Path:
        """The file that the scene names for its picture."""
    @property
    def diagnostics(self) -> List[Dict[str, Any]]:
        """The warnings and notes of the scene, as in `check`."""
    @property
    def meshes(self) -> List[Mesh]:
        """The triangle meshes of the world, without those of objects."""
    def set_mesh(self, index: int, mesh: Mesh) -> None:
        """Replaces a mesh, by its number in `meshes`. It keeps material, light and medium."""

class Picture:
    """A picture, from `render` or from a file."""

    @staticmethod
    def read(path: _Path) -> Picture:
        """Reads .exr, .pfm, .png, .tga, .jpg or .hdr."""
    @property
    def pixels(self) -> NDArray[np.float32]:
        """Linear RGB: height x width x 3. A new copy each time."""
    @property
    def layers(self) -> Dict[str, NDArray[np.float32]]:
        """The layers by their names in `render`: height x width, or height x width x channels."""
    @property
    def standard_error(self) -> Optional[NDArray[np.float32]]:
        """The standard error of each value: height x width x 3. None without error layers."""
    @property
    def samples(self) -> Optional[NDArray[np.uint32]]:
        """The samples of each pixel: height x width. None without error layers and without the layer `samples`."""
    @property
    def statistics(self) -> Dict[str, Any]:
        """Samples, rays and seconds of the rendering. None for pictures from files."""
    @property
    def window(self) -> Tuple[int, int, int, int]:
        """Left, top, width and height of the pixels in the full picture."""
    def save(
        self,
        path: _Path,
        exposure: Union[float, Literal["auto"], None] = None,
        tone: Literal["none", "reinhard", "aces", "neutral"] = "none",
    ) -> None:
        """Writes .exr or .pfm, linear, or .png or .tga, with an exposure in stops and a tone curve. Raises `OSError`."""
    def __array__(self, dtype: Any = None, copy: Optional[bool] = None) -> NDArray[Any]: ...

class Chart:
    """Error against render time, from `chart`."""

    @property
    def results(self) -> Dict[str, Any]:
        """The results, as `lookat chart` writes them to chart.json."""
    @property
    def svg(self) -> str:
        """The figure."""

def load(path_or_text: _Path) -> Scene:
    """Reads a scene: a path, or a text, which has line breaks or quotes. Raises `SceneError` if it has errors."""

def check(path_or_text: _Path, *, view: bool = False) -> List[Dict[str, Any]]:
    """The problems of a scene, as `lookat check --json` lists them: severity, message, labels with places, help, fix.

    `view` adds warnings about what the picture shows: a camera inside a shape, nothing in view, nothing sharp, lights without effect.
    """

def render(
    scene: Union[Scene, _Path],
    *,
    spp: Optional[int] = None,
    seed: int = 0,
    threads: int = 0,
    target_error: Optional[float] = None,
    confidence: Optional[float] = None,
    time: Optional[float] = None,
    adaptive: bool = False,
    error_layers: bool = False,
    layers: Sequence[str] = (),
    progress: Union[None, bool, Callable[[int, int], Any]] = None,
) -> Picture:
    """Renders a scene. The same scene, seed and version give the bits of the program's picture.

    Arguments are those of `lookat render`. `threads`: 0 means one per processor. `progress`: True shows a bar by tqdm, where it is
    installed; a function is called with the samples done and the samples in all. Other Python threads run meanwhile, and Ctrl-C raises
    `KeyboardInterrupt` within a moment, once the scene is prepared. Raises `ValueError` for settings that do not fit together, `MemoryError` for
    pictures that do not fit the memory, and `RuntimeError` in a process that was forked after lookat was used.
    """

def compare(
    actual: _Picture, expected: _Picture, *, only: Sequence[str] = (), threshold: float = 0.01
) -> Dict[str, Any]:
    """The difference between two pictures, as `lookat compare --json` prints it: metrics, and whether noise explains it."""

def chart(
    scene: Scene,
    *,
    methods: Optional[Sequence[str]] = None,
    spp: int = 64,
    seeds: int = 8,
    seed: int = 0,
    reference: Optional[_Picture] = None,
) -> Chart:
    """Renders a scene by several methods with 1 to `spp` samples per pixel, a power of two, and measures their errors."""
