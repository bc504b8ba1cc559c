//! Files in all encodings, whole and broken.

use std::io::Write;

use flate2::Compression;
use flate2::write::GzEncoder;

use super::header::{PropertyType, Scalar};
use super::*;

const XYZ: &str = "property float x\nproperty float y\nproperty float z\n";
const CORNERS: &str = "property list uchar int vertex_indices\n";

/// An ascii file with one vertex or face per line. `vertex_lines` and `face_lines` are header lines of additional
/// properties, which come after the usual ones.
fn file(vertex_lines: &str, face_lines: &str, vertices: &[&str], faces: &[&str]) -> String {
    let (v, f) = (vertices.len(), faces.len());
    let rows = [vertices, faces].concat().join("\n");
    format!(
        "ply\nformat ascii 1.0\nelement vertex {v}\n{XYZ}{vertex_lines}element face {f}\n\
         {CORNERS}{face_lines}end_header\n{rows}\n"
    )
}

fn mesh(bytes: &[u8]) -> Result<PlyMesh, PlyError> {
    read(bytes).unwrap()
}

fn read(file: impl Read) -> io::Result<Result<PlyMesh, PlyError>> {
    super::read(file, &MemoryBudget::default())
}

/// A unit square of two triangles.
fn square() -> String {
    file("", "", &["0 0 0", "1 0 0", "1 1 0", "0 1 0.5"], &["3 0 1 2", "3 0 2 3"])
}

fn ply_mesh(positions: Vec<[f64; 3]>, indices: Vec<i32>) -> PlyMesh {
    PlyMesh {
        mesh: Mesh { positions: positions.into(), indices: indices.into(), ..Mesh::default() },
        ..PlyMesh::default()
    }
}

fn square_mesh() -> PlyMesh {
    let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.5]];
    ply_mesh(positions, vec![0, 1, 2, 0, 2, 3])
}

/// The same file with a binary body.
fn to_binary(ascii: &str, big: bool) -> Vec<u8> {
    let header = header::parse(&mut Stream::new(ascii.as_bytes())).unwrap();
    let format = if big { "binary_big_endian" } else { "binary_little_endian" };
    let mut bytes = ascii[..header.size as usize].replacen("ascii", format, 1).into_bytes();
    let mut words = ascii[header.size as usize..].split_ascii_whitespace();
    let mut write = |scalar| {
        let value = words.next().unwrap().parse().unwrap();
        bytes.extend(encode(scalar, value, big));
        value
    };
    for element in header.elements.iter().filter(|element| !element.properties.is_empty()) {
        for property in (0..element.count).flat_map(|_| &element.properties) {
            let (first, rest) = match property.kind {
                PropertyType::One(scalar) => (scalar, None),
                PropertyType::List { count, item } => (count, Some(item)),
            };
            let length = write(first) as usize;
            for item in rest.into_iter().flat_map(|item| std::iter::repeat_n(item, length)) {
                write(item);
            }
        }
    }
    bytes
}

