//! Help for grammar mistakes that are more than a misspelling.

use crate::Directive;
use crate::synonyms::directive_advice;
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
