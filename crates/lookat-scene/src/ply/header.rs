//! The header of a PLY file: the elements of the body, their order and encoding.

use std::io::Read;

use super::stream::{LONGEST, Stream};
use super::{PlyError, quote};
use crate::files::content::{LFS_POINTER, LFS_REASON};

/// The most lines of a header.
const MOST_LINES: usize = 100_000;

/// The encoding of the body.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    Ascii,
    /// Binary, least significant byte first.
    BinaryLittleEndian,
    /// Binary, most significant byte first.
    BinaryBigEndian,
}

/// The type of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scalar {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Scalar {
    /// The type with this name. PLY has old and new names.
    fn from_name(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Scalar::I8,
            "uchar" | "uint8" => Scalar::U8,
            "short" | "int16" => Scalar::I16,
            "ushort" | "uint16" => Scalar::U16,
            "int" | "int32" => Scalar::I32,
            "uint" | "uint32" => Scalar::U32,
            "float" | "float32" => Scalar::F32,
            "double" | "float64" => Scalar::F64,
            _ => return None,
        })
    }

    /// Bytes per number in a binary body.
    pub fn size(self) -> usize {
        match self {
            Scalar::I8 | Scalar::U8 => 1,
            Scalar::I16 | Scalar::U16 => 2,
            Scalar::I32 | Scalar::U32 | Scalar::F32 => 4,
            Scalar::F64 => 8,
        }
    }

    /// True if it can be a count or an index.
    pub fn is_integer(self) -> bool {
        !matches!(self, Scalar::F32 | Scalar::F64)
    }
}

/// The contents of a property in each row.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PropertyType {
    /// A number.
    One(Scalar),
    /// A count of integer type, and as many items.
    List { count: Scalar, item: Scalar },
}

/// A column of an element.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Property {
    pub name: String,
    pub kind: PropertyType,
}

/// A table of the body: `count` rows, each with all `properties`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Element {
    pub name: String,
    pub count: u64,
    pub properties: Vec<Property>,
}

impl Element {
    /// The index of the first property with this name.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.properties.iter().position(|property| property.name == name)
    }

    /// The bytes of a binary row with empty lists.
    pub fn binary_size(&self) -> usize {
        let size = |property: &Property| match property.kind {
            PropertyType::One(scalar) => scalar.size(),
            PropertyType::List { count, .. } => count.size(),
        };
        self.properties.iter().map(size).sum()
    }

    /// The singular noun for a row in messages.
    pub fn noun(&self) -> String {
        match self.name.as_str() {
            name @ ("vertex" | "face") => name.to_owned(),
            name => quote(name.as_bytes()),
        }
    }

    /// The declared number of rows, for messages.
    pub fn promise(&self) -> String {
        format!("the header declares {} {}", self.count, self.plural())
    }

    /// The plural noun for rows in messages.
    fn plural(&self) -> String {
        match self.name.as_str() {
            "vertex" => "vertices".to_owned(),
            "face" => "faces".to_owned(),
            name => format!("rows of {}", quote(name.as_bytes())),
        }
    }
}

/// A parsed header.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Header {
    pub format: Format,
    /// The elements in the order of the body.
    pub elements: Vec<Element>,
    /// Bytes before the body.
    pub size: u64,
}

