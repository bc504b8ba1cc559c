//! The way out of mistakes in the grammar that are more than slips.

use crate::Directive;
use crate::token::{Input, is_unseen};

/// Directives that pbrt-v4 added.
pub(crate) const V4_DIRECTIVES: [&str; 4] = ["Option", "ColorSpace", "Attribute", "Import"];

/// The way out for words that are no directives.
pub(crate) fn advice(word: Input) -> Option<String> {
    let text = String::from_utf8_lossy(word);
    match text.chars().find(|c| is_unseen(*c)).map(u32::from) {
        Some(code) => {
            Some(format!("the character U+{code:04X} is no blank to the format: write one, or delete it"))
        }
        None => foreign(word).map(str::to_owned),
    }
}

/// The way out for words of other languages and older versions, and for what other tools leave behind.
fn foreign(word: Input) -> Option<&'static str> {
    let starts = |prefix: &str| word.starts_with(prefix.as_bytes());
    Some(match word {
        b"SurfaceIntegrator" => "this is a directive of an older pbrt; in pbrt-v3 it is Integrator \"path\"",
        b"Renderer" | b"VolumeIntegrator" => {
            "this is a directive of an older pbrt; pbrt-v3 has the Integrator alone: delete this one"
        }
        b"Volume" | b"Exterior" | b"Interior" => {
            "this is a directive of an older pbrt; pbrt-v3 has MakeNamedMedium and MediumInterface"
        }
        b"AreaLight" => "this is a directive of an older pbrt; in pbrt-v3 it is AreaLightSource",
        b"SearchPath" => {
            "this is a directive of an older pbrt; in pbrt-v3 names of files are relative to the scene: delete it"
        }
        b"Filter" => "filters are given by PixelFilter",
        b"Light" => "lights are given by LightSource, and by AreaLightSource for shapes that glow",
        b"," => "blanks alone stand between parameters",
        _ if starts("//") || starts("--") || starts(";") || starts("%") || starts("/*") => {
            "a comment starts with #"
        }
        _ if starts("<<<<<<<") || starts("=======") || starts(">>>>>>>") => {
            "a merge has left this: keep one of its two sides, and delete the marks"
        }
        _ if starts("```") => "a mark of Markdown: delete the line",
        _ if starts("(") || starts("{") => "lists stand in square brackets: [1 2 3]",
        _ if starts("\u{201c}") || starts("'") || starts("\u{2018}") => {
            "names stand in straight double quotes"
        }
        [b'a'..=b'z', ..] => "directives begin with a capital; a parameter is written as \"float radius\" 3",
        _ => return None,
    })
}

/// What stands in quotes after a keyword, or after a part of a Texture, and an example.
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

/// What to say of a value behind a directive that takes no parameters.
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
