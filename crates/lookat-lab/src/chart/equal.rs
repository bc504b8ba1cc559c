//! Errors at equal times, and times to equal errors, between the measured points.

use std::ops::RangeInclusive;

/// Most columns of a table.
const COLUMNS: usize = 6;

/// The points of a method: seconds and error, both positive, by rising number of samples. Between them it is straight on
/// logarithmic axes; beyond them nothing is known.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Curve(pub Vec<(f64, f64)>);

/// Methods at a few places.
#[derive(Debug, Clone, PartialEq)]
pub struct EqualValues {
    /// The places: seconds, or errors.
    pub at: Vec<f64>,
    /// For each method, what it has there; `None` where it has no points on both sides.
    pub values: Vec<Vec<Option<f64>>>,
}

impl Curve {
    /// The error after so many seconds.
    pub fn error_at(&self, seconds: f64) -> Option<f64> {
        first_crossing(&self.in_order(), seconds)
    }

    /// The least error within so many seconds.
    pub(super) fn reached(&self, seconds: f64) -> Option<f64> {
        let before = self.0.iter().filter(|point| point.0 <= seconds).map(|point| point.1);
        before.chain(self.error_at(seconds)).reduce(f64::min)
    }

    /// The seconds until the error is as small as this for the first time.
    pub fn seconds_to(&self, error: f64) -> Option<f64> {
        first_crossing(&self.by_error(), error)
    }

    /// The first point that counts.
    pub fn first(&self) -> Option<(f64, f64)> {
        self.in_order().first().copied()
    }

    /// The same points as error and seconds.
    fn by_error(&self) -> Vec<(f64, f64)> {
        self.in_order().into_iter().map(|(seconds, error)| (error, seconds)).collect()
    }

    /// Without the points that took longer than one of more samples: the machine had other work to do then.
    fn in_order(&self) -> Vec<(f64, f64)> {
        let mut soonest = f64::INFINITY;
        let mut points: Vec<(f64, f64)> = self.0.iter().rev().copied().collect();
        points.retain(|(seconds, _)| {
            let is_in_order = *seconds < soonest;
            soonest = soonest.min(*seconds);
            is_in_order
        });
        points.reverse();
        points
    }
}

/// Errors at a few times that all curves have or, if there are none, that the first has, if possible with others.
pub(super) fn equal_times(curves: &[Curve]) -> EqualValues {
    equal(&curves.iter().map(Curve::in_order).collect::<Vec<_>>())
}

/// Times to a few errors that all curves have or, if there are none, that the first has, if possible with others; the largest
/// first.
pub(super) fn equal_errors(curves: &[Curve]) -> EqualValues {
    let mut found = equal(&curves.iter().map(Curve::by_error).collect::<Vec<_>>());
    found.at.reverse();
    found.values.iter_mut().for_each(|values| values.reverse());
    found
}

/// The ordinates of lines at a few abscissas.
fn equal(lines: &[Vec<(f64, f64)>]) -> EqualValues {
    let at = places(lines);
    let values = lines.iter().map(|line| at.iter().map(|at| first_crossing(line, *at)).collect()).collect();
    EqualValues { at, values }
}

/// The ordinate where a line through points first comes to an abscissa, from either side.
fn first_crossing(points: &[(f64, f64)], at: f64) -> Option<f64> {
    points.windows(2).find_map(|pair| {
        let [a, b] = [pair[0], pair[1]];
        if !(a.0.min(b.0)..=a.0.max(b.0)).contains(&at) {
            return None;
        }
        let share = if a.0 == b.0 { 0.0 } else { (at / a.0).ln() / (b.0 / a.0).ln() };
        Some((a.1.ln() + share * (b.1 / a.1).ln()).exp())
    })
}

/// From the least to the greatest abscissa.
fn span(line: &[(f64, f64)]) -> Option<RangeInclusive<f64>> {
    let values = line.iter().map(|point| point.0);
    Some(values.clone().reduce(f64::min)?..=values.reduce(f64::max)?)
}

