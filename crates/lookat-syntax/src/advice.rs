//! Help for unknown words: the nearest known name, words of other programs, and marks of other languages.

use crate::Directive;
use crate::token::{Input, is_unseen};

/// Directives that pbrt-v4 added.
pub(crate) const V4_DIRECTIVES: [&str; 4] = ["Option", "ColorSpace", "Attribute", "Import"];

/// Help for a word that is not a directive.
pub(crate) fn advice(word: Input) -> Option<String> {
    let text = String::from_utf8_lossy(word);
    match text.chars().find(|c| is_unseen(*c)).map(u32::from) {
        Some(code) => Some(format!(
            "pbrt does not treat the character U+{code:04X} as white space: replace it by a space, or delete it"
        )),
        None => directive_advice(&text).or_else(|| foreign(word)).map(str::to_owned),
    }
}

/// Help for marks of other languages and tools.
fn foreign(word: Input) -> Option<&'static str> {
    let starts = |prefix: &str| word.starts_with(prefix.as_bytes());
    Some(match word {
        b"," => "separate parameters by spaces only",
        _ if starts("//") || starts("--") || starts(";") || starts("%") || starts("/*") => {
            "a comment starts with #"
        }
        _ if starts("<<<<<<<") || starts("=======") || starts(">>>>>>>") => {
            "this is an unresolved merge conflict: keep one side, and delete the markers"
        }
        _ if starts("```") => "this is Markdown: delete the line",
        _ if starts("(") || starts("{") => "write lists in square brackets: [1 2 3]",
        _ if starts("\u{201c}") || starts("'") || starts("\u{2018}") => {
            "write names in straight double quotes"
        }
        [b'a'..=b'z', ..] => {
            "directives begin with a capital letter; write a parameter as \"float radius\" 3"
        }
        _ => return None,
    })
}

/// The meaning of the quoted string after a keyword or after a part of a Texture, and an example.
pub(crate) fn quoted_after(keyword: Input) -> (&'static str, &'static str) {
    const TEXTURE: &str = "Texture \"wood\" \"spectrum\" \"imagemap\"";
    match keyword {
        b"Texture" => ("name", TEXTURE),
        b"the name of a Texture" => ("type of values", TEXTURE),
        b"the value type of a Texture" => ("type", TEXTURE),
        b"Shape" => ("type", "Shape \"sphere\""),
        b"Material" => ("type", "Material \"matte\""),
        b"LightSource" => ("type", "LightSource \"point\""),
        b"AreaLightSource" => ("type", "AreaLightSource \"diffuse\""),
        b"Camera" => ("type", "Camera \"perspective\""),
        b"Film" => ("type", "Film \"image\""),
        b"Sampler" => ("type", "Sampler \"halton\""),
        b"Integrator" => ("type", "Integrator \"path\""),
        b"PixelFilter" => ("type", "PixelFilter \"box\""),
        b"Accelerator" => ("type", "Accelerator \"bvh\""),
        b"MakeNamedMaterial" => ("name", "MakeNamedMaterial \"red\" \"string type\" \"matte\""),
        b"NamedMaterial" => ("name", "NamedMaterial \"red\""),
        b"ObjectBegin" => ("name", "ObjectBegin \"tree\""),
        b"ObjectInstance" => ("name", "ObjectInstance \"tree\""),
        b"CoordinateSystem" => ("name", "CoordinateSystem \"lamp\""),
        b"CoordSysTransform" => ("name", "CoordSysTransform \"lamp\""),
        b"Include" => ("name", "Include \"part.pbrt\""),
        b"MediumInterface" => ("name", "MediumInterface \"inside\" \"outside\""),
        // MakeNamedMedium.
        _ => ("name", "MakeNamedMedium \"fog\" \"string type\" \"homogeneous\""),
    }
}

/// The message for a value after a directive that takes no parameters.
pub(crate) fn surplus(directive: &Directive) -> Option<String> {
    let takes = match directive {
        Directive::NamedMaterial(_) => "a name only; parameters belong to MakeNamedMaterial",
        Directive::ObjectBegin(_)
        | Directive::ObjectInstance(_)
        | Directive::CoordinateSystem(_)
        | Directive::CoordSysTransform(_) => "a name only",
        Directive::MediumInterface { .. } => "one name or two",
        Directive::ActiveTransform(_) => "All, StartTime or EndTime, and nothing else",
        Directive::Identity
        | Directive::ReverseOrientation
        | Directive::WorldBegin
        | Directive::WorldEnd
        | Directive::AttributeBegin
        | Directive::AttributeEnd
        | Directive::TransformBegin
        | Directive::TransformEnd
        | Directive::ObjectEnd => "no values",
        _ => return None,
    };
    Some(format!("{} takes {takes}", directive.keyword()))
}

// Words of other programs (Mitsuba, Blender, POV-Ray, Arnold) and other versions of pbrt for the directives of pbrt-v3, as
// plain data.

/// What to write instead of a word from elsewhere that stands in place of a directive.
pub fn directive_advice(word: &str) -> Option<&'static str> {
    synonym(word).map(|(_, _, advice)| *advice)
}

