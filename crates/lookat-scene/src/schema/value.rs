//! The types of a parameter's value: how to take it, and the words for its default.

use glam::{DVec3, Vec3};
use lookat_syntax::Text;

use super::range::number;
use super::{Count, Key, Range, Unit};
use crate::params::Params;
use crate::texture::{Texture, TextureParams};

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

/// A type of value: what a constructor gets for a key.
pub(crate) trait Value: DefaultValue {
    /// What the constructor gets.
    type Taken;

    fn take(key: &Key<Self>, params: &mut Params) -> Self::Taken;
}

/// A type of value that can name a texture instead.
pub(crate) trait Textured: DefaultValue {
    /// What the constructor gets.
    type Taken;

    fn take(key: &Key<Self>, params: &mut TextureParams) -> Self::Taken;
}

impl DefaultValue for f64 {
    fn words(self) -> String {
        number(self)
    }
}

impl Value for f64 {
    type Taken = f64;

    /// An angle that looks like radians gets a message.
    fn take(key: &Key<f64>, params: &mut Params) -> f64 {
        let value = match key.unit {
            Unit::Degrees => params.angle(key.name, key.default),
            _ => params.float(key.name, key.default),
        };
        if params.check_within(key, value) { value } else { key.default }
    }
}

impl DefaultValue for i32 {
    fn words(self) -> String {
        self.to_string()
    }
}

impl Value for i32 {
    type Taken = i32;

    fn take(key: &Key<i32>, params: &mut Params) -> i32 {
        let value = params.integer(key.name, key.default);
        if params.check_within(key, value) { value } else { key.default }
    }
}

impl DefaultValue for bool {
    fn words(self) -> String {
        self.to_string()
    }
}

impl Value for bool {
    type Taken = bool;

    fn take(key: &Key<bool>, params: &mut Params) -> bool {
        params.bool(key.name, key.default)
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

impl Value for &'static [&'static str] {
    type Taken = &'static str;

    fn take(key: &Key<Self>, params: &mut Params) -> &'static str {
        params.choice(key.name, key.default)
    }
}

/// A point or a direction.
impl DefaultValue for [f64; 3] {
    fn words(self) -> String {
        self.map(number).join(" ")
    }
}

impl Value for [f64; 3] {
    type Taken = DVec3;

    fn take(key: &Key<Self>, params: &mut Params) -> DVec3 {
        params.triple(key.name, key.ty, key.default)
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

impl Value for Color {
    type Taken = Vec3;

    fn take(key: &Key<Self>, params: &mut Params) -> Vec3 {
        params.spectrum(key.name, Vec3::splat(key.default.0))
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

impl Textured for FloatTexture {
    type Taken = Texture<f64>;

    fn take(key: &Key<Self>, params: &mut TextureParams) -> Texture<f64> {
        let texture = params.float_texture(key.name, key.default.0);
        match texture.constant() {
            Some(value) if !params.check_within(key, value) => Texture::Constant(key.default.0),
            _ => texture,
        }
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

impl Textured for GivenTexture {
    type Taken = Option<Texture<f64>>;

    fn take(key: &Key<Self>, params: &mut TextureParams) -> Option<Texture<f64>> {
        let texture = params.float_texture_if_given(key.name)?;
        let is_within = texture.constant().is_none_or(|value| params.check_within(key, value));
        is_within.then_some(texture)
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

impl Textured for ColorTexture {
    type Taken = Texture<Vec3>;

    fn take(key: &Key<Self>, params: &mut TextureParams) -> Texture<Vec3> {
        params.spectrum_texture(key.name, key.default.0)
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

impl Value for Edges {
    type Taken = Option<[f64; 4]>;

    fn take(key: &Key<Edges>, params: &mut Params) -> Option<[f64; 4]> {
        let edges: Result<[f64; 4], Vec<f64>> = params.floats(key.name)?.try_into();
        if let Err(other) = &edges {
            let message = format!("{} takes 4 values, not {}", key.name, other.len());
            params.reject(key.name, message, Some("write the edges as xmin xmax ymin ymax"));
        }
        edges.ok()
    }
}

/// Values without a default: the constructor gets `None`.
macro_rules! optional {
    ($($(#[$doc:meta])* $name:ident: $taken:ty, $count:expr, $take:ident $($field:ident)?;)*) => {$(
        $(#[$doc])*
        #[derive(Clone, Copy)]
        pub(crate) struct $name;

        impl DefaultValue for $name {
            const COUNT: Count = $count;

            fn words(self) -> String {
                "none".into()
            }
        }

        impl Value for $name {
            type Taken = Option<$taken>;

            fn take(key: &Key<Self>, params: &mut Params) -> Option<$taken> {
                params.$take(key.name $(, key.$field)?)
            }
        }
    )*};
}

optional! {
    /// A number, if given.
    Given: f64, Count::One, float_if_given;
    /// A string, if given.
    Name: Text, Count::One, string;
    /// A list of numbers, if given.
    Floats: Vec<f64>, Count::List, floats;
    /// A list of whole numbers, if given.
    Integers: Vec<i32>, Count::List, integers;
    /// A list of points in a plane, if given.
    Pairs: Vec<[f64; 2]>, Count::List, pairs;
    /// A list of points, directions or normals, if given.
    Triples: Vec<[f64; 3]>, Count::List, triples ty;
}
