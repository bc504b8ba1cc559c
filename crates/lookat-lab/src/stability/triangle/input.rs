//! T6: triangles without area.

use crate::stability::prelude::*;

/// Triangles without area, as points and indices. Their vertices come after the three of a triangle that is right.
const NO_AREA: [(&str, &str, &str); 5] = [
    ("one point three times", "7 7 7  7 7 7  7 7 7", "3 4 5"),
    ("a vertex twice", "1 2 0  0 2 1", "3 3 4"),
    ("two vertices in one place", "1 2 0  1 2 0  0 2 1", "3 4 5"),
    ("vertices in a line", "0 0 0  1 1 0  3 3 0", "3 4 5"),
    ("a vertex thrice in front of the eye", "0 0 -3", "3 3 3"),
];

pub(super) fn no_area(_: &Effort) -> Found {
    let mut found = Found::default();
    let alone = render(&scene(&with("", "", "", "")), 1);
    for (name, points, indices) in NO_AREA {
        let loaded = load(&with("", points, indices, ""));
        let is_said = loaded.diagnostics.iter().any(|problem| problem.message.contains("area"));
        found.check(is_said, || format!("{name}: is left out, which is not said"));
        let picture = loaded.scene.map(|scene| render(&scene, 1));
        found.check(picture.is_some(), || format!("{name}: the whole scene is refused"));
        let same = picture.is_some_and(|picture| picture.rgb() == alone.rgb());
        found.check(same, || format!("{name}: changes the picture"));
        // As a light, and with normals that have no length either.
        let normals =
            format!("\"normal N\" [{}]", "0 0 0 ".repeat(3 + points.split_whitespace().count() / 3));
        for (light, more) in [("AreaLightSource \"diffuse\"", ""), ("", normals.as_str())] {
            let picture = load(&with(light, points, indices, more)).scene.map(|scene| render(&scene, 1));
            let rgb = picture.and_then(|picture| picture.rgb());
            let finite = rgb.is_some_and(|rgb| rgb.as_flattened().iter().all(|x| x.is_finite()));
            found.check(finite, || format!("{name} {light}{more}: the picture is not finite"));
        }
    }
    found
}

/// A scene with one triangle and what is to be added to its mesh.
fn with(light: &str, points: &str, indices: &str, more: &str) -> String {
    let shape = format!("Shape \"trianglemesh\" \"point P\" [-1 -1 0  1 -1 0  0 1 1  {points}]");
    let world =
        format!("LightSource \"infinite\" {light} {shape} \"integer indices\" [0 1 2 {indices}] {more}");
    pictured("LookAt 0 0 -5  0 0 0  0 1 0  Camera \"perspective\"", 16, 4, "path", &world)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_triangle_is_seen() {
        let rgb = render(&scene(&with("", "", "", "")), 1).rgb().unwrap();
        assert!(rgb.iter().any(|pixel| *pixel != rgb[0]), "the triangle is not seen");
    }
}