pub(crate) fn synonym(word: &str) -> Option<&'static Row> {
    let plain: String = word.to_ascii_lowercase().replace(['_', '-', ' '], "");
    DIRECTIVES.iter().find(|(words, ..)| words.contains(&&plain[..]))
}

/// Directives of older versions that pbrt-v3 does without.
pub(crate) fn is_gone(word: &str) -> bool {
    matches!(word, "Renderer" | "VolumeIntegrator" | "SearchPath")
}

/// Words, in lower case and without `_`, `-` and spaces; the directive with the same arguments, or an empty text; the advice.
pub(crate) type Row = (&'static [&'static str], &'static str, &'static str);

#[rustfmt::skip]
const DIRECTIVES: &[Row] = &[
    (&["surfaceintegrator"], "Integrator", "this is a directive of an older pbrt; in pbrt-v3 it is Integrator"),
    (&["renderer", "volumeintegrator"], "", "this is a directive of an older pbrt; pbrt-v3 has only Integrator: delete this directive"),
    (&["volume", "exterior", "interior"], "", "this is a directive of an older pbrt; pbrt-v3 has MakeNamedMedium and MediumInterface"),
    (&["arealight"], "AreaLightSource", "this is a directive of an older pbrt; in pbrt-v3 it is AreaLightSource"),
    (&["searchpath"], "", "this is a directive of an older pbrt; in pbrt-v3 names of files are relative to the scene: delete it"),
    (&["filter", "rfilter", "reconstructionfilter"], "PixelFilter", "write PixelFilter, as in PixelFilter \"gaussian\""),
    (&["light"], "", "write LightSource \"point\", or AreaLightSource \"diffuse\" before a shape that glows"),
    (&["pointlight", "omnilight", "lightpoint"], "", "write LightSource \"point\" \"rgb I\" [1 1 1]"),
    (&["spotlight"], "", "write LightSource \"spot\" \"rgb I\" [1 1 1]"),
    (&["distantlight", "directionallight", "sunlight", "sun", "lightdistant"], "", "write LightSource \"distant\" \"rgb L\" [1 1 1]"),
    (&["environmentlight", "envmap", "environmentmap", "skylight", "sky", "skydome", "domelight", "background", "infinitelight"], "", "write LightSource \"infinite\", with \"string mapname\" for a picture"),
    (&["emitter", "emission"], "", "write AreaLightSource \"diffuse\" \"rgb L\" [1 1 1] before the shapes that glow"),
    (&["sphere"], "", "write Shape \"sphere\" \"float radius\" 1; to move it, write Translate before it"),
    (&["disk", "disc", "circle"], "", "write Shape \"disk\" \"float radius\" 1"),
    (&["cylinder", "tube"], "", "write Shape \"cylinder\" with \"radius\", \"zmin\" and \"zmax\""),
    (&["cone"], "", "write Shape \"cone\" with \"radius\" and \"height\""),
    (&["curve", "hair", "bezier"], "", "write Shape \"curve\" with \"point P\""),
    (&["mesh", "trianglemesh", "triangles", "triangle", "polygonmesh", "polygon", "polymesh", "mesh2"], "", "write Shape \"trianglemesh\" with \"point P\" and \"integer indices\""),
    (&["plymesh", "ply"], "", "write Shape \"plymesh\" \"string filename\" \"mesh.ply\""),
    (&["obj", "objmesh"], "", "pbrt-v3 reads no OBJ: convert the mesh to PLY for Shape \"plymesh\""),
    (&["box", "cube", "plane", "quad", "rectangle", "square"], "", "write Shape \"trianglemesh\": pbrt-v3 has no shape for it"),
    (&["bsdf", "shader", "surface"], "", "write Material, as in Material \"matte\" \"rgb Kd\" [.5 .5 .5]"),
    (&["namedbsdf", "makenamedbsdf"], "", "MakeNamedMaterial defines a material, NamedMaterial uses it"),
    (&["pigment", "color", "colour", "finish"], "", "write a color as a parameter: Material \"matte\" \"rgb Kd\" [.5 .5 .5]"),
    (&["medium", "media", "fog", "smoke", "mist", "haze", "cloud", "volumetric"], "", "write MakeNamedMedium to define a medium, MediumInterface to use it"),
    (&["motionblur", "motion", "animation"], "", "write ActiveTransform StartTime and EndTime for two transformations; lookat renders the start time alone"),
    (&["sensor"], "", "write Camera and Film"),
    (&["output", "resolution", "imagesize"], "", "write Film \"image\" \"integer xresolution\" 640 \"integer yresolution\" 480 \"string filename\" \"a.exr\""),
    (&["samples", "spp", "pixelsamples"], "", "write Sampler \"halton\" \"integer pixelsamples\" 64"),
    (&["eye", "lookto", "origin"], "", "write LookAt with nine numbers: the eye, the point it looks at, the up direction"),
    (&["fov"], "", "write Camera \"perspective\" \"float fov\" 45"),
    (&["matrix", "toworld"], "", "write Transform with 16 numbers in brackets"),
    (&["rotatex", "rotatey", "rotatez"], "", "write Rotate with an angle in degrees and an axis, as in Rotate 90 1 0 0"),
    (&["pushtransform", "pushmatrix"], "TransformBegin", "write TransformBegin"),
    (&["poptransform", "popmatrix"], "TransformEnd", "write TransformEnd"),
    (&["pushattributes", "pushattribute"], "AttributeBegin", "write AttributeBegin"),
    (&["popattributes", "popattribute"], "AttributeEnd", "write AttributeEnd"),
    (&["instance"], "", "ObjectBegin and ObjectEnd define an object, ObjectInstance places a copy"),
    (&["scene", "world"], "", "WorldBegin and WorldEnd enclose the lights and shapes"),
];

