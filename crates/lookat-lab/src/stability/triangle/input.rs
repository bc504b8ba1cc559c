//! T6 and T7: meshes that are not as they should be.

use std::io;
use std::path::Path;

use lookat_scene::Loaded;
use lookat_scene::syntax::Severity;

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
    format!(
        "LookAt 0 0 -5  0 0 0  0 1 0  Camera \"perspective\"\n\
         Film \"image\" \"integer xresolution\" 16 \"integer yresolution\" 16\n\
         Sampler \"sobol\" \"integer pixelsamples\" 4  Integrator \"path\"\n\
         WorldBegin LightSource \"infinite\"\n{light}\n\
         Shape \"trianglemesh\" \"point P\" [-1 -1 0  1 -1 0  0 1 1  {points}] \"integer indices\" [0 1 2 {indices}]\n\
         {more} WorldEnd"
    )
}

/// What is wrong: the points, indices or faces, with the fault in the third line of the shape.
const BAD: [(&str, &str, &str); 8] = [
    ("a vertex that is not a number", "1 0\n nan", "0 1 2"),
    ("an infinite vertex", "1 0\n inf", "0 1 2"),
    ("an infinite vertex, negative", "1 0\n -inf", "0 1 2"),
    ("a vertex beyond all numbers", "1 0\n 1e400", "0 1 2"),
    ("a number with a tail", "1 0\n 1.5abc", "0 1 2"),
    ("an index out of range", "1 0 0", "0 1\n 3"),
    ("a negative index", "1 0 0", "0 1\n -1"),
    ("an index beyond all integers", "1 0 0", "0 1\n 4294967296"),
];

pub(super) fn bad_mesh(_: &Effort) -> Found {
    let mut found = Found::default();
    for (name, last, indices) in BAD {
        let (points, place) = (format!("0 0 0  0 1 0  {last}"), "Shape \"trianglemesh\"");
        let shape = format!("{place}\n\"point P\" [{points}] \"integer indices\" [{indices}]");
        let loaded = load(&around_eye(&format!("\n{shape}\n")));
        found.check(loaded.scene.is_none(), || format!("{name}: there is a scene"));
        let told = errors(&loaded).any(|error| error.0 == 4);
        found.check(told, || format!("{name}: no error in line 4: {:?}", loaded.diagnostics));
        let loaded = load_ply(&ply(last, indices));
        found.check(loaded.scene.is_none(), || format!("{name} in a PLY file: there is a scene"));
        // The place in the other file is in the message.
        let line = if last.contains('\n') { "mesh.ply: line 12: " } else { "mesh.ply: line 13: " };
        let told = errors(&loaded).any(|error| error.0 == 2 && error.1.contains(line));
        found.check(told, || format!("{name}: no error at \"{line}\": {:?}", loaded.diagnostics));
    }
    found
}

/// Lines and messages of errors.
fn errors(loaded: &Loaded) -> impl Iterator<Item = (usize, &str)> {
    let errors = loaded.diagnostics.iter().filter(|problem| problem.severity == Severity::Error);
    errors.map(|problem| (loaded.sources.location(problem.span()).line, problem.message.as_str()))
}

/// A PLY file with one triangle, whose third vertex is in line 12 and whose face is in line 13.
fn ply(last: &str, indices: &str) -> String {
    let (last, indices) = (last.replace('\n', " "), indices.replace('\n', " "));
    format!(
        "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
         element face 1\nproperty list uchar int vertex_indices\nend_header\n\
         0 0 0\n0 1 0\n{last}\n3 {indices}\n"
    )
}

fn load_ply(mesh: &str) -> Loaded {
    let text = around_eye("\nShape \"plymesh\" \"string filename\" \"mesh.ply\"\n");
    let read = |path: &Path| -> io::Result<Vec<u8>> {
        Ok(if path.extension().is_some_and(|end| end == "ply") { mesh.into() } else { text.clone().into() })
    };
    lookat_scene::load(Path::new("case.pbrt"), &read, &Default::default())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_right_has_no_errors() {
        let loaded = load_ply(&ply("1 0 0", "0 1 2"));
        assert_eq!(errors(&loaded).count(), 0);
        assert!(loaded.scene.is_some());
        let rgb = render(&scene(&with("", "", "", "")), 1).rgb().unwrap();
        assert!(rgb.iter().any(|pixel| *pixel != rgb[0]), "the triangle is not seen");
    }
}
