//! Screen windows and numbers that are read as they are, or refused: C15 and C19.

use super::text;
use crate::stability::prelude::*;

/// A reversed window turns the picture.
pub(super) fn screen_window(_: &Effort) -> Found {
    let mut found = refused("C15");
    for kind in ["perspective", "orthographic"] {
        let views = ["[-1 1 -1 1]", "[1 -1 1 -1]"].map(|edges| {
            scene(&text(&format!(
                "Camera \"{kind}\" \"float screenwindow\" {edges}
                 Film \"image\" \"integer xresolution\" 64 \"integer yresolution\" 48"
            )))
        });
        let [plain, reversed] = views.each_ref().map(Probe::new);
        for film in [DVec2::new(0.0, 0.0), DVec2::new(5.0, 40.0), DVec2::new(63.5, 1.25)] {
            let u = DVec2::splat(0.5);
            let (a, b) = (plain.camera_ray(film, u), reversed.camera_ray(DVec2::new(64.0, 48.0) - film, u));
            let is_mirrored = (a.d - b.d).length().max((a.o - b.o).length()) < 1e-15;
            found.check(is_mirrored, || format!("{kind}, reversed window: {a:?} is not {b:?}"));
        }
    }
    found
}

/// Decimal numbers are read as the nearest number with 53 bits.
pub(super) fn numbers(_: &Effort) -> Found {
    let mut found = refused("C19");
    let exact = [
        ("100000000000000000000", 1e20),
        ("-9223372036854775809", -9223372036854775808.0),
        ("9007199254740993", 9007199254740992.0),
        ("9007199254740993.00000000000000000001", 9007199254740994.0),
        (".1", f64::from_bits(0x3FB9_9999_9999_999A)),
        ("+1.25e-3", 0.00125),
        ("16777217", 16777217.0),
        ("1E+22", 1e22),
    ];
    for (number, value) in exact {
        let scene = scene(&text(&format!("Translate {number} 0 0\nCamera \"perspective\"")));
        let read = -scene.view.camera.world_from_camera.matrix().w_axis.x;
        found.check(read == value, || format!("{number} is read as {read:?}, not {value:?}"));
    }
    found
}