/// Round numbers in what all curves have; or else in what the first and some others have, with one for each of these; or else
/// in what the first has.
fn places(lines: &[Vec<(f64, f64)>]) -> Vec<f64> {
    let ranges: Vec<_> = lines.iter().filter_map(|line| span(line)).collect();
    let [first, others @ ..] = &ranges[..] else { return Vec::new() };
    let all = ranges.iter().cloned().reduce(|a, b| shared(&a, &b)).into_iter();
    let with_first = others.iter().map(|other| shared(first, other)).filter(|both| !both.is_empty());
    let some = with_first.clone().reduce(|a, b| a.start().min(*b.start())..=a.end().max(*b.end()));
    let columns = |range: RangeInclusive<f64>| match round_numbers(&range, COLUMNS) {
        few if few.len() < 2 => multiples(&range, FINE),
        several => several,
    };
    let found = all.chain(some).map(columns).find(|columns| !columns.is_empty());
    let mut found = found.unwrap_or_else(|| round_numbers(first, COLUMNS));
    for both in with_first {
        if !found.iter().any(|column| both.contains(column)) {
            let fine = multiples(&both, FINE);
            found.extend(fine.get(fine.len() / 2));
        }
    }
    found.sort_by(f64::total_cmp);
    found
}

/// What is in both.
fn shared(a: &RangeInclusive<f64>, b: &RangeInclusive<f64>) -> RangeInclusive<f64> {
    a.start().max(*b.start())..=a.end().min(*b.end())
}

/// Of a narrow range.
const FINE: &[&str] = &["1", "1.2", "1.5", "2", "2.5", "3", "4", "5", "6", "8"];

/// The numbers 1, 2, 5, 10, ... within a range or, where these are less than three, also some between; of more than `most`
/// only some of them.
pub(super) fn round_numbers(range: &RangeInclusive<f64>, most: usize) -> Vec<f64> {
    let coarse = multiples(range, &["1", "2", "5"]);
    let all = if coarse.len() < 3 { multiples(range, &["1", "1.5", "2", "3", "5", "7"]) } else { coarse };
    let step = all.len().div_ceil(most).max(1);
    all.into_iter().step_by(step).collect()
}

