//! Words for `AreaLightSource`.

use super::Table;

#[rustfmt::skip]
pub(super) const TABLE: Table = Table {
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
