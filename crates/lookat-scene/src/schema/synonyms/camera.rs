//! Words for `Camera`.

use super::{PLACE, SAMPLES, Table};

const LOOKAT: &str =
    "write LookAt before Camera, with the eye, the point to look at and the up vector, three numbers each";
const RESOLUTION: &str =
    "Film \"image\" sets the size, with \"integer xresolution\" and \"integer yresolution\"";
const APERTURE: &str = "lensradius is half the diameter of the aperture";

#[rustfmt::skip]
pub(super) const TABLE: Table = Table {
    directive: "Camera",
    types: &[
        (&["thinlens", "pinhole", "persp", "perspectivepinhole"], "perspective", ""),
        (&["ortho", "parallel"], "orthographic", ""),
        (&["spherical", "panorama", "panoramic", "equirectangular", "latlong"], "environment", ""),
    ],
    parameters: &[
        (&["perspective", "orthographic", "environment"], &["aperture", "aperturediameter", "aperturesize", "aperturewidth", "lensdiameter"], "lensradius", APERTURE),
        (&[], &["aperture", "apertureradius", "radius", "lens", "defocusradius"], "lensradius", ""),
        (&[], &["fstop", "fnumber", "aperturefstop"], "", "lensradius is the focal length divided by twice the f-stop, in the units of the scene"),
        (&[], &["focus", "focusdistance", "focaldist", "focallengthdistance", "focalplane", "distance"], "focaldistance", ""),
        (&[], &["focallength", "lenslength"], "", "\"float fov\" is the angle of the shorter side in degrees: 2 atan(s / 2f), with the shorter side s of the film and the focal length f"),
        (&[], &["angle", "fieldofview", "viewangle", "yfov", "xfov"], "fov", "fov is the angle of the shorter side, in degrees"),
        (&[], &["fovaxis"], "", "fov is always the angle of the shorter side: leave fov_axis out"),
        (&[], &["eye", "origin", "position", "from", "location", "pos", "up", "lookat", "look", "target", "to", "direction", "sky"], "", LOOKAT),
        (&[], &["toworld", "transform", "matrix", "rotation", "translate"], "", PLACE),
        (&[], &["resolution", "width", "height", "xresolution", "yresolution", "size"], "", RESOLUTION),
        (&[], &["samples", "spp", "pixelsamples", "samplecount"], "", SAMPLES),
        (&[], &["near", "nearclip", "nearplane", "far", "farclip", "farplane", "clipstart", "clipend", "hither", "yon"], "", "pbrt-v3 has no clip planes: leave it out"),
        (&[], &["aspect", "aspectratio"], "frameaspectratio", ""),
        (&[], &["orthowidth", "orthographicscale", "orthoscale", "scale"], "", "\"float screenwindow\" [xmin xmax ymin ymax] is the part that is seen"),
    ],
};
