//! The known name that a misspelt one most likely stands for.

/// The one of `known` that is nearest to `name`, if it is near enough to be a slip: at most a third of its letters are
/// changed, missing, added or swapped with a neighbour; or else the only one that it is the beginning of. Case counts for little.
pub fn nearest<'a>(name: &str, known: impl IntoIterator<Item = &'a str, IntoIter: Clone>) -> Option<&'a str> {
    let (lower, letters) = (name.to_lowercase(), name.chars().count());
    let slips = |candidate: &str| candidate.chars().count().max(2) / 3;
    let known = known.into_iter();
    known
        .clone()
        .filter(|candidate| *candidate != name && !candidate.is_empty())
        .filter(|candidate| candidate.chars().count().abs_diff(letters) <= slips(candidate))
        .map(|candidate| (distance(&lower, &candidate.to_lowercase()), candidate))
        .filter(|(edits, candidate)| *edits <= slips(candidate))
        .min_by_key(|(edits, _)| *edits)
        .map(|(_, candidate)| candidate)
        .or_else(|| begun(&lower, known))
}

/// The only candidate that begins so.
fn begun<'a>(lower: &str, known: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    const FEWEST: usize = 3;
    let mut longer = known
        .filter(|candidate| candidate.len() > lower.len() && candidate.to_lowercase().starts_with(lower));
    longer.next().filter(|_| lower.len() >= FEWEST && longer.next().is_none())
}

/// The optimal string alignment distance: edits and swaps of neighbours.
fn distance(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().take(64).collect(), b.chars().take(64).collect());
    let mut rows = vec![vec![0; b.len() + 1]; a.len() + 1];
    for i in 0..=a.len() {
        for j in 0..=b.len() {
            if i == 0 || j == 0 {
                rows[i][j] = i + j;
                continue;
            }
            let change = usize::from(a[i - 1] != b[j - 1]);
            let mut best = (rows[i - 1][j] + 1).min(rows[i][j - 1] + 1).min(rows[i - 1][j - 1] + change);
            if i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1] {
                best = best.min(rows[i - 2][j - 2] + 1);
            }
            rows[i][j] = best;
        }
    }
    rows[a.len()][b.len()]
}

#[cfg(test)]
mod tests {
    use super::nearest;

    #[test]
    fn finds_slips_and_refuses_strangers() {
        let known = ["sphere", "trianglemesh", "plymesh", "disk", "cone"];
        let check = |name, expected| assert_eq!(nearest(name, known), expected, "{name}");
        check("triangle", Some("trianglemesh"));
        check("tr", None);
        check("sphrere", Some("sphere"));
        check("Sphere", Some("sphere"));
        check("triangelmesh", Some("trianglemesh"));
        check("plymehs", Some("plymesh"));
        check("dsik", Some("disk"));
        check("teapot", None);
        check("", None);
    }
}
