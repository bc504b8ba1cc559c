//! Words for `PixelFilter`.

use super::Table;

#[rustfmt::skip]
pub(super) const TABLE: Table = Table {
    directive: "PixelFilter",
    types: &[
        (&["tent", "bartlett"], "triangle", ""),
        (&["lanczos", "windowedsinc"], "sinc", ""),
        (&["gauss"], "gaussian", ""),
        (&["catmullrom"], "mitchell", "Catmull-Rom is \"mitchell\" with \"float B\" 0 and \"float C\" 0.5"),
        (&["blackmanharris"], "gaussian", ""),
    ],
    parameters: &[
        (&[], &["radius", "size", "support"], "", "\"float xwidth\" and \"float ywidth\" are the radius along each axis, in pixels"),
        (&[], &["width"], "", "\"float xwidth\" and \"float ywidth\" are half the width, in pixels"),
        (&[], &["xradius"], "xwidth", ""),
        (&[], &["yradius"], "ywidth", ""),
        (&["gaussian"], &["stddev", "sigma"], "", "\"float alpha\" is 1 / (2 sigma^2)"),
    ],
};