/// Reads the lines up to `end_header`. Lines may end in LF or CR LF.
pub fn parse(stream: &mut Stream<impl Read>) -> Result<Header, PlyError> {
    let first = stream.line();
    let no_end = PlyError(match first.strip_prefix(b"ply") {
        Some([b'\r' | b'\n' | b' ' | b'\t', ..]) => "the header has no `end_header` line".into(),
        _ if first.starts_with(LFS_POINTER) => LFS_REASON.into(),
        _ => "line 1: this is not a PLY file, which begins with a line `ply`".into(),
    });
    if first.trim_ascii() != b"ply" {
        return Err(no_end);
    }
    let mut format = None;
    let mut elements = Vec::new();
    for number in 2.. {
        let line = stream.line();
        if line.is_empty() {
            break;
        }
        // A header without an end must not fill the memory.
        if line.len() >= LONGEST || number > MOST_LINES {
            let message = format!("line {number}: the header is too long");
            return Err(PlyError(message));
        }
        let line = String::from_utf8_lossy(line);
        let words: Vec<&str> = line.split_ascii_whitespace().collect();
        if words == ["end_header"] {
            let format = format.ok_or_else(|| PlyError("the header has no `format` line".into()))?;
            return Ok(Header { format, elements, size: stream.position() });
        }
        read_line(&words, &mut format, &mut elements)
            .map_err(|error| PlyError(format!("line {number}: {error}")))?;
    }
    Err(no_end)
}

/// Reads one line between the first and the last.
fn read_line(
    words: &[&str],
    format: &mut Option<Format>,
    elements: &mut Vec<Element>,
) -> Result<(), PlyError> {
    match words {
        [] | ["comment" | "obj_info", ..] => {}
        ["format", ..] if format.is_some() => return Err(PlyError("a second `format` line".into())),
        ["format", name, version] => *format = Some(read_format(name, version)?),
        ["element", name, count] => elements.push(new_element(name, count, elements)?),
        ["property", rest @ ..] => match elements.last_mut() {
            Some(element) => element.properties.push(read_property(rest)?),
            None => return Err(PlyError("a property before the first element".into())),
        },
        ["format", ..] => return Err(PlyError("write `format`, a name and a version".into())),
        ["element", ..] => return Err(PlyError("write `element`, a name and a count".into())),
        [word, ..] => return Err(PlyError(format!("unknown keyword {}", quote(word.as_bytes())))),
    }
    Ok(())
}

fn read_format(name: &str, version: &str) -> Result<Format, PlyError> {
    if version != "1.0" {
        return Err(PlyError(format!("unknown PLY version {}; only 1.0 exists", quote(version.as_bytes()))));
    }
    match name {
        "ascii" => Ok(Format::Ascii),
        "binary_little_endian" => Ok(Format::BinaryLittleEndian),
        "binary_big_endian" => Ok(Format::BinaryBigEndian),
        _ => Err(PlyError(format!(
            "unknown format {}; use ascii, binary_little_endian or binary_big_endian",
            quote(name.as_bytes())
        ))),
    }
}

fn new_element(name: &str, count: &str, before: &[Element]) -> Result<Element, PlyError> {
    // Two vertex tables would be ambiguous.
    if matches!(name, "vertex" | "face") && before.iter().any(|element| element.name == name) {
        return Err(PlyError(format!("a second element `{name}`")));
    }
    let count = count.parse().map_err(|_| PlyError(format!("{} is not a count", quote(count.as_bytes()))))?;
    Ok(Element { name: name.to_owned(), count, properties: Vec::new() })
}

/// Reads the rest of a `property` line.
fn read_property(words: &[&str]) -> Result<Property, PlyError> {
    let (name, kind) = match words {
        ["list", count, item, name] => {
            let (count, item) = (read_scalar(count)?, read_scalar(item)?);
            (name, PropertyType::List { count, item })
        }
        ["list", ..] => return Err(PlyError("write `property list`, two types and a name".into())),
        [scalar, name] => (name, PropertyType::One(read_scalar(scalar)?)),
        _ => return Err(PlyError("write `property`, a type and a name".into())),
    };
    match kind {
        PropertyType::List { count, .. } if !count.is_integer() => Err(PlyError(format!(
            "the count of the list {} must have an integer type",
            quote(name.as_bytes())
        ))),
        _ => Ok(Property { name: (*name).to_owned(), kind }),
    }
}

