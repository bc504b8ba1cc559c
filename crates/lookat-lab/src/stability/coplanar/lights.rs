//! Lights in the plane of a floor: P5.

use super::{look_at, placed_mesh, straight};
use crate::stability::prelude::*;

/// Half the side of the square, and the radius of the disk.
const HALF: f64 = 0.5;

/// Directives for one light of each kind in the plane, on the x axis, at this distance. They light the sphere equally from any
/// distance.
fn lights(frame: &DMat4, distance: f64) -> [String; 7] {
    let at = distance * DVec3::X;
    let bright = distance * distance;
    let [from, to, x, middle] =
        [at, 2.0 * DVec3::Y, DVec3::X, DVec3::ZERO].map(|p| xyz(frame.transform_point3(p)));
    let turned = |x, y, z| {
        transform(&(*frame * DMat4::from_translation(at) * DMat4::from_mat3(DMat3::from_cols(x, y, z))))
    };
    let toward_middle = turned(DVec3::NEG_Z, DVec3::Y, DVec3::NEG_X);
    let upright = turned(DVec3::Z, DVec3::X, DVec3::Y);
    let square = placed_mesh(frame, &flat_square(at, HALF), &[[0, 1, 2], [0, 2, 3]]);
    let intensity = format!("\"rgb I\" [{bright} 1 1]");
    let area = format!("AreaLightSource \"diffuse\" \"bool twosided\" \"true\" \"rgb L\" [{bright} 1 1]");
    let lights = [
        format!("LightSource \"point\" \"point from\" [{from}] {intensity}"),
        format!(
            "LightSource \"spot\" \"point from\" [{from}] \"point to\" [{to}] \"float coneangle\" 89 {intensity}"
        ),
        format!("Translate {from} LightSource \"goniometric\" {intensity}"),
        format!("{toward_middle} LightSource \"projection\" \"float fov\" 89 {intensity}"),
        format!("LightSource \"distant\" \"point from\" [{x}] \"point to\" [{middle}]"),
        format!("{area} {square}"),
        format!("{area} {upright} Shape \"disk\" \"float radius\" {HALF}"),
    ];
    lights.map(|light| format!("AttributeBegin {light} AttributeEnd"))
}

fn has_area(light: &str) -> bool {
    light.contains("AreaLightSource")
}

/// The corners of a square in the plane, with its center and half its side.
fn flat_square(middle: DVec3, half: f64) -> [DVec3; 4] {
    square(middle, half * DVec3::X, half * DVec3::Z)
}

/// A black floor, with a hole for an area light.
fn floor(has_area: bool, frame: &DMat4, distance: f64) -> String {
    let at = distance * DVec3::X;
    let around = flat_square(at, 3.0 * distance);
    let mesh = if has_area {
        let points = [flat_square(at, HALF), around].concat();
        let sides = (0..4).flat_map(|i| [[i, (i + 1) % 4, i + 4], [(i + 1) % 4, (i + 1) % 4 + 4, i + 4]]);
        placed_mesh(frame, &points, &sides.collect::<Vec<_>>())
    } else {
        placed_mesh(frame, &around, &[[0, 1, 2], [0, 2, 3]])
    };
    format!("Material \"matte\" \"rgb Kd\" [0 0 0] {mesh}")
}

/// A scene with a sphere of radius 1 at this height over the plane, seen from slightly above the plane.
fn text(light: &str, frame: &DMat4, height: f64, floor: &str) -> String {
    let (eye, forward) = (DVec3::new(0.0, 0.25, -8.0), DVec3::new(0.0, height - 0.25, 8.0));
    let camera =
        format!("{} Camera \"perspective\" \"float fov\" 20", look_at(frame, eye, forward, DVec3::Y));
    let at = xyz(frame.transform_point3(height * DVec3::Y));
    let sphere = format!("AttributeBegin Translate {at} Shape \"sphere\" AttributeEnd");
    pictured(&camera, 24, 4, "directlighting", &format!("{light} {sphere} {floor}"))
}

/// The floor does not change the picture of the sphere. The lowest point of the sphere is above the floor or on it.
pub(super) fn in_plane(_: &Effort) -> Found {
    Found::sweep(0, [4.0, 30.0, 1e3, 1e5], |_, distance| {
        let mut tally = Tally::default();
        let frames = straight(DVec3::new(3.3, -0.7, 0.1), 1.0);
        let lit =
            frames.iter().flat_map(|frame| lights(frame, distance).into_iter().map(move |l| (frame, l)));
        for (frame, light) in lit {
            // At any distance, the part of the sphere near the plane sees an area light edge-on, so the sphere stays
            // above the plane.
            let heights = if has_area(&light) { [2.0, 1.5] } else { [2.0, 1.0] };
            for height in heights {
                let picture = |floor: &str| render(&scene(&text(&light, frame, height, floor)), 0);
                let (open, floored) = (picture(""), picture(&floor(has_area(&light), frame, distance)));
                for (a, b) in open.iter().zip(&floored) {
                    tally.answer((a[0] - b[0]).abs() <= 1e-5 * a[0]);
                }
            }
        }
        tally
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each light reaches the sphere, and a floor above the light hides it.
    #[test]
    fn lights_are_seen_and_can_be_hidden() {
        let [frame, ..] = straight(DVec3::ZERO, 1.0);
        let higher = DMat4::from_translation(1e-6 * DVec3::Y) * frame;
        for light in lights(&frame, 4.0) {
            let sum = |floor: &str| {
                let scene = scene(&text(&light, &frame, 2.0, floor));
                render(&scene, 1).iter().map(|pixel| pixel[0]).sum::<f32>()
            };
            assert!(sum("") > 0.0, "{light}");
            // Distant light arrives parallel to the floor, so the floor cannot hide it.
            if !light.contains("\"distant\"") {
                let hidden = sum(&floor(false, &higher, 4.0));
                assert!(hidden < 0.5 * sum(""), "{light}");
            }
        }
    }
}
