//! Words of other programs (Mitsuba, Blender, POV-Ray, Arnold) and other versions of pbrt for the directives of pbrt-v3, as
//! plain data.

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

#[cfg(test)]
mod tests {
    use super::*;
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
