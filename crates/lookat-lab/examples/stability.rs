use lookat_lab::stability::*;
fn main() {
    let rays = std::env::args().nth(1).map_or(100_000, |x| x.parse().unwrap());
    let only = std::env::args().nth(2).unwrap_or_default();
    for case in cases() {
        if !only.is_empty() && case.id != only {
            continue;
        }
        let start = std::time::Instant::now();
        let found = (case.run)(&Effort { rays });
        println!(
            "{} {} {} {:.1}s: {}",
            case.id,
            case.name,
            if found.passes(&case) { "pass" } else { "FAIL" },
            start.elapsed().as_secs_f64(),
            case.claim
        );
        for row in &found.rows {
            println!(
                "   {:24} {:>10} {:>10}/{:<10} {:?}",
                row.method,
                row.at.map_or(String::new(), |a| format!("{a:.0e}")),
                row.failed,
                row.tried,
                row.worst
            );
        }
        for r in found.remarks.iter().take(20) {
            println!("   {r}");
        }
    }
}