fn encode(scalar: Scalar, value: f64, big: bool) -> Vec<u8> {
    let mut bytes = match scalar {
        Scalar::F32 => (value as f32).to_le_bytes().to_vec(),
        Scalar::F64 => value.to_le_bytes().to_vec(),
        integer => (value as i64).to_le_bytes()[..integer.size()].to_vec(),
    };
    if big {
        bytes.reverse();
    }
    bytes
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// Checks that the file reads as `expected` in all encodings.
#[track_caller]
fn check(ascii: &str, expected: &PlyMesh) {
    for bytes in [ascii.as_bytes().to_vec(), to_binary(ascii, false), to_binary(ascii, true)] {
        assert_eq!(mesh(&bytes).as_ref(), Ok(expected));
        let oddities = Oddities { is_zipped: true, ..expected.oddities };
        assert_eq!(mesh(&gzip(&bytes)), Ok(PlyMesh { oddities, ..expected.clone() }));
    }
}

#[track_caller]
fn check_error(bytes: &[u8], expected: &str) {
    assert_eq!(mesh(bytes), Err(PlyError(expected.into())));
}

/// Checks the error messages in ascii and in both binary encodings.
#[track_caller]
fn check_errors(ascii: &str, in_ascii: &str, in_binary: &str) {
    check_error(ascii.as_bytes(), in_ascii);
    check_error(&to_binary(ascii, false), in_binary);
    check_error(&to_binary(ascii, true), in_binary);
}

#[test]
fn triangles() {
    check(&square(), &square_mesh());
}

#[test]
fn quads_split_as_in_pbrt_and_other_faces_are_left_out() {
    let vertices = ["0 0 0", "1 0 0", "1 1 0", "0 1 0.5"];
    let faces = ["4 3 2 1 0", "0", "2 0 1", "5 0 1 2 3 0", "3 0 1 2"];
    let indices = vec![3, 2, 1, 0, 3, 1, 0, 1, 2];
    check(
        &file("", "", &vertices, &faces),
        &PlyMesh {
            mesh: Mesh { indices: indices.into(), ..square_mesh().mesh },
            oddities: Oddities { other_faces: 3, ..Oddities::default() },
        },
    );
}

#[test]
fn normals_and_texture_coordinates() {
    let normals = "property float nz\nproperty float nx\nproperty double ny\n";
    for [u, v] in [["u", "v"], ["s", "t"], ["texture_u", "texture_v"], ["texture_s", "texture_t"]] {
        let lines = format!("{normals}property float {v}\nproperty short {u}\n");
        let rows = ["0 0 0 1 0 0.1 0.5 -7", "1 0 0 0 1 0 0.25 300"];
        let mut expected = ply_mesh(vec![[0.0; 3], [1.0, 0.0, 0.0]], vec![0, 1, 0]);
        expected.mesh = expected.mesh.with_normals(vec![[0.0, 0.1, 1.0], [1.0, 0.0, 0.0]]).unwrap();
        expected.mesh = expected.mesh.with_uvs(vec![[-7.0, 0.5], [300.0, 0.25]]).unwrap();
        check(&file(&lines, "", &rows, &["3 0 1 0"]), &expected);
    }
}

#[test]
fn incomplete_normals_and_texture_coordinates_are_ignored() {
    let lines = "property float nx\nproperty float ny\nproperty float u\nproperty float t\n";
    let rows = ["0 0 0 1 2 3 4", "1 0 0 1 2 3 4", "1 1 0 1 2 3 4", "0 1 0.5 1 2 3 4"];
    check(&file(lines, "", &rows, &["3 0 1 2", "3 0 2 3"]), &square_mesh());
}

#[test]
fn unknown_properties_and_elements_are_stepped_over() {
    let ascii = format!(
        "ply\nformat ascii 1.0\nelement nothing 4000000000\nelement camera 2\nproperty double fov\n\
         property list short double l\nelement vertex 4\nproperty list ushort char before\n{XYZ}\
         property uchar red\nelement edge 1\nproperty int a\nproperty int b\nelement face 2\n\
         property list uint short flags\n{CORNERS}property list uchar float uv\nproperty char last\n\
         element tail 1\nproperty float x\nend_header\n\
         45 0 30 2 1 2  0 0 0 0 255 2 7 -8 1 0 0 1 1 9 1 1 0 2 0 0 1 0.5 3  5 6\n\
         0 3 0 1 2 1 0.5 -1  2 8 9 3 0 2 3 0 -2  1"
    );
    check(&ascii, &square_mesh());
}

#[test]
fn all_types_of_coordinates_and_indices() {
    for coordinate in ["char", "short", "int", "uint8", "uint16", "uint32", "float32", "float64"] {
        for [count, index] in
            [["char", "uchar"], ["uint8", "int16"], ["short", "ushort"], ["uint", "uint32"], ["int", "int8"]]
        {
            let ascii = file("", "", &["0 100 2", "3 4 5"], &["3 1 0 1"])
                .replace("float", coordinate)
                .replace("uchar int vertex_indices", &format!("{count} {index} vertex_index"));
            let expected = PlyMesh {
                oddities: Oddities { is_vertex_index: true, ..Oddities::default() },
                ..ply_mesh(vec![[0.0, 100.0, 2.0], [3.0, 4.0, 5.0]], vec![1, 0, 1])
            };
            check(&ascii, &expected);
        }
    }
}

#[test]
fn what_the_header_does_not_count_is_told() {
    let goes_on = |bytes: Vec<u8>| read(&bytes[..]).unwrap().unwrap().oddities.goes_on;
    for (rest, expected) in [("", false), (" \n\0", false), ("3 0 1 2", true), ("\n\n   \n    3", true)] {
        assert_eq!(goes_on((square() + rest).into_bytes()), expected, "{rest:?}");
        assert_eq!(goes_on([&to_binary(&square(), true), rest.as_bytes()].concat()), expected, "{rest:?}");
    }
}

#[test]
fn doubles_keep_their_digits() {
    let ascii = file("", "", &["0.1 1e-300 1234567.891"], &["3 0 0 0"]).replace("float", "double");
    let positions = vec![[0.1, 1e-300, 1_234_567.891]];
    check(&ascii, &ply_mesh(positions, vec![0, 0, 0]));
}

#[test]
fn line_ends_layout_and_order_do_not_matter() {
    let crlf = square().replace('\n', "\r\n");
    check(&crlf, &square_mesh());
    let header = square().find("end_header\n").unwrap() + 11;
    let one_line = square()[..header].to_owned() + &square()[header..].trim().replace('\n', "\t ");
    check(&one_line, &square_mesh());
    let faces_first = format!(
        "ply\nformat ascii 1.0\nelement face 1\n{CORNERS}element vertex 2\n{XYZ}end_header\n\
         3 0 1 1 0 0 0 1 2 3"
    );
    let positions = vec![[0.0; 3], [1.0, 2.0, 3.0]];
    check(&faces_first, &ply_mesh(positions, vec![0, 1, 1]));
}

#[test]
fn bytes_after_the_last_element_are_ignored() {
    let bytes = [to_binary(&square(), true), vec![0; 9]].concat();
    assert_eq!(mesh(&bytes), Ok(square_mesh()));
}

#[test]
fn vertices_and_faces_must_be_there() {
    let without_faces = format!("ply\nformat ascii 1.0\nelement vertex 1\n{XYZ}end_header\n1 2 3\n");
    check_error(without_faces.as_bytes(), "the PLY file has no faces");
    let none = "the PLY file has no faces";
    check_errors(&file("", "", &["0 0 0"], &[]), none, none);
    let none = "the PLY file has no vertices";
    check_errors(&file("", "", &[], &["3 0 0 0"]), none, none);
    let no_z = "the vertices have no number `z`";
    check_errors(&square().replace("float z", "float w"), no_z, no_z);
    let list_y = file("", "", &["0 1 1 0"], &["3 0 0 0"]).replace("float y", "list char float y");
    let no_y = "the vertices have no number `y`";
    check_errors(&list_y, no_y, no_y);
    let no_list = "the faces have no list property `vertex_indices`";
    check_errors(&square().replace("vertex_indices", "corners"), no_list, no_list);
    let one = square().replace("list uchar int vertex_indices", "int vertex_indices");
    check_errors(&one, no_list, no_list);
    let float = "the list `vertex_indices` of the faces has no integer type";
    check_errors(&square().replace("uchar int", "uchar float"), float, float);
}

#[test]
fn indices_must_be_in_range() {
    let with = |face: &str| file("", "", &["0 0 0", "1 0 0"], &["3 0 1 0", face]);
    let (line, byte) = ("line 13: face 1 refers to vertex", to_binary(&with("0"), true).len() - 1);
    for (face, vertex) in [("3 0 2 1", "2"), ("3 -1 0 0", "-1"), ("4 0 0 0 2147483647", "2147483647")] {
        let rest = format!("{vertex}, but there are 2 vertices");
        let (text, binary) = (with(face), format!("byte {}: face 1 refers to vertex {rest}", byte));
        check_error(text.as_bytes(), &format!("{line} {rest}"));
        check_error(&to_binary(&text, true), &binary);
        // The name of this format is 3 bytes longer, which moves the body.
        let binary = binary.replacen(&byte.to_string(), &(byte + 3).to_string(), 1);
        check_error(&to_binary(&text, false), &binary);
    }
    let huge = with("3 0 0 2147483648").replace("uchar int", "uchar uint");
    check_error(huge.as_bytes(), &format!("{line} 2147483648, but there are 2 vertices"));
    assert!(mesh(&to_binary(&huge, true)).unwrap_err().0.contains("face 1 refers to vertex 2147483648,"));
    assert!(mesh(with("3 0 0 99999999999999999999").as_bytes()).is_err());
}

#[test]
fn values_must_be_finite() {
    let uv = "property float nx\nproperty float ny\nproperty float nz\nproperty float u\nproperty float v\n";
    for (index, what) in
        [(1, "position [1.0, NaN, 1.0]"), (5, "normal [1.0, 1.0, NaN]"), (6, "texture coordinate [NaN, 1.0]")]
    {
        for value in ["nan", "inf", "-inf"] {
            let mut row = ["1"; 8];
            row[index] = value;
            let ascii = file(uv, "", &["0 0 0 0 0 0 0 0", &row.join(" ")], &["3 0 0 0"]);
            let shown = if value == "nan" { "NaN" } else { value };
            let text = format!("vertex 1 has the {}, which is not finite", what.replace("NaN", shown));
            check_error(ascii.as_bytes(), &format!("line 16: {text}"));
            for big in [false, true] {
                let binary = to_binary(&ascii, big);
                let start = binary.len() - 13 - 32;
                check_error(&binary, &format!("byte {start}: {text}"));
            }
        }
    }
}

#[test]
fn words_must_be_numbers() {
    let bad = square().replace("1 1 0", "1 one 0");
    check_error(bad.as_bytes(), "line 12: vertex 2 has `one` in place of a number");
    let bad = square().replace("3 0 2 3", "3 0 2.0 3");
    check_error(bad.as_bytes(), "line 15: face 1 has `2.0` in place of an integer");
    let bad = square().replace("3 0 2 3", "\u{1} 0 2 3");
    check_error(bad.as_bytes(), "line 15: face 1 has `\\u{1}` in place of an integer");
    let bad = square().replace("3 0 2 3", "-3 0 2 3");
    check_error(bad.as_bytes(), "line 15: face 1 has a list of -3 values");
    let negative = to_binary(&square().replace("uchar int", "char int").replace("3 0 2 3", "-3"), true);
    check_error(&negative, &format!("byte {}: face 1 has a list of -3 values", negative.len() - 1));
}

#[test]
fn what_has_no_end_is_not_read_to_it() {
    let long = "1".repeat(1 << 17);
    let bad = square().replace("1 1 0", &format!("1 {long} 0"));
    check_error(
        bad.as_bytes(),
        &format!("line 12: vertex 2 has `{}...` in place of a number", "1".repeat(32)),
    );
    let bad = square().replace("element vertex", &format!("comment {long}\nelement vertex"));
    check_error(bad.as_bytes(), "line 3: the header is too long");
    let bad = square().replace("element vertex", &format!("{}element vertex", "comment\n".repeat(100_000)));
    check_error(bad.as_bytes(), "line 100001: the header is too long");
}

#[test]
fn promises_are_checked_before_memory_is_reserved() {
    let promising = |bytes: &[u8], count: &str| {
        let (header, body) = bytes.split_at(header::parse(&mut Stream::new(bytes)).unwrap().size as usize);
        [String::from_utf8_lossy(header).replace("face 2", count).as_bytes(), body].concat()
    };
    let promise = "the header declares 4000000000 faces, but the file has only";
    let ascii = promising(square().as_bytes(), "face 4000000000");
    check_error(&ascii, &format!("{promise} 42 bytes after it"));
    let binary = promising(&to_binary(&square(), true), "face 4000000000");
    check_error(&binary, &format!("{promise} 74 bytes after it"));
    // The body has enough bytes for this many faces if each is an empty list.
    let binary = promising(&to_binary(&square(), true), "face 74");
    check_error(&binary, "the file ends inside face 2 of 74");
    let ascii = promising(square().as_bytes(), "face 18446744073709551615");
    check_error(
        &ascii,
        &format!("{promise} 42 bytes after it").replace("4000000000", "18446744073709551615"),
    );
    let rows = square().replace("element face", "element e 99999\nproperty int i\nelement face");
    let expected = "the header declares 99999 rows of `e`, but the file has only 42 bytes after it";
    check_error(rows.as_bytes(), expected);
    let long_list = to_binary(&square().replace("uchar", "uint"), false);
    let at = long_list.len() - 16;
    let long_list = [&long_list[..at], &[0xff; 4], &long_list[at + 4..]].concat();
    check_error(&long_list, "the file ends inside face 1 of 2");
}

#[test]
fn vertices_must_be_few_enough_to_index() {
    let count = 1 << 31;
    let element = |name: &str, count| Element { name: name.into(), count, properties: Vec::new() };
    let elements = vec![element("vertex", count), element("face", 1)];
    let expected = "the header declares 2147483648 vertices, but at most 2147483647 can be indexed";
    let header = Header { format: Format::Ascii, elements, size: 0 };
    assert_eq!(super::check(&header), Err(PlyError(expected.into())));
}

#[test]
fn a_file_cut_anywhere_is_an_error() {
    let ascii = square();
    // Only the final line end can be missing.
    assert!(mesh(&ascii.as_bytes()[..ascii.len() - 1]).is_ok());
    let needed = ascii.trim_end().as_bytes().to_vec();
    for file in [needed, to_binary(&ascii, false), to_binary(&ascii, true), gzip(ascii.as_bytes())] {
        assert!(mesh(&file).is_ok());
        for end in 0..file.len() {
            assert!(mesh(&file[..end]).is_err(), "cut at {end} of {}", file.len());
        }
    }
    check_error(&ascii.as_bytes()[..ascii.len() - 3], "the file ends inside face 1 of 2");
    let cut = square().replace("1 0 0\n1 1 0\n0 1 0.5\n3 0 1 2\n3 0 2 3\n", "1234567890 0 123456789");
    check_error(cut.as_bytes(), "the file ends inside vertex 2 of 4");
}

#[test]
fn no_change_of_a_byte_makes_it_panic() {
    for file in [square().into_bytes(), to_binary(&square(), false), to_binary(&square(), true)] {
        for at in 0..file.len() {
            for byte in [0, 1, 0x7f, 0x80, 0xff, b' ', b'\n', b'9', b'-'] {
                let mut changed = file.clone();
                changed[at] = byte;
                let _ = mesh(&changed);
            }
        }
    }
}

#[test]
fn gzip_is_bounded_and_checked() {
    let packed = gzip(square().as_bytes());
    let size = square().len() as u64;
    let oddities = Oddities { is_zipped: true, ..Oddities::default() };
    let zipped = PlyMesh { oddities, ..square_mesh() };
    assert_eq!(read_zipped(&packed[..], size, &MemoryBudget::default()), Ok(zipped));
    let expected = PlyError(format!("the gzip data unpacks to more than {} bytes", size - 1));
    assert_eq!(read_zipped(&packed[..], size - 1, &MemoryBudget::default()), Err(expected));
    // A wrong size at the end is an error, and no memory is reserved for it.
    let mut lying = packed.clone();
    lying.truncate(packed.len() - 4);
    lying.extend([0xff; 4]);
    assert!(mesh(&lying).unwrap_err().0.starts_with("the gzip data is damaged or cut short ("));
    check_error(
        &gzip(b"no"),
        "in the unpacked data: line 1: this is not a PLY file, which begins with a line `ply`",
    );
}

/// A reader that returns its bytes with interruptions, then fails.
struct Failing<'a>(&'a [u8], bool);

impl Read for Failing<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.1 = !self.1;
        if self.1 {
            return Err(io::ErrorKind::Interrupted.into());
        }
        match self.0.read(buffer)? {
            0 => Err(io::ErrorKind::TimedOut.into()),
            count => Ok(count),
        }
    }
}

#[test]
fn a_file_that_cannot_be_read_to_its_end_is_no_mesh() {
    for whole in [square().into_bytes(), to_binary(&square(), false)] {
        // The file seems to end where reading fails, but the error must be the failed read.
        for end in 0..whole.len() {
            assert_eq!(read(Failing(&whole[..end], false)).unwrap_err().kind(), io::ErrorKind::TimedOut);
        }
    }
    let packed = gzip(square().as_bytes());
    let error = read(Failing(&packed[..40], false)).unwrap().unwrap_err();
    assert!(error.0.starts_with("the gzip data is damaged or cut short ("), "{error}");
}