fn read_scalar(name: &str) -> Result<Scalar, PlyError> {
    Scalar::from_name(name)
        .ok_or_else(|| PlyError(format!("unknown property type {}", quote(name.as_bytes()))))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The error for a header with `lines` from its second line on.
    #[track_caller]
    fn check_error(lines: &str, expected: &str) {
        let text = format!("ply\n{lines}\nend_header\n");
        assert_eq!(parse(&mut Stream::new(text.as_bytes())), Err(PlyError(expected.into())));
    }

    #[test]
    fn headers_with_comments_blank_lines_and_crlf() {
        let text = "ply\r\ncomment \u{fc} x\r\nformat ascii 1.0\r\n\r\nobj_info y\r\nelement vertex 7\r\n\
                    comment z\r\nproperty float32 x\r\nproperty list uchar uint l\r\nend_header\r\n";
        let property = |name: &str, kind| Property { name: name.into(), kind };
        let properties = vec![
            property("x", PropertyType::One(Scalar::F32)),
            property("l", PropertyType::List { count: Scalar::U8, item: Scalar::U32 }),
        ];
        let elements = vec![Element { name: "vertex".into(), count: 7, properties }];
        let expected = Ok(Header { format: Format::Ascii, elements, size: text.len() as u64 });
        assert_eq!(parse(&mut Stream::new(format!("{text}\n1 2 3").as_bytes())), expected);
    }

    #[test]
    fn comments_need_not_be_utf8() {
        assert!(
            parse(&mut Stream::new(&b"ply\ncomment \xff\xfe\nformat ascii 1.0\nend_header\n"[..])).is_ok()
        );
    }

    #[test]
    fn every_type_has_two_names() {
        let old = ["char", "uchar", "short", "ushort", "int", "uint", "float", "double"];
        let new = ["int8", "uint8", "int16", "uint16", "int32", "uint32", "float32", "float64"];
        for (old, new) in old.into_iter().zip(new) {
            let scalar = Scalar::from_name(old);
            assert!(scalar.is_some());
            assert_eq!(scalar, Scalar::from_name(new));
        }
    }

    #[test]
    fn files_that_are_not_ply() {
        for bytes in [&b""[..], b"pl", b"plymouth\n", b"solid cube\n", b"\xff\xd8\xff\xe0\n", b"ply ply\n"] {
            let error = parse(&mut Stream::new(bytes)).unwrap_err().0;
            assert!(error.starts_with("line 1: ") || error.contains("end_header"), "{error}");
        }
        let expected = PlyError("the header has no `end_header` line".into());
        assert_eq!(parse(&mut Stream::new(&b"ply\nformat ascii 1.0\nelement vertex 1"[..])), Err(expected));
    }

    #[test]
    fn errors_name_the_line() {
        let format = "format ascii 1.0\n";
        check_error("", "the header has no `format` line");
        check_error("format ascii 1.1", "line 2: unknown PLY version `1.1`; only 1.0 exists");
        check_error(
            "format binary 1.0",
            "line 2: unknown format `binary`; use ascii, binary_little_endian or binary_big_endian",
        );
        check_error("format ascii", "line 2: write `format`, a name and a version");
        check_error(&format!("{format}{format}"), "line 3: a second `format` line");
        check_error("property int x", "line 2: a property before the first element");
        check_error("element face -1", "line 2: `-1` is not a count");
        check_error("element face", "line 2: write `element`, a name and a count");
        check_error("element face 1\nelement face 1", "line 3: a second element `face`");
        check_error("elephant", "line 2: unknown keyword `elephant`");
        check_error(&"e".repeat(99), "line 2: unknown keyword `eeeeeeeeeeeeeeeeeeeeeeeeeeeeeeee...`");
        let property = |text: &str, expected: &str| check_error(&format!("element e 1\n\n{text}"), expected);
        property("property flot x", "line 4: unknown property type `flot`");
        property("property list uchar", "line 4: write `property list`, two types and a name");
        property("property list uchar in x", "line 4: unknown property type `in`");
        property("property list float int x", "line 4: the count of the list `x` must have an integer type");
        property("property int", "line 4: write `property`, a type and a name");
    }
}
