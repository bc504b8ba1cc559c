//! The results as files for other programs.

use lookat_image::Means;
use serde_json::{Value, json};

use super::equal::Curve;
use super::estimate::Estimate;
use super::plan::Plan;
use super::point::{Picture, Point};
use super::reference::{Origin, Reference};
use super::results::{End, Results};

/// What was asked for, and what it was done with.
#[derive(Debug, Clone)]
pub struct Header {
    /// The scene's file.
    pub scene: String,
    /// Width and height of the rendered part in pixels.
    pub size: [u32; 2],
    /// The number of threads.
    pub threads: usize,
    /// The seed of the first picture.
    pub seed: u64,
    /// Wall time in seconds to read the scene's files.
    pub parse: f64,
    /// Wall time in seconds to prepare the scene for rendering, the median of all pictures.
    pub preparation: f64,
}

/// A line for each picture, after a line of names. Only the times differ from run to run.
pub fn as_csv(results: &Results) -> String {
    let mut text = String::from(
        "method,samples_per_pixel,seed,samples_taken,seconds,preparation_seconds,rmse,relative_mse,mean_error\n",
    );
    for row in &results.measured.rows {
        let Picture { method, rung, samples, seed, seconds, preparation, means } = row;
        let (name, Means { rmse, relative_mse, error, .. }) = (results.name(*method), means);
        text += &format!(
            "{name},{rung},{seed},{samples},{seconds:e},{preparation:e},{rmse:e},{relative_mse:e},{error:e}\n"
        );
    }
    text
}

/// Everything but the single pictures.
pub fn as_json(header: &Header, plan: &Plan, reference: &Reference, results: &Results) -> Value {
    json!({
        "program": "lookat", "version": env!("CARGO_PKG_VERSION"),
        "scene": header.scene, "size": header.size, "threads": header.threads, "seed": header.seed,
        "seeds_per_point": plan.seeds, "parse_seconds": header.parse, "preparation_seconds": header.preparation,
        "reference": of_reference(reference),
        "complete": results.measured.end == End::Whole, "interrupted": results.measured.end == End::Interrupted,
        "methods": (0..results.measured.methods.len()).map(|i| of_method(results, i)).collect::<Vec<_>>(),
        "points": results.markers.iter().map(|marker| json!({
            "name": marker.name, "seconds": marker.seconds, "rmse": marker.means.rmse,
            "relative_mse": marker.means.relative_mse, "mean_error": marker.means.error,
            "stored_as_integers": marker.rounded, "lookat_seconds_to_same_rmse": reached(results, marker.means.rmse),
        })).collect::<Vec<_>>(),
        "front": results.front.iter().map(|reign| json!({
            "name": results.name(reign.who), "points": reign.points, "until": reign.until,
            "as_good": reign.ties.iter().map(|who| results.name(*who)).collect::<Vec<_>>(),
        })).collect::<Vec<_>>(),
        "equal_time": {"seconds": results.equal_times.at, "rmse": by_name(results, &results.equal_times.values)},
        "equal_error": {"rmse": results.equal_errors.at, "seconds": by_name(results, &results.equal_errors.values)},
    })
}

/// For each method, when it has this error.
fn reached(results: &Results, rmse: f64) -> Value {
    let seconds = |(i, curve): (usize, &Curve)| (results.name(i).to_owned(), json!(curve.seconds_to(rmse)));
    results.curves.iter().enumerate().map(seconds).collect()
}

fn of_reference(reference: &Reference) -> Value {
    let mut value = match &reference.origin {
        Origin::Rendered { samples, seed, seconds } => {
            json!({"samples_per_pixel": samples, "sampler": "sobol", "seed": seed, "seconds": seconds})
        }
        Origin::File { path, rounded } => json!({"file": path, "stored_as_integers": rounded}),
    };
    value["rms_standard_error"] = reference.noise.into();
    value
}

fn of_method(results: &Results, i: usize) -> Value {
    let method = results.measured.methods[i];
    let fit = results.fits[i].map(|fit| {
        json!({
            "slope": fit.slope, "interval": [fit.slope - fit.half_width, fit.slope + fit.half_width],
            "rmse_at_1_sample": fit.scale, "points": fit.rungs, "largest_log_deviation": fit.deviation,
        })
    });
    // JSON has no infinity: it becomes null.
    let point = |point: &Point| {
        json!({
            "samples_per_pixel": point.rung, "samples_taken": point.samples, "pictures": point.squares.len(), "seconds": of(point.seconds),
            "rmse": of(point.rmse), "relative_mse": of(point.relative_mse), "mean_error": of(point.error),
            "common_square_error": {"value": point.level.square, "standard_error": point.level.standard_error},
            "above_reference_noise": results.is_clear(point.rmse.value),
        })
    };
    let points: Vec<Value> = results.measured.points[i].iter().map(point).collect();
    json!({
        "name": method.name, "about": method.about, "points": points, "slope": fit,
        "levels_off_at": results.levels[i],
    })
}

fn of(estimate: Estimate) -> Value {
    json!({"value": estimate.value, "interval": [estimate.low, estimate.high]})
}

fn by_name(results: &Results, values: &[Vec<Option<f64>>]) -> Value {
    values.iter().enumerate().map(|(i, row)| (results.name(i).to_owned(), json!(row))).collect()
}
