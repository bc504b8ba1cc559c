//! `Accelerator`: lookat always builds its own BVH.

use lookat_syntax::Severity;

use crate::params::Params;
use crate::schema::{DefaultValue, Effect, Key, Kind, Name, names};

const fn unread<T: DefaultValue>(key: Key<T>) -> Key<T> {
    key.effect(Effect::NotRendered)
}

const SPLIT_METHOD: Key<Name> = unread(
    Key::string("splitmethod", "how nodes are split: sah, hlbvh, middle or equal").default_words("\"sah\""),
);
const MOST_IN_NODE: Key<i32> = unread(Key::integer("maxnodeprims", 4, "the most shapes in a leaf"));
const INTERSECT_COST: Key<i32> =
    unread(Key::integer("intersectcost", 80, "the cost of an intersection test"));
const TRAVERSAL_COST: Key<i32> = unread(Key::integer("traversalcost", 1, "the cost of visiting a node"));
const EMPTY_BONUS: Key<f64> =
    unread(Key::float("emptybonus", 0.5, "the share of the cost that a split saves with an empty side"));
const MOST_IN_LEAF: Key<i32> = unread(Key::integer("maxprims", 1, "the most shapes in a leaf"));
const MAX_DEPTH: Key<i32> =
    unread(Key::integer("maxdepth", -1, "the depth of the tree; negative depends on the number of shapes"));

pub(crate) const KINDS: &[Kind] = &[
    Kind::new(
        "Accelerator",
        "bvh",
        "a bounding volume hierarchy; lookat always builds its own",
        &[&[&SPLIT_METHOD, &MOST_IN_NODE]],
    ),
    Kind::new(
        "Accelerator",
        "kdtree",
        "a k-d tree; lookat builds its own bounding volume hierarchy",
        &[&[&INTERSECT_COST, &TRAVERSAL_COST, &EMPTY_BONUS, &MOST_IN_LEAF, &MAX_DEPTH]],
    ),
];

/// Reports an unknown type, which is only a warning, because the picture does not depend on it.
pub(crate) fn accelerator(params: &mut Params) {
    if !names(KINDS).contains(&params.kind()) {
        params.say_unknown_kind(&names(KINDS), Severity::Warning);
    }
}
