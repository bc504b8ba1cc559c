//! Takes the value of a key.

use glam::{DVec3, Vec3};
use lookat_syntax::Text;

use super::Params;
use crate::schema::{
    Color, DefaultValue, Edges, Floats, Given, Integers, Key, Name, Needed, Pairs, Triples, Unit,
};

/// A type of value: what a constructor gets for a key.
pub(crate) trait Take: DefaultValue {
    /// What the constructor gets.
    type Taken;

    fn take(key: &Key<Self>, params: &mut Params) -> Self::Taken;
}

impl Take for f64 {
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

impl Take for i32 {
    type Taken = i32;

    fn take(key: &Key<i32>, params: &mut Params) -> i32 {
        let value = params.integer(key.name, key.default);
        if params.check_within(key, value) { value } else { key.default }
    }
}

impl Take for bool {
    type Taken = bool;

    fn take(key: &Key<bool>, params: &mut Params) -> bool {
        params.bool(key.name, key.default)
    }
}

impl Take for &'static [&'static str] {
    type Taken = &'static str;

    fn take(key: &Key<Self>, params: &mut Params) -> &'static str {
        params.choice(key.name, key.default)
    }
}

impl Take for [f64; 3] {
    type Taken = DVec3;

    fn take(key: &Key<Self>, params: &mut Params) -> DVec3 {
        params.triple(key.name, key.ty, key.default)
    }
}

impl Take for Color {
    type Taken = Vec3;

    fn take(key: &Key<Self>, params: &mut Params) -> Vec3 {
        params.spectrum(key.name, Vec3::splat(key.default.0))
    }
}

impl Take for Edges {
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

impl Take for Needed {
    type Taken = Option<i32>;

    fn take(key: &Key<Self>, params: &mut Params) -> Option<i32> {
        let value = params.integer(key.name, 0);
        if params.was_taken(key.name) {
            return params.check_within(key, value).then_some(value);
        }
        let message = format!("a {} needs {}", params.kind(), key.name);
        params.missing(key.name, &message, &format!("\"integer {}\" is {}", key.name, key.meaning));
        None
    }
}

/// Values without a default: the constructor gets `None`.
macro_rules! optional {
    ($($name:ident: $taken:ty, $take:ident $($field:ident)?;)*) => {$(
        impl Take for $name {
            type Taken = Option<$taken>;

            fn take(key: &Key<Self>, params: &mut Params) -> Option<$taken> {
                params.$take(key.name $(, key.$field)?)
            }
        }
    )*};
}

optional! {
    Given: f64, float_if_given;
    Name: Text, string;
    Floats: Vec<f64>, floats;
    Integers: Vec<i32>, integers;
    Pairs: Vec<[f64; 2]>, pairs;
    Triples: Vec<[f64; 3]>, triples ty;
}
