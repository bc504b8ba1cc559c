//! The types of a parameter's value, and the words for its default.

use glam::Vec3;

use super::range::number;
use super::{Count, REQUIRED, Range};

/// A default, as `lookat explain` shows it.
pub(crate) trait DefaultValue: Copy + 'static {
    const COUNT: Count = Count::One;
    const IS_TEXTURED: bool = false;

    /// The default in words.
    fn words(self) -> String;

    /// The range in words.
    fn range(self, range: Range) -> String {
        range.words()
    }
}

impl DefaultValue for f64 {
    fn words(self) -> String {
        number(self)
    }
}

impl DefaultValue for i32 {
    fn words(self) -> String {
        self.to_string()
    }
}

impl DefaultValue for bool {
    fn words(self) -> String {
        self.to_string()
    }
}

/// A closed list of strings. The first is the default.
impl DefaultValue for &'static [&'static str] {
    fn words(self) -> String {
        format!("\"{}\"", self[0])
    }

    fn range(self, _: Range) -> String {
        let words: Vec<String> = self.iter().map(|word| format!("\"{word}\"")).collect();
        format!("one of {}", words.join(", "))
    }
}

/// A point or a direction.
impl DefaultValue for [f64; 3] {
    fn words(self) -> String {
        self.map(number).join(" ")
    }
}

/// A color; the default is a gray.
#[derive(Clone, Copy)]
pub(crate) struct Color(pub f32);

impl DefaultValue for Color {
    fn words(self) -> String {
        self.0.to_string()
    }
}

/// A number or the name of a float texture.
#[derive(Clone, Copy)]
pub(crate) struct FloatTexture(pub f64);

impl DefaultValue for FloatTexture {
    const IS_TEXTURED: bool = true;

    fn words(self) -> String {
        number(self.0)
    }
}

/// A number or the name of a float texture, if given.
#[derive(Clone, Copy)]
pub(crate) struct GivenTexture;

impl DefaultValue for GivenTexture {
    const IS_TEXTURED: bool = true;

    fn words(self) -> String {
        "none".into()
    }
}

/// A color or the name of a spectrum texture.
#[derive(Clone, Copy)]
pub(crate) struct ColorTexture(pub Vec3);

impl DefaultValue for ColorTexture {
    const IS_TEXTURED: bool = true;

    fn words(self) -> String {
        match self.0.to_array() {
            [gray, green, blue] if gray == green && gray == blue => gray.to_string(),
            channels => channels.map(|channel| channel.to_string()).join(" "),
        }
    }
}

/// A whole number that a type needs. The constructor gets `None` after an error.
#[derive(Clone, Copy)]
pub(crate) struct Needed;

impl DefaultValue for Needed {
    fn words(self) -> String {
        REQUIRED.into()
    }
}

/// The four edges of a window, if given.
#[derive(Clone, Copy)]
pub(crate) struct Edges;

impl DefaultValue for Edges {
    const COUNT: Count = Count::Exactly(4);

    fn words(self) -> String {
        "none".into()
    }
}

/// Values without a default: the constructor gets `None`.
macro_rules! optional {
    ($($(#[$doc:meta])* $name:ident, $count:expr;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy)]
        pub(crate) struct $name;

        impl DefaultValue for $name {
            const COUNT: Count = $count;

            fn words(self) -> String {
                "none".into()
            }
        }
    )*};
}

optional! {
    /// A number, if given.
    Given, Count::One;
    /// A string, if given.
    Name, Count::One;
    /// A list of numbers, if given.
    Floats, Count::List;
    /// A list of whole numbers, if given.
    Integers, Count::List;
    /// A list of points in a plane, if given.
    Pairs, Count::List;
    /// A list of points, directions or normals, if given.
    Triples, Count::List;
}
