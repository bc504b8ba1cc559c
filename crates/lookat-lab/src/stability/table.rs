//! What the cases have found, as files for other programs.

use serde_json::{Value, json};

use super::case::{Case, Found, Row};
use crate::interval::interval;

/// One line for each row of each case, after a line of names.
pub fn as_csv(results: &[(Case, Found)]) -> String {
    let mut text =
        String::from("case,name,method,axis,at,tried,wrong,share,low,high,worst,error,limit,case_passes\n");
    for (case, found) in results {
        let passes = found.passes(case);
        for Row { method, at, tried, failed, worst } in &found.rows {
            let [low, high] = interval(*failed, *tried);
            let number = |x: &Option<f64>| x.map_or(String::new(), |x| format!("{x:e}"));
            let (at, worst, share) = (number(at), number(worst), *failed as f64 / *tried as f64);
            // Names have no quotes and no line breaks.
            text += &format!(
                "{},{},\"{method}\",\"{}\",{at},{tried},{failed},{share:e},{low:e},{high:e},{worst},\"{}\",{:e},{passes}\n",
                case.id, case.name, case.axis, case.error, case.limit
            );
        }
    }
    text
}

/// The same as a list of cases.
pub fn as_json(results: &[(Case, Found)]) -> Value {
    let case = |(case, found): &(Case, Found)| {
        let rows = found.rows.iter().map(|row| {
            json!({
                "method": row.method, "at": row.at, "tried": row.tried, "wrong": row.failed,
                "interval": interval(row.failed, row.tried), "worst": row.worst,
            })
        });
        json!({
            "case": case.id, "name": case.name, "claim": case.claim, "axis": case.axis,
            "error": case.error, "limit": case.limit, "passes": found.passes(case),
            "rows": rows.collect::<Vec<_>>(), "remarks": found.remarks,
        })
    };
    results.iter().map(case).collect()
}
