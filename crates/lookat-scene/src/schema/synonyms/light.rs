//! Words for `LightSource` and `AreaLightSource`.

use super::{OLDER, PLACE, Table};

const DIRECTION: &str = "write \"to\" as a point: \"from\" plus the direction";
const POINT_LIGHTS: &[&str] = &["point", "spot", "goniometric", "projection"];

#[rustfmt::skip]
pub(super) const LIGHT_SOURCE: Table = Table {
    directive: "LightSource",
    types: &[
        (&["envmap", "environment", "constant", "sky", "skydome", "hdri", "dome", "background", "sunsky"], "infinite", ""),
        (&["infinitesample"], "infinite", OLDER),
        (&["directional", "sun", "parallel"], "distant", ""),
        (&["omni", "pointlight", "bulb"], "point", ""),
        (&["spotlight"], "spot", ""),
        (&["projector", "slide"], "projection", ""),
        (&["ies", "photometric"], "goniometric", "\"goniometric\" takes a picture of the light in all directions as \"mapname\", no IES file"),
        (&["arealight", "rectangle", "quad", "mesh"], "", "AreaLightSource \"diffuse\" makes the shapes that follow it emit light"),
    ],
    parameters: &[
        (POINT_LIGHTS, &["l", "intensity", "color", "radiance", "emission", "emit"], "I", ""),
        (POINT_LIGHTS, &["power", "strength", "energy", "flux", "watts", "lumens"], "", "\"rgb I\" is the power divided by 4 pi, in each channel"),
        (&["distant", "infinite", "exinfinite"], &["i", "intensity", "color", "radiance", "irradiance", "emission", "emit"], "L", ""),
        (&["distant", "infinite", "exinfinite"], &["power", "strength", "energy", "illuminance"], "", "\"rgb L\" is the radiance, and \"rgb scale\" multiplies it"),
        (&["point", "spot", "distant"], &["position", "location", "origin", "pos", "eye", "center"], "from", ""),
        (&["spot", "distant"], &["target", "lookat", "look", "pointat"], "to", ""),
        (&["spot", "distant"], &["direction", "dir"], "", DIRECTION),
        (&["spot"], &["cutoffangle", "angle", "cutoff"], "coneangle", ""),
        (&["spot"], &["spotsize", "outerangle", "fov"], "coneangle", "coneangle is half of the angle of the cone, in degrees"),
        (&["spot"], &["conedelta", "penumbra"], "conedeltaangle", ""),
        (&["spot"], &["beamwidth", "innerangle", "spotblend", "falloff"], "", "\"float conedeltaangle\" is the angle inside the edge of the cone over which the light falls to 0"),
        (&["infinite", "exinfinite", "goniometric", "projection"], &["filename", "file", "map", "texture", "image", "imagefile", "bitmap"], "mapname", ""),
        (&["infinite", "exinfinite", "goniometric", "projection"], &["rotation", "toworld", "transform"], "", PLACE),
        (&["point", "spot"], &["radius", "size"], "", "this light is a point; for a light with a size, write a small sphere after AreaLightSource \"diffuse\""),
        (&["distant"], &["radius", "size", "angle"], "", "this light has a direction but no size; for a sun of any size, use LightSource \"infinite\" with a map"),
    ],
};

#[rustfmt::skip]
pub(super) const AREA_LIGHT_SOURCE: Table = Table {
    directive: "AreaLightSource",
    types: &[
        (&["arealight", "emitter", "mesh", "point"], "diffuse", ""),
    ],
    parameters: &[
        (&[], &["i", "radiance", "emission", "emit", "color", "intensity"], "L", ""),
        (&[], &["power", "strength", "energy", "flux", "watts"], "", "\"rgb L\" is the power divided by pi and by the area of the shape; half of that with \"twosided\""),
        (&[], &["radius", "size", "width", "height"], "", "the Shape that follows sets the size of the light"),
        (&[], &["sides", "doublesided"], "twosided", ""),
    ],
};
