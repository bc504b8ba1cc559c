//! Prints directives as pbrt text: the inverse of the grammar.

use std::fmt::{Display, Formatter, Result, Write};

use crate::{ActiveTransform, Directive, Entity, Param, Values};

impl Display for Directive {
    fn fmt(&self, f: &mut Formatter) -> Result {
        f.write_str(self.keyword())?;
        match self {
            Directive::Translate(n) | Directive::Scale(n) => numbers(f, n),
            Directive::Rotate(n) => numbers(f, n),
            Directive::LookAt(n) => numbers(f, n),
            Directive::TransformTimes(n) => numbers(f, n),
            Directive::Transform(n) | Directive::ConcatTransform(n) => {
                f.write_str(" [")?;
                numbers(f, n)?;
                f.write_str(" ]")
            }
            Directive::CoordinateSystem(name)
            | Directive::CoordSysTransform(name)
            | Directive::ObjectBegin(name)
            | Directive::ObjectInstance(name)
            | Directive::NamedMaterial(name) => string(f, &name.value),
            Directive::ActiveTransform(which) => f.write_str(match which {
                ActiveTransform::All => " All",
                ActiveTransform::StartTime => " StartTime",
                ActiveTransform::EndTime => " EndTime",
            }),
            Directive::MediumInterface { inside, outside } => {
                string(f, &inside.value)?;
                outside.iter().try_for_each(|outside| string(f, &outside.value))
            }
            Directive::Texture { name, value, entity } => {
                string(f, &name.value)?;
                string(f, &value.value)?;
                write!(f, " {entity}")
            }
            Directive::Entity(_, entity) => write!(f, " {entity}"),
            Directive::Include { file, rest } => {
                string(f, &file.value)?;
                rest.iter().try_for_each(|param| write!(f, " {param}"))
            }
            Directive::Identity
            | Directive::TransformBegin
            | Directive::TransformEnd
            | Directive::AttributeBegin
            | Directive::AttributeEnd
            | Directive::ObjectEnd
            | Directive::ReverseOrientation
            | Directive::WorldBegin
            | Directive::WorldEnd => Ok(()),
        }
    }
}

impl Display for Entity {
    fn fmt(&self, f: &mut Formatter) -> Result {
        quote(f, &self.name.value)?;
        self.params.iter().try_for_each(|param| write!(f, " {param}"))
    }
}

impl Display for Param {
    fn fmt(&self, f: &mut Formatter) -> Result {
        quote(f, &format!("{} {}", self.ty.name(), self.name.value))?;
        f.write_str(" [")?;
        match &self.values.value {
            Values::Integers(list) => list.iter().try_for_each(|value| write!(f, " {value}"))?,
            Values::Numbers(list) => numbers(f, list)?,
            Values::Pairs(list) => numbers(f, list.as_flattened())?,
            Values::Triples(list) => numbers(f, list.as_flattened())?,
            Values::Bools(list) => list.iter().try_for_each(|value| write!(f, " \"{value}\""))?,
            Values::Strings(list) => list.iter().try_for_each(|value| string(f, &value.value))?,
        }
        f.write_str(" ]")
    }
}

/// Prints a space before each number, and the fewest digits that read back as the same number.
fn numbers(f: &mut Formatter, list: &[f64]) -> Result {
    for value in list {
        if value.abs() < 1e16 && value.fract() == 0.0 {
            write!(f, " {value}")?;
        } else {
            write!(f, " {value:?}")?;
        }
    }
    Ok(())
}

fn string(f: &mut Formatter, text: &str) -> Result {
    f.write_char(' ')?;
    quote(f, text)
}

fn quote(f: &mut Formatter, text: &str) -> Result {
    f.write_char('"')?;
    for c in text.chars() {
        match c {
            '"' | '\\' => write!(f, "\\{c}")?,
            '\n' => f.write_str("\\n")?,
            '\r' => f.write_str("\\r")?,
            '\t' => f.write_str("\\t")?,
            '\u{8}' => f.write_str("\\b")?,
            '\u{c}' => f.write_str("\\f")?,
            _ => f.write_char(c)?,
        }
    }
    f.write_char('"')
}
