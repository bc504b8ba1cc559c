//! Trees, secondary rays, samples and whole pictures: V1 to V15.

mod adaptive;
mod boxes;
mod brute_force;
mod crowds;
mod gaps;
mod lens;
mod offsets;
mod pictures;
mod samples;
mod shadows;

use super::case::{Axis, Case, Effort, Family, Found};

pub(super) fn cases() -> Vec<Case> {
    let case = |id, name, claim, axis, error, limit, run: fn(&Effort) -> Found| Case {
        id,
        name,
        family: Family::Traversal,
        claim,
        axis,
        error,
        limit,
        run,
    };
    let offset = "offset of the origin / largest of coordinates and size";
    let beyond = "share of pixels beyond the target, 99 % bound of the worst stratum";
    vec![
        case(
            "V1",
            "box-faces",
            "no ray in the plane of a box loses its hit",
            Axis::None,
            "",
            0.0,
            boxes::faces,
        ),
        case(
            "V2",
            "brute-force",
            "trees give the element and the distance, to the bit, that asking everything gives",
            Axis::None,
            "",
            0.0,
            brute_force::agreement,
        ),
        case(
            "V3",
            "one-place",
            "trees of elements at one place are built and right",
            Axis::None,
            "",
            0.0,
            crowds::one_place,
        ),
        case("V4", "giant", "one huge element does not hide small ones", Axis::None, "", 0.0, crowds::giant),
        case(
            "V5",
            "acne",
            "a ray that leaves a convex body outward meets nothing, inward the other side",
            Axis::Of("size"),
            offset,
            offsets::LIMIT,
            offsets::by_size,
        ),
        case(
            "V5b",
            "acne-far",
            "the same where the body is far from the origin of the world",
            Axis::Of("distance from the origin / size"),
            offset,
            offsets::LIMIT,
            offsets::by_distance,
        ),
        case(
            "V6",
            "thin-gap",
            "a ray that leaves a surface meets the next one, however close",
            Axis::Of("gap / size"),
            "",
            0.0,
            gaps::thin,
        ),
        case(
            "V7",
            "blocked-light",
            "what is close to a light shades it, and what lies in its plane does not",
            Axis::Of("gap / distance of the light"),
            "relative error of the light that arrives",
            1e-3,
            shadows::close_to_light,
        ),
        case(
            "V8",
            "lens-edge",
            "an edge out of focus converges as fast as four well distributed dimensions allow",
            Axis::None,
            "slope of the error over samples, log-log",
            -0.6,
            samples::slopes,
        ),
        case(
            "V9",
            "thousand",
            "what 1000 samples cost against 1024; a figure, not a promise",
            Axis::None,
            "RMSE of 1000 samples / RMSE of 1024",
            f64::INFINITY,
            samples::thousand,
        ),
        case(
            "V10",
            "neighbours",
            "errors of neighbouring pixels have nothing in common",
            Axis::None,
            "correlation of errors",
            0.05,
            samples::neighbours,
        ),
        case(
            "V11",
            "few-first-samples",
            "with a target error, pixels at sharp edges are as exact as it says, however dark",
            Axis::None,
            beyond,
            adaptive::LIMIT,
            adaptive::sharp,
        ),
        case(
            "V12",
            "half-buffers",
            "the same at edges out of focus",
            Axis::None,
            beyond,
            adaptive::LIMIT,
            adaptive::out_of_focus,
        ),
        case(
            "V13",
            "fireflies",
            "light too rare for a target error to be sure of is told of, edges are not taken for it",
            Axis::None,
            "",
            0.0,
            adaptive::rare,
        ),
        case(
            "V14",
            "edge-pictures",
            "a picture without a pixel or a sample is an error with a place, any other is finite",
            Axis::None,
            "",
            0.0,
            pictures::degenerate,
        ),
        case(
            "V15",
            "threads",
            "1, 2 and 7 threads give the same bits",
            Axis::None,
            "",
            0.0,
            pictures::threads,
        ),
    ]
}