/// These numbers times powers of ten within a range.
fn multiples(range: &RangeInclusive<f64>, numbers: &[&str]) -> Vec<f64> {
    let decades = range.start().log10().floor() as i32..=range.end().log10().floor() as i32;
    // Read as people write them, they are not off in the last digit.
    let all =
        decades.flat_map(|decade| numbers.iter().map(move |number| format!("{number}e{decade}").parse()));
    all.filter_map(Result::ok).filter(|number| range.contains(number)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn close(found: Option<f64>, expected: f64) {
        let found = found.unwrap();
        assert!((found / expected - 1.0).abs() < 1e-12, "{found}, not {expected}");
    }

    /// error = a seconds^slope at 1, 2, 4, ... times `start`.
    fn power(a: f64, slope: f64, start: f64) -> Curve {
        let seconds = (0..6).map(|i| start * 2.0_f64.powi(i));
        Curve(seconds.map(|seconds| (seconds, a * seconds.powf(slope))).collect())
    }

    /// Of three methods, one shares much with the first, and one a little: it has a column too.
    #[test]
    fn whoever_shares_something_has_a_column() {
        let curve = |points: &[(f64, f64)]| Curve(points.to_vec());
        let first = curve(&[(0.01, 0.34), (0.35, 0.0126)]);
        let curves = [first, curve(&[(0.01, 0.34), (0.37, 0.06)]), curve(&[(0.08, 0.0163), (0.32, 0.0073)])];
        let EqualValues { at, values } = equal_errors(&curves);
        assert_eq!(at, [0.2, 0.1, 0.05, 0.02, 0.015]);
        assert!(values.iter().all(|row| row.iter().any(Option::is_some)), "{values:?}");
        assert!(values[2][4].is_some() && values[0][4].is_some());
    }

    #[test]
    fn powers_are_exact_between_the_points() {
        let curve = power(0.3, -0.5, 1.0);
        close(curve.error_at(7.0), 0.3 / 7.0_f64.sqrt());
        close(curve.seconds_to(0.1), 9.0);
        close(curve.error_at(1.0), 0.3);
        close(curve.seconds_to(0.3), 1.0);
        assert_eq!([curve.error_at(0.99), curve.error_at(32.1), curve.seconds_to(0.31)], [None; 3]);
        // Where an error rises again, the first time counts.
        let bent = Curve(vec![(1.0, 1.0), (2.0, 0.1), (4.0, 0.4), (8.0, 0.1)]);
        assert!(bent.seconds_to(0.2).unwrap() < 2.0);
        assert_eq!(Curve::default().error_at(1.0), None);
        // What has taken longer than more samples tells nothing.
        let held_up = Curve(vec![(2.4, 0.22), (1.0, 0.12), (1.7, 0.07), (3.0, 0.03)]);
        assert_eq!((held_up.seconds_to(0.2), held_up.first()), (None, Some((1.0, 0.12))));
        assert!(held_up.error_at(2.0).unwrap() < 0.07);
    }

    #[test]
    fn tables_hold_what_all_have() {
        // Twice the samples in the same time: half the variance.
        let curves = [power(0.4, -0.5, 1.0), power(0.4 / 2.0_f64.sqrt(), -0.5, 2.0)];
        let times = equal_times(&curves);
        assert_eq!(times.at, [2.0, 5.0, 10.0, 20.0]);
        for (first, second) in times.values[0].iter().zip(&times.values[1]) {
            close(Some(first.unwrap() / second.unwrap()), 2.0_f64.sqrt());
        }
        let errors = equal_errors(&curves);
        assert_eq!(errors.at, [0.2, 0.15, 0.1]);
        for (first, second) in errors.values[0].iter().zip(&errors.values[1]) {
            close(Some(first.unwrap() / second.unwrap()), 2.0);
        }
    }

    #[test]
    fn where_nothing_is_shared_the_first_counts() {
        let found = equal_times(&[power(1.0, -0.5, 1.0), power(1.0, -0.5, 1000.0)]);
        assert_eq!(found.at, [1.0, 2.0, 5.0, 10.0, 20.0]);
        assert!(found.values[0].iter().all(Option::is_some) && found.values[1].iter().all(Option::is_none));
        assert_eq!(equal_times(&[]).at, [0.0; 0]);
    }

    #[test]
    fn what_some_share_with_the_first_counts() {
        let curve = |start| power(1.0, -0.5, start);
        // From 1 to 32, from 25 to 800, and from 1000 on.
        assert_eq!(equal_times(&[curve(1.0), curve(25.0)]).at, [25.0, 30.0]);
        let found = equal_times(&[curve(1.0), curve(25.0), curve(1000.0)]);
        assert_eq!(found.at, [25.0, 30.0]);
        assert!(found.values[..2].iter().flatten().all(Option::is_some));
        assert!(found.values[2].iter().all(Option::is_none));
    }

    #[test]
    fn round_numbers_are_few() {
        assert_eq!(round_numbers(&(0.9..=5.0), 6), [1.0, 2.0, 5.0]);
        assert_eq!(round_numbers(&(3e-4..=1.0), 6).len(), 6);
        assert_eq!(round_numbers(&(3e-4..=1.0), 6)[0], 5e-4);
        assert_eq!(round_numbers(&(1.1..=5.1), 6), [1.5, 2.0, 3.0, 5.0]);
        assert!(round_numbers(&(1.1..=1.4), 6).is_empty());
    }
}