/// The name in `known` nearest to `name`, by the optimal string alignment distance without case. `None` if more than a
/// third of its letters are changed, missing, added or swapped with a neighbor.
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let (lower, letters) = (name.to_lowercase(), name.chars().count());
    let slips = |candidate: &str| candidate.chars().count().max(2) / 3;
    known
        .into_iter()
        .filter(|candidate| *candidate != name && !candidate.is_empty())
        .filter(|candidate| candidate.chars().count().abs_diff(letters) <= slips(candidate))
        .map(|candidate| (distance(&lower, &candidate.to_lowercase()), candidate))
        .filter(|(edits, candidate)| *edits <= slips(candidate))
        .min_by_key(|(edits, _)| *edits)
        .map(|(_, candidate)| candidate)
}

/// The only name in `known` that starts with `name`, without case. `None` if several names do, or if `name` has fewer
/// than three letters.
pub fn begun<'a>(name: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    const FEWEST: usize = 3;
    let begins = |candidate: &&str| {
        candidate.len() > name.len()
            && candidate.get(..name.len()).is_some_and(|start| start.eq_ignore_ascii_case(name))
    };
    let mut longer = known.into_iter().filter(begins);
    longer.next().filter(|_| name.chars().count() >= FEWEST && longer.next().is_none())
}

/// The optimal string alignment distance: edits and swaps of neighbors. Compares at most 64 characters.
fn distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().take(64).collect(), b.chars().take(64).collect());
    let mut rows = vec![vec![0; b.len() + 1]; a.len() + 1];
    for i in 0..=a.len() {
        for j in 0..=b.len() {
            if i == 0 || j == 0 {
                rows[i][j] = i + j;
                continue;
            }
            let change = usize::from(a[i - 1] != b[j - 1]);
            let mut best = (rows[i - 1][j] + 1).min(rows[i][j - 1] + 1).min(rows[i - 1][j - 1] + change);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                best = best.min(rows[i - 2][j - 2] + 1);
            }
            rows[i][j] = best;
        }
    }
    rows[a.len()][b.len()]
}

/// True if two names have the same digits in the same order. `wood1` is not a misspelling of `wood2`.
pub fn same_digits(a: &str, b: &str) -> bool {
    let digits = |name: &str| name.bytes().filter(u8::is_ascii_digit).collect::<Vec<u8>>();
    digits(a) == digits(b)
}

#[cfg(test)]
mod tests {
    mod synonyms {
        use super::super::*;
        use crate::Directive;

        #[test]
        fn words_are_written_as_they_are_looked_up() {
            for (words, keyword, advice) in DIRECTIVES {
                assert!(keyword.is_empty() || Directive::KEYWORDS.contains(keyword), "{keyword}");
                assert!(!advice.is_empty() && advice.contains(keyword), "{words:?}");
                for word in *words {
                    assert!(
                        word.bytes().all(|byte| byte.is_ascii_lowercase() || byte.is_ascii_digit()),
                        "{word}"
                    );
                }
            }
            assert!(directive_advice("PointLight").is_some_and(|advice| advice.contains("LightSource")));
        }
    }
    mod nearest {
        use super::super::{begun, nearest};

        #[test]
        fn finds_slips_and_refuses_strangers() {
            let known = ["sphere", "trianglemesh", "plymesh", "disk", "cone"];
            let check = |name, expected| assert_eq!(nearest(name, known), expected, "{name}");
            check("sphrere", Some("sphere"));
            check("Sphere", Some("sphere"));
            check("triangelmesh", Some("trianglemesh"));
            check("plymehs", Some("plymesh"));
            check("dsik", Some("disk"));
            check("teapot", None);
            check("", None);
        }

        #[test]
        fn finds_the_only_name_that_is_begun() {
            let known = ["perspective", "orthographic", "orbit", "environment"];
            let check = |name, expected| assert_eq!(begun(name, known), expected, "{name}");
            check("persp", Some("perspective"));
            check("Ortho", Some("orthographic"));
            check("or", None);
            check("orb", Some("orbit"));
            check("pe", None);
            check("environment", None);
            check("\u{e9}\u{e9}\u{e9}", None);
            assert_eq!(begun("ort", ["orthographic", "ortho"]), None);
        }
    }
}
